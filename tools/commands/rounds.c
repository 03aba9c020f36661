/* rounds: the sweeps, which begin again with nodes of layers held where heights have changed by much.
 *
 * A round begins at the input. So a limit or signal that ends it early leaves a mesh that is hardly smoothed,
 * but keeps more heights than the round before, which has come to its end. Both are valid. A user wants the
 * heights of layers, but not at the price of all else: an unfinished round stands if it has no more invalid
 * elements, has its heights less far off, and has had half the sweeps of the last one that stands. Else that
 * one comes back, and the note on heights says what they have become. A round for which there is less than half
 * the time of the last one does not begin.
 *
 * Every function that returns an int returns 0, or an exit status after a message.
 */
#include "commands/rounds.h"

#include "job/cells.h"
#include "job/heights.h"
#include "job/held.h"
#include "job/valid_ratios.h"
#include "terminal/message.h"
#include "terminal/signals.h"
#include "terminal/terminal.h"

#include "base/clock.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Rounds that hold more nodes, at most, and rounds that let nodes go again. */
enum { HOLDS = 7, RELEASES = 2 };

/* Part of the last round that the next one should have: of its time, to begin at all, and of its sweeps, to stand. */
static const double ENOUGH = 0.5;

/** The callback of the sweeps; user is a pl_listeners. */
static int tell(const planish_progress *step, void *user) {
    const pl_listeners *to = user;
    pl_history_take(to->history, step);
    return pl_progress_step(step, to->progress);
}

static int run_sweeps(pl_job *job, pl_result *result, pl_listeners *to) {
    const planish_result *smooth = &result->smooth;
    const pl_progress *progress = to->progress;
    planish_error error;
    char text[256];
    const double begin = pl_seconds();
    pl_signals_install_stop(); /* before, there is nothing to save: a signal just ends the program
                                */
    job->options.progress = tell;
    job->options.progress_user = to;
    const int code = job->engine->smooth(job, &result->smooth, &error);
    result->smooth_seconds = pl_seconds() - begin;
    if (code)
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    pl_progress_clear(to->progress);
    if (progress->out_of_memory) /* no reason to lose the mesh */
        pl_note(stderr,
                "%s: out of memory for the history of the sweeps; the report lacks some sweeps",
                job->arguments->output);
    if (job->arguments->verbosity >= PL_VERBOSE && pl_result_has_optimality(job)) {
        snprintf(text, sizeof text,
                 "KKT residual: largest %.3g, RMS %.3g; %" PRId64
                 " active constraints, largest multiplier %.3g",
                 smooth->kkt_residual, smooth->kkt_rms, smooth->n_active, smooth->max_multiplier);
        pl_terminal_wrap(stderr, text);
    }
    return 0;
}

/* ---- beginning again ------------------------------------------------------------------------ */

/** Whether the last sweeps have come to their end. */
static int has_ended(const pl_result *result) {
    const planish_stop stop = result->smooth.stop;
    return stop == PLANISH_STOP_CONVERGED || stop == PLANISH_STOP_MAX_SWEEPS;
}

/** Whether a limit or a signal has ended the last sweeps. */
static int is_cut(const pl_result *result) {
    const planish_stop stop = result->smooth.stop;
    return stop == PLANISH_STOP_TIME_LIMIT || stop == PLANISH_STOP_INTERRUPTED;
}

/** Whether sweeps may be repeated from the start: kept layers may have changed their heights. */
static int may_repeat(const pl_job *job, const pl_result *result) {
    return job->layers.n_kept > 0 && !job->onto.fit && !pl_signals_stop_asked() &&
           has_ended(result);
}

/** Go back to the start, with the nodes held that job->constraint fixes now. */
static int begin_again(pl_job *job, pl_result *result, pl_listeners *to) {
    const size_t size = (size_t)(job->mesh.n_nodes * job->mesh.dim) * sizeof(double);
    double *coordinates = planish_file_coordinates(job->file);
    int status;
    memcpy(coordinates, job->like.place, size);
    job->engine->plan_destroy(job);
    free(job->wrapped);
    job->wrapped = NULL;
    to->progress->n_sweeps = 0;
    pl_history_free(to->history);
    to->history = NULL;
    if ((status = pl_job_plan(job)))
        return status;
    if ((status = pl_held_count(job)))
        return status;
    pl_cells_validity_free(&result->validity_before);
    if ((status = pl_measure_valid(job, &result->before, &result->validity_before)))
        return status;
    return pl_history_begin(job, result->picture, &to->history);
}

/* ---- results that may stand in the end ------------------------------------------------------ */

/** What there is to a result: it can come back after rounds that hold more nodes. */
typedef struct standing {
    double *place;     /* [n_nodes][dim] owned */
    uint8_t *in_layer; /* [n_nodes] as that of the job; owned */
    planish_result smooth;
    int64_t n_faults; /* elements that are not valid */
    double worst;     /* by how much a height is off most */
    pl_sweep *sweep;  /* owned */
    int64_t n_sweeps;
    pl_history *history; /* owned */
} standing;

static void standing_free(standing *s) {
    free(s->place);
    free(s->in_layer);
    free(s->sweep);
    pl_history_free(s->history);
}

/** Let the result as it is now stand, in place of that in s. The listeners lose it. */
static int standing_take(standing *s, const pl_job *job, const pl_result *result,
                         pl_listeners *to) {
    const size_t n = (size_t)job->mesh.n_nodes, dim = (size_t)job->mesh.dim;
    standing_free(s);
    *s = (standing){.place = malloc((n + 1) * dim * sizeof *s->place),
                    .in_layer = calloc(n + 1, 1),
                    .smooth = result->smooth,
                    .sweep = to->progress->sweep,
                    .n_sweeps = to->progress->n_sweeps,
                    .history = to->history};
    to->progress->sweep = NULL;
    to->progress->n_sweeps = to->progress->capacity = 0;
    to->history = NULL;
    if (!s->place || !s->in_layer)
        return pl_job_complain_memory(job, "values of nodes");
    memcpy(s->place, job->mesh.coordinates, n * dim * sizeof *s->place);
    if (job->in_layer)
        memcpy(s->in_layer, job->in_layer, n);
    return 0;
}

/** Let the result that stands come back. Sweeps that a limit or signal has ended say so still. */
static int standing_return(standing *s, pl_job *job, pl_result *result, pl_listeners *to) {
    const size_t n = (size_t)(job->mesh.n_nodes * job->mesh.dim);
    const planish_stop stop = has_ended(result) ? s->smooth.stop : result->smooth.stop;
    pl_progress *progress = to->progress;
    pl_heights_hold(job, s->in_layer);
    const int status = begin_again(job, result, to);
    if (status)
        return status;
    memcpy(planish_file_coordinates(job->file), s->place, n * sizeof *s->place);
    result->smooth = s->smooth;
    result->smooth.stop = stop;
    free(progress->sweep);
    progress->sweep = s->sweep;
    progress->n_sweeps = progress->capacity = s->n_sweeps;
    pl_history_free(to->history);
    to->history = s->history;
    s->sweep = NULL;
    s->history = NULL;
    return 0;
}

/* ---- rounds --------------------------------------------------------------------------------- */

/** What the rounds have come to. */
typedef struct rounds {
    uint8_t *in_layer; /* [n_nodes] those that are held next; owned */
    int n_holds;       /* rounds that hold more nodes, */
    int n_releases;    /* and that let nodes go */
    double seconds;    /* of the last round */
    double worst;      /* after it, by how much a height is off most, if more nodes are held next */
    int is_tangled;    /* the mesh had elements that are not valid; 0: there are none */
    uint8_t *is_faulty; /* [n_elements] not valid now; owned; NULL: there are none */
    int64_t n_faults;   /* of these, */
    int64_t n_first;    /* and after the first round */
    standing standing;  /* after the last round that was followed by one that holds more nodes */
} rounds;

static void rounds_free(rounds *r) {
    free(r->in_layer);
    free(r->is_faulty);
    standing_free(&r->standing);
}

static int begin_rounds(const pl_job *job, const pl_result *result, rounds *r) {
    *r = (rounds){.in_layer = malloc((size_t)job->mesh.n_nodes + 1),
                  .is_tangled =
                      pl_cells_validity_faults(&result->validity_before, &result->before) > 0};
    return r->in_layer ? 0 : pl_job_complain_memory(job, "values of nodes");
}

/** Find the elements that are not valid after a round. */
static int find_faults(const pl_job *job, rounds *r) {
    if (!r->is_tangled)
        return 0;
    free(r->is_faulty);
    r->is_faulty = NULL;
    r->n_faults = 0;
    const int status = pl_cells_find_faults(job, &r->is_faulty);
    for (int64_t i = 0; !status && i < job->mesh.n_elements; i++)
        r->n_faults += r->is_faulty[i];
    return status;
}

/** Choose more nodes to be held, or fewer, without those around elements that are not valid as nodes are
 *  held; *n: how many change. */
static int choose_nodes(pl_job *job, rounds *r, int64_t *n) {
    *n = 0;
    if (r->n_faults > r->n_first && r->n_releases < RELEASES) {
        r->n_releases++;
        *n = pl_heights_release(job, r->is_faulty, r->in_layer);
    } else if (r->n_faults <= r->n_first && r->n_holds < HOLDS) {
        return pl_heights_choose(job, ++r->n_holds == HOLDS, r->in_layer, n, &r->worst);
    }
    return 0;
}

/** Whether enough is left of the time for another round. */
static int has_time(const pl_result *result, double limit, const rounds *r) {
    return limit <= 0 || limit - result->smooth_seconds >= ENOUGH * r->seconds;
}

/** Smooth again from the start, in what is left of the time, with the chosen nodes held. The result as it is
 *  now stands, unless nodes are let go as it leaves too many elements that are not valid. */
static int run_again(pl_job *job, pl_result *result, pl_listeners *to, double limit, rounds *r) {
    static const double LEAST = 1e-3;
    const double before = result->smooth_seconds;
    int status = 0;
    if (r->n_faults <= r->n_first) {
        status = standing_take(&r->standing, job, result, to);
        r->standing.n_faults = r->n_faults;
        r->standing.worst = r->worst;
    }
    if (status)
        return status;
    pl_heights_hold(job, r->in_layer);
    if (limit > 0)
        job->options.time_limit = limit - before > LEAST ? limit - before : LEAST;
    status = begin_again(job, result, to);
    if (!status)
        status = run_sweeps(job, result, to);
    r->seconds = result->smooth_seconds;
    result->smooth_seconds += before;
    return status ? status : find_faults(job, r);
}

/** Find whether a round that was ended early is to stand: see the beginning of this file. */
static int stands(const pl_job *job, const pl_result *result, const rounds *r, int *is_standing) {
    const standing *last = &r->standing;
    double worst = 0;
    *is_standing =
        r->n_faults <= last->n_faults && result->smooth.sweeps >= ENOUGH * last->smooth.sweeps;
    const int status = *is_standing ? pl_heights_find_worst(job, &worst) : 0;
    *is_standing &= worst < last->worst;
    return status;
}

/** Find whether the result is to give way to the one that stands. */
static int gives_way(const pl_job *job, const pl_result *result, const rounds *r, int *is_worse) {
    int is_standing = r->n_faults <= r->n_first;
    int status = 0;
    if (r->standing.place && is_cut(result))
        status = stands(job, result, r, &is_standing);
    *is_worse = !is_standing;
    return status;
}

/** Hold nodes in rounds until no heights change by much; the mesh has been smoothed once. */
static int hold_in_rounds(pl_job *job, pl_result *result, pl_listeners *to, rounds *r) {
    const double limit = job->options.time_limit;
    int64_t n = 1;
    int is_worse, is_late = 0, status = find_faults(job, r);
    r->n_first = r->n_faults;
    r->seconds = result->smooth_seconds;
    while (!status && n > 0 && !is_late && may_repeat(job, result)) {
        status = choose_nodes(job, r, &n);
        is_late = n > 0 && !has_time(result, limit, r);
        if (!status && n > 0 && !is_late)
            status = run_again(job, result, to, limit, r);
        if (r->n_faults > r->n_first && has_ended(result) && job->wanted.n_faults == 0)
            job->wanted.n_faults = r->n_faults - r->n_first;
    }
    job->options.time_limit = limit;
    if (!status)
        status = gives_way(job, result, r, &is_worse);
    if (!status && is_worse)
        status = standing_return(&r->standing, job, result, to);
    if (is_late)
        result->smooth.stop = PLANISH_STOP_TIME_LIMIT;
    return status;
}

int pl_rounds_smooth(pl_job *job, pl_result *result, pl_listeners *to) {
    rounds r;
    int status = run_sweeps(job, result, to);
    if (status || !may_repeat(job, result))
        return status;
    status = begin_rounds(job, result, &r);
    if (!status)
        status = hold_in_rounds(job, result, to, &r);
    rounds_free(&r);
    return status;
}
