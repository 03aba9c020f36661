/* progress: what the smoothing tells while it runs: on standard error, and kept for the report. */
#ifndef PL_TOOLS_PROGRESS_H
#define PL_TOOLS_PROGRESS_H

#include "options.h"

/** A sweep that was done. */
typedef struct pl_sweep {
    double rms, rms_movable, objective, seconds;
    int64_t inverted, below_min_volume, visits;
    int restoring, worst; /* as in planish_progress */
} pl_sweep;

typedef struct pl_progress {
    enum { PL_SHOW_NOTHING, PL_SHOW_BAR, PL_SHOW_LINES } show;
    int shows_objective; /* F is another number than the RMS */
    double last_shown;   /* planish_progress.elapsed of the last update of the bar */
    int bar_is_shown;
    pl_sweep *sweep; /* [n_sweeps], owned */
    int64_t n_sweeps, capacity;
    int out_of_memory; /* a sweep could not be kept */
} pl_progress;

/** Quiet: nothing; verbose: a line per sweep; else a bar if standard error is a terminal. */
void pl_progress_init(pl_progress *progress, const pl_arguments *arguments);

/** The callback for planish_options; user is the pl_progress. Stops when a signal asked to. */
int pl_progress_step(const planish_progress *step, void *user);

/** Take the bar away, so that other text can follow. */
void pl_progress_clear(pl_progress *progress);

void pl_progress_free(pl_progress *progress);

#endif
