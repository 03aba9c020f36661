/* plex_copies: other places of a DMPlex file where the coordinates of the mesh stand once more.
 *
 * Firedrake keeps coordinates as a function, names it in an attribute of its mesh, and loads that,
 * not DMPlex's own; PETSc writes them once more for viewers. In: coordinates that have been read.
 * Out: the places of all that have the same values in the same order, which are changed alike. What
 * is said to be coordinates and has other values is refused, as it would stay behind.
 */
#ifdef PL_HDF5
#include "io/plex/plex.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/** Vectors that Firedrake calls coordinates. */
typedef struct functions {
    io_hdf5_names name; /* of the vectors, */
    io_hdf5_names mesh; /* and of which of its meshes they are the coordinates */
} functions;

static int add_name(io_hdf5_names *names, const char *name, planish_error *error) {
    char **grown = pl_grow(names->name, names->n, names->n + 1, &names->capacity, sizeof *grown);
    if (grown)
        names->name = grown;
    char *copy = grown ? pl_copy_text(name) : NULL;
    if (!copy)
        return pl_fail_memory(error, "the names of coordinates");
    names->name[names->n++] = copy;
    return PLANISH_OK;
}

/** Find the vectors that are coordinates of the meshes of Firedrake in a topology. */
static int find_functions(plex_reader *r, const char *topology, functions *f) {
    char group[IO_HDF5_PATH_SIZE], mesh[IO_HDF5_PATH_SIZE], name[256];
    io_hdf5_names meshes;
    int found, status = plex_list(r, topology, "firedrake_meshes", group, &meshes);
    for (int64_t i = 0; i < meshes.n && !status; i++) {
        status = io_hdf5_path(r->file, mesh, "%s/%s", group, meshes.name[i]);
        if (!status)
            status = io_hdf5_text_attribute(r->file, mesh, "firedrake_coordinates", name,
                                            sizeof name, &found);
        if (status || !found)
            continue;
        status = add_name(&f->name, name, r->error);
        if (!status)
            status = add_name(&f->mesh, meshes.name[i], r->error);
    }
    io_hdf5_names_release(&meshes);
    return status;
}

static void release_functions(functions *f) {
    io_hdf5_names_release(&f->name);
    io_hdf5_names_release(&f->mesh);
}

/** Look at a vector in the layout of a section: at path; mesh: whose coordinates it is said to be,
 *  or NULL. */
typedef int visit_fn(plex_reader *r, const char *section, const char *path, const char *mesh,
                     int *n);

/** Visit all vectors of the mesh, of whatever section. */
static int visit_vectors(plex_reader *r, const functions *f, visit_fn *visit, int *n) {
    char group[IO_HDF5_PATH_SIZE], section[IO_HDF5_PATH_SIZE], path[IO_HDF5_PATH_SIZE];
    io_hdf5_names sections, vectors;
    int status = plex_list(r, r->root, "dms", group, &sections);
    for (int64_t i = 0; i < sections.n && !status; i++) {
        status = io_hdf5_path(r->file, section, "%s/%s", group, sections.name[i]);
        if (status)
            break;
        status = plex_list(r, section, "vecs", path, &vectors);
        for (int64_t k = 0; k < vectors.n && !status; k++) {
            const char *name = vectors.name[k], *mesh = NULL;
            for (int64_t j = f->name.n - 1; j >= 0; j--)
                mesh = strcmp(f->name.name[j], name) == 0 ? f->mesh.name[j] : mesh;
            status = io_hdf5_path(r->file, path, "%s/vecs/%s/%s", section, name, name);
            if (!status && io_hdf5_kind_of(r->file, path) == IO_HDF5_DATASET)
                status = visit(r, section, path, mesh, n);
        }
        io_hdf5_names_release(&vectors);
    }
    io_hdf5_names_release(&sections);
    return status;
}

/** Take the first vector that is said to be coordinates; n: of those found. */
static int take_first(plex_reader *r, const char *section, const char *path, const char *mesh,
                      int *n) {
    if (!mesh || (*n)++ > 0)
        return PLANISH_OK;
    memcpy(r->section, section, strlen(section) + 1);
    memcpy(r->coordinates, path, strlen(path) + 1);
    return PLANISH_OK;
}

int plex_find_function(plex_reader *r) {
    functions f = {.name = {0}};
    int n = 0, status = find_functions(r, r->root, &f);
    if (!status && f.name.n > 0)
        status = visit_vectors(r, &f, take_first, &n);
    release_functions(&f);
    return status;
}

/** Take in a vector if it is a copy; n, if not NULL: count those as long as the coordinates, and
 *  look no closer. */
static int take_copy(plex_reader *r, const char *section, const char *path, const char *mesh,
                     int *n) {
    char copy[IO_HDF5_PATH_SIZE];
    const int columns = r->model->columns;
    const io_hdf5_place place = {copy, 0, columns, columns, 1};
    int is_copy = 0;
    (void)section;
    if (strcmp(path, r->coordinates) == 0)
        return PLANISH_OK;
    if (n) {
        *n += mesh || io_hdf5_is_as_long(r->file, path, columns * r->n_nodes);
        return PLANISH_OK;
    }
    memcpy(copy, path, strlen(path) + 1);
    const int status = io_hdf5_coordinates_again(r->file, &place, &is_copy);
    if (status || is_copy || !mesh)
        return status;
    return io_hdf5_fail(r->file, path,
                        "these are coordinates of '%s', too, but not the same values in the same "
                        "order as %s: they would stay behind; write a file that has the "
                        "coordinates of the nodes alone",
                        mesh, r->coordinates);
}

/** Check that Firedrake has made no other meshes of this one, which have coordinates of their own
 *  (extruded ones). */
static int check_others(plex_reader *r) {
    char topology[IO_HDF5_PATH_SIZE];
    io_hdf5_names names = {0};
    int status = io_hdf5_list(r->file, PLEX_MESHES, &names);
    for (int64_t i = 0; i < names.n && !status; i++) {
        functions f = {.name = {0}};
        status = io_hdf5_path(r->file, topology, PLEX_MESHES "/%s", names.name[i]);
        if (!status && strcmp(topology, r->root) != 0)
            status = find_functions(r, topology, &f);
        if (!status && f.name.n > 0)
            status = io_hdf5_fail(r->file, topology,
                                  "another mesh ('%s') with coordinates of its own is made of this "
                                  "one (extruded, say): they would stay behind; write the mesh to "
                                  "a file of its own",
                                  f.mesh.name[0]);
        release_functions(&f);
    }
    io_hdf5_names_release(&names);
    return status;
}

int plex_visit_copies(plex_reader *r, int *n_more) {
    static const char *const viewed[] = {"/geometry/vertices", "/viz/geometry/vertices"};
    functions f = {.name = {0}};
    int status = r->version > 1 ? check_others(r) : PLANISH_OK;
    if (!status && r->version > 1)
        status = find_functions(r, r->root, &f);
    if (!status && r->version > 1)
        status = visit_vectors(r, &f, take_copy, n_more);
    for (int i = 0; i < 2 && !status; i++)
        if (io_hdf5_kind_of(r->file, viewed[i]) == IO_HDF5_DATASET)
            status = take_copy(r, NULL, viewed[i], "the mesh", n_more);
    release_functions(&f);
    return status;
}

#endif
