/* progress: what is told while a command works: on standard error, and kept for the report. */
#include "job/progress.h"

#include "job/bar.h"
#include "terminal/signals.h"
#include "terminal/terminal.h"

#include "base/clock.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_CAPACITY = 64 };

void pl_progress_init(pl_progress *progress, const pl_arguments *arguments) {
    const pl_verbosity verbosity = arguments->verbosity;
    memset(progress, 0, sizeof *progress);
    progress->arguments = arguments;
    progress->plain = !pl_arguments_change_objective(arguments);
    progress->has_volumes = pl_arguments_bound_volumes(arguments);
    progress->begin = pl_seconds();
    progress->last_shown = -1;
    if (verbosity >= PL_VERBOSE)
        progress->show = verbosity == PL_VERBOSE ? PL_SHOW_SWEEPS : PL_SHOW_COLOURS;
    else if (verbosity == PL_NORMAL && pl_terminal_is(stderr))
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

/* ---- lines per sweep and colour: columns of 5, 12, 12, 9, (9,) 11 and 9 characters ---------- */

/** The names of the columns, once. */
static void show_head(pl_progress *progress) {
    if (progress->has_head)
        return;
    progress->has_head = 1;
    fprintf(stderr, "%s%5s%12s%12s%9s%s%11s%9s  phase%s\n",
            pl_style_begin(stderr, PL_STYLE_HEADING), "sweep", "RMS",
            progress->plain ? "movable" : "F", "inverted", progress->has_volumes ? "    below" : "",
            "visits", "seconds", pl_style_end(stderr, PL_STYLE_HEADING));
}

static void show_sweep(const pl_progress *progress, const planish_progress *step) {
    fprintf(stderr, "%5d%12.6g%12.6g%9" PRId64, step->sweep, step->rms,
            progress->plain ? step->rms_movable : step->objective, step->inverted);
    if (progress->has_volumes)
        fprintf(stderr, "%9" PRId64, step->below_min_volume);
    fprintf(stderr, "%11" PRId64 "%9.3f  %s\n", step->visits, step->seconds,
            step->restoring ? "untangling"
            : step->worst   ? "worst"
                            : "smoothing");
}

/** Colours come one after another; many nodes that move together are of no colour. */
static void name_step(pl_progress *progress, const planish_progress *step, char *name,
                      size_t size) {
    if (step->colour == progress->last_colour + 1) {
        progress->last_colour = step->colour;
        snprintf(name, size, "colour %d/%d", step->colour, step->n_colours);
    } else {
        progress->n_together++;
        snprintf(name, size, "step %d", progress->n_together);
    }
}

static void show_colour(pl_progress *progress, const planish_progress *step) {
    char name[64];
    name_step(progress, step, name, sizeof name);
    fprintf(stderr, "%5s  %-*s%11" PRId64 "%9.3f\n", "", progress->has_volumes ? 40 : 31, name,
            step->colour_visits, step->seconds - progress->colour_seconds);
    progress->colour_seconds = step->seconds;
}

static void show_lines(pl_progress *progress, const planish_progress *step) {
    show_head(progress);
    if (!step->sweep_done && step->colour > 0 && progress->show == PL_SHOW_COLOURS)
        show_colour(progress, step);
    if (!step->sweep_done)
        return;
    show_sweep(progress, step);
    progress->colour_seconds = 0;
    progress->last_colour = progress->n_together = 0;
}

/* ---- what the others call ------------------------------------------------------------------- */

void pl_progress_phase(pl_progress *progress, pl_phase phase) {
    if (phase == PL_PHASE_PLANNING)
        progress->write_seconds = pl_seconds() - progress->begin;
    if (progress->show == PL_SHOW_BAR)
        pl_bar_phase(progress, phase);
}

int pl_progress_step(const planish_progress *step, void *user) {
    pl_progress *progress = user;
    if (step->sweep_done)
        keep_sweep(progress, step);
    if (progress->show >= PL_SHOW_SWEEPS)
        show_lines(progress, step);
    else if (progress->show == PL_SHOW_BAR)
        pl_bar_step(progress, step);
    return pl_signals_stop_asked();
}

void pl_progress_clear(pl_progress *progress) {
    if (progress->show == PL_SHOW_BAR)
        pl_line_clear();
}

void pl_progress_free(pl_progress *progress) {
    pl_progress_clear(progress);
    free(progress->sweep);
    progress->sweep = NULL;
}
