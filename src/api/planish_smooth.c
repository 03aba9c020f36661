/* planish_smooth: coordinates in, the phases, coordinates out. */
#include "improve/improve.h"
#include "improve/patch.h"

#include "base/clock.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/angle.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/* ---- coordinates out ----------------------------------------------------------------------- */

enum { CHUNK_NODES = 1024 };

/** How many nodes have moved, and how far. */
typedef struct transfer {
    pl_run *run;
    pl_points points; /* of the caller */
    int writes;       /* 0: only look */
    int64_t moved;
    double farthest;
} transfer;

static void transfer_chunk(void *context, int64_t begin, int64_t end, int thread) {
    transfer *t = context;
    const planish_plan *plan = t->run->plan;
    const int dim = plan->dim;
    int64_t moved = 0;
    double farthest = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const double *start = t->run->outside + i * dim;
        const double *inside = plan->coordinates + (int64_t)plan->inner[i] * dim;
        const double far = plan->work.mobility[i] ? pl_distance(dim, inside, start) : 0;
        if (!(far > 0))
            continue;
        moved += pl_is_own(pl_part_here(), i);
        farthest = fmax(farthest, far);
        for (int d = 0; d < dim && t->writes; d++)
            t->run->coordinates[pl_point_at(&t->points, i, d)] = inside[d];
    }
    pl_raise_double(&t->farthest, farthest);
    __atomic_fetch_add(&t->moved, moved, __ATOMIC_RELAXED);
}

static void transfer_all(transfer *t) {
    t->moved = 0;
    t->farthest = 0;
    pl_parallel_for(t->run->plan->threads, t->run->plan->work.n_nodes, CHUNK_NODES, transfer_chunk,
                    t);
}

/** Write the nodes that moved to the caller's coordinates; how many and how far is the result's.
 *  Nothing is written if other processes are not reached any more: what they ought to be told comes
 *  first. */
static int transfer_out(pl_run *r, planish_error *error) {
    const int is_part = pl_part_here() != NULL;
    transfer t = {.run = r, .points = pl_plan_points(r->plan, r->coordinates), .writes = !is_part};
    transfer_all(&t);
    r->result->max_displacement = t.farthest;
    pl_parts_add(&t.moved, 1);
    pl_parts_largest(&r->result->max_displacement, 1);
    r->result->moved_nodes = t.moved;
    const int status = pl_parts_check(error);
    t.writes = 1;
    if (!status && is_part)
        transfer_all(&t);
    return status;
}

/* ---- a call --------------------------------------------------------------------------------- */

/** Followers keep the way that they are from the others now. */
static void begin_following(const planish_plan *plan, pl_follower *f) {
    double *x = plan->coordinates;
    const int dim = plan->dim;
    for (int d = 0; d < dim; d++) {
        const double way = x[(int64_t)f->to * dim + d] - x[(int64_t)f->from * dim + d];
        f->origin[d] = x[(int64_t)f->of * dim + d];
        if (f->node >= plan->work.n_nodes)
            x[(int64_t)f->node * dim + d] = f->origin[d] + way;
        f->start[d] = x[(int64_t)f->node * dim + d];
    }
}

/** Planes and lines go through where their nodes are now. */
static void begin_sliding(planish_plan *plan) {
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++) {
        const double *x = plan->coordinates + (int64_t)plan->sliding.centre[s] * plan->dim;
        memcpy(plan->slide[s].point, x, (size_t)plan->dim * sizeof *x);
    }
    for (int64_t k = 0; k < plan->sliding.n_followers; k++)
        begin_following(plan, &plan->sliding.follower[k]);
}

/** Note the limits that no element may end up worse than. The run compares them afterwards, as
 *  sweeps guard neither the smallest angle of the input mesh, where that is promised, nor the
 *  elements of followers. */
static void note_start(pl_run *r) {
    const planish_options *o = r->options;
    r->inverted_at_start = pl_run_inverted(r);
    r->below_at_start = pl_run_below(r);
    r->at_start = pl_star_no_limits();
    if (o->method != PLANISH_METHOD_PLANISH || r->inverted_at_start > 0 || r->below_at_start > 0)
        return;
    if (o->objective == PLANISH_RADIUS_RATIO && !(o->area_weight > 0))
        r->at_start = pl_run_limits(r, 1);
    else if (pl_run_has_followers(r))
        r->at_start.rr2 = pl_run_limits(r, 1).rr2;
}

/** Coordinates into the plan; the guard, with a delta that may be a fraction of the volume of all
 * of the mesh, whose coordinates all [.][dim] are. */
static int begin(pl_run *r, const double *all, planish_error *error) {
    planish_plan *plan = r->plan;
    pl_plan_order(plan, r->outside, plan->coordinates);
    begin_sliding(plan);
    const double delta = pl_minimum_volume(plan, r->options, all);
    int status = pl_guard_create(plan, r->options, r->outside, delta, &r->guard, error);
    if (status)
        return status;
    r->plain = !r->guard.wanted && r->options->method == PLANISH_METHOD_PLANISH;
    r->unit = r->plain ? pl_box_of_fixed(plan).scale : 1;
    return PLANISH_OK;
}

/** Begin as begin does where all of the mesh is known, and measure the rest of the mesh. Errors:
 *  those of begin, _MEMORY. */
static int begin_with_all(pl_run *r, planish_error *error) {
    const pl_points points = pl_plan_all_points(r->plan, r->coordinates);
    double *all = pl_alloc(points.n * points.dim, sizeof *all);
    if (!all)
        return pl_fail_memory(error, "the coordinates");
    pl_points_gather(&points, r->plan->threads, all);
    const int status = begin(r, all, error);
    for (int64_t i = 0; !status && i < points.n * points.dim; i++)
        all[i] *= r->unit;
    if (!status)
        pl_run_measure_rest(r, all);
    pl_free(all);
    return status;
}

static int smooth(pl_run *r, planish_error *error) {
    planish_plan *plan = r->plan;
    const pl_points points = pl_plan_points(plan, r->coordinates);
    r->outside = pl_plan_dense(plan, &points, plan->start);
    int status =
        plan->scope == PL_SUBSET_OF_ALL ? begin_with_all(r, error) : begin(r, r->outside, error);
    if (status)
        return status;
    pl_run_measure(r);
    if (plan->scope == PL_SUBSET_OF_ALL) {
        r->rest.inverted -= pl_run_inverted(r);
        r->rest.below -= pl_run_below(r);
    }
    r->result->objective_before = pl_run_objective(r);
    note_start(r);
    pl_run_prepare(r);
    r->stop = PLANISH_STOP_CONVERGED;
    status = pl_run_phases(r, error);
    /* What helps is left out without memory, and the mesh would not be the one that it is with. */
    if (!status && __atomic_load_n(&plan->context->failed, __ATOMIC_RELAXED))
        status = pl_fail_memory(error, "the smoothing of a mesh");
    if (!status)
        status = pl_parts_check(error);
    return status ? status : transfer_out(r, error);
}

static void fill_result(const pl_run *r) {
    planish_result *result = r->result;
    result->stop = r->stop;
    result->sweeps = r->sweep;
    result->inverted = pl_run_inverted(r) + r->rest.inverted;
    result->rms = pl_run_rms(r);
    result->rms_movable = pl_run_rms_of_movable(r);
    result->min_volume = r->guard.min_volume;
    result->below_min_volume = pl_run_below(r) + r->rest.below;
    result->held_outside = r->guard.held_outside;
    result->objective = pl_run_objective(r);
    result->seconds = pl_seconds() - r->start;
}

static void say_result(const planish_result *r) {
    static const char *const stops[] = {"converged", "reached max_sweeps", "reached time_limit",
                                        "was interrupted",
                                        "converged, with minimum volumes that cannot be met"};
    pl_log(PLANISH_LOG_DETAIL,
           "%s after %d sweeps, %d of them untangling: F %.6g -> %.6g, %" PRId64
           " nodes moved, %.3g s",
           stops[r->stop], r->sweeps, r->untangling_sweeps, r->objective_before, r->objective,
           r->moved_nodes, r->seconds);
    if (r->inverted > 0)
        pl_log(PLANISH_LOG_NOTE, "%" PRId64 " elements are not positive", r->inverted);
    if (r->below_min_volume > 0)
        pl_log(PLANISH_LOG_NOTE, "%" PRId64 " elements are below their minimum volume",
               r->below_min_volume);
    if (r->held_outside > 0)
        pl_log(PLANISH_LOG_NOTE, "%" PRId64 " nodes started outside of their bounds and stay",
               r->held_outside);
    if (r->put_back > 0)
        pl_log(PLANISH_LOG_NOTE,
               "nodes were put back %" PRId64 " times, where angles had become too small",
               r->put_back);
}

static int smooth_in_context(planish_plan *plan, double *coordinates,
                             const planish_options *options, planish_result *found,
                             planish_error *error) {
    pl_run r = {.plan = plan,
                .coordinates = coordinates,
                .options = options,
                .accelerate = pl_run_accelerate,
                .start = pl_seconds(),
                .result = found};
    pl_placement_enter(plan->placement);
    const int status = smooth(&r, error);
    pl_placement_leave(plan->placement);
    if (!status) {
        fill_result(&r);
        say_result(found);
    }
    pl_guard_destroy(&r.guard);
    return status;
}

int planish_smooth(planish_plan *plan, double *coordinates, const planish_options *options,
                   planish_result *result, planish_error *error) {
    planish_options defaults;
    planish_result found = {0};
    if (!plan || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "plan and coordinates must not be NULL");
    if (!options) {
        planish_options_init(&defaults);
        options = &defaults;
    }
    const pl_outside outside = pl_call_enter(plan->context);
    pl_context_begin(plan->context);
    int status = pl_plan_check_call(plan, coordinates, options, error);
    if (!status)
        status = smooth_in_context(plan, coordinates, options, &found, error);
    pl_context_end(plan->context);
    pl_call_leave(&outside);
    if (!status && result)
        *result = found;
    return status;
}
