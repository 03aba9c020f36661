/* smooth: the last steps of the command, for programs that read and write meshes otherwise (mpi/).
 */
#ifndef PL_TOOLS_SMOOTH_H
#define PL_TOOLS_SMOOTH_H

#include "report/result.h"

/** The library promises not to make anything worse; a mesh that says otherwise is not written.
 *  Laplacian methods promise nothing; F and the ratios are over the valid elements, and to untangle
 *  others, or bring them above their minimum volume, may cost both. Returns 0, or an exit status
 *  after a message. */
int pl_smooth_check(const pl_job *job, const pl_result *result);

/** Tell of the plan, what is odd about the mesh first; and with -v how near the end is to a local
 *  optimum. */
void pl_smooth_tell_plan(const pl_job *job);
void pl_smooth_tell_end(const pl_job *job, const planish_result *smooth);

/** Tell what came of it, once the mesh is written: table, JSON and page; report: 0, or the exit
 *  status if what they need is not there. Returns the exit status. */
int pl_smooth_tell(const pl_job *job, pl_result *result, const pl_progress *progress, int report);

#endif
