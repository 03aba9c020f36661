/* smooth: sweeps over the colours of a surface mesh, and stages for its worst elements. */
#include "surface/smooth.h"

#include "base/clock.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/positions.h"
#include "base/status.h"
#include "geometry/arc_cosine.h"
#include "geometry/simplex.h"
#include "sweep/sweep.h"

#include <math.h>
#include <string.h>

enum { CHUNK_NODES = 4096 };

/* As sweep/run.c: a move that brings less than this part of the tolerance wakes nobody. */
#define CALM 0.5
/* The worst may not become worse by more than rounding. */
#define LIMIT_MARGIN (1 - 1e-9)

#define PI 3.14159265358979323846

/* ---- measures ------------------------------------------------------------------------------- */

static void scale_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const pl_surface_run *r = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < 3; d++)
            r->scaled[i][d] = r->x[i][d] * r->shape->scale;
}

int pl_surface_run_measure(pl_surface_run *r, planish_error *error) {
    pl_parallel_for(r->threads, r->shape->n_nodes, CHUNK_NODES, scale_chunk, r);
    return pl_surface_measure(&r->stars, (const double(*)[3])r->scaled, r->moves, r->is_movable,
                              r->threads, r->ratio, &r->sums, error);
}

static double rms_of(double sum, double n) {
    return n > 0 ? sqrt(sum / n) : 0;
}

double pl_surface_rms(const pl_surface_sums *s) {
    return rms_of(s->ratio[PL_SURFACE_FIXED] + s->ratio[PL_SURFACE_MOVES] +
                      s->ratio[PL_SURFACE_HELD],
                  s->n[PL_SURFACE_FIXED] + s->n[PL_SURFACE_MOVES] + s->n[PL_SURFACE_HELD]);
}

double pl_surface_rms_of_movable(const pl_surface_sums *s) {
    return rms_of(s->ratio[PL_SURFACE_MOVES] + s->ratio[PL_SURFACE_HELD],
                  s->n[PL_SURFACE_MOVES] + s->n[PL_SURFACE_HELD]);
}

/** The RMS of the elements that can change. */
static double rms_of_moving(const pl_surface_sums *s) {
    return rms_of(s->ratio[PL_SURFACE_MOVES], s->n[PL_SURFACE_MOVES]);
}

/* ---- progress ------------------------------------------------------------------------------- */

static planish_progress progress_of(const pl_surface_run *r, int colour, int64_t visits) {
    const double now = pl_seconds();
    return (planish_progress){.sweep = r->sweep,
                              .colour = colour,
                              .n_colours = r->stars.n_colours,
                              .rms = pl_surface_rms(&r->sums),
                              .rms_movable = pl_surface_rms_of_movable(&r->sums),
                              .objective = pl_surface_rms(&r->sums),
                              .n_inverted = r->sums.n_inverted,
                              .phase = r->phase,
                              .visits = visits,
                              .seconds = now - r->sweep_start,
                              .elapsed = now - r->start_seconds};
}

/** Ask the caller with progress; not 0 if the run is to end: r->stop says why. */
static int ask_caller(pl_surface_run *r, const planish_progress *progress) {
    const planish_options *o = r->options;
    int answer = 0;
    if (o->progress) {
        pl_context *before = pl_context_enter(NULL);
        answer = o->progress(progress, o->progress_user);
        pl_context_enter(before);
    }
    if (answer)
        r->stop = PLANISH_STOP_INTERRUPTED;
    else if (o->time_limit > 0 && progress->elapsed >= o->time_limit)
        r->stop = PLANISH_STOP_TIME_LIMIT;
    else
        return 0;
    return 1;
}

/** Write where the nodes of the surface are to coordinates, laid out as the caller's: all, because a run that
 *  begins anew moves fewer. run: a pl_surface_run. */
static void fill_positions(const void *run, double *coordinates) {
    const pl_surface_run *r = run;
    const pl_points points = pl_points_of(r->mesh, coordinates);
    for (int64_t i = 0; i < r->shape->n_nodes; i++) {
        const double *place = pl_distance(3, r->x[i], r->start[i]) > 0 ? r->x[i] : r->start[i];
        for (int d = 0; d < 3; d++)
            coordinates[pl_point_at(&points, r->shape->node[i], d)] = place[d];
    }
}

/* ---- one sweep ------------------------------------------------------------------------------ */

/** Colour under way. */
typedef struct colour_pass {
    pl_surface_run *run;
    int64_t first;
} colour_pass;

static void visit_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const colour_pass *pass = context;
    pl_surface_visit(&pass->run->problem, pass->first + begin, pass->first + end, thread,
                     &pass->run->tally[thread].of);
}

static void visit_colour(pl_surface_run *r, int colour) {
    enum { FEWEST = 4, MOST = 64, CHUNKS_EACH = 8 };
    const int64_t begin = r->stars.colour_begin[colour],
                  n = r->stars.colour_begin[colour + 1] - begin;
    int64_t chunk = n / CHUNKS_EACH / r->threads;
    chunk = chunk < FEWEST ? FEWEST : chunk > MOST ? MOST : chunk;
    colour_pass pass = {r, begin};
    pl_parallel_for(r->threads, n, chunk, visit_chunk, &pass);
}

static int64_t visits_so_far(const pl_surface_run *r) {
    int64_t n = 0;
    for (int t = 0; t < r->threads; t++)
        n += r->tally[t].of.visits;
    return n;
}

/** Sweep once, measure, and tell the caller; *stopped: the run is to end. tally: of the sweep. Errors:
 *  _MEMORY. */
static int sweep_once(pl_surface_run *r, pl_star_tally *tally, int *stopped, planish_error *error) {
    int64_t visits = 0;
    int colours = 0;
    *stopped = 0;
    r->sweep++;
    r->sweep_start = pl_seconds();
    memset(r->tally, 0, (size_t)r->threads * sizeof *r->tally);
    while (colours < r->stars.n_colours && !*stopped) {
        visit_colour(r, colours++);
        planish_progress progress = progress_of(r, colours, 0);
        progress.colour_visits = visits_so_far(r) - visits;
        visits += progress.colour_visits;
        *stopped = ask_caller(r, &progress);
    }
    *tally = (pl_star_tally){.visits = visits};
    for (int t = 0; t < r->threads; t++) {
        tally->evaluations += r->tally[t].of.evaluations;
        tally->improved += r->tally[t].of.improved;
    }
    r->result->visits += tally->visits;
    r->result->evaluations += tally->evaluations;
    const int status = pl_surface_run_measure(r, error);
    const struct planish_positions positions = {fill_positions, r, pl_context_current(),
                                                r->coordinates};
    planish_progress progress = progress_of(r, colours, visits);
    progress.sweep_done = 1;
    progress.positions = &positions;
    if (!status && !*stopped)
        *stopped = ask_caller(r, &progress);
    return status;
}

int pl_surface_sweeps(pl_surface_run *r, planish_error *error) {
    pl_convergence convergence = {.n_falls = 0};
    pl_star_tally tally;
    int stopped = 0, status = PLANISH_OK;
    memset(r->changed, 1, (size_t)r->shape->n_nodes);
    r->problem.measure =
        r->stars.by_radius && r->options->objective == PLANISH_OBJECTIVE_RADIUS_RATIO
            ? PL_FACET_RR
            : PL_FACET_MEAN;
    r->problem.limit = 0;
    r->problem.calm = CALM * r->options->tolerance;
    r->problem.worst = r->sums.worst * LIMIT_MARGIN;
    r->problem.acuteness = r->sums.acuteness * LIMIT_MARGIN;
    r->stop = PLANISH_STOP_MAX_SWEEPS;
    for (int k = 0; k < r->options->max_sweeps && !stopped && !status; k++) {
        const double before = rms_of_moving(&r->sums);
        status = sweep_once(r, &tally, &stopped, error);
        const double after = rms_of_moving(&r->sums);
        if (!stopped && !status &&
            (tally.visits == 0 ||
             pl_converged(&convergence, before, after, r->options->tolerance))) {
            r->stop = PLANISH_STOP_CONVERGED;
            break;
        }
    }
    return status;
}

/* ---- the worst ------------------------------------------------------------------------------ */

/* As improve/worst.c: a limit falls by this factor from stage to stage, down to this. */
#define STAGE_FACTOR 0.9
#define STAGE_LEAST  1.05
enum { STAGE_SWEEPS = 20, HALVINGS = 3, FEW = 50 };

/** Square of the worst measure that stages lower. */
static double worst_of(const pl_surface_run *r) {
    return r->problem.measure == PL_FACET_ACUTENESS ? r->sums.acuteness : r->sums.worst;
}

/** Try a stage: lower powers of what is above limit. It stands if the worst falls, and F does not rise
 *  above most. Errors: _MEMORY. */
static int try_stage(pl_surface_run *r, double limit, double most, int *stands, int *stopped,
                     planish_error *error) {
    const size_t bytes = (size_t)r->shape->n_nodes * sizeof *r->x;
    const double before = worst_of(r);
    int64_t most_improved = 0;
    int status = PLANISH_OK;
    void *saved = pl_skin_save(&r->skin);
    if (!saved)
        return pl_fail_memory(error, "the surface of a mesh");
    memcpy(r->before, r->x, bytes);
    memset(r->changed, 1, (size_t)r->shape->n_nodes);
    r->problem.limit = r->problem.skip = limit;
    r->problem.calm = 0;
    for (int k = 0; k < STAGE_SWEEPS && !*stopped && !status; k++) {
        pl_star_tally tally;
        status = sweep_once(r, &tally, stopped, error);
        r->result->worst_sweeps++;
        most_improved = tally.improved > most_improved ? tally.improved : most_improved;
        if (tally.improved * FEW <= most_improved)
            break;
    }
    *stands = !status && worst_of(r) < before && pl_surface_rms(&r->sums) <= most;
    if (!*stands) {
        memcpy(r->x, r->before, bytes);
        pl_skin_restore(&r->skin, saved);
        status = status ? status : pl_surface_run_measure(r, error);
    }
    pl_free(saved);
    return status;
}

/** The worst in the terms of options.worst: a ratio, degrees, or a scaled Jacobian. */
static double worst_in_words(const pl_surface_run *r) {
    const double sine = 1 / sqrt(r->sums.acuteness);
    switch (r->options->worst) {
    case PLANISH_WORST_ANGLE:
        return (90 - pl_arc_cosine(sine) * (180 / PI));
    case PLANISH_WORST_SCALED_JACOBIAN:
        return sine;
    default:
        return sqrt(r->sums.worst);
    }
}

int pl_surface_improve_worst(pl_surface_run *r, planish_error *error) {
    const planish_worst worst = r->options->worst;
    const double most = pl_surface_rms(&r->sums) * (1 + r->options->worst_rise);
    int stopped = 0, status = PLANISH_OK, failures = 0;
    double factor = STAGE_FACTOR;
    r->phase = PLANISH_PHASE_WORST;
    if (worst == PLANISH_WORST_ANGLE || worst == PLANISH_WORST_SCALED_JACOBIAN)
        r->problem.measure = PL_FACET_ACUTENESS;
    r->result->worst_before = worst_in_words(r);
    r->result->objective_of_worst = pl_surface_rms(&r->sums);
    while (!status && !stopped && failures <= HALVINGS && worst_of(r) > STAGE_LEAST * STAGE_LEAST) {
        const double reached = sqrt(worst_of(r)), next = reached * factor;
        int stands = 0;
        r->problem.worst = r->sums.worst * LIMIT_MARGIN;
        r->problem.acuteness = r->sums.acuteness * LIMIT_MARGIN;
        status = try_stage(r, next * next, most, &stands, &stopped, error);
        failures = stands ? 0 : failures + 1;
        factor = stands ? STAGE_FACTOR : 1 - (1 - factor) / 2;
    }
    r->result->worst_after = worst_in_words(r);
    return status;
}
