/* domain: what a plan works on: all of the mesh, or the subset of it around some nodes. */
#include "topology/walk.h"
#include "plan/draft.h"
#include "plan/targets.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/cells.h"
#include "topology/no_node.h"

#include <inttypes.h>
#include <math.h>

/** Copy the minimum volumes of the elements. */
static int copy_min_volumes(const pl_draft *d, planish_error *error) {
    planish_plan *plan = d->plan;
    const planish_mesh *mesh = d->mesh;
    if (!mesh->min_volume)
        return PLANISH_OK;
    double *min_volume = pl_alloc(plan->work.n_elements, sizeof *min_volume);
    plan->work.min_volume = min_volume;
    if (!min_volume)
        return pl_fail_memory(error, "the minimum volumes of the elements");
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        double least = mesh->min_volume[i];
        const int64_t element = pl_plan_element(plan, i);
        if (!(least >= 0) || !isfinite(least))
            return pl_fail_at(error, PLANISH_ERROR_MESH, element, -1,
                              "element %" PRId64
                              " has the minimum volume %g; give a finite number, "
                              "0 or more (0: none)",
                              element, least);
        min_volume[i] = least;
    }
    return PLANISH_OK;
}

/** Make the plan one for the subset of the mesh that has been found. plan->whole keeps all that the
 * plan knows of the whole mesh. */
static int narrow(pl_draft *d, const planish_mesh *mesh, pl_scope scope, planish_error *error) {
    planish_plan *plan = d->plan;
    plan->whole.n_nodes = mesh->n_nodes;
    plan->whole.n_elements = mesh->n_elements;
    int status = pl_submesh_create(mesh, &d->subset, plan->threads, &d->submesh, error);
    if (status)
        return status;
    d->mesh = &d->submesh.mesh;
    pl_free(d->is_selected);
    d->is_selected = d->subset.is_selected;
    plan->scope = scope;
    plan->work.n_nodes = d->subset.n_nodes;
    plan->work.n_elements = d->subset.n_elements;
    plan->work.elements = plan->own_elements = d->subset.elements;
    plan->node_of = d->subset.node;
    plan->element_of = d->subset.element;
    d->subset = (pl_subset){0};
    return copy_min_volumes(d, error);
}

/* ---- plans for a few nodes ---------------------------------------------------------------- */

static int check_around(const planish_mesh *mesh, const planish_options *options,
                        planish_error *error) {
    char there[PL_NODES_TEXT];
    if (options->n_around < 1)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.n_around is %" PRId64 "; give at least one node",
                       options->n_around);
    if (options->n_around > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.n_around is %" PRId64 "; it must be at most %" PRId32,
                       options->n_around, INT32_MAX);
    if (options->only_worse_than > 0 || options->min_volume_fraction > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.%s is about all of the mesh; do without options.around, or without "
                       "it",
                       options->only_worse_than > 0 ? "only_worse_than" : "min_volume_fraction");
    for (int64_t i = 0; i < options->n_around; i++)
        if (options->around[i] < 0 || options->around[i] >= mesh->n_nodes)
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, options->around[i],
                              "options.around[%" PRId64 "] is node %" PRId64
                              ", but the mesh has %s",
                              i, options->around[i], pl_nodes_there(mesh->n_nodes, there));
    return PLANISH_OK;
}

/** Keep what the plan has to know of cells of several types. */
static void keep_cells(pl_draft *d, const planish_mesh *mesh, pl_dense *dense) {
    if (!dense->role)
        return;
    d->plan->cells = *mesh->cells;
    d->plan->role = dense->role;
    dense->role = NULL;
}

/** Find the subset around options->around by passes over the mesh. */
static int find_around(const planish_mesh *mesh, pl_draft *d, planish_error *error) {
    const int threads = d->plan->threads;
    pl_dense dense;
    int status = pl_dense_create(mesh, threads, &dense, error);
    if (status)
        return status;
    uint8_t *selected = pl_alloc_zero(mesh->n_nodes, sizeof *selected);
    if (selected) {
        pl_select_around(&dense.mesh, &d->plan->work, d->options, threads, selected);
        status = pl_subset_by_marks(&dense.mesh, selected, threads, &d->subset, error);
    } else {
        status = pl_fail_memory(error, "the nodes that are worked on");
    }
    pl_free(selected);
    for (int64_t i = 0; dense.cell_of && i < d->subset.n_elements; i++)
        d->subset.element[i] = dense.cell_of[d->subset.element[i]];
    d->dense.constraint = dense.constraint;
    keep_cells(d, mesh, &dense);
    dense.constraint = NULL;
    pl_dense_destroy(&dense);
    return status;
}

/** Choose the nodes of options.around in all of the mesh, whose elements are corners: cells are not
 *  taken apart. */
static int select_around(const planish_mesh *mesh, pl_draft *d, planish_error *error) {
    const int status = check_around(mesh, d->options, error);
    d->is_selected = status ? NULL : pl_alloc_zero(mesh->n_nodes, sizeof *d->is_selected);
    if (d->is_selected)
        pl_select_around(&d->dense.mesh, &d->plan->work, d->options, d->plan->threads,
                         d->is_selected);
    return status || d->is_selected ? status
                                    : pl_fail_memory(error, "the nodes that are worked on");
}

/** Begin with the subset around the nodes of options.around. */
static int begin_around(const planish_mesh *mesh, pl_draft *d, planish_error *error) {
    const planish_options *options = d->options;
    const pl_seeds seeds = {options->n_around, options->around, options->around_elements};
    pl_submesh *submesh = &d->submesh;
    int status = pl_check_counts(mesh, error);
    if (!status)
        status = check_around(mesh, options, error);
    if (!status && seeds.element && (mesh->neighbours || mesh->neighbours64))
        status = pl_subset_by_walk(mesh, &seeds, options->rings, &d->subset, error);
    else if (!status)
        status = find_around(mesh, d, error);
    if (status)
        return status;
    const pl_subset subset = d->subset;
    planish_mesh whole = *mesh;
    if (d->dense.constraint)
        whole.constraint = d->dense.constraint;
    status = narrow(d, &whole, PL_SUBSET_ALONE, error);
    if (!status)
        status = pl_check_periodic(mesh, error);
    if (status || mesh->n_periodic == 0)
        return status;
    /* Nodes of periodic pairs stay: what is on the other side is not in the subset. */
    if (!submesh->constraint)
        submesh->mesh.constraint = submesh->constraint = pl_alloc_zero(subset.n_nodes, 1);
    if (!submesh->constraint)
        return pl_fail_memory(error, "periodic nodes");
    for (int64_t i = 0; i < 2 * mesh->n_periodic; i++) {
        const int64_t node = pl_subset_find_node(&subset, mesh->periodic[i]);
        if (node >= 0)
            submesh->constraint[node] = PLANISH_CONSTRAINT_FIXED;
    }
    return PLANISH_OK;
}

/* ---- the beginning ------------------------------------------------------------------------ */

/** Check that mesh and options have nothing that does not go together so far. */
static int check_together(const planish_mesh *mesh, const planish_options *options,
                          planish_error *error) {
    const char *field = mesh->is_layer ? "mesh.is_layer"
                        : mesh->size   ? "mesh.size"
                        : mesh->metric ? "mesh.metric"
                                       : "mesh.reference";
    if (mesh->part && (options->around || mesh->n_periodic > 0 || pl_has_targets(mesh)))
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "%s is not possible with a mesh in parts; do without it, or in one process",
                       options->around    ? "options.around"
                       : mesh->n_periodic ? "mesh.periodic"
                                          : field);
    if (pl_has_targets(mesh) && !mesh->is_layer && mesh->n_periodic > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s is not possible with mesh.periodic; leave out one of them", field);
    if (mesh->is_layer && (options->size_weight > 0 || pl_has_sizes(mesh)))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s is not possible with mesh.is_layer: layers have sizes of their own",
                       mesh->size     ? "mesh.size"
                       : mesh->metric ? "mesh.metric"
                                      : "options.size_weight");
    if (mesh->size && !(options->size_weight > 0))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.size_weight is 0, so that mesh.size would not count; give more, "
                       "such as 0.5");
    return PLANISH_OK;
}

int pl_draft_begin(const planish_mesh *mesh, pl_draft *d, planish_error *error) {
    planish_plan *plan = d->plan;
    int status = mesh->is_layer ? pl_check_counts(mesh, error) : PLANISH_OK;
    if (!status) {
        mesh = pl_drop_targets(mesh, &d->with_cells);
        status = check_together(mesh, d->options, error);
    }
    if (!status && pl_has_targets(mesh) && !mesh->cells) {
        status = pl_own_cells_make(mesh, plan->threads, &plan->own_cells, &d->cells, &d->with_cells,
                                   error);
        mesh = &d->with_cells;
    }
    if (status)
        return status;
    d->given = mesh;
    if (!d->options->around || mesh->cells)
        status = pl_dense_create(mesh, plan->threads, &d->dense, error);
    if (!status && d->options->around && !d->dense.corner) {
        pl_dense_destroy(&d->dense);
        return begin_around(mesh, d, error);
    }
    if (status)
        return status;
    d->mesh = &d->dense.mesh;
    plan->work.elements = d->mesh->elements;
    plan->work.n_elements = plan->whole.n_elements = d->mesh->n_elements;
    plan->own_elements = d->dense.elements;
    plan->cell_of = d->dense.cell_of;
    keep_cells(d, mesh, &d->dense);
    plan->work.corner = d->dense.corner;
    plan->work.cell_begin = d->dense.cell_begin;
    plan->work.n_cells = d->dense.n_cells;
    if (plan->work.corner)
        pl_corner_forms_make(plan->dim, plan->form);
    d->dense.elements = NULL;
    d->dense.cell_of = NULL;
    d->dense.corner = NULL;
    d->dense.cell_begin = NULL;
    status = pl_check_part(d->mesh, error);
    if (!status && d->options->around)
        status = select_around(mesh, d, error);
    return status ? status : copy_min_volumes(d, error);
}

/* ---- around bad elements ------------------------------------------------------------------ */

/** Make the plan one for the subset around the nodes that are selected; all of the mesh is measured
 *  all the same. */
static int narrow_to_bad(pl_draft *d, planish_error *error) {
    planish_plan *plan = d->plan;
    const planish_mesh *mesh = d->mesh;
    int status = PLANISH_OK;
    if (d->subset.n_elements == 0)
        status = pl_subset_by_marks(mesh, d->is_selected, plan->threads, &d->subset, error);
    if (status)
        return status;
    plan->whole = plan->work;
    plan->whole.sign = d->boundary.sign;
    plan->own_whole_elements = plan->own_elements;
    plan->own_elements = NULL;
    plan->work.min_volume = NULL;
    d->boundary.sign = NULL;
    plan->whole.mobility = d->whole_mobility = pl_alloc_zero(mesh->n_nodes, 1);
    plan->scratch.is_movable = pl_alloc_zero(mesh->n_elements, 1);
    plan->all = &plan->whole;
    if (!d->whole_mobility || !plan->scratch.is_movable)
        return pl_fail_memory(error, "the subset of the mesh that is worked on");
    plan->info.n_negative_order = d->boundary.n_reversed;
    return narrow(d, mesh, PL_SUBSET_OF_ALL, error);
}

/** Elements that get the signs of their cells. */
typedef struct sign_copy {
    const planish_plan *plan;
    const int8_t *of_cell;
    int8_t *sign;
    int64_t n_reversed; /* shared */
} sign_copy;

static void count_reversed(void *context, int64_t begin, int64_t end, int thread) {
    sign_copy *c = context;
    const pl_view *v = &c->plan->work;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        n += c->of_cell[c->plan->cell_of[v->cell_begin[i]]] < 0;
    __atomic_fetch_add(&c->n_reversed, n, __ATOMIC_RELAXED);
}

static void copy_signs(void *context, int64_t begin, int64_t end, int thread) {
    const sign_copy *c = context;
    (void)thread;
    for (int64_t e = begin; e < end; e++)
        c->sign[e] = c->of_cell[c->plan->cell_of[e]];
}

/** Give the elements the signs of their cells, if one is reversed. */
static int sign_corners(const planish_plan *plan, const int8_t *of_cell, pl_boundary *b,
                        planish_error *error) {
    enum { CHUNK = 8192 };
    sign_copy copy = {.plan = plan, .of_cell = of_cell};
    pl_parallel_for(plan->threads, plan->work.n_cells, CHUNK, count_reversed, &copy);
    b->n_reversed = copy.n_reversed;
    if (copy.n_reversed == 0)
        return PLANISH_OK;
    b->sign = copy.sign = pl_alloc(plan->work.n_elements, sizeof *copy.sign);
    if (!b->sign)
        return pl_fail_memory(error, "the orientation of elements");
    pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK, copy_signs, &copy);
    return PLANISH_OK;
}

/** Find the boundary and the orientation of a mesh whose elements are corners, by its cells. */
static int find_boundary_of_cells(pl_draft *d, planish_error *error) {
    const planish_mesh *mesh = d->mesh;
    planish_plan *plan = d->plan;
    pl_boundary *b = &d->boundary;
    pl_cell_census census;
    int status = pl_cell_census_find(&plan->cells, plan->dim, mesh->n_nodes, mesh->coordinates,
                                     plan->threads, &census, error);
    if (status)
        return status;
    *b = (pl_boundary){.on_boundary = census.on_boundary,
                       .n_boundary_facets = census.n_boundary_facets,
                       .n_nonmanifold_facets = census.n_nonmanifold_facets,
                       .n_duplicate_elements = census.n_duplicate_elements};
    census.on_boundary = NULL;
    status = sign_corners(plan, census.sign, b, error);
    pl_cell_census_destroy(&census);
    return status;
}

/** Make the targets of the plan's elements, from the sizes, the layers or the reference of the given
 *  mesh. */
static int make_targets(pl_draft *d, planish_error *error) {
    d->plan->work.size_weight = d->options->size_weight;
    if (pl_has_sizes(d->given))
        return pl_size_targets_make(d->plan, d->given, d->dense.mesh.coordinates, error);
    if (d->given->is_layer)
        return pl_layer_targets_make(d->plan, d->given, error);
    return pl_targets_make(d->plan, pl_points_of(d->given, d->given->reference), d->boundary.sign,
                           error);
}

int pl_draft_choose_scope(pl_draft *d, planish_error *error) {
    /* A subset pays if one node in so many is selected: each brings some 20 elements along. */
    enum { SHARE = 4 };
    const int threads = d->plan->threads, selective = d->options->only_worse_than > 0;
    if (d->plan->work.corner) {
        int found = find_boundary_of_cells(d, error);
        if (!found && pl_has_targets(d->given))
            found = make_targets(d, error);
        return found || !selective ? found : pl_draft_select(d, error);
    }
    int status = selective ? pl_draft_select(d, error) : PLANISH_OK;
    if (!status)
        status = pl_boundary_create(d->mesh, d->all_positive, threads, &d->boundary, error);
    if (!status && selective && d->boundary.sign)
        status = pl_draft_select(d, error);
    if (status || !selective || !d->all_positive || d->mesh->n_periodic > 0 || d->mesh->part)
        return status;
    int64_t n = 0;
    for (int64_t i = 0; i < d->mesh->n_nodes; i++)
        n += d->is_selected[i] != 0;
    if (n > d->mesh->n_nodes / SHARE)
        return PLANISH_OK;
    status = narrow_to_bad(d, error);
    pl_boundary_destroy(&d->boundary);
    if (status)
        return status;
    return pl_boundary_create(d->mesh, !d->plan->whole.sign, threads, &d->boundary, error);
}
