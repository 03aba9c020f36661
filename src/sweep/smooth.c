/* smooth: planish_smooth and planish_measure, the calls that work on coordinates. */
#include "sweep/sweep.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "quality/measure.h"
#include "sweep/guard.h"

#include <math.h>
#include <string.h>

enum { CHUNK_NODES = 4096 };

/* Where the tracked sum has fallen below this fraction of the one measured last, rounding
 * could show in it: measure again. */
#define MEASURE_AGAIN 0.5
/* The largest RR^2 that a move may make, relative to the worst of the input: the margin is for the
 * rounding of slivers, whose RR^2 depends on the node it is seen from. */
#define LIMIT_MARGIN (1 - 1e-9)

/** One call of planish_smooth. */
typedef struct run {
    planish_plan *plan;
    const planish_options *options;
    double *outside; /* [n][dim] the caller's coordinates */
    pl_star_problem problem;
    pl_guard guard;
    int plain;                /* the plain problem: sums are what counts, else totals */
    pl_ratio_sums sums;       /* as measured last, movable then tracked */
    pl_objective_sums totals; /* as measured last, ratio[1] then tracked if mu2 = 0 */
    double measured;          /* the sum that is tracked, as measured last */
    double factor;            /* from a star's function to F, of the last sweep's weights */
    int restoring;            /* the last sweep brought elements above their least volume */
    double start;             /* clock */
    double sweep_start;
    int sweep;
    planish_stop stop;
    planish_result *result;
} run;

/* ---- coordinates in and out --------------------------------------------------------------- */

/** The present coordinates by the caller's numbers, for measuring. */
static void transfer_measured(void *context, int64_t begin, int64_t end, int thread) {
    const run *r = context;
    const planish_plan *plan = r->plan;
    const int dim = plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < dim; d++)
            plan->measured[i * dim + d] = plan->coordinates[(int64_t)plan->inner[i] * dim + d];
}

static double distance(const double *a, const double *b, int dim) {
    double far = 0;
    for (int d = 0; d < dim; d++)
        far = hypot(far, a[d] - b[d]);
    return far;
}

/** Write the nodes that moved to the caller's coordinates; how many and how far is the result's. */
static void transfer_out(run *r) {
    const planish_plan *plan = r->plan;
    const int dim = plan->dim;
    planish_result *result = r->result;
    for (int64_t i = 0; i < plan->n_nodes; i++) {
        double *outside = r->outside + i * dim;
        const double *inside = plan->coordinates + (int64_t)plan->inner[i] * dim;
        double far = plan->is_free[i] ? distance(inside, outside, dim) : 0;
        if (!(far > 0))
            continue;
        result->moved_nodes++;
        result->max_displacement = far > result->max_displacement ? far : result->max_displacement;
        for (int d = 0; d < dim; d++)
            outside[d] = inside[d];
    }
}

/* ---- what the mesh is worth --------------------------------------------------------------- */

static double rms(double sum, double n) {
    return n > 0 ? sqrt(sum / n) : 0;
}

static double rms_of_all(const run *r) {
    const pl_objective_sums *t = &r->totals;
    return r->plain
               ? rms(r->sums.movable + r->sums.fixed, (double)(r->sums.n_movable + r->sums.n_fixed))
               : rms(t->ratio[0] + t->ratio[1], t->n[0] + t->n[1]);
}

static double rms_of_movable(const run *r) {
    return r->plain ? rms(r->sums.movable, (double)r->sums.n_movable)
                    : rms(r->totals.ratio[1], r->totals.n[1]);
}

static double objective_of_all(const run *r) {
    return r->plain ? rms_of_all(r) : pl_objective_of_all(r->options, &r->totals);
}

static double objective_of_movable(const run *r) {
    return r->plain ? rms_of_movable(r) : pl_objective_of_movable(r->options, &r->totals);
}

static int64_t inverted(const run *r) {
    return r->plain ? r->sums.inverted : (int64_t)r->totals.inverted;
}

static int64_t below_min_volume(const run *r) {
    return r->plain ? 0 : (int64_t)r->totals.below;
}

static void measure_ratios(run *r) {
    const planish_plan *plan = r->plan;
    pl_sum_radius_ratio(plan->dim, plan->n_elements, plan->elements, plan->sign, plan->is_free,
                        plan->measured, plan->threads, &r->sums);
    r->measured = r->sums.movable;
}

static pl_objective_problem objective_problem(const run *r) {
    const planish_plan *plan = r->plan;
    return (pl_objective_problem){.dim = plan->dim,
                                  .n_elements = plan->n_elements,
                                  .elements = plan->elements,
                                  .sign = plan->sign,
                                  .is_free = r->guard.is_free ? r->guard.is_free : plan->is_free,
                                  .coordinates = plan->measured,
                                  .objective = r->options->objective,
                                  .min_volume = r->guard.min_volume,
                                  .own_min_volume = plan->min_volume,
                                  .threads = plan->threads};
}

static void measure_again(run *r) {
    const planish_plan *plan = r->plan;
    pl_parallel_for(plan->threads, plan->n_nodes, CHUNK_NODES, transfer_measured, r);
    if (r->plain) {
        measure_ratios(r);
        return;
    }
    const pl_objective_problem problem = objective_problem(r);
    pl_sum_objective(&problem, &r->totals);
    r->measured = r->totals.ratio[1];
}

/** The sum of RR^2, or AR^2, over the movable elements falls by what the visits say, unless other
 *  things happened: then, and where rounding could show, it is measured. */
static void keep_track(run *r, const pl_sweep_tally *tally) {
    double *sum = r->plain ? &r->sums.movable : &r->totals.ratio[1];
    *sum -= tally->decrease;
    if (r->restoring || r->options->area_weight > 0 ||
        r->options->method != PLANISH_METHOD_PLANISH || !(*sum > MEASURE_AGAIN * r->measured))
        measure_again(r);
    if (r->restoring && r->totals.radius_max > r->problem.rr2_limit)
        r->problem.rr2_limit = r->totals.radius_max; /* of elements that were brought up */
}

/* ---- sweeps ------------------------------------------------------------------------------- */

static planish_progress progress_of(const run *r, int colour, int64_t visits) {
    double now = pl_seconds();
    return (planish_progress){.sweep = r->sweep,
                              .colour = colour,
                              .n_colours = r->plan->n_colours,
                              .rms = rms_of_all(r),
                              .rms_movable = rms_of_movable(r),
                              .objective = objective_of_all(r),
                              .inverted = inverted(r),
                              .below_min_volume = below_min_volume(r),
                              .restoring = r->restoring,
                              .visits = visits,
                              .seconds = now - r->sweep_start,
                              .elapsed = now - r->start};
}

static int call_progress(run *r, const planish_progress *progress) {
    if (!r->options->progress || !r->options->progress(progress, r->options->progress_user))
        return 0;
    r->stop = PLANISH_STOP_INTERRUPTED;
    return 1;
}

static int after_colour(void *context, int colours_done) {
    run *r = context;
    planish_progress progress = progress_of(r, colours_done, 0);
    if (call_progress(r, &progress))
        return 1;
    if (r->options->time_limit > 0 && progress.elapsed >= r->options->time_limit) {
        r->stop = PLANISH_STOP_TIME_LIMIT;
        return 1;
    }
    return 0;
}

/** One sweep and what is to be said of it; not 0 if it was cut short. */
static int one_sweep(run *r) {
    r->sweep++;
    r->sweep_start = pl_seconds();
    if (!r->plain)
        r->factor = pl_guard_weigh(&r->guard, r->options, &r->totals);
    pl_sweep_tally tally = pl_sweep(r->plan, &r->problem, r->options->method, after_colour, r);
    r->restoring = tally.restored > 0;
    r->result->visits += tally.visits;
    r->result->evaluations += tally.evaluations;
    keep_track(r, &tally);
    planish_progress progress = progress_of(r, tally.colours, tally.visits);
    progress.sweep_done = 1;
    if (!tally.stopped)
        return call_progress(r, &progress);
    if (r->options->progress) /* the reason to stop stands: no answer is wanted */
        r->options->progress(&progress, r->options->progress_user);
    return 1;
}

/** Take note of a sweep; not 0 if another one is not worth its time. The averages may raise F: for
 *  them it must stay as it is. */
static int has_converged(const run *r, pl_convergence *convergence, double before, int64_t visits) {
    double after = objective_of_movable(r);
    if (visits == 0)
        return 1;
    if (r->restoring) {
        convergence->n_falls = 0;
        return 0;
    }
    if (r->options->method != PLANISH_METHOD_PLANISH)
        return pl_converged(convergence, fmax(before, after), fmin(before, after),
                            r->options->tolerance);
    return pl_converged(convergence, before, after, r->options->tolerance);
}

static void run_sweeps(run *r) {
    pl_convergence convergence = {{0}, 0};
    r->stop = PLANISH_STOP_MAX_SWEEPS;
    while (r->sweep < r->options->max_sweeps) {
        double before = objective_of_movable(r);
        int64_t visits = r->result->visits;
        if (one_sweep(r))
            return;
        if (has_converged(r, &convergence, before, r->result->visits - visits)) {
            r->stop = PLANISH_STOP_CONVERGED;
            return;
        }
    }
}

static void prepare_problem(run *r) {
    const planish_plan *plan = r->plan;
    double worse = r->options->only_worse_than;
    r->problem = pl_plan_problem(plan);
    r->problem.direction = r->options->direction;
    r->problem.rr2_limit = (r->plain ? r->sums.max : r->totals.radius_max) * LIMIT_MARGIN;
    r->problem.rr2_skip = worse * worse;
    r->problem.to_float = r->options->precision == PLANISH_FLOAT;
    r->problem.guard = r->guard.wanted ? &r->guard.star : NULL;
    memset(plan->changed, 1, (size_t)plan->n_nodes);
}

/** How near the nodes are to a constrained optimum. */
static int judge(run *r, planish_error *error) {
    pl_star_optimality optimality;
    planish_result *result = r->result;
    if (!r->guard.wanted || r->options->method != PLANISH_METHOD_PLANISH)
        return PLANISH_OK;
    r->factor = pl_guard_weigh(&r->guard, r->options, &r->totals);
    int status = pl_optimality(r->plan, &r->problem, &optimality, error);
    if (status)
        return status;
    result->kkt_residual = optimality.residual;
    result->kkt_rms = rms(optimality.residual2, (double)optimality.n_stars);
    result->max_multiplier = optimality.multiplier * r->factor;
    result->n_active = optimality.n_active;
    return PLANISH_OK;
}

/** Say so if it has converged with elements that cannot reach their least volume. */
static int look_for_infeasible(run *r, planish_error *error) {
    const planish_plan *plan = r->plan;
    if (r->stop != PLANISH_STOP_CONVERGED || below_min_volume(r) == 0)
        return PLANISH_OK;
    int64_t n_infeasible = 0;
    const pl_objective_problem problem = objective_problem(r);
    uint8_t *state = pl_alloc(plan->n_elements, sizeof *state);
    int status = state ? PLANISH_OK : pl_fail_memory(error, "the states of the elements");
    if (state) {
        pl_find_below(&problem, state);
        status = pl_mark_infeasible(plan, &r->guard.star, state, &n_infeasible, error);
    }
    pl_free(state);
    if (n_infeasible > 0)
        r->stop = PLANISH_STOP_INFEASIBLE;
    return status;
}

static int smooth(run *r, planish_error *error) {
    planish_plan *plan = r->plan;
    pl_plan_load(plan, r->outside);
    int status = pl_guard_create(plan, r->options, r->outside, &r->guard, error);
    if (status)
        return status;
    r->plain = !r->guard.wanted && r->options->method == PLANISH_METHOD_PLANISH;
    measure_again(r);
    r->result->objective_before = objective_of_all(r);
    prepare_problem(r);
    if (plan->stars.n_stars > 0)
        run_sweeps(r);
    else
        r->stop = PLANISH_STOP_CONVERGED;
    measure_again(r);
    status = judge(r, error);
    if (!status)
        status = look_for_infeasible(r, error);
    if (!status)
        transfer_out(r);
    return status;
}

static void fill_result(const run *r) {
    planish_result *result = r->result;
    result->stop = r->stop;
    result->sweeps = r->sweep;
    result->inverted = inverted(r);
    result->rms = rms_of_all(r);
    result->rms_movable = rms_of_movable(r);
    result->min_volume = r->guard.min_volume;
    result->below_min_volume = below_min_volume(r);
    result->held_outside = r->guard.held_outside;
    result->objective = objective_of_all(r);
    result->seconds = pl_seconds() - r->start;
}

int planish_smooth(planish_plan *plan, double *coordinates, const planish_options *options,
                   planish_result *result, planish_error *error) {
    planish_options defaults;
    planish_result unwanted;
    if (!plan || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "plan and coordinates must not be NULL");
    if (!options) {
        planish_options_init(&defaults);
        options = &defaults;
    }
    int status = pl_options_check(options, error);
    if (!status)
        status =
            pl_validate_coordinates(coordinates, plan->n_nodes, plan->dim, plan->threads, error);
    if (status)
        return status;

    run r = {.plan = plan,
             .outside = coordinates,
             .options = options,
             .start = pl_seconds(),
             .result = result ? result : &unwanted};
    memset(r.result, 0, sizeof *r.result);
    pl_placement_enter(plan->placement);
    status = smooth(&r, error);
    pl_placement_leave(plan->placement);
    if (!status)
        fill_result(&r);
    pl_guard_destroy(&r.guard);
    return status;
}

int planish_measure(const planish_plan *plan, const double *coordinates, planish_quality *quality,
                    planish_error *error) {
    if (!plan || !coordinates || !quality)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "plan, coordinates and quality must not be NULL");
    int status =
        pl_validate_coordinates(coordinates, plan->n_nodes, plan->dim, plan->threads, error);
    if (status)
        return status;
    return pl_measure(plan->dim, plan->n_elements, plan->elements, plan->sign, plan->is_free,
                      coordinates, plan->threads, quality, error);
}
