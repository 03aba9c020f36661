/* moved: the nodes of a mesh go where another file has them. */
#ifndef PL_TOOLS_MOVED_H
#define PL_TOOLS_MOVED_H

#include "job/job.h"

/** Move the nodes of the job's mesh to their places in after, which has the same elements, and count in
 *  *moved the nodes that are elsewhere there, and how far. Where one of the files has single precision,
 *  nodes that are no farther apart than its digits tell are not elsewhere. Returns 0, or an exit status after
 *  a message. */
int pl_moved_take(pl_job *job, const planish_file *after, planish_result *moved);

/** Set job->goal to the box of those places. As pl_moved_take. */
int pl_moved_bound(pl_job *job, const planish_file *after);

/** Compute the checksum of the coordinates that file has, as pl_job_checksum of a job with this file. */
uint64_t pl_moved_checksum(const planish_file *file);

#endif
