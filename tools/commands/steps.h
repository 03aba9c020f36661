/* steps: from a mesh that has been read to its smoothed nodes; nothing is written.
 *
 *     pl_steps_check     whether there is anything to smooth
 *     pl_steps_smooth    plan, measure, smooth, measure, check
 *     pl_steps_compare   the same for nodes that somebody else has moved
 *     pl_steps_free      what a result owns
 */
#ifndef PL_TOOLS_STEPS_H
#define PL_TOOLS_STEPS_H

#include "report/result.h"

/** Return 0, or an exit status after a message: the mesh has no element of a type that is smoothed. */
int pl_steps_check(const pl_job *job);

/** Smooth the mesh of job in place, and find out what came of it. Returns 0, or an exit status after a
 *  message. */
int pl_steps_smooth(pl_job *job, pl_result *result, pl_progress *progress);

/** Measure the mesh of job before and after its nodes go to their places in the file after, which has the
 *  same elements: as pl_steps_smooth, but nothing is smoothed, and nothing is promised. */
int pl_steps_compare(pl_job *job, const planish_file *after, pl_result *result,
                     pl_progress *progress);

/** Release what the result owns. */
void pl_steps_free(pl_result *result);

#endif
