/* improve: the phases of a call beside plain sweeps.
 *
 *   phases.c             pl_run_phases: all phases, in their order
 *   slow.c               pl_run_accelerate: centring and L-BFGS for slow meshes
 *   untangle/untangle.c  pl_run_untangle, pl_run_raise_volumes: inverted or too small elements
 *   angles.c             pl_run_has_followers, pl_run_put_back_angles: keep the smallest angle
 *   worst.c              pl_run_worst: improve the worst elements
 *   augmented.c          pl_run_augmented: minimum volumes by multipliers
 *
 * A phase returns at once if options do not want it. If it makes sweeps r->stop says why they
 * ended.
 */
#ifndef PL_IMPROVE_IMPROVE_H
#define PL_IMPROVE_IMPROVE_H

#include "sweep/run.h"

/** Do all phases of a call on a run that is measured and prepared. Errors: _MEMORY, _PARTS. */
int pl_run_phases(pl_run *r, planish_error *error);

/** Move all nodes at once (a pl_accelerate_fn), counted as one sweep or several. fall: what the
 * last sweep has brought, relative. F does not rise. Not 0 if it was cut short; without memory it
 * does nothing. For the plain problem only. */
int pl_run_accelerate(pl_run *r, pl_acceleration acceleration, double fall);

/** Untangle the mesh as measured last: what is inverted or flat. If anything was done r->stop is
 *  _CONVERGED then, unless it was cut short, and the mesh is measured and prepared for sweeps.
 *  Errors: _MEMORY. */
int pl_run_untangle(pl_run *r, planish_error *error);

/** Bring elements up to their minimum volumes, as described above. Errors: _MEMORY. */
int pl_run_raise_volumes(pl_run *r, planish_error *error);

/** Whether nodes move with others, whose stars alone have been looked at: rounding may do to their
 *  own elements what it has not done to those. */
int pl_run_has_followers(const pl_run *r);

/** Put nodes back to where they were if the mesh as measured last has a smaller angle than at the
 *  start, or with followers anything else that is worse: the nodes around. How many is the
 * result's. Errors: _MEMORY. */
int pl_run_put_back_angles(pl_run *r, planish_error *error);

/** Improve the worst elements of a mesh that has been smoothed, and measured. Errors: _MEMORY. */
int pl_run_worst(pl_run *r, planish_error *error);

/** Look for a better mesh by augmented Lagrangian after the sweeps have converged with minimum
 *  volumes in force, and take it if it is one. Without memory it does nothing. */
int pl_run_augmented(pl_run *r, planish_error *error);

#endif
