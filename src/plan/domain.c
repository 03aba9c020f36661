/* domain: what a plan works on: all of the mesh, or the subset of it around some nodes. */
#include "plan/draft.h"
#include "plan/select.h"

#include "base/memory.h"
#include "base/status.h"

#include <inttypes.h>
#include <math.h>

/** A copy of the elements' minimum volumes. */
static int copy_min_volumes(planish_plan *plan, const planish_mesh *mesh, planish_error *error) {
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
                              "0 for none",
                              element, least);
        min_volume[i] = least;
    }
    return PLANISH_OK;
}

/** From now on the plan is for the subset of the mesh that has been found; of all of it is known
 * what is in plan->whole. */
static int narrow(planish_plan *plan, pl_draft *d, const planish_mesh *mesh, pl_scope scope,
                  planish_error *error) {
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
    return copy_min_volumes(plan, d->mesh, error);
}

/** Refuse options that do not work, so far, where other processes have parts of the mesh.
 *  Errors: _PARTS. */
static int check_alone(const planish_mesh *mesh, const planish_options *options,
                       planish_error *error) {
    const char *what = options->around        ? "options.around"
                       : mesh->n_periodic > 0 ? "mesh.periodic"
                                              : NULL;
    return what && mesh->part
               ? pl_fail(
                     error, PLANISH_ERROR_PARTS,
                     "%s is not possible with a mesh in parts; do without it, or in one process",
                     what)
               : PLANISH_OK;
}

/** The draft for all of the mesh. */
static int take_all(planish_plan *plan, const planish_mesh *mesh, pl_draft *d,
                    planish_error *error) {
    int status = pl_dense_create(mesh, plan->threads, &d->dense, error);
    if (status)
        return status;
    d->mesh = &d->dense.mesh;
    plan->work.elements = d->mesh->elements;
    plan->own_elements = d->dense.elements;
    d->dense.elements = NULL;
    status = pl_check_part(d->mesh, error);
    return status ? status : copy_min_volumes(plan, d->mesh, error);
}

/* ---- plans for a few nodes ---------------------------------------------------------------- */

static int check_around(const planish_mesh *mesh, const planish_options *options,
                        planish_error *error) {
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
                              ", but the mesh has the nodes 0 to %" PRId64,
                              i, options->around[i], mesh->n_nodes - 1);
    return PLANISH_OK;
}

/** The subset by passes over the mesh. */
static int find_around(const planish_plan *plan, const planish_mesh *mesh, pl_draft *d,
                       planish_error *error) {
    const planish_options *options = d->options;
    pl_dense dense;
    int status = pl_dense_create(mesh, plan->threads, &dense, error);
    if (status)
        return status;
    uint8_t *selected = pl_alloc_zero(mesh->n_nodes, sizeof *selected);
    if (selected) {
        pl_select_around(&dense.mesh, options, plan->threads, selected);
        status = pl_subset_by_marks(&dense.mesh, selected, plan->threads, &d->subset, error);
    } else {
        status = pl_fail_memory(error, "the nodes that are worked on");
    }
    pl_free(selected);
    pl_dense_destroy(&dense);
    return status;
}

/** Nodes of periodic pairs stay: what is on the other side is not in the subset. */
static int hold_paired(const planish_mesh *mesh, const pl_subset *subset, pl_submesh *submesh,
                       planish_error *error) {
    int status = pl_check_periodic(mesh, error);
    if (status || mesh->n_periodic == 0)
        return status;
    if (!submesh->constraint)
        submesh->mesh.constraint = submesh->constraint = pl_alloc_zero(subset->n_nodes, 1);
    if (!submesh->constraint)
        return pl_fail_memory(error, "periodic nodes");
    for (int64_t i = 0; i < 2 * mesh->n_periodic; i++) {
        const int64_t node = pl_subset_find_node(subset, mesh->periodic[i]);
        if (node >= 0)
            submesh->constraint[node] = PLANISH_FIXED;
    }
    return PLANISH_OK;
}

/** The draft for what is around the nodes of options.around. */
static int take_around(planish_plan *plan, const planish_mesh *mesh, pl_draft *d,
                       planish_error *error) {
    const planish_options *options = d->options;
    const pl_seeds seeds = {options->n_around, options->around, options->around_elements};
    int status = pl_check_counts(mesh, error);
    if (!status)
        status = check_around(mesh, options, error);
    if (!status && seeds.element && (mesh->neighbours || mesh->neighbours64))
        status = pl_subset_by_walk(mesh, &seeds, options->rings, &d->subset, error);
    else if (!status)
        status = find_around(plan, mesh, d, error);
    if (status)
        return status;
    const pl_subset subset = d->subset;
    status = narrow(plan, d, mesh, PL_SUBSET_ALONE, error);
    return status ? status : hold_paired(mesh, &subset, &d->submesh, error);
}

/* ---- the beginning ------------------------------------------------------------------------ */

int pl_draft_begin(planish_plan *plan, const planish_mesh *mesh, pl_draft *d,
                   planish_error *error) {
    const int status = check_alone(mesh, d->options, error);
    if (status)
        return status;
    return d->options->around ? take_around(plan, mesh, d, error) : take_all(plan, mesh, d, error);
}

/* ---- around bad elements ------------------------------------------------------------------ */

/** The plan is then for the subset around the nodes that are selected; all of the mesh is measured
 *  all the same. */
static int narrow_to_bad(planish_plan *plan, pl_draft *d, planish_error *error) {
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
    plan->is_movable = pl_alloc_zero(mesh->n_elements, 1);
    plan->all = &plan->whole;
    if (!d->whole_mobility || !plan->is_movable)
        return pl_fail_memory(error, "the subset of the mesh that is worked on");
    plan->info.n_reversed = d->boundary.n_reversed;
    return narrow(plan, d, mesh, PL_SUBSET_OF_ALL, error);
}

int pl_draft_select(planish_plan *plan, pl_draft *d, int *all_positive, planish_error *error) {
    if (!d->is_selected)
        d->is_selected = pl_alloc(plan->work.n_nodes, sizeof *d->is_selected);
    if (!d->is_selected)
        return pl_fail_memory(error, "the nodes of bad elements");
    plan->is_selective = 1;
    pl_subset_destroy(&d->subset);
    return pl_select(d->mesh, d->boundary.sign, d->options, plan->threads, d->is_selected,
                     all_positive, &d->subset, error);
}

/** Whether so few nodes are selected that to work on their subset of the mesh pays: each brings
 * some 20 elements along. */
static int are_few(const pl_draft *d) {
    enum { SHARE = 4 };
    int64_t n = 0;
    for (int64_t i = 0; i < d->mesh->n_nodes; i++)
        n += d->is_selected[i] != 0;
    return n <= d->mesh->n_nodes / SHARE;
}

int pl_draft_look_at_measures(planish_plan *plan, pl_draft *d, planish_error *error) {
    const int selective = d->options->only_worse_than > 0;
    int all_positive = 0, status = PLANISH_OK;
    if (selective)
        status = pl_draft_select(plan, d, &all_positive, error);
    if (!status)
        status = pl_boundary_create(d->mesh, all_positive, plan->threads, &d->boundary, error);
    if (!status && selective && d->boundary.sign)
        status = pl_draft_select(plan, d, &all_positive, error);
    if (status || !selective || !all_positive || d->mesh->n_periodic > 0 || d->mesh->part ||
        !are_few(d))
        return status;
    status = narrow_to_bad(plan, d, error);
    pl_boundary_destroy(&d->boundary);
    return status
               ? status
               : pl_boundary_create(d->mesh, !plan->whole.sign, plan->threads, &d->boundary, error);
}
