/* begin_end: begin and end of a run: the caller's coordinates into the plan, and back. */
#ifndef PL_SWEEP_BEGIN_END_H
#define PL_SWEEP_BEGIN_END_H

#include "sweep/run.h"

/** Begin a run that has plan, coordinates, options, accelerate, start_seconds and result: bring the
 *  coordinates into the plan, make the guard and the watch, measure, and prepare the sweeps. Errors:
 *  those of pl_guard_create and pl_watch_create, _MEMORY. */
int pl_run_begin(pl_run *r, planish_error *error);

/** Begin such a run only as far as its guard, watch and skin, which then know what they hold. Targets by
 *  sizes stay as they are. Nothing but pl_run_destroy may follow. Errors: as of pl_run_begin. */
int pl_run_begin_limits(pl_run *r, planish_error *error);

/** End a run: write the nodes that have moved to the caller's coordinates, unless memory was
 *  lacking or another process is not reached, and fill the result. Errors: _MEMORY, _PROCESS. */
int pl_run_end(pl_run *r, planish_error *error);

/** Free the memory of a run, also after an error. */
void pl_run_destroy(pl_run *r);

#endif
