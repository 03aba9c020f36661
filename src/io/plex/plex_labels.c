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
#include "io/plex/plex_reader.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/** Labels that PETSc and Firedrake make for themselves. */
static const char *const notes[] = {"celltype",    "depth",           "ghost",
                                    "vtk",         "interior_facets", "pyop2_core",
                                    "pyop2_owned", "pyop2_ghost",     "exterior_facets"};

static const char regions[] = "Cell Sets";

/* Labels that list all points so many times over are no mesh's. */
enum { MOST_LISTINGS = 64 };

/** Points with one value of a label. */
typedef struct label_set {
    const char *label, *value;
    io_hdf5_integers points;
    int dim; /* the highest of its points */
} label_set;

typedef struct labels {
    plex_reader *r;
    label_set *set; /* [n] */
    int64_t n, capacity;
    int64_t listed; /* points in all sets */
} labels;

/* ---- sets ----------------------------------------------------------------------------------- */

static int is_note(const char *label) {
    for (size_t i = 0; i < sizeof notes / sizeof *notes; i++)
        if (strcmp(label, notes[i]) == 0)
            return 1;
    return 0;
}

/** Read the points of a set, in the group at path, and find its dimension. */
static int read_set(labels *l, label_set *s, const char *path) {
    plex_reader *r = l->r;
    const io_hdf5_path points = io_hdf5_path_of(r->file, "%s/indices", path);
    int status = PLANISH_OK;
    if (io_hdf5_kind_of(r->file, points.text) != IO_HDF5_NONE) /* else it has no points */
        status = io_hdf5_integers_read(r->file, points.text, &s->points);
    /* So many as stand in the file may be there in any case. */
    const int64_t most = MOST_LISTINGS * r->n_points + r->model->input.size / 4;
    if (!status && s->points.n > most - l->listed)
        return io_hdf5_fail(r->file, points.text,
                            "labels up to this one list all points more than %d times over; the "
                            "file is damaged",
                            MOST_LISTINGS);
    l->listed += s->points.n;
    for (int64_t i = 0; i < s->points.n && !status; i++) {
        const int64_t point = io_hdf5_integer(&s->points, i);
        if (point < 0 || point >= r->n_points)
            return io_hdf5_fail(r->file, points.text, "point %lld is not in 0 .. %lld",
                                (long long)point, (long long)r->n_points - 1);
        const int dim = plex_dim_of(r, point);
        s->dim = dim > s->dim ? dim : s->dim;
    }
    return status;
}

/** Read the sets of all labels, with or without those that programs make for themselves. */
static int read_sets(labels *l, int with_notes) {
    plex_reader *r = l->r;
    io_hdf5_path group, label;
    io_hdf5_names names, values;
    int status = plex_list_group(r, r->root.text, "labels", &group, &names);
    for (int64_t i = 0; i < names.n && !status; i++) {
        if (!with_notes && is_note(names.name[i]))
            continue;
        status = plex_list_group(r, group.text, names.name[i], &label, &values);
        for (int64_t k = 0; k < values.n && !status; k++) {
            const io_hdf5_path value =
                io_hdf5_path_of(r->file, "%s/%s", label.text, values.name[k]);
            if (io_hdf5_kind_of(r->file, value.text) != IO_HDF5_GROUP)
                continue;
            const label_set named = {.label = names.name[i], .value = values.name[k]};
            label_set *s = pl_append(&l->set, &l->n, &l->capacity, &named, sizeof named);
            status =
                s ? read_set(l, s, value.text) : pl_fail_memory(r->error, "the labels of the file");
        }
    }
    return status;
}

static void release_sets(labels *l) {
    for (int64_t i = 0; i < l->n; i++)
        io_hdf5_integers_release(&l->set[i].points);
    pl_free(l->set);
}

int plex_check_labels(plex_reader *r, int *has_regions_alone) {
    labels l = {.r = r};
    uint8_t *seen = pl_alloc_zero(r->n_elements, 1); /* elements that a region has */
    const int status = seen ? read_sets(&l, 1) : pl_fail_memory(r->error, "the labels of the file");
    int is_good = 1;
    for (int64_t i = 0; i < l.n && !status && is_good; i++) {
        const label_set *s = &l.set[i];
        if (is_note(s->label))
            continue;
        /* PETSc reads nothing of -1, as that is no set. */
        is_good = strcmp(s->label, regions) == 0 && strcmp(s->value, "-1") != 0;
        for (int64_t k = 0; k < s->points.n && is_good; k++) {
            const int64_t point = io_hdf5_integer(&s->points, k);
            is_good = point < r->n_elements && !seen[point];
            if (is_good)
                seen[point] = 1;
        }
    }
    *has_regions_alone = is_good;
    release_sets(&l);
    pl_free(seen);
    return status;
}

/* ---- cells, entities and groups ------------------------------------------------------------- */

/** Add the members of a set: its points of the highest dimension, as far as they are cells of dim;
 *  with dim 0 the nodes of those that are no cells. */
static int add_members(const labels *l, int64_t index, int dim, io_memberships *m) {
    plex_reader *r = l->r;
    const label_set *s = &l->set[index];
    const int32_t tag = (int32_t)index + 1;
    for (int64_t k = 0; k < s->points.n; k++) {
        int32_t node[PLEX_MOST_NODES];
        const int64_t point = io_hdf5_integer(&s->points, k), cell = r->of_point[point];
        if (plex_dim_of(r, point) != s->dim)
            continue;
        if (cell >= 0 && dim == s->dim)
            io_memberships_add(
                m, cell + (plex_list_of(r, point) == dim ? 0 : io_model_cells(r->model, dim)->n),
                tag);
        if (cell >= 0 || dim > 0)
            continue;
        const int n = plex_nodes_of(r, point, node);
        if (n < 0)
            return plex_fail_point(r, point);
        for (int i = 0; i < n; i++)
            io_memberships_add(m, node[i], tag);
    }
    return PLANISH_OK;
}

/** Make the entities of all elements of a dimension, or of nodes (0), by the sets that each is in. */
static int make_entities(labels *l, int dim) {
    io_model *model = l->r->model;
    io_cells *cells = dim > 0 ? io_model_cells(model, dim) : NULL;
    const io_others *others = dim > 1 ? io_model_others(model, dim) : NULL;
    const int64_t n_others = others ? others->n : 0;
    io_memberships m = {.n = 0};
    int status = io_memberships_begin(&m, cells ? cells->n + n_others : l->r->n_nodes, l->r->error);
    for (int pass = 0; pass < 2 && !status; pass++) {
        for (int64_t i = 0; i < l->n && !status; i++)
            status = add_members(l, i, dim, &m);
        if (pass == 0 && !status)
            status = io_memberships_counted(&m, l->r->error);
    }
    if (!status && !cells)
        status = io_memberships_of_nodes(&m, model, l->r->error);
    if (!status && cells)
        status =
            io_memberships_entities(&m, model, dim, 0, cells->n, NULL, cells->entity, l->r->error);
    if (!status && n_others > 0)
        status = io_memberships_entities(&m, model, dim, cells->n, n_others, NULL, others->entity,
                                         l->r->error);
    io_memberships_destroy(&m);
    return status;
}

/** Name a set LABEL:VALUE, and LABEL for all values: its cells, and its nodes, which have dimension
 *  0. */
static int name_set(const labels *l, int64_t index) {
    const plex_reader *r = l->r;
    const label_set *s = &l->set[index];
    const io_hdf5_path name = io_hdf5_path_of(r->file, "%s:%s", s->label, s->value);
    const char *const names[] = {name.text, s->label};
    int has_cells = 0, has_nodes = 0;
    for (int64_t k = 0; k < s->points.n; k++) {
        const int64_t point = io_hdf5_integer(&s->points, k);
        if (plex_dim_of(r, point) == s->dim)
            *(r->of_point[point] >= 0 ? &has_cells : &has_nodes) = 1;
    }
    int status = PLANISH_OK;
    for (int i = 0; i < 4 && !status; i++)
        if (i < 2 ? has_cells : has_nodes)
            status = io_model_group(r->model, i < 2 ? s->dim : 0, (int32_t)index + 1, names[i % 2],
                                    (int64_t)strlen(names[i % 2]), r->error);
    return status;
}

int plex_read_labels(plex_reader *r) {
    labels l = {.r = r};
    int status = read_sets(&l, 0);
    r->model->groups_by_name = 1;
    /* Points of sets of lower dimension become cells. */
    for (int64_t i = 0; i < l.n && !status; i++) {
        const int dim = l.set[i].dim;
        const io_hdf5_integers *points = &l.set[i].points;
        if (dim == 0 || dim == r->dim)
            continue;
        status = io_cells_reserve(r->model, dim, points->n, 1, 0, r->error);
        for (int64_t k = 0; k < points->n && !status; k++)
            if (plex_dim_of(r, io_hdf5_integer(points, k)) == dim)
                status = plex_add_cell(r, io_hdf5_integer(points, k));
    }
    for (int dim = r->dim; dim > 0 && !status; dim--)
        if (io_model_cells(r->model, dim)->n + (dim > 1 ? io_model_others(r->model, dim)->n : 0) >
            0)
            status = make_entities(&l, dim);
    if (!status && l.n > 0)
        status = make_entities(&l, 0);
    for (int64_t i = 0; i < l.n && !status; i++)
        status = name_set(&l, i);
    release_sets(&l);
    return status;
}

#endif
