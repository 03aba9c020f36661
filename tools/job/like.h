/* like: the target of each element is its shape in another file, --like FILE.
 *
 *     pl_like_read      read FILE, and check that it fits
 *     pl_like_free      what that keeps
 *
 * Where there is such a file all ratios are aspect ratios AR against the targets, of simplices, too, and the
 * mesh of the job has cells.
 */
#ifndef PL_TOOLS_LIKE_H
#define PL_TOOLS_LIKE_H

#include "job/job.h"

/** Read the file of --like, if there is one, for the mesh of job, which has all elements of its file: they must
 *  be the same there. Fills job->like, and gives the mesh cells. Returns 0, or an exit status after a message. */
int pl_like_read(pl_job *job);

void pl_like_free(pl_job *job);

#endif
