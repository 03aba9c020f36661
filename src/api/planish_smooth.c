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

/** A way out: how many nodes have moved, and how far. */
typedef struct transfer {
    const pl_run *run;
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

/** Write the nodes that moved to the caller's coordinates; how many and how far is the result's.
 *  Nothing is written if other processes are not reached any more: what they ought to be told comes
 *  first. */
static int transfer_out(const pl_run *r, planish_error *error) {
    const planish_plan *plan = r->plan;
    const int is_part = pl_part_here() != NULL;
    transfer t = {.run = r, .points = pl_plan_points(plan, r->coordinates), .writes = !is_part};
    pl_parallel_for(plan->threads, plan->work.n_nodes, CHUNK_NODES, transfer_chunk, &t);
    r->result->max_displacement = t.farthest;
    pl_parts_add(&t.moved, 1);
    pl_parts_largest(&r->result->max_displacement, 1);
    r->result->moved_nodes = t.moved;
    const int status = pl_parts_check(error);
    t.writes = 1;
    if (!status && is_part)
        pl_parallel_for(plan->threads, plan->work.n_nodes, CHUNK_NODES, transfer_chunk, &t);
    return status;
}

/* ---- a call --------------------------------------------------------------------------------- */

/** Put planes and lines through where their nodes are now; followers keep the way that they are
 * from the others. */
static void begin_sliding(planish_plan *plan) {
    double *x = plan->coordinates;
    const int dim = plan->dim;
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++)
        memcpy(plan->slide[s].point, x + (int64_t)plan->sliding.centre[s] * dim,
               (size_t)dim * sizeof *x);
    for (int64_t k = 0; k < plan->sliding.n_followers; k++) {
        pl_follower *f = &plan->sliding.follower[k];
        for (int d = 0; d < dim; d++) {
            const double way = x[(int64_t)f->to * dim + d] - x[(int64_t)f->from * dim + d];
            f->origin[d] = x[(int64_t)f->of * dim + d];
            if (f->node >= plan->work.n_nodes)
                x[(int64_t)f->node * dim + d] = f->origin[d] + way;
            f->start[d] = x[(int64_t)f->node * dim + d];
        }
    }
}

/** Bring coordinates into the plan, make the guard, and measure the mesh, with the rest of it where
 *  more than the plan's subset is known. Errors: those of pl_guard_create, _MEMORY. */
static int begin_run(pl_run *r, planish_error *error) {
    planish_plan *plan = r->plan;
    const int is_subset = plan->scope == PL_SUBSET_OF_ALL;
    const pl_points points = pl_plan_points(plan, r->coordinates);
    const pl_points all_points = pl_plan_all_points(plan, r->coordinates);
    const int64_t n_values = all_points.n * all_points.dim;
    r->outside = pl_plan_dense(plan, &points, plan->start);
    double *all = is_subset ? pl_alloc(n_values, sizeof *all) : NULL;
    if (is_subset && !all)
        return pl_fail_memory(error, "the coordinates");
    if (is_subset)
        pl_points_gather(&all_points, plan->threads, all);
    pl_plan_order(plan, r->outside, plan->coordinates);
    begin_sliding(plan);
    /* delta may be a fraction of the volume of all of the mesh. */
    double delta;
    int status = pl_minimum_volume(plan, r->options, is_subset ? all : r->outside, &delta, error);
    if (!status)
        status = pl_guard_create(plan, r->options, r->outside, delta, &r->guard, error);
    r->plain = !r->guard.wanted && r->options->method == PLANISH_METHOD_PLANISH;
    r->unit = r->plain && !status ? pl_box_of_fixed(plan).scale : 1;
    for (int64_t i = 0; !status && is_subset && i < n_values; i++)
        all[i] *= r->unit;
    if (!status && is_subset)
        pl_run_measure_rest(r, all);
    pl_free(all);
    if (status)
        return status;
    pl_run_measure(r);
    if (is_subset) {
        r->rest.inverted -= r->sums.inverted;
        r->rest.below -= r->sums.below;
    }
    return PLANISH_OK;
}

/** Note the limits that no element may end up worse than. The run compares them afterwards, as
 *  sweeps guard neither the smallest angle of the input mesh, where that is promised, nor the
 *  elements of followers. */
static void note_start(pl_run *r) {
    const planish_options *o = r->options;
    r->result->objective_before = pl_run_objective(r);
    r->sums_at_start = r->sums;
    r->limits_at_start = pl_star_no_limits();
    if (o->method != PLANISH_METHOD_PLANISH || r->sums.inverted > 0 || r->sums.below > 0)
        return;
    if (o->objective == PLANISH_RADIUS_RATIO && !(o->area_weight > 0))
        r->limits_at_start = pl_run_worst_limits(r, 1);
    else if (pl_run_has_followers(r))
        r->limits_at_start.rr2 = pl_run_worst_limits(r, 1).rr2;
}

static int smooth_run(pl_run *r, planish_error *error) {
    int status = begin_run(r, error);
    if (status)
        return status;
    note_start(r);
    pl_run_prepare(r);
    r->stop = PLANISH_STOP_CONVERGED;
    status = pl_run_phases(r, error);
    /* What helps is left out without memory, and the mesh would not be the one that it is with. */
    if (!status && __atomic_load_n(&r->plan->context->failed, __ATOMIC_RELAXED))
        status = pl_fail_memory(error, "the smoothing of a mesh");
    if (!status)
        status = pl_parts_check(error);
    return status ? status : transfer_out(r, error);
}

/** Fill the rest of the result, and tell it to the caller's log. */
static void say_result(const pl_run *run) {
    static const char *const stops[] = {"converged", "reached max_sweeps", "reached time_limit",
                                        "was interrupted",
                                        "converged, with minimum volumes that cannot be met"};
    planish_result *r = run->result;
    r->stop = run->stop;
    r->sweeps = run->sweep;
    r->inverted = (int64_t)(run->sums.inverted + run->rest.inverted);
    r->rms = pl_rms_of_all(&run->sums);
    r->rms_movable = pl_rms_of_movable(&run->sums);
    r->min_volume = run->guard.min_volume;
    r->below_min_volume = (int64_t)(run->sums.below + run->rest.below);
    r->held_outside = run->guard.held_outside;
    r->objective = pl_run_objective(run);
    r->seconds = pl_seconds() - run->start;
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

int planish_smooth(planish_plan *plan, double *coordinates, const planish_options *options,
                   planish_result *result, planish_error *error) {
    planish_options defaults;
    planish_result found = {0};
    if (!plan || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "plan and coordinates must not be NULL");
    planish_options_init(&defaults);
    const pl_outside outside = pl_call_enter(plan->context);
    pl_context_begin(plan->context);
    pl_run r = {.plan = plan,
                .coordinates = coordinates,
                .options = options ? options : &defaults,
                .accelerate = pl_run_accelerate,
                .start = pl_seconds(),
                .result = &found};
    int status = pl_plan_check_call(plan, coordinates, r.options, error);
    if (!status) {
        pl_placement_enter(plan->placement);
        status = smooth_run(&r, error);
        pl_placement_leave(plan->placement);
    }
    if (!status)
        say_result(&r);
    pl_guard_destroy(&r.guard);
    pl_context_end(plan->context);
    pl_call_leave(&outside);
    if (!status && result)
        *result = found;
    return status;
}
