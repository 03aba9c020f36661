/* measure: the quality of a mesh for the caller, with a plan and without; its checksum. */
#include "sweep/sweep.h"

#include "base/checksum.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"
#include "quality/measure.h"

#include <string.h>

/* ---- with a plan --------------------------------------------------------------------------- */

/** Measure all of the mesh if the plan knows that, else its part. */
static int measure(const planish_plan *plan, const double *coordinates, planish_quality *quality,
                   planish_error *error) {
    const int status = pl_measure(plan->all, coordinates, plan->threads, quality, error);
    if (!status && plan->all == &plan->work && quality->worst_element >= 0)
        quality->worst_element = pl_plan_element(plan, quality->worst_element);
    return status;
}

/** RR of all elements that the plan knows, NAN of the others. */
static int find_ratios(const planish_plan *plan, const double *coordinates, double *ratio,
                       planish_error *error) {
    const pl_view all = pl_view_of_all_elements(plan->all);
    if (plan->scope != PL_SUBSET_ALONE) {
        pl_find_ratios(&all, coordinates, plan->threads, ratio);
        return PLANISH_OK;
    }
    double *of_part = pl_alloc(all.n_elements, sizeof *of_part);
    if (!of_part)
        return pl_fail_memory(error, "the radius ratios");
    pl_find_ratios(&all, coordinates, plan->threads, of_part);
    for (int64_t i = 0; i < plan->whole.n_elements; i++)
        ratio[i] = (double)NAN;
    for (int64_t i = 0; i < all.n_elements; i++)
        ratio[pl_plan_element(plan, i)] = of_part[i];
    pl_free(of_part);
    return PLANISH_OK;
}

/** Result of find_reversed; owned. */
typedef struct found {
    uint8_t *state; /* [n] of the elements that are measured */
    int64_t n;
} found;

/** Find the reversed elements among all elements that the plan knows. Errors: _MEMORY. */
static int find_reversed(const planish_plan *plan, const double *coordinates, found *f,
                         planish_error *error) {
    const int64_t n = plan->all->n_elements;
    f->state = pl_alloc(n, sizeof *f->state);
    const int is_short = pl_parts_any(!f->state);
    if (is_short)
        return pl_fail_memory(error, "the elements that are numbered the other way round");
    f->n = pl_find_reversed(plan->all, coordinates, plan->threads, f->state);
    return PLANISH_OK;
}

/** Hand out what was found, by the caller's numbers. */
static void put_reversed(const planish_plan *plan, const found *f, uint8_t *reversed, int64_t *n) {
    const int64_t n_all = plan->whole.n_elements;
    if (n)
        *n = f->n;
    if (!reversed)
        return;
    if (plan->scope != PL_SUBSET_ALONE) {
        memcpy(reversed, f->state, (size_t)n_all);
        return;
    }
    memset(reversed, 0, (size_t)n_all);
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        reversed[pl_plan_element(plan, i)] = f->state[i];
}

/** Output that is asked for: one of these is not NULL. */
typedef struct wanted {
    planish_quality *quality;
    double *ratio;
    found *reversed;
} wanted;

static int look(const planish_plan *plan, const double *x, const wanted *w, planish_error *error) {
    if (w->quality)
        return measure(plan, x, w->quality, error);
    return w->ratio ? find_ratios(plan, x, w->ratio, error)
                    : find_reversed(plan, x, w->reversed, error);
}

static int check_and_measure(const planish_plan *plan, const double *coordinates, const wanted *w,
                             planish_error *error) {
    const pl_points points = pl_plan_all_points(plan, coordinates);
    const int is_dense = pl_points_are_dense(&points);
    int status = pl_points_check(&points, plan->threads, error);
    if (status)
        return status;
    double *room = is_dense ? NULL : pl_alloc(points.n * points.dim, sizeof *room);
    if (!is_dense && !room)
        return pl_fail_memory(error, "the coordinates");
    const double *x = pl_plan_dense(plan, &points, room);
    status = look(plan, x, w, error);
    pl_free(room);
    return status ? status : pl_parts_check(error);
}

int planish_measure(const planish_plan *plan, const double *coordinates, planish_quality *quality,
                    planish_error *error) {
    if (!plan || !coordinates || !quality)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "plan, coordinates and quality must not be NULL");
    const pl_outside outside = pl_call_enter(plan->context);
    const wanted w = {.quality = quality};
    const int status = check_and_measure(plan, coordinates, &w, error);
    pl_call_leave(&outside);
    return status;
}

int planish_measure_elements(const planish_plan *plan, const double *coordinates,
                             double *radius_ratio, planish_error *error) {
    if (!plan || !coordinates || !radius_ratio)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "plan, coordinates and radius_ratio must not be NULL");
    const pl_outside outside = pl_call_enter(plan->context);
    const wanted w = {.ratio = radius_ratio};
    const int status = check_and_measure(plan, coordinates, &w, error);
    pl_call_leave(&outside);
    return status;
}

int planish_find_reversed(const planish_plan *plan, const double *coordinates, uint8_t *reversed,
                          int64_t *n, planish_error *error) {
    if (!plan || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "plan and coordinates must not be NULL");
    const pl_outside outside = pl_call_enter(plan->context);
    found f = {0};
    const wanted w = {.reversed = &f};
    const int status = check_and_measure(plan, coordinates, &w, error);
    if (!status)
        put_reversed(plan, &f, reversed, n);
    pl_free(f.state);
    pl_call_leave(&outside);
    return status;
}

/* ---- without ------------------------------------------------------------------------------- */

int planish_measure_mesh(const planish_mesh *mesh, const planish_options *options,
                         planish_quality *quality, planish_error *error) {
    planish_plan *plan = NULL;
    if (!mesh || !quality)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh and quality must not be NULL");
    int status = planish_plan_create(mesh, options, &plan, error);
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
