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

#include <string.h>

/* ---- lists ---------------------------------------------------------------------------------- */

int plex_read_list(plex_reader *r, const char *group, const char *name, io_hdf5_integers *list) {
    char path[IO_HDF5_PATH_SIZE];
    const int status = io_hdf5_path(r->file, path, "%s/%s", group, name);
    return status ? status : io_hdf5_integers_read(r->file, path, list);
}

int plex_list(plex_reader *r, const char *parent, const char *name, char *path,
              io_hdf5_names *names) {
    *names = (io_hdf5_names){0};
    const int status = io_hdf5_path(r->file, path, "%s/%s", parent, name);
    const int is_there = !status && io_hdf5_kind_of(r->file, path) == IO_HDF5_GROUP;
    return is_there ? io_hdf5_list(r->file, path, names) : status;
}

/* ---- which mesh, and where it is ------------------------------------------------------------ */

/** Find the one mesh of versions 2 and 3; name is "" without it. */
static int find_root(plex_reader *r, char *name, size_t size) {
    char path[IO_HDF5_PATH_SIZE];
    io_hdf5_names names;
    const char *found[2] = {NULL, NULL}; /* the first two meshes */
    int64_t n = 0;
    r->version = io_hdf5_kind_of(r->file, PLEX_MESHES) == IO_HDF5_GROUP ? 2 : 1;
    r->root[0] = name[0] = '\0';
    int status = plex_list(r, "", "topologies", path, &names);
    for (int64_t i = 0; i < names.n && !status; i++) {
        status = io_hdf5_path(r->file, path, PLEX_MESHES "/%s/topology", names.name[i]);
        if (status || io_hdf5_kind_of(r->file, path) != IO_HDF5_GROUP)
            continue; /* Firedrake keeps more there */
        if (n < 2)
            found[n] = names.name[i];
        n++;
    }
    if (!status && r->version > 1 && n == 0)
        status = io_hdf5_fail(r->file, PLEX_MESHES, "there is no mesh");
    if (!status && n > 1)
        status = io_hdf5_fail(r->file, PLEX_MESHES,
                              "there are %lld meshes (%.60s, %.60s, ...); planish reads files with "
                              "one: write each to a file of its own",
                              (long long)n, found[0], found[1]);
    if (!status && n == 1 && strlen(found[0]) >= size)
        status = io_hdf5_fail(r->file, PLEX_MESHES, "the name of the mesh is too long");
    if (!status && n == 1) {
        memcpy(name, found[0], strlen(found[0]) + 1);
        status = io_hdf5_path(r->file, r->root, PLEX_MESHES "/%s", name);
    }
    io_hdf5_names_release(&names);
    return status;
}

/** Find the mesh, its form, and the dimension of the elements. */
static int find_mesh(plex_reader *r, char *name, size_t size) {
    char strata[IO_HDF5_PATH_SIZE], cells[IO_HDF5_PATH_SIZE];
    int64_t dim = 0;
    int found;
    int status = find_root(r, name, size);
    if (!status)
        status = io_hdf5_path(r->file, r->topology, "%s/topology", r->root);
    if (!status)
        status = io_hdf5_path(r->file, strata, "%s/strata", r->topology);
    if (!status)
        status = io_hdf5_path(r->file, cells, "%s/cells", r->topology);
    if (status)
        return status;
    if (io_hdf5_kind_of(r->file, strata) == IO_HDF5_GROUP)
        r->version = 3;
    else if (io_hdf5_kind_of(r->file, cells) == IO_HDF5_NONE)
        return io_hdf5_fail(r->file, cells,
                            "there is no such thing: this is no mesh that DMView of PETSc wrote "
                            "(in its own format, not for ParaView)");
    const char *path = r->version == 3 ? r->topology : cells;
    status = io_hdf5_attribute(r->file, path, "cell_dim", &dim, &found);
    if (!status && !found)
        return io_hdf5_fail(r->file, path, "the dimension of elements (cell_dim) is not there");
    if (!status && dim != 2 && dim != 3)
        return io_hdf5_fail(r->file, path,
                            "elements of dimension %lld; planish smooths tetrahedra or triangles",
                            (long long)dim);
    r->dim = (int)dim;
    return status;
}

/* ---- coordinates ---------------------------------------------------------------------------- */

/** Find the group of coordinates, and the coordinates; the names of both may be others. */
static int find_coordinates(plex_reader *r) {
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
        status = io_hdf5_path(r->file, r->section, "%s/dms/%s", r->root, group);
    if (!status)
        status = io_hdf5_path(r->file, r->coordinates, "%s/vecs/%s/%s", r->section, name, name);
    return status || io_hdf5_kind_of(r->file, r->coordinates) != IO_HDF5_NONE
               ? status
               : plex_find_function(r);
}

/** Check that there is one row for each node, in their order; others may be of edges, or be there
 *  for each element (of curved and periodic meshes). */
static int check_section(plex_reader *r) {
    io_hdf5_integers points = {0}, sizes = {0}, begins = {0};
    const int columns = r->model->columns;
    int64_t n = 0; /* rows of nodes */
    int status = plex_read_list(r, r->section, "order", &points);
    if (!status)
        status = plex_read_list(r, r->section, "section/atlasDof", &sizes);
    if (!status)
        status = plex_read_list(r, r->section, "section/atlasOff", &begins);
    int is_good = !status && sizes.n == points.n && begins.n == points.n;
    for (int64_t i = 0; is_good && i < points.n; i++) {
        const int64_t size = io_hdf5_integer(&sizes, i);
        is_good =
            size == 0 || (size == columns && io_hdf5_integer(&points, i) == r->n_elements + n &&
                          io_hdf5_integer(&begins, i) == n * columns);
        n += size != 0;
    }
    if (!status && (!is_good || n != r->n_nodes))
        status = io_hdf5_fail(r->file, r->section,
                              "coordinates are not one place for each node, in their order, as of "
                              "curved or periodic meshes");
    io_hdf5_integers_release(&points);
    io_hdf5_integers_release(&sizes);
    io_hdf5_integers_release(&begins);
    return status;
}

/** Check that coordinates are rows of two or three for each node. */
static int check_coordinates(plex_reader *r) {
    io_hdf5_shape shape;
    int status = find_coordinates(r);
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
    return r->version == 1 ? PLANISH_OK : check_section(r);
}

/* ---- the format ----------------------------------------------------------------------------- */

static int read_mesh(plex_reader *r) {
    io_model *model = r->model;
    char name[256];
    int status = find_mesh(r, name, sizeof name);
    if (!status)
        status = plex_read_topology(r);
    if (!status)
        status = check_coordinates(r);
    if (!status)
        status = io_model_nodes(model, r->n_nodes, 0, r->error);
    if (status)
        return status;
    for (int64_t i = 0; model->columns < 3 && i < r->n_nodes; i++)
        model->xyz[3 * i + 2] = 0;
    const io_hdf5_place place = {r->coordinates, 0, model->columns, model->columns, 1};
    status = io_hdf5_coordinates(r->file, &place);
    if (!status)
        status = plex_visit_copies(r, NULL);
    if (!status)
        status = io_hdf5_coordinates_end(r->file);
    if (!status)
        status = plex_read_elements(r);
    return status ? status : plex_read_labels(r);
}

/** Release all that a reader holds, after it has come to a status; return the status. */
static int end_reading(plex_reader *r, int status) {
    status = status ? status : io_hdf5_check(r->file);
    plex_release_topology(r);
    io_hdf5_close(r->file);
    return status;
}

static int plex_read(io_model *model, planish_error *error) {
    plex_reader r = {.model = model, .error = error};
    const int status = io_hdf5_open(model, &r.file, error);
    return end_reading(&r, status ? status : read_mesh(&r));
}

static int plex_recognise(const char *data, int64_t size) {
    return io_hdf5_recognise(data, size, PLEX_MESHES) ||
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
        status = plex_visit_copies(r, &o->has_copies);
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
    status = end_reading(&r, status ? status : outline_mesh(&r, outline));
    io_bytes_close(&model.input);
    return status;
}

#endif
