/* job: what all commands on a mesh share: its file, the nodes that this holds, and a plan.
 *
 *     pl_job_read, _close                  the file, with constraints, minimum volumes and the box
 *     pl_job_find_slides, _count_slides    nodes that slide, or could
 *     pl_job_find_layers, _layer_mesh, _hold_layers    boundary layers
 *     pl_job_plan, _get_free, _measure     by the engine
 *
 * Every function returns 0, or an exit status after a message.
 */
#ifndef PL_TOOLS_JOB_H
#define PL_TOOLS_JOB_H

#include "job/engine.h"
#include "job/job_state.h"

/** Read the file of arguments and find out which nodes it holds and what bounds there are. */
int pl_job_read(pl_job *job, const pl_arguments *arguments, const pl_engine *engine);

/** Whether the file has elements that job->mesh does not, as it is that of the command quality. */
int pl_job_lacks_types(const pl_job *job);

/** Put all elements of the file in job->mesh, in a copy of a job of the command quality. */
void pl_job_take_all(pl_job *job);

/** Find the nodes that slide, if any shall. */
int pl_job_find_slides(pl_job *job);

/** Find the elements of any type that are thin in layers, and their number *n: is_layer
 *  [mesh.n_elements, and one for each other element of planish_file_cells], owned by the caller also
 *  after an error. */
int pl_job_find_layers(const pl_job *job, uint8_t **is_layer, int64_t *n);

/** The mesh with all elements that are looked at for layers, in cells where it is not job->mesh. */
int pl_job_layer_mesh(const pl_job *job, planish_cells *cells, planish_mesh *mesh);

/** Fix the nodes of layers that are held, if there are any, in constraint [n_nodes]. */
void pl_job_hold_layers(const pl_job *job, uint8_t *constraint);

/** Whether scaled Jacobians count: elements are not to be like others that may be sharp. */
int pl_job_is_blunt(const pl_job *job);

/** Objective that is minimised: of a mesh with elements of other types the mean ratio by default. */
planish_objective pl_job_objective(const pl_job *job);

/** Whether F is another number than the RMS of the measure of the mesh, radius or aspect ratio. */
int pl_job_changes_objective(const pl_job *job);

/** Make the plan. */
int pl_job_plan(pl_job *job);

/** Whether anything is going to be said of the mesh: in a table, or a report. */
int pl_job_is_told(const pl_job *job);

/** Count, once there is a plan, the nodes that may move while parameters, or boundary conditions, in the file
 *  do not. */
int pl_job_count_bound(pl_job *job);

/** Count and mark the nodes that could slide, if none shall and any may move; there is a plan. */
int pl_job_count_slides(pl_job *job);

/** Make room for the marks of held nodes, job->released_by, unless there is room already. */
int pl_job_need_released_by(pl_job *job);

/** is_free [mesh.n_nodes] as planish_plan_get_free. */
int pl_job_get_free(const pl_job *job, uint8_t *is_free);

/** planish_checksum of the mesh as it is now; in a tilted plane, of its places in space. */
uint64_t pl_job_checksum(const pl_job *job);

/** Whether an angle in degrees is smaller than it was, by more than rounding explains: that of a
 *  sliver's is that of its volume. */
int pl_angle_is_smaller(double after, double before);

/** Measure the mesh as it is now; measures over no element are NAN. */
int pl_job_measure(const pl_job *job, planish_quality *quality);

void pl_job_close(pl_job *job);

#endif
