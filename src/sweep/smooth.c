/* smooth: planish_smooth and planish_measure, the calls that work on coordinates. */
#include "sweep/sweep.h"

#include "base/clock.h"
#include "base/parallel.h"
#include "base/status.h"
#include "quality/measure.h"

#include <math.h>
#include <string.h>

enum {
    CHUNK_NODES = 4096,
    EXPONENT_LIMIT = 1000 /* so that the power of two and its inverse are doubles */
};

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
    pl_star_problem problem;
    int exponent;       /* coordinates of the caller = coordinates inside * 2^exponent */
    pl_ratio_sums sums; /* as measured last, movable then tracked */
    double measured;    /* sums.movable as measured last */
    double start;       /* clock */
    double sweep_start;
    int sweep;
    planish_stop stop;
    planish_result *result;
} run;

/* ---- coordinates in and out --------------------------------------------------------------- */

/** Exponent of the power of two that brings the mesh's extent to between 1/2 and 1. Powers of two
 *  change no bit of any result. */
static int extent_exponent(const double *coordinates, int64_t n_nodes, int dim) {
    double extent = 0;
    for (int d = 0; d < dim; d++) {
        double low = 0, high = 0;
        for (int64_t i = 0; i < n_nodes; i++) {
            double value = coordinates[i * dim + d];
            low = i == 0 || value < low ? value : low;
            high = i == 0 || value > high ? value : high;
        }
        double half = high / 2 - low / 2; /* the whole could overflow */
        extent = half > extent ? half : extent;
    }
    int exponent = 0;
    if (extent > 0)
        frexp(extent, &exponent);
    if (exponent > EXPONENT_LIMIT)
        return EXPONENT_LIMIT;
    return exponent < -EXPONENT_LIMIT ? -EXPONENT_LIMIT : exponent + 1;
}

typedef struct transfer {
    const planish_plan *plan;
    const double *outside; /* [n][dim] the caller's */
    double scale;
} transfer;

static void transfer_in(void *context, int64_t begin, int64_t end, int thread) {
    const transfer *t = context;
    const int dim = t->plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < dim; d++) {
            double value = t->outside[i * dim + d] * t->scale;
            t->plan->coordinates[(int64_t)t->plan->inner[i] * dim + d] = value;
            t->plan->measured[i * dim + d] = value;
        }
}

/** The caller's order of the coordinates inside, for measuring. */
static void transfer_measured(void *context, int64_t begin, int64_t end, int thread) {
    const planish_plan *plan = context;
    const int dim = plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < dim; d++)
            plan->measured[i * dim + d] = plan->coordinates[(int64_t)plan->inner[i] * dim + d];
}

/** Write back the nodes that moved; how many and how far is the result's. */
static void transfer_out(run *r, double *outside) {
    const planish_plan *plan = r->plan;
    const int dim = plan->dim;
    double shrink = ldexp(1, -r->exponent), grow = ldexp(1, r->exponent), farthest2 = 0;
    for (int64_t i = 0; i < plan->n_nodes; i++) {
        if (!plan->is_free[i])
            continue;
        double moved2 = 0;
        const double *inside = plan->coordinates + (int64_t)plan->inner[i] * dim;
        for (int d = 0; d < dim; d++) {
            double before = outside[i * dim + d] * shrink;
            if (inside[d] == before)
                continue;
            moved2 += (inside[d] - before) * (inside[d] - before);
            outside[i * dim + d] = inside[d] * grow;
        }
        r->result->moved_nodes += moved2 > 0;
        farthest2 = moved2 > farthest2 ? moved2 : farthest2;
    }
    r->result->max_displacement = sqrt(farthest2) * grow;
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
    pl_parallel_for(r->plan->threads, r->plan->n_nodes, CHUNK_NODES, transfer_measured, r->plan);
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
    planish_progress progress = progress_of(r, r->plan->n_colours, tally.visits);
    progress.sweep_done = 1;
    return call_progress(r, &progress) | tally.stopped;
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
    r->problem = (pl_star_problem){
        .coordinates = plan->coordinates,
        .node = plan->centre,
        .ring_offset = plan->stars.ring_offset,
        .ring = plan->stars.ring,
        .link_offset = plan->stars.link_offset,
        .link = plan->stars.link,
        .changed = plan->changed,
        .direction = r->options->direction,
        .rr2_limit = r->sums.max * LIMIT_MARGIN,
        .rr2_skip = worse * worse,
        .float_scale = r->options->precision == PLANISH_FLOAT ? ldexp(1, r->exponent) : 0};
    memset(plan->changed, 1, (size_t)plan->n_nodes);
}

static void smooth(run *r, double *coordinates) {
    planish_plan *plan = r->plan;
    r->exponent = extent_exponent(coordinates, plan->n_nodes, plan->dim);
    transfer t = {plan, coordinates, ldexp(1, -r->exponent)};
    pl_parallel_for(plan->threads, plan->n_nodes, CHUNK_NODES, transfer_in, &t);
    measure(r);
    prepare_problem(r);
    if (plan->stars.n_stars > 0)
        run_sweeps(r);
    else
        r->stop = PLANISH_STOP_CONVERGED;
    measure_again(r);
    transfer_out(r, coordinates);
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
             .options = options,
             .start = pl_seconds(),
             .result = result ? result : &unwanted};
    memset(r.result, 0, sizeof *r.result);
    pl_placement_enter(plan->placement);
    smooth(&r, coordinates);
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
