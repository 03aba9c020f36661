/* measure: the quality of a mesh for the caller, with a plan and without; its checksum. */
#include "sweep/sweep.h"

#include "base/checksum.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"
#include "quality/measure.h"
#include "topology/points.h"

#include <string.h>

/* ---- with a plan --------------------------------------------------------------------------- */

/** A call that measures. */
typedef struct measuring {
    pl_outside outside;
    double *room;    /* of x, owned, or NULL */
    const double *x; /* [.][dim] all coordinates that the plan knows */
} measuring;

/** Enter the plan and check the coordinates; end_measuring follows in any case. */
static int begin_measuring(const planish_plan *plan, const double *coordinates, measuring *m,
                           planish_error *error) {
    *m = (measuring){.outside = pl_call_enter(plan->context)};
    const pl_points points = pl_plan_all_points(plan, coordinates);
    const int status = pl_points_check(&points, plan->threads, error);
    if (status)
        return status;
    if (!pl_points_are_dense(&points)) {
        m->room = pl_alloc(points.n * points.dim, sizeof *m->room);
        if (!m->room)
            return pl_fail_memory(error, "the coordinates");
    }
    m->x = pl_plan_dense(plan, &points, m->room);
    return PLANISH_OK;
}

static int end_measuring(measuring *m, int status, planish_error *error) {
    pl_free(m->room);
    if (!status)
        status = pl_parts_check(error);
    pl_call_leave(&m->outside);
    return status;
}

int planish_measure(const planish_plan *plan, const double *coordinates, planish_quality *quality,
                    planish_error *error) {
    if (!plan || !coordinates || !quality)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "plan, coordinates and quality must not be NULL");
    measuring m;
    planish_quality found;
    int status = begin_measuring(plan, coordinates, &m, error);
    if (!status)
        status = pl_measure(plan->all, m.x, plan->threads, &found, error);
    status = end_measuring(&m, status, error);
    if (status)
        return status;
    const int32_t *row = pl_plan_rows(plan);
    if (row && found.worst_element >= 0)
        found.worst_element = row[found.worst_element];
    *quality = found;
    return PLANISH_OK;
}

/** Whether an element of the caller is one that plans measure. */
static int has_ratio(const planish_plan *plan, int64_t element) {
    return plan->cells.n == 0 || pl_is_smoothed(&plan->cells, element, plan->dim);
}

/** Give the caller the ratios of all elements. Those that are not known to the plan have none. */
static void give_ratios(const planish_plan *plan, const double *ratio, double *radius_ratio) {
    for (int64_t i = 0; i < pl_plan_given(plan); i++)
        radius_ratio[i] = has_ratio(plan, i) ? (double)NAN : 0;
    pl_plan_put(plan, ratio, sizeof *ratio, radius_ratio);
}

int planish_measure_elements(const planish_plan *plan, const double *coordinates,
                             double *radius_ratio, planish_error *error) {
    if (!plan || !coordinates || !radius_ratio)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "plan, coordinates and radius_ratio must not be NULL");
    measuring m;
    const pl_view all = pl_view_of_all_elements(plan->all);
    double *ratio = NULL; /* of the elements that are measured */
    int status = begin_measuring(plan, coordinates, &m, error);
    if (!status)
        status = pl_parts_check(error);
    if (!status) {
        ratio = pl_plan_rows(plan) ? pl_alloc(all.n_elements, sizeof *ratio) : radius_ratio;
        status = ratio ? PLANISH_OK : pl_fail_memory(error, "the radius ratios");
    }
    if (!status)
        pl_find_ratios(&all, m.x, plan->threads, ratio);
    if (!status && ratio != radius_ratio)
        give_ratios(plan, ratio, radius_ratio);
    if (ratio != radius_ratio)
        pl_free(ratio);
    return end_measuring(&m, status, error);
}

int planish_find_reversed(const planish_plan *plan, const double *coordinates, uint8_t *reversed,
                          int64_t *n, planish_error *error) {
    if (!plan || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "plan and coordinates must not be NULL");
    measuring m;
    uint8_t *state = NULL; /* of the elements that are measured */
    int64_t n_found = 0;
    int status = begin_measuring(plan, coordinates, &m, error);
    if (!status) {
        state = pl_alloc(plan->all->n_elements, sizeof *state);
        if (pl_parts_any(!state))
            status = pl_fail_memory(error, "the elements that are numbered the other way round");
        else
            n_found = pl_find_reversed(plan->all, m.x, plan->threads, state);
    }
    if (!status)
        status = pl_parts_check(error);
    if (!status && reversed) {
        memset(reversed, 0, (size_t)pl_plan_given(plan));
        pl_plan_put(plan, state, sizeof *state, reversed);
    }
    if (!status && n)
        *n = n_found;
    pl_free(state);
    return end_measuring(&m, status, error);
}

/* ---- without ------------------------------------------------------------------------------- */

int planish_measure_mesh(const planish_mesh *mesh, const planish_options *options,
                         planish_quality *quality, planish_error *error) {
    planish_plan *plan = NULL;
    if (!mesh || !quality)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh and quality must not be NULL");
    planish_mesh measured = *mesh;
    if (mesh->size && !mesh->metric && !mesh->is_layer && !(options && options->size_weight > 0)) {
        measured.size = NULL; /* which does not count: a plan would refuse it */
        measured.reference = NULL;
    }
    int status = planish_plan_create(&measured, options, &plan, error);
    if (!status)
        status = planish_measure(plan, mesh->coordinates, quality, error);
    planish_plan_destroy(plan);
    return status;
}

/* ---- the checksum -------------------------------------------------------------------------- */

uint64_t planish_checksum(const planish_mesh *mesh) {
    uint64_t checksum = 0;
    if (!mesh || !mesh->coordinates || pl_check_nodes(mesh, NULL))
        return 0;
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    for (int64_t i = 0; i < points.n; i++)
        for (int d = 0; d < points.dim; d++)
            checksum = pl_checksum_add(checksum, points.x[pl_point_at(&points, i, d)], d);
    return checksum;
}
