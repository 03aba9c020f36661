/* progress: what the smoothing tells while it runs: on standard error, and kept for the report. */
#include "progress.h"

#include "signals.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LINE_WIDTH = 79, BAR_WIDTH = 20, FIRST_CAPACITY = 64 };

/* Seconds between two updates of the bar: more often is not seen and only costs. */
static const double BAR_INTERVAL = 0.1;

void pl_progress_init(pl_progress *progress, const pl_arguments *arguments) {
    const pl_verbosity verbosity = arguments->verbosity;
    memset(progress, 0, sizeof *progress);
    progress->shows_objective = pl_arguments_change_objective(arguments);
    progress->last_shown = -BAR_INTERVAL;
    if (verbosity == PL_VERBOSE)
        progress->show = PL_SHOW_LINES;
    else if (verbosity == PL_NORMAL && isatty(STDERR_FILENO))
        progress->show = PL_SHOW_BAR;
}

static void keep_sweep(pl_progress *progress, const planish_progress *step) {
    if (progress->n_sweeps == progress->capacity) {
        const int64_t capacity = progress->capacity ? 2 * progress->capacity : FIRST_CAPACITY;
        pl_sweep *sweep = realloc(progress->sweep, (size_t)capacity * sizeof *sweep);
        if (!sweep) {
            progress->out_of_memory = 1;
            return;
        }
        progress->sweep = sweep;
        progress->capacity = capacity;
    }
    progress->sweep[progress->n_sweeps++] = (pl_sweep){.rms = step->rms,
                                                       .rms_movable = step->rms_movable,
                                                       .objective = step->objective,
                                                       .seconds = step->seconds,
                                                       .inverted = step->inverted,
                                                       .below_min_volume = step->below_min_volume,
                                                       .visits = step->visits,
                                                       .restoring = step->restoring,
                                                       .worst = step->worst};
}

static void show_line(const pl_progress *progress, const planish_progress *step) {
    fprintf(stderr, "sweep %d: RMS %.6g, movable %.6g", step->sweep, step->rms, step->rms_movable);
    if (progress->shows_objective)
        fprintf(stderr, ", F %.6g", step->objective);
    if (step->inverted > 0)
        fprintf(stderr, ", %" PRId64 " inverted", step->inverted);
    if (step->below_min_volume > 0)
        fprintf(stderr, ", %" PRId64 " below minimum", step->below_min_volume);
    fprintf(stderr, "%s, %" PRId64 " visits, %.3f s\n",
            step->restoring ? ", untangling"
            : step->worst   ? ", for the worst"
                            : "",
            step->visits, step->seconds);
}

/** One line, written over the last one; the bar is the share of this sweep's colours. */
static void show_bar(pl_progress *progress, const planish_progress *step) {
    if (step->elapsed - progress->last_shown < BAR_INTERVAL)
        return;
    progress->last_shown = step->elapsed;
    progress->bar_is_shown = 1;
    char bar[BAR_WIDTH + 1], state[32] = "", line[LINE_WIDTH + 1];
    const int filled = step->n_colours > 0 ? BAR_WIDTH * step->colour / step->n_colours : BAR_WIDTH;
    for (int i = 0; i < BAR_WIDTH; i++)
        bar[i] = i < filled ? '#' : '.';
    bar[BAR_WIDTH] = '\0';
    if (step->restoring && step->inverted > 0) /* the RMS would be that of the others */
        snprintf(state, sizeof state, "%" PRId64 " inverted, ", step->inverted);
    else if (progress->n_sweeps > 0)
        snprintf(state, sizeof state, "RMS %.6g, ", progress->sweep[progress->n_sweeps - 1].rms);
    snprintf(line, sizeof line, "sweep %d [%s] %s%.1f s", step->sweep, bar, state, step->elapsed);
    fprintf(stderr, "\r%-*s", LINE_WIDTH, line);
    fflush(stderr);
}

int pl_progress_step(const planish_progress *step, void *user) {
    pl_progress *progress = user;
    if (step->sweep_done)
        keep_sweep(progress, step);
    if (progress->show == PL_SHOW_LINES && step->sweep_done)
        show_line(progress, step);
    else if (progress->show == PL_SHOW_BAR)
        show_bar(progress, step);
    return pl_signals_stop_asked();
}

void pl_progress_clear(pl_progress *progress) {
    if (!progress->bar_is_shown)
        return;
    fprintf(stderr, "\r%*s\r", LINE_WIDTH, "");
    progress->bar_is_shown = 0;
}

void pl_progress_free(pl_progress *progress) {
    free(progress->sweep);
    progress->sweep = NULL;
}
