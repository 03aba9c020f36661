/* trial: change the mesh, and keep the change or undo it.
 *
 *   pl_trial_begin    keep a copy of the mesh
 *   pl_trial_end      accept the mesh as it is now, or restore the copy
 */
#ifndef PL_SWEEP_TRIAL_H
#define PL_SWEEP_TRIAL_H

#include "sweep/run.h"

/** A trial under way. */
typedef struct pl_trial {
    pl_run *run;
    pl_worth standing; /* of the mesh that stands */
    double *before;    /* its coordinates, the caller's array */
} pl_trial;

/** Begin a trial with the mesh as measured last. before [n_nodes][dim] is room for coordinates, and
 *  stays the caller's. Progress reports show what stands until the trial ends. */
void pl_trial_begin(pl_run *r, double *before, pl_trial *trial);

/** End the trial. is_taken: the mesh as it is now, and measured, stands from now on. Else the
 *  coordinates from before come back and are measured. */
void pl_trial_end(const pl_trial *trial, int is_taken);

#endif
