/* progress: progress of a command, shown on standard error and kept for the report.
 *
 *     pl_progress_init, _free       the history of the sweeps
 *     pl_progress_stage, _step      what is done now, and the sweeps: the callback of the library
 *     pl_progress_clear             before something else is printed
 */
#ifndef PL_TOOLS_PROGRESS_H
#define PL_TOOLS_PROGRESS_H

#include "options/options.h"

/** Step that a command is at. */
typedef enum pl_stage {
    PL_STAGE_READING,
    PL_STAGE_PLANNING,
    PL_STAGE_MEASURING,
    PL_STAGE_SMOOTHING, /* told by the sweeps themselves */
    PL_STAGE_CHECKING,
    PL_STAGE_WRITING
} pl_stage;

/** A sweep that was done. */
typedef struct pl_sweep {
    double rms, rms_movable, objective, seconds;
    int64_t inverted, below_min_volume, visits;
    planish_phase phase;
} pl_sweep;

typedef struct pl_progress {
    enum { PL_SHOW_NOTHING, PL_SHOW_BAR, PL_SHOW_SWEEPS, PL_SHOW_COLOURS } show;
    const pl_arguments *arguments; /* the caller's */
    int file;                      /* which of their inputs, from 0 */
    int plain;                     /* F is the RMS */
    int has_volumes;               /* some elements have a minimum volume */
    double begin;                  /* pl_seconds at the beginning */
    double write_seconds;          /* that writing is going to take, about: those of reading */
    double last_shown;             /* planish_progress.elapsed of the last update of the bar */
    double share;                  /* of the whole that the bar shows as done: never falls */
    double colour_seconds;         /* of the present sweep, when its last colour was done */
    int last_colour;               /* of the present sweep that is done; 0: none */
    int n_together;                /* calls of it that many nodes moved together before */
    int has_head;                  /* the columns of the sweeps have been named */
    pl_sweep *sweep;               /* [n_sweeps], owned */
    int64_t n_sweeps, capacity;
    int out_of_memory; /* a sweep could not be kept */
} pl_progress;

/** Quiet: nothing; verbose: a line per sweep, or colour, too; else a bar if standard error is a
 *  terminal. arguments must live as long. */
void pl_progress_init(pl_progress *progress, const pl_arguments *arguments);

/** Tell what begins now. */
void pl_progress_stage(pl_progress *progress, pl_stage stage);

/** The callback for planish_options; user is the pl_progress. Stops when a signal asked to. */
int pl_progress_step(const planish_progress *step, void *user);

/** Take the bar away, so that other text can follow. */
void pl_progress_clear(pl_progress *progress);

void pl_progress_free(pl_progress *progress);

#endif
