/* entities: Gmsh's elementary entities of one physical group, which count as regions.
 *
 *     pl_entities_count    the nodes that are held between them
 *     pl_entities_note     a line on these
 */
#ifndef PL_TOOLS_ENTITIES_H
#define PL_TOOLS_ENTITIES_H

#include "job/job.h"

#include <stdio.h>

/** Count the nodes that are held for one reason: they are between elementary entities of one physical group.
 *  The count is job->n_between_entities. There is a plan. Returns 0, or an exit status after a message. */
int pl_entities_count(pl_job *job);

/** Note on stream how many nodes these are, and the option that lets them move. Print nothing if there is none. */
void pl_entities_note(FILE *stream, const pl_job *job);

#endif
