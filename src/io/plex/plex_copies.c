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

#define MESHES "/topologies"

/** What is looked for among the vectors of a mesh. */
typedef struct search {
    plex_reader *r;
    io_hdf5_names named; /* vectors that Firedrake calls coordinates, */
    io_hdf5_names of;    /* and of which of its meshes */
    char *vector;        /* [IO_HDF5_PATH_SIZE] of the first of these, or NULL: not wanted */
    char *section;       /* [IO_HDF5_PATH_SIZE] and of the group that tells its layout */
    int found;
    int *n_more; /* vectors as long as the coordinates, or NULL: not wanted */
} search;

/* ---- what Firedrake calls coordinates -------------------------------------------------------- */

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

/** Of the meshes of Firedrake in a topology: which vectors are their coordinates. */
static int find_named(search *s, const char *topology) {
    plex_reader *r = s->r;
    char group[IO_HDF5_PATH_SIZE], mesh[IO_HDF5_PATH_SIZE], name[256];
    io_hdf5_names meshes = {0};
    int status = io_hdf5_path(r->file, group, "%s/firedrake_meshes", topology), found;
    if (!status && io_hdf5_kind_of(r->file, group) == IO_HDF5_GROUP)
        status = io_hdf5_list(r->file, group, &meshes);
    for (int64_t i = 0; i < meshes.n && !status; i++) {
        status = io_hdf5_path(r->file, mesh, "%s/%s", group, meshes.name[i]);
        if (!status)
            status = io_hdf5_text_attribute(r->file, mesh, "firedrake_coordinates", name,
                                            sizeof name, &found);
        if (status || !found)
            continue;
        status = add_name(&s->named, name, r->error);
        if (!status)
            status = add_name(&s->of, meshes.name[i], r->error);
    }
    io_hdf5_names_release(&meshes);
    return status;
}

/** The mesh of which a vector is said to be the coordinates, or NULL. */
static const char *mesh_of(const search *s, const char *vector) {
    for (int64_t i = 0; i < s->named.n; i++)
        if (strcmp(s->named.name[i], vector) == 0)
            return s->of.name[i];
    return NULL;
}

static void release_search(search *s) {
    io_hdf5_names_release(&s->named);
    io_hdf5_names_release(&s->of);
}

/* ---- vectors --------------------------------------------------------------------------------- */

/** Take in the vector if it is a copy; mesh: whose coordinates it is said to be, or NULL. */
static int look_at(search *s, const char *path, const char *mesh) {
    plex_reader *r = s->r;
    char copy[IO_HDF5_PATH_SIZE];
    const io_hdf5_place place = {copy, 0, r->model->columns, r->model->columns, 1};
    int is_copy = 0;
    if (strcmp(path, r->coordinates) == 0)
        return PLANISH_OK;
    int status = io_hdf5_path(r->file, copy, "%s", path);
    if (!status && s->n_more)
        *s->n_more +=
            mesh != NULL || io_hdf5_is_as_long(r->file, path, r->model->columns * r->n_nodes);
    if (status || s->n_more)
        return status;
    status = io_hdf5_coordinates_again(r->file, &place, &is_copy);
    if (!status && !is_copy && mesh)
        status = io_hdf5_fail(r->file, path,
                              "these are coordinates of '%s', too, but not the same values in the "
                              "same order as %s: they would stay behind; write a file that has "
                              "the coordinates of the nodes alone",
                              mesh, r->coordinates);
    return status;
}

static int visit_vector(search *s, const char *section, const char *name) {
    plex_reader *r = s->r;
    const char *mesh = mesh_of(s, name);
    char path[IO_HDF5_PATH_SIZE];
    int status = io_hdf5_path(r->file, path, "%s/vecs/%s/%s", section, name, name);
    if (status || io_hdf5_kind_of(r->file, path) != IO_HDF5_DATASET)
        return status;
    if (!s->vector)
        return look_at(s, path, mesh);
    if (mesh && !s->found) {
        s->found = 1;
        memcpy(s->vector, path, sizeof path);
        memcpy(s->section, section, strlen(section) + 1);
    }
    return PLANISH_OK;
}

static int visit_section(search *s, const char *section) {
    char group[IO_HDF5_PATH_SIZE];
    io_hdf5_names names = {0};
    int status = io_hdf5_path(s->r->file, group, "%s/vecs", section);
    if (!status && io_hdf5_kind_of(s->r->file, group) == IO_HDF5_GROUP)
        status = io_hdf5_list(s->r->file, group, &names);
    for (int64_t i = 0; i < names.n && !status; i++)
        status = visit_vector(s, section, names.name[i]);
    io_hdf5_names_release(&names);
    return status;
}

/** All vectors of the mesh, of whatever section. */
static int visit_vectors(search *s) {
    char group[IO_HDF5_PATH_SIZE], section[IO_HDF5_PATH_SIZE];
    io_hdf5_names names = {0};
    int status = io_hdf5_path(s->r->file, group, "%s/dms", s->r->root);
    if (!status && io_hdf5_kind_of(s->r->file, group) == IO_HDF5_GROUP)
        status = io_hdf5_list(s->r->file, group, &names);
    for (int64_t i = 0; i < names.n && !status; i++) {
        status = io_hdf5_path(s->r->file, section, "%s/%s", group, names.name[i]);
        if (!status)
            status = visit_section(s, section);
    }
    io_hdf5_names_release(&names);
    return status;
}

/* ---- the calls ------------------------------------------------------------------------------- */

int plex_find_function(plex_reader *r, char *section, int *found) {
    search s = {.r = r, .vector = r->coordinates, .section = section};
    int status = find_named(&s, r->root);
    if (!status && s.named.n > 0)
        status = visit_vectors(&s);
    *found = s.found;
    release_search(&s);
    return status;
}

/** Meshes that Firedrake has made of this one have coordinates of their own (extruded ones). */
static int check_others(plex_reader *r) {
    char topology[IO_HDF5_PATH_SIZE];
    io_hdf5_names names = {0};
    int status = io_hdf5_list(r->file, MESHES, &names);
    for (int64_t i = 0; i < names.n && !status; i++) {
        search s = {.r = r};
        status = io_hdf5_path(r->file, topology, MESHES "/%s", names.name[i]);
        if (!status && strcmp(topology, r->root) != 0)
            status = find_named(&s, topology);
        if (!status && s.named.n > 0)
            status = io_hdf5_fail(r->file, topology,
                                  "another mesh ('%s') with coordinates of its own is made of this "
                                  "one (extruded, say): they would stay behind; write the mesh to "
                                  "a file of its own",
                                  s.of.name[0]);
        release_search(&s);
    }
    io_hdf5_names_release(&names);
    return status;
}

/** n_more: count them, and look no closer; NULL: take them in. */
static int visit_copies(plex_reader *r, int *n_more) {
    static const char *const viewed[] = {"/geometry/vertices", "/viz/geometry/vertices"};
    search s = {.r = r, .n_more = n_more};
    int status = r->version > 1 ? check_others(r) : PLANISH_OK;
    if (!status && r->version > 1)
        status = find_named(&s, r->root);
    if (!status && r->version > 1)
        status = visit_vectors(&s);
    for (int i = 0; i < 2 && !status; i++)
        if (io_hdf5_kind_of(r->file, viewed[i]) == IO_HDF5_DATASET)
            status = look_at(&s, viewed[i], "the mesh");
    release_search(&s);
    return status;
}

int plex_read_copies(plex_reader *r) {
    return visit_copies(r, NULL);
}

int plex_count_copies(plex_reader *r, int *n) {
    *n = 0;
    return visit_copies(r, n);
}

#endif
