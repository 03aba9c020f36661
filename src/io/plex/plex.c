/* plex: meshes of PETSc's DMPlex in HDF5, as DMView writes them: one mesh of a file.
 *
 * Read are points with their cones, coordinates that stand there node by node, and labels. Fields
 * (vectors) are not looked at. Elements are numbered as DMPlex's points are, nodes by the rows of
 * their coordinates, from 0.
 */
#ifdef PL_HDF5
#include "io/core/format.h"
#include "io/plex/plex.h"
#include "io/core/bytes.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdio.h>
#include <string.h>

#define MESHES "/topologies"

/* ---- which mesh, and where it is ------------------------------------------------------------ */

/** Of names in the group of meshes those that have a topology: Firedrake keeps more there. */
static int keep_meshes(plex_reader *r, io_hdf5_names *names) {
    int64_t n = 0;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < names->n; i++) {
        char path[IO_HDF5_PATH_SIZE];
        if (!status)
            status = io_hdf5_path(r->file, path, MESHES "/%s/topology", names->name[i]);
        if (!status && io_hdf5_kind_of(r->file, path) != IO_HDF5_GROUP) {
            pl_free(names->name[i]);
            continue;
        }
        names->name[n++] = names->name[i];
    }
    names->n = n;
    return status;
}

/** The one mesh of versions 2 and 3. */
static int find_root(plex_reader *r, char *name, size_t size) {
    io_hdf5_names names = {0};
    r->version = io_hdf5_kind_of(r->file, MESHES) == IO_HDF5_GROUP ? 2 : 1;
    r->root[0] = name[0] = '\0';
    if (r->version == 1)
        return PLANISH_OK;
    int status = io_hdf5_list(r->file, MESHES, &names);
    if (!status)
        status = keep_meshes(r, &names);
    if (!status && names.n == 0)
        status = io_hdf5_fail(r->file, MESHES, "there is no mesh");
    if (!status && names.n > 1)
        status = io_hdf5_fail(r->file, MESHES,
                              "there are %lld meshes (%.60s, %.60s, ...); planish reads files with "
                              "one: write each to a file of its own",
                              (long long)names.n, names.name[0], names.name[1]);
    if (!status && strlen(names.name[0]) >= size)
        status = io_hdf5_fail(r->file, MESHES, "the name of the mesh is too long");
    if (!status) {
        memcpy(name, names.name[0], strlen(names.name[0]) + 1);
        status = io_hdf5_path(r->file, r->root, MESHES "/%s", name);
    }
    io_hdf5_names_release(&names);
    return status;
}

/** Its form, and the dimension of the elements. */
static int find_form(plex_reader *r) {
    char group[IO_HDF5_PATH_SIZE], path[IO_HDF5_PATH_SIZE];
    int64_t dim = 0;
    int found = 1;
    int status = io_hdf5_path(r->file, group, "%s/topology", r->root);
    if (!status)
        status = io_hdf5_path(r->file, path, "%s/strata", group);
    if (!status && io_hdf5_kind_of(r->file, path) == IO_HDF5_GROUP)
        r->version = 3;
    else if (!status)
        status = io_hdf5_path(r->file, path, "%s/cells", group);
    if (!status && io_hdf5_kind_of(r->file, path) == IO_HDF5_NONE)
        status = io_hdf5_fail(r->file, path,
                              "there is no such thing: this is no mesh that DMView of PETSc wrote "
                              "(in its own format, not for ParaView)");
    if (!status)
        status =
            io_hdf5_attribute(r->file, r->version == 3 ? group : path, "cell_dim", &dim, &found);
    if (!status && !found)
        status = io_hdf5_fail(r->file, path, "the dimension of elements (cell_dim) is not there");
    if (!status && dim != 2 && dim != 3)
        status = io_hdf5_fail(r->file, path,
                              "elements of dimension %lld; planish smooths tetrahedra or triangles",
                              (long long)dim);
    r->dim = (int)dim;
    return status;
}

/** The path of the group of coordinates, and of the coordinates; the names of both may be others.
 */
static int find_coordinates(plex_reader *r, char *section) {
    char group[256] = "coordinateDM", name[256] = "coordinates";
    int found;
    if (r->version == 1)
        return io_hdf5_path(r->file, r->coordinates, "/geometry/vertices");
    int status =
        io_hdf5_text_attribute(r->file, r->root, "coordinateDMName", group, sizeof group, &found);
    if (!status)
        status =
            io_hdf5_text_attribute(r->file, r->root, "coordinatesName", name, sizeof name, &found);
    if (!status)
        status = io_hdf5_path(r->file, section, "%s/dms/%s", r->root, group);
    if (!status)
        status = io_hdf5_path(r->file, r->coordinates, "%s/vecs/%s/%s", section, name, name);
    if (status || io_hdf5_kind_of(r->file, r->coordinates) != IO_HDF5_NONE)
        return status;
    char function[IO_HDF5_PATH_SIZE];
    memcpy(function, r->coordinates, sizeof function);
    status = plex_find_function(r, section, &found);
    if (!found)
        memcpy(r->coordinates, function, sizeof function);
    return status;
}

/* ---- coordinates ---------------------------------------------------------------------------- */

/** Whether there is one row for each node, in their order; others may be of edges, or be there for
 *  each element (of curved and periodic meshes). */
static int rows_are_nodes(const plex_reader *r, const io_hdf5_integers *points,
                          const io_hdf5_integers *sizes, const io_hdf5_integers *begins) {
    const int columns = r->model->columns;
    int64_t n = 0;
    if (sizes->n != points->n || begins->n != points->n)
        return 0;
    for (int64_t i = 0; i < points->n; i++) {
        const int64_t size = io_hdf5_integer(sizes, i);
        if (size == 0)
            continue;
        if (size != columns || io_hdf5_integer(points, i) != r->n_elements + n ||
            io_hdf5_integer(begins, i) != n * columns)
            return 0;
        n++;
    }
    return n == r->n_nodes;
}

static int check_section(plex_reader *r, const char *group) {
    static const char *const names[] = {"order", "section/atlasDof", "section/atlasOff"};
    io_hdf5_integers list[3] = {{0}};
    int status = PLANISH_OK;
    for (int i = 0; i < 3 && !status; i++) {
        char path[IO_HDF5_PATH_SIZE];
        status = io_hdf5_path(r->file, path, "%s/%s", group, names[i]);
        if (!status)
            status = io_hdf5_integers_read(r->file, path, &list[i]);
    }
    if (!status && !rows_are_nodes(r, &list[0], &list[1], &list[2]))
        status = io_hdf5_fail(r->file, group,
                              "coordinates are not one place for each node, in their order, as of "
                              "curved or periodic meshes");
    for (int i = 0; i < 3; i++)
        io_hdf5_integers_release(&list[i]);
    return status;
}

/** Where they are: rows of two or three for each node. */
static int check_coordinates(plex_reader *r) {
    char section[IO_HDF5_PATH_SIZE];
    io_hdf5_shape shape;
    int status = find_coordinates(r, section);
    if (!status)
        status = io_hdf5_shape_of(r->file, r->coordinates, &shape);
    if (status)
        return status;
    const int is_list = r->version > 1 && (shape.rank == 1 || shape.dims[1] == 1);
    const int64_t columns = is_list ? shape.n / r->n_nodes : shape.dims[1];
    if ((columns != 2 && columns != 3) || shape.n != columns * r->n_nodes)
        return io_hdf5_fail(r->file, r->coordinates,
                            "%lld coordinates in rows of %lld for %lld nodes; two or three each "
                            "were expected",
                            (long long)shape.n, (long long)columns, (long long)r->n_nodes);
    r->model->columns = (int)columns;
    return r->version == 1 ? PLANISH_OK : check_section(r, section);
}

static int read_coordinates(plex_reader *r) {
    io_model *model = r->model;
    int status = check_coordinates(r);
    if (!status)
        status = io_model_nodes(model, r->n_nodes, 0, r->error);
    for (int64_t i = 0; !status && model->columns < 3 && i < r->n_nodes; i++)
        model->xyz[3 * i + 2] = 0;
    const io_hdf5_place place = {r->coordinates, 0, model->columns, model->columns, 1};
    if (!status)
        status = io_hdf5_coordinates(r->file, &place);
    if (!status)
        status = plex_read_copies(r);
    return status ? status : io_hdf5_coordinates_end(r->file);
}

/* ---- the format ----------------------------------------------------------------------------- */

static int find_mesh(plex_reader *r, char *name, size_t size) {
    const int status = find_root(r, name, size);
    return status ? status : find_form(r);
}

static int read_mesh(plex_reader *r) {
    char name[256];
    int status = find_mesh(r, name, sizeof name);
    if (!status)
        status = plex_read_topology(r);
    if (!status)
        status = read_coordinates(r);
    if (!status)
        status = plex_read_elements(r);
    return status ? status : plex_read_labels(r);
}

static int plex_read(io_model *model, planish_error *error) {
    plex_reader r = {.model = model, .error = error};
    int status = io_hdf5_open(model, &r.file, error);
    if (!status)
        status = read_mesh(&r);
    if (!status)
        status = io_hdf5_check(r.file);
    plex_release_topology(&r);
    io_hdf5_close(r.file);
    return status;
}

static int plex_recognise(const char *data, int64_t size) {
    return io_hdf5_recognise(data, size, MESHES) ||
           io_hdf5_recognise(data, size, "/topology/cells");
}

static const char *const extensions[] = {".h5", NULL};

const io_format io_format_plex = {.name = "dmplex",
                                  .extensions = extensions,
                                  .recognise = plex_recognise,
                                  .read = plex_read,
                                  .amend = io_hdf5_amend,
                                  .release = io_hdf5_release};

/* ---- for those who load such files with PETSc ----------------------------------------------- */

static int outline_mesh(plex_reader *r, io_plex_outline *o) {
    int status = find_mesh(r, o->name, sizeof o->name);
    if (!status)
        status = plex_read_topology(r);
    if (!status)
        status = check_coordinates(r);
    if (!status)
        status = plex_count_copies(r, &o->has_copies);
    if (!status)
        status = plex_check_labels(r, &o->has_regions_alone);
    if (status)
        return status;
    o->version = r->version;
    o->dim = r->dim;
    o->columns = r->model->columns;
    o->n_nodes = r->n_nodes;
    o->has_simplices_alone = plex_has_simplices_alone(r);
    memcpy(o->coordinates, r->coordinates, sizeof o->coordinates);
    return PLANISH_OK;
}

int io_plex_outline_of(const char *path, io_plex_outline *outline, planish_error *error) {
    io_model model = {.n_nodes = 0};
    plex_reader r = {.model = &model, .error = error};
    *outline = (io_plex_outline){.version = 0};
    int status = io_bytes_open(path, INT64_MAX, &model.input, error);
    if (status)
        return status;
    status = io_hdf5_open(&model, &r.file, error);
    if (!status)
        status = outline_mesh(&r, outline);
    if (!status)
        status = io_hdf5_check(r.file);
    plex_release_topology(&r);
    io_hdf5_close(r.file);
    io_bytes_close(&model.input);
    return status;
}

#endif
