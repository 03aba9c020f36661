/* improve: the phases of a call beside plain sweeps.
 *
 *   phases.c             pl_run_phases: all phases, in their order
 *   sized.c              pl_run_sized_sweeps: sizes that depend on where elements are
 *   slow.c               pl_run_accelerate: for slow meshes
 *   coarse.c             pl_run_coarse: Newton's steps on a lattice
 *   untangle/untangle.c  pl_run_untangle, pl_run_raise_volumes: inverted or too small elements
 *   angles.c             pl_run_put_back_angles: keep the smallest angle
 *   worst.c              pl_run_worst: improve the worst elements; joint.h, maxmin.h: joint steps
 *   mend/curved.c        pl_run_mend_curved, _improve_curved, pl_mark_hopeless: mids of curved
 *                        elements
 *   augmented.c          pl_run_augmented: minimum volumes by multipliers
 *
 * The table in phases.c says when each phase is run. If it makes sweeps r->stop says why they ended.
 */
#ifndef PL_IMPROVE_IMPROVE_H
#define PL_IMPROVE_IMPROVE_H

#include "sweep/run.h"

/** Do all phases of a call on a run that is measured and prepared. Errors: _MEMORY. */
int pl_run_phases(pl_run *r, planish_error *error);

/** Sweep a mesh whose plan has sizes until that converges or must end: r->stop says why. F against the
 *  targets where the elements are is lower then, or nothing has moved. Errors: _MEMORY. */
int pl_run_sized_sweeps(pl_run *r, planish_error *error);

/** Move all nodes at once (a pl_accelerate_fn), counted as one sweep or several. fall: relative
 *  fall that the last sweep has brought. F does not rise. Return not 0 if the work was cut short;
 *  without memory do nothing. For the plain problem only. */
int pl_run_accelerate(pl_run *r, pl_acceleration acceleration, double fall);

/** Make Newton's steps for smooth displacements, and sweeps between them, while they pay. F does not
 *  rise, no element becomes inverted or worse than the worst. Return not 0 if the work was cut short;
 *  without memory, and on other meshes than of linear elements and the plain problem, do nothing. */
int pl_run_coarse(pl_run *r);

/** Climb the ladder for elements that are inverted or flat in the mesh as measured last. If
 *  anything was done, r->stop is _CONVERGED then unless the work was cut short, and the mesh is
 *  measured and prepared for sweeps. Errors: _MEMORY. */
int pl_run_untangle(pl_run *r, planish_error *error);

/** Climb the ladder for elements below their minimum volume. Errors: _MEMORY. */
int pl_run_raise_volumes(pl_run *r, planish_error *error);

/** Put nodes back to their start around elements that are worse than at the start: in the mesh as
 *  measured last, by a smaller angle or, with followers, by anything else. r->result->n_put_back
 *  counts them. Errors: _MEMORY. */
int pl_run_put_back_angles(pl_run *r, planish_error *error);

/** Improve the worst elements of a mesh that has been smoothed, and measured. Errors: _MEMORY. */
int pl_run_worst(pl_run *r, planish_error *error);

/** Prove which invalid curved elements stay so wherever free nodes go, and repair others by moving
 *  their mids, and corners where that helps. No element becomes invalid. The mesh is measured, and
 *  prepared for sweeps. r->result counts. Errors: _MEMORY. */
int pl_run_mend_curved(pl_run *r, planish_error *error);

/** Improve the curved elements below options.curve_quality of a mesh that has been smoothed, and
 *  measured: by their mids alone. Errors: _MEMORY. */
int pl_run_improve_curved(pl_run *r, planish_error *error);

/** Mark in state [n_elements of the plan], as PLANISH_VOLUME_INFEASIBLE, the curved simplices of
 *  coordinates that are proved invalid wherever free nodes go. given [n][dim]: those of the plan's
 *  nodes. Writes the plan's own coordinates. Errors: _MESH (a mid that is not finite), _MEMORY.
 */
int pl_mark_hopeless(const planish_plan *plan, const planish_options *options, const double *given,
                     const double *coordinates, pl_stop_check *limit, uint8_t *state,
                     planish_error *error);

/** Look for a better mesh by the augmented Lagrangian method, after the sweeps have converged with
 *  minimum volumes in force. Keep the mesh if it is better. Without memory it does nothing. */
int pl_run_augmented(pl_run *r, planish_error *error);

#endif
