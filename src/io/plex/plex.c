/* plex: meshes of PETSc's DMPlex in HDF5, as DMView writes them: one mesh of a file.
 *
 * Read are points with their cones, coordinates that stand there node by node, and labels. Of
 * fields (vectors) only those that may be coordinates are looked at. Elements are numbered as
 * DMPlex's points are, nodes by the rows of their coordinates, from 0.
 */
#ifdef PL_HDF5
#include "io/core/format.h"
#include "io/plex/plex.h"
#include "io/plex/plex_reader.h"
#include "io/core/bytes.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

#define MESHES "/topologies"

/* ---- which mesh, and where it is ------------------------------------------------------------ */

/** Find the mesh, its form, and the dimension of the elements. */
static int find_mesh(plex_reader *r) {
    io_hdf5_path path;
    io_hdf5_names names;
    int64_t dim = 0, n_meshes = 0;
    int found;
    r->version = io_hdf5_kind_of(r->file, MESHES) == IO_HDF5_GROUP ? 2 : 1;
    int status = plex_list_group(r, "", "topologies", &path, &names);
    for (int64_t i = 0; i < names.n; i++) {
        path = io_hdf5_path_of(r->file, MESHES "/%s/topology", names.name[i]);
        if (io_hdf5_kind_of(r->file, path.text) == IO_HDF5_GROUP) /* Firedrake keeps more there */
            names.name[n_meshes++] = names.name[i];
    }
    names.n = n_meshes;
    if (!status && r->version > 1)
        status = io_hdf5_check_only(r->file, MESHES, "mesh", &names);
    if (status)
        return status;
    r->name = r->version > 1 ? names.name[0] : "";
    if (r->version > 1)
        r->root = io_hdf5_path_of(r->file, MESHES "/%s", r->name);
    r->topology = io_hdf5_path_of(r->file, "%s/topology", r->root.text);
    const io_hdf5_path strata = io_hdf5_path_of(r->file, "%s/strata", r->topology.text);
    const io_hdf5_path cells = io_hdf5_path_of(r->file, "%s/cells", r->topology.text);
    if (io_hdf5_kind_of(r->file, strata.text) == IO_HDF5_GROUP)
        r->version = 3;
    else if (io_hdf5_kind_of(r->file, cells.text) == IO_HDF5_NONE)
        return io_hdf5_fail(r->file, cells.text,
                            "this does not exist: the file is not a mesh that DMView of PETSc "
                            "wrote in its own format (not for ParaView)");
    const char *at = r->version == 3 ? r->topology.text : cells.text;
    status = io_hdf5_attribute(r->file, at, "cell_dim", &dim, &found);
    if (!status && !found)
        return io_hdf5_fail(r->file, at, "the dimension of elements (cell_dim) is not there");
    if (!status && dim != 2 && dim != 3)
        return io_hdf5_fail(r->file, at,
                            "elements of dimension %lld; planish smooths tetrahedra or triangles",
                            (long long)dim);
    r->dim = (int)dim;
    return status;
}

/* ---- other places of coordinates ------------------------------------------------------------ */

/* Firedrake keeps coordinates as a function, names it in an attribute of its mesh, and loads that,
 * not DMPlex's own; PETSc writes them once more for viewers. All places that have the same values
 * in the same order are changed alike. What is said to be coordinates and has other values is
 * refused, as it would stay behind. */

/** Vectors that Firedrake calls coordinates. */
typedef struct coordinate_functions {
    io_hdf5_names name; /* of the vectors, */
    io_hdf5_names mesh; /* and of which of its meshes they are the coordinates */
} coordinate_functions;

/** Find the vectors that are coordinates of the meshes of Firedrake in a topology. */
static int find_functions(plex_reader *r, const char *topology, coordinate_functions *f) {
    char name[256];
    io_hdf5_path group;
    io_hdf5_names meshes;
    int found, status = plex_list_group(r, topology, "firedrake_meshes", &group, &meshes);
    for (int64_t i = 0; i < meshes.n && !status; i++) {
        const io_hdf5_path mesh = io_hdf5_path_of(r->file, "%s/%s", group.text, meshes.name[i]);
        status = io_hdf5_text_attribute(r->file, mesh.text, "firedrake_coordinates", name,
                                        sizeof name, &found);
        if (status || !found)
            continue;
        status = io_hdf5_names_add(r->file, &f->name, name);
        if (!status)
            status = io_hdf5_names_add(r->file, &f->mesh, meshes.name[i]);
    }
    return status;
}

/** Take in a vector if it is a copy. mesh: whose coordinates it is said to be, or NULL. n_more, if
 *  not NULL: count vectors as long as the coordinates, and look no closer. */
static int take_copy(plex_reader *r, const char *path, const char *mesh, int *n_more) {
    const int columns = r->model->columns;
    int is_copy = 0;
    if (strcmp(path, r->coordinates.text) == 0)
        return PLANISH_OK;
    if (n_more) {
        *n_more += mesh || io_hdf5_is_as_long(r->file, path, columns * r->n_nodes);
        return PLANISH_OK;
    }
    const io_hdf5_place place = {
        io_hdf5_path_of(r->file, "%s", path), 0, columns, columns, 1, 0, 0};
    const int status = io_hdf5_coordinates_again(r->file, &place, &is_copy);
    if (status || is_copy || !mesh)
        return status;
    return io_hdf5_fail(r->file, path,
                        "these are coordinates of '%s', too, but not the same values in the same "
                        "order as %s: they would stay behind; write a file that has the "
                        "coordinates of the nodes alone",
                        mesh, r->coordinates.text);
}

/** Visit all vectors of the mesh, of whatever section: take copies of the coordinates; or, if they
 *  are wanted still, make the first vector that Firedrake calls so the coordinates. */
static int visit_vectors(plex_reader *r, int is_wanted, int *n_more) {
    io_hdf5_path group, path;
    io_hdf5_names sections = {0}, vectors;
    coordinate_functions f = {.name = {0}};
    int found = 0, status = find_functions(r, r->root.text, &f);
    if (!status && (f.name.n > 0 || !is_wanted))
        status = plex_list_group(r, r->root.text, "dms", &group, &sections);
    for (int64_t i = 0; i < sections.n && !status; i++) {
        const io_hdf5_path section =
            io_hdf5_path_of(r->file, "%s/%s", group.text, sections.name[i]);
        status = plex_list_group(r, section.text, "vecs", &path, &vectors);
        for (int64_t k = 0; k < vectors.n && !status; k++) {
            const char *name = vectors.name[k], *mesh = NULL;
            for (int64_t j = f.name.n - 1; j >= 0; j--)
                mesh = strcmp(f.name.name[j], name) == 0 ? f.mesh.name[j] : mesh;
            path = io_hdf5_path_of(r->file, "%s/vecs/%s/%s", section.text, name, name);
            if (io_hdf5_kind_of(r->file, path.text) != IO_HDF5_DATASET)
                continue;
            if (!is_wanted) {
                status = take_copy(r, path.text, mesh, n_more);
            } else if (mesh && !found) {
                found = 1;
                r->section = section;
                r->coordinates = path;
            }
        }
    }
    return status;
}

/** Check that Firedrake has made no other meshes of this one, which have coordinates of their own
 *  (extruded ones). */
static int check_others(plex_reader *r) {
    io_hdf5_names names;
    int status = io_hdf5_list(r->file, MESHES, &names);
    for (int64_t i = 0; i < names.n && !status; i++) {
        coordinate_functions f = {.name = {0}};
        const io_hdf5_path topology = io_hdf5_path_of(r->file, MESHES "/%s", names.name[i]);
        if (strcmp(topology.text, r->root.text) != 0)
            status = find_functions(r, topology.text, &f);
        if (!status && f.name.n > 0)
            status = io_hdf5_fail(r->file, topology.text,
                                  "another mesh ('%s') with coordinates of its own is made of this "
                                  "one (extruded, say): they would stay behind; write the mesh to "
                                  "a file of its own",
                                  f.mesh.name[0]);
    }
    return status;
}

/** After the coordinates have been read: make all copies of them coordinates, too. Fail on others
 *  that would stay behind. n_more, if not NULL: count the arrays that may be copies instead. */
static int visit_copies(plex_reader *r, int *n_more) {
    static const char *const viewed[] = {"/geometry/vertices", "/viz/geometry/vertices"};
    int status = r->version > 1 ? check_others(r) : PLANISH_OK;
    if (!status && r->version > 1)
        status = visit_vectors(r, 0, n_more);
    for (int i = 0; i < 2 && !status; i++)
        if (io_hdf5_kind_of(r->file, viewed[i]) == IO_HDF5_DATASET)
            status = take_copy(r, viewed[i], "the mesh", n_more);
    return status;
}

/* ---- coordinates ---------------------------------------------------------------------------- */

/** Check that there is one row for each node, in their order; others may be of edges, or be there
 *  for each element (of curved and periodic meshes). */
static int check_section(plex_reader *r) {
    io_hdf5_integers points = {0}, sizes = {0}, begins = {0};
    const int columns = r->model->columns;
    int64_t n = 0; /* rows of nodes */
    int status = plex_read_integers(r, r->section.text, "order", &points);
    if (!status)
        status = plex_read_integers(r, r->section.text, "section/atlasDof", &sizes);
    if (!status)
        status = plex_read_integers(r, r->section.text, "section/atlasOff", &begins);
    int is_good = !status && sizes.n == points.n && begins.n == points.n;
    for (int64_t i = 0; is_good && i < points.n; i++) {
        const int64_t size = io_hdf5_integer(&sizes, i);
        is_good =
            size == 0 || (size == columns && io_hdf5_integer(&points, i) == r->n_elements + n &&
                          io_hdf5_integer(&begins, i) == n * columns);
        n += size != 0;
    }
    if (!status && (!is_good || n != r->n_nodes))
        status = io_hdf5_fail(r->file, r->section.text,
                              "coordinates are not one place for each node, in their order, as of "
                              "curved or periodic meshes");
    io_hdf5_integers_release(&points);
    io_hdf5_integers_release(&sizes);
    io_hdf5_integers_release(&begins);
    return status;
}

/** Find the coordinates and their group, whose names may be others, and check that they are rows of
 *  two or three for each node. */
static int find_coordinates(plex_reader *r) {
    char group[256] = "coordinateDM", name[256] = "coordinates";
    const char *const root = r->root.text;
    io_hdf5_shape shape;
    int status = PLANISH_OK;
    r->coordinates = io_hdf5_path_of(r->file, "/geometry/vertices");
    if (r->version > 1) {
        status =
            io_hdf5_text_attribute(r->file, root, "coordinateDMName", group, sizeof group, NULL);
        if (!status)
            status =
                io_hdf5_text_attribute(r->file, root, "coordinatesName", name, sizeof name, NULL);
        r->section = io_hdf5_path_of(r->file, "%s/dms/%s", root, group);
        r->coordinates = io_hdf5_path_of(r->file, "%s/vecs/%s/%s", r->section.text, name, name);
        if (!status && io_hdf5_kind_of(r->file, r->coordinates.text) == IO_HDF5_NONE)
            status = visit_vectors(r, 1, NULL);
    }
    if (!status)
        status = io_hdf5_shape_of(r->file, r->coordinates.text, &shape);
    if (status)
        return status;
    const int is_list = r->version > 1 && (shape.rank == 1 || shape.dims[1] == 1);
    const int64_t columns = is_list ? shape.n / r->n_nodes : shape.dims[1];
    if ((columns != 2 && columns != 3) || shape.n != columns * r->n_nodes)
        return io_hdf5_fail(r->file, r->coordinates.text,
                            "%lld coordinates in rows of %lld for %lld nodes; two or three each "
                            "were expected",
                            (long long)shape.n, (long long)columns, (long long)r->n_nodes);
    r->model->columns = (int)columns;
    return r->version == 1 ? PLANISH_OK : check_section(r);
}

/* ---- the format ----------------------------------------------------------------------------- */

/** Open the file, and find the mesh and where its coordinates stand. */
static int begin_reading(plex_reader *r) {
    int status = io_hdf5_open(r->model, &r->file, r->error);
    if (!status)
        status = find_mesh(r);
    if (!status)
        status = plex_read_topology(r);
    return status ? status : find_coordinates(r);
}

static int plex_read(io_model *model, planish_error *error) {
    plex_reader r = {.model = model, .error = error};
    int status = begin_reading(&r);
    if (!status)
        status = io_model_alloc_nodes(model, r.n_nodes, 0, error);
    const io_hdf5_place place = {r.coordinates, 0, model->columns, model->columns, 1, 0, 0};
    if (!status)
        status = io_hdf5_coordinates(r.file, &place);
    if (!status)
        status = visit_copies(&r, NULL);
    if (!status)
        status = io_hdf5_coordinates_end(r.file);
    if (!status)
        status = plex_read_elements(&r);
    if (!status)
        status = plex_read_labels(&r);
    plex_release_topology(&r);
    return io_hdf5_end(r.file, status);
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

int io_plex_outline_of(const char *path, io_plex_outline *outline, planish_error *error) {
    io_model model = {.n_nodes = 0};
    plex_reader r = {.model = &model, .error = error};
    *outline = (io_plex_outline){.version = 0};
    int status = io_bytes_open(path, INT64_MAX, &model.input, error);
    if (status)
        return status;
    io_plex_outline o = {.version = 0};
    status = begin_reading(&r);
    if (!status && strlen(r.name) >= sizeof o.name)
        status = io_hdf5_fail(r.file, MESHES, "the name of the mesh is too long");
    if (!status)
        status = visit_copies(&r, &o.has_copies);
    if (!status)
        status = plex_check_labels(&r, &o.has_regions_alone);
    if (!status) {
        o.version = r.version;
        o.dim = r.dim;
        o.columns = model.columns;
        o.n_nodes = r.n_nodes;
        o.has_simplices_alone = plex_has_simplices_alone(&r);
        memcpy(o.name, r.name, strlen(r.name));
        memcpy(o.coordinates, r.coordinates.text, sizeof o.coordinates);
    }
    plex_release_topology(&r);
    status = io_hdf5_end(r.file, status);
    io_bytes_close(&model.input);
    if (!status)
        *outline = o;
    return status;
}

#endif
