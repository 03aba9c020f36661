/* smooth: planish_smooth and planish_measure, the calls that work on coordinates. */
#include "sweep/sweep.h"

#include "base/clock.h"
#include "base/parallel.h"
#include "base/status.h"
#include "quality/measure.h"

#include <math.h>
#include <string.h>

enum { CHUNK_NODES = 4096 };

/* Where the tracked sum of RR^2 has fallen below this fraction of the one measured last, rounding
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
    pl_ratio_sums sums; /* as measured last, movable then tracked */
    double measured;    /* sums.movable as measured last */
    double start;       /* clock */
    double sweep_start;
    int sweep;
    planish_stop stop;
    planish_result *result;
} run;

/* ---- coordinates in and out --------------------------------------------------------------- */

static void transfer_in(void *context, int64_t begin, int64_t end, int thread) {
    const run *r = context;
    const int dim = r->plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < dim; d++)
            r->plan->coordinates[(int64_t)r->plan->inner[i] * dim + d] = r->outside[i * dim + d];
}

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

/* ---- the RMS ------------------------------------------------------------------------------ */

static double rms(double sum, int64_t n) {
    return n > 0 ? sqrt(sum / (double)n) : 0;
}

static double rms_of_all(const run *r) {
    return rms(r->sums.movable + r->sums.fixed, r->sums.n_movable + r->sums.n_fixed);
}

static double rms_of_movable(const run *r) {
    return rms(r->sums.movable, r->sums.n_movable);
}

static void measure(run *r) {
    const planish_plan *plan = r->plan;
    pl_sum_radius_ratio(plan->dim, plan->n_elements, plan->elements, plan->sign, plan->is_free,
                        plan->measured, plan->threads, &r->sums);
    r->measured = r->sums.movable;
}

static void measure_again(run *r) {
    pl_parallel_for(r->plan->threads, r->plan->n_nodes, CHUNK_NODES, transfer_measured, r);
    measure(r);
}

/* ---- sweeps ------------------------------------------------------------------------------- */

static planish_progress progress_of(const run *r, int colour, int64_t visits) {
    double now = pl_seconds();
    return (planish_progress){.sweep = r->sweep,
                              .colour = colour,
                              .n_colours = r->plan->n_colours,
                              .rms = rms_of_all(r),
                              .rms_movable = rms_of_movable(r),
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
    pl_sweep_tally tally = pl_sweep(r->plan, &r->problem, after_colour, r);
    r->sums.movable -= tally.decrease;
    r->result->visits += tally.visits;
    if (!(r->sums.movable > MEASURE_AGAIN * r->measured))
        measure_again(r);
    planish_progress progress = progress_of(r, tally.colours, tally.visits);
    progress.sweep_done = 1;
    if (!tally.stopped)
        return call_progress(r, &progress);
    if (r->options->progress) /* the reason to stop stands: no answer is wanted */
        r->options->progress(&progress, r->options->progress_user);
    return 1;
}

static void run_sweeps(run *r) {
    pl_convergence convergence = {{0}, 0};
    r->stop = PLANISH_STOP_MAX_SWEEPS;
    while (r->sweep < r->options->max_sweeps) {
        double before = rms_of_movable(r);
        if (one_sweep(r))
            return;
        if (pl_converged(&convergence, before, rms_of_movable(r), r->options->tolerance)) {
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
    r->problem.rr2_limit = r->sums.max * LIMIT_MARGIN;
    r->problem.rr2_skip = worse * worse;
    r->problem.to_float = r->options->precision == PLANISH_FLOAT;
    memset(plan->changed, 1, (size_t)plan->n_nodes);
}

static void smooth(run *r) {
    planish_plan *plan = r->plan;
    pl_parallel_for(plan->threads, plan->n_nodes, CHUNK_NODES, transfer_in, r);
    measure_again(r);
    prepare_problem(r);
    if (plan->stars.n_stars > 0)
        run_sweeps(r);
    else
        r->stop = PLANISH_STOP_CONVERGED;
    measure_again(r);
    transfer_out(r);
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
    smooth(&r);
    pl_placement_leave(plan->placement);
    r.result->stop = r.stop;
    r.result->sweeps = r.sweep;
    r.result->inverted = r.sums.inverted;
    r.result->rms = rms_of_all(&r);
    r.result->rms_movable = rms_of_movable(&r);
    r.result->seconds = pl_seconds() - r.start;
    return PLANISH_OK;
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
