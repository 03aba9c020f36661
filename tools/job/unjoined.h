/* unjoined: quadrilateral faces against two triangles, where elements do not share faces.
 *
 *     pl_unjoined_count    these faces, and their nodes
 *     pl_unjoined_note     a line on them
 */
#ifndef PL_TOOLS_UNJOINED_H
#define PL_TOOLS_UNJOINED_H

#include "job/job.h"

#include <stdio.h>

/** Count the quadrilateral faces of one element that have two triangles of other elements on the other side,
 *  and their corners: job->n_unjoined_faces and job->n_unjoined_nodes. Both kinds of faces count as
 *  boundary, so that these nodes do not leave it. There is a plan. Returns 0, or an exit status after a message. */
int pl_unjoined_count(pl_job *job);

/** Note on stream how many faces and nodes these are, and how to join the elements. Print nothing if there is none. */
void pl_unjoined_note(FILE *stream, const pl_job *job);

#endif
