/* plex_labels: what labels of a DMPlex say of its points.
 *
 * A label gives points values; those of one value are a set, whose name is that of the label, and
 * LABEL:VALUE. What a set is of is told by its points of the highest dimension, as labels often
 * have all that bounds these, too: sets of elements are regions, those of facets surfaces (in 2-D
 * lines), in 3-D those of edges lines; those of nodes are no more than groups. By convention the
 * labels "Cell Sets", "Face Sets" and "Edge Sets" are of these kinds; others are, too.
 */
#ifdef PL_HDF5
#include "io/core/memberships.h"
#include "io/plex/plex.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/** What PETSc and Firedrake note of points for themselves. */
static const char *const notes[] = {"celltype",    "depth",           "ghost",
                                    "vtk",         "interior_facets", "pyop2_core",
                                    "pyop2_owned", "pyop2_ghost",     "exterior_facets"};

static const char regions[] = "Cell Sets";

/* Labels that list all points so many times over are no mesh's. */
enum { MOST_LISTINGS = 64 };

/** Points with one value of a label. */
typedef struct set {
    char *label, *value; /* owned */
    io_hdf5_integers points;
    int dim; /* the highest of its points */
} set;

typedef struct labels {
    plex_reader *r;
    set *set; /* [n] */
    int64_t n, capacity;
    int64_t listed; /* points in all sets */
    int dim;        /* the kind of things whose sets are being told: cells of the model; 0: nodes */
} labels;

/* ---- sets ----------------------------------------------------------------------------------- */

static int is_note(const char *label) {
    for (size_t i = 0; i < sizeof notes / sizeof *notes; i++)
        if (strcmp(label, notes[i]) == 0)
            return 1;
    return 0;
}

/** Its points are points; and of which dimension they are. */
static int look_at_points(plex_reader *r, const char *path, set *s) {
    for (int64_t i = 0; i < s->points.n; i++) {
        const int64_t point = io_hdf5_integer(&s->points, i);
        if (point < 0 || point >= r->n_points)
            return io_hdf5_fail(r->file, path, "point %lld is not in 0 .. %lld", (long long)point,
                                (long long)r->n_points - 1);
        const int dim = plex_dim_of(r, point);
        s->dim = dim > s->dim ? dim : s->dim;
    }
    return PLANISH_OK;
}

/** Takes over label and value, which are NULL then. */
static int add_set(labels *l, const char *path, char **label, char **value) {
    plex_reader *r = l->r;
    char points[IO_HDF5_PATH_SIZE];
    set *grown = pl_grow(l->set, l->n, l->n + 1, &l->capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(r->error, "the labels of the file");
    l->set = grown;
    set *s = &l->set[l->n++];
    *s = (set){.label = *label, .value = *value};
    *label = *value = NULL;
    int status = io_hdf5_path(r->file, points, "%s/indices", path);
    if (!status && io_hdf5_kind_of(r->file, points) != IO_HDF5_NONE) /* else it has no points */
        status = io_hdf5_integers_read(r->file, points, &s->points);
    /* So many as stand in the file may be there in any case. */
    const int64_t most = MOST_LISTINGS * r->n_points + r->model->input.size / 4;
    if (!status && s->points.n > most - l->listed)
        status = io_hdf5_fail(r->file, points,
                              "labels up to this one list all points more than %d times over; the "
                              "file is damaged",
                              MOST_LISTINGS);
    l->listed += s->points.n;
    return status ? status : look_at_points(r, points, s);
}

static int read_label(labels *l, const char *group, const char *label) {
    plex_reader *r = l->r;
    char path[IO_HDF5_PATH_SIZE], of_value[IO_HDF5_PATH_SIZE];
    io_hdf5_names values = {0};
    int status = io_hdf5_path(r->file, path, "%s/%s", group, label);
    if (!status && io_hdf5_kind_of(r->file, path) == IO_HDF5_GROUP)
        status = io_hdf5_list(r->file, path, &values);
    for (int64_t i = 0; i < values.n && !status; i++) {
        status = io_hdf5_path(r->file, of_value, "%s/%s", path, values.name[i]);
        if (status || io_hdf5_kind_of(r->file, of_value) != IO_HDF5_GROUP)
            continue;
        char *copy = pl_copy_text(label);
        status = copy ? add_set(l, of_value, &copy, &values.name[i])
                      : pl_fail_memory(r->error, "the labels of the file");
        pl_free(copy);
    }
    io_hdf5_names_release(&values);
    return status;
}

static int list_labels(plex_reader *r, char *group, io_hdf5_names *names) {
    *names = (io_hdf5_names){0};
    const int status = io_hdf5_path(r->file, group, "%s/labels", r->root);
    return status || io_hdf5_kind_of(r->file, group) != IO_HDF5_GROUP
               ? status
               : io_hdf5_list(r->file, group, names);
}

static int read_sets(labels *l, int with_notes) {
    char group[IO_HDF5_PATH_SIZE];
    io_hdf5_names names;
    int status = list_labels(l->r, group, &names);
    for (int64_t i = 0; i < names.n && !status; i++)
        if (with_notes || !is_note(names.name[i]))
            status = read_label(l, group, names.name[i]);
    io_hdf5_names_release(&names);
    return status;
}

static void release_sets(labels *l) {
    for (int64_t i = 0; i < l->n; i++) {
        pl_free(l->set[i].label);
        pl_free(l->set[i].value);
        io_hdf5_integers_release(&l->set[i].points);
    }
    pl_free(l->set);
}

/** Whether a set is of elements alone, none of which another one has: seen [n_elements]. */
static int is_of_new_elements(const plex_reader *r, const set *s, uint8_t *seen) {
    for (int64_t k = 0; k < s->points.n; k++) {
        const int64_t point = io_hdf5_integer(&s->points, k);
        if (point >= r->n_elements || seen[point])
            return 0;
        seen[point] = 1;
    }
    return 1;
}

/** Whether a set is a region, as PETSc reads it: of -1 it reads nothing, as that is no set. */
static int is_region(const plex_reader *r, const set *s, uint8_t *seen) {
    return strcmp(s->label, regions) == 0 && strcmp(s->value, "-1") != 0 &&
           is_of_new_elements(r, s, seen);
}

static int check_labels(labels *l, uint8_t *seen, int *has_regions_alone) {
    const int status = read_sets(l, 1);
    *has_regions_alone = 1;
    for (int64_t i = 0; i < l->n && !status && *has_regions_alone; i++)
        *has_regions_alone = is_note(l->set[i].label) || is_region(l->r, &l->set[i], seen);
    return status;
}

int plex_check_labels(plex_reader *r, int *has_regions_alone) {
    labels l = {.r = r};
    uint8_t *seen = pl_alloc_zero(r->n_elements, 1);
    const int status = seen ? check_labels(&l, seen, has_regions_alone)
                            : pl_fail_memory(r->error, "the labels of the file");
    release_sets(&l);
    pl_free(seen);
    return status;
}

/* ---- surfaces and lines --------------------------------------------------------------------- */

/** Points of the sets of dimension dim become cells. */
static int make_cells(labels *l, int dim, io_cells *cells) {
    plex_reader *r = l->r;
    int64_t n = 0;
    for (int64_t i = 0; i < l->n; i++)
        n += l->set[i].dim == dim ? l->set[i].points.n : 0;
    int status = n > 0 ? io_cells_reserve(cells, dim, n, 1, 0, r->error) : PLANISH_OK;
    for (int64_t i = 0; i < l->n && !status; i++) {
        const io_hdf5_integers *points = &l->set[i].points;
        for (int64_t k = 0; l->set[i].dim == dim && k < points->n && !status; k++)
            if (plex_dim_of(r, io_hdf5_integer(points, k)) == dim)
                status = plex_add_cell(r, io_hdf5_integer(points, k));
    }
    return status;
}

/* ---- entities and groups -------------------------------------------------------------------- */

/** What is in a set: its points of the highest dimension, if they are cells; else their nodes. */
static int add_members_of(labels *l, int64_t index, io_memberships *m) {
    const plex_reader *r = l->r;
    const set *s = &l->set[index];
    const int32_t tag = (int32_t)index + 1;
    for (int64_t k = 0; k < s->points.n; k++) {
        int32_t node[PLEX_MOST_NODES];
        const int64_t point = io_hdf5_integer(&s->points, k), cell = r->of_point[point];
        if (plex_dim_of(r, point) != s->dim)
            continue;
        if (cell >= 0 && l->dim == s->dim)
            io_memberships_add(m, cell, tag);
        if (cell >= 0 || l->dim > 0)
            continue;
        const int n = plex_nodes_of(r, point, node);
        if (n < 0)
            return plex_fail_point(l->r, point);
        for (int i = 0; i < n; i++)
            io_memberships_add(m, node[i], tag);
    }
    return PLANISH_OK;
}

static int add_members(labels *l, io_memberships *m) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < l->n && !status; i++)
        status = add_members_of(l, i, m);
    return status;
}

/** The sets of all cells of a dimension, or nodes (0). */
static int collect(labels *l, int dim, int64_t n, io_memberships *m) {
    l->dim = dim;
    int status = io_memberships_begin(m, n, l->r->error);
    if (!status)
        status = add_members(l, m);
    if (!status)
        status = io_memberships_counted(m, l->r->error);
    return status ? status : add_members(l, m);
}

static int make_cell_entities(labels *l, int dim, io_cells *cells) {
    io_memberships m = {.n = 0};
    int32_t last = -1;
    int status = collect(l, dim, cells->n, &m);
    for (int64_t i = 0; i < cells->n && !status; i++) {
        last = io_memberships_entity(&m, l->r->model, i, dim, 0, last, l->r->error);
        cells->entity[i] = last;
        status = last < 0 ? last : PLANISH_OK;
    }
    io_memberships_destroy(&m);
    return status;
}

static int make_node_entities(labels *l) {
    io_memberships m = {.n = 0};
    int status = collect(l, 0, l->r->n_nodes, &m);
    if (!status)
        status = io_memberships_of_nodes(&m, l->r->model, l->r->error);
    io_memberships_destroy(&m);
    return status;
}

static int has_cells(const labels *l, const set *s, int are_cells) {
    for (int64_t k = 0; k < s->points.n; k++) {
        const int64_t point = io_hdf5_integer(&s->points, k);
        if (plex_dim_of(l->r, point) == s->dim && (l->r->of_point[point] >= 0) == are_cells)
            return 1;
    }
    return 0;
}

static int add_group(labels *l, int dim, int64_t index, const char *name) {
    return io_model_group(l->r->model, dim, (int32_t)index + 1, name, (int64_t)strlen(name),
                          l->r->error);
}

/** LABEL:VALUE, and LABEL for all values: of cells, and of nodes, which have dimension 0. */
static int name_set(labels *l, int64_t index) {
    const set *s = &l->set[index];
    const int dims[] = {s->dim, 0};
    char name[IO_HDF5_PATH_SIZE];
    int status = io_hdf5_path(l->r->file, name, "%s:%s", s->label, s->value);
    for (int i = 0; i < 2 && !status; i++) {
        if (!has_cells(l, s, i == 0))
            continue;
        status = add_group(l, dims[i], index, name);
        if (!status)
            status = add_group(l, dims[i], index, s->label);
    }
    return status;
}

static int make_groups(labels *l) {
    io_model *model = l->r->model;
    io_cells *const cells[] = {NULL, &model->line, &model->triangle, &model->tetrahedron};
    int status = PLANISH_OK;
    model->groups_by_name = 1;
    for (int dim = l->r->dim - 1; dim > 0 && !status; dim--)
        status = make_cells(l, dim, cells[dim]);
    for (int dim = l->r->dim; dim > 0 && !status; dim--)
        if (cells[dim]->n > 0)
            status = make_cell_entities(l, dim, cells[dim]);
    if (!status && l->n > 0)
        status = make_node_entities(l);
    for (int64_t i = 0; i < l->n && !status; i++)
        status = name_set(l, i);
    return status;
}

int plex_read_labels(plex_reader *r) {
    labels l = {.r = r};
    int status = read_sets(&l, 0);
    if (!status)
        status = make_groups(&l);
    release_sets(&l);
    return status;
}

#endif
