/* layers: elements thin in layers, which smoothing would make regular: held, or warned of.
 *
 *     pl_layers_count       find them
 *     pl_layers_print       the note on them; pl_layers_are_many: whether there is one
 */
#ifndef PL_TOOLS_LAYERS_H
#define PL_TOOLS_LAYERS_H

#include "job/job.h"

#include <stdio.h>

/** Without --fix-layers, and unless quality (of the mesh as it is) rules out that there are many:
 *  count the elements that are thin in layers, and those of them with a node that moves. There is a
 *  plan. Returns 0, or an exit status after a message. */
int pl_layers_count(pl_job *job, const planish_quality *quality);

/** Say how many elements are held; or how many are not, if there are enough, and what keeps them as
 *  they are. */
void pl_layers_print(FILE *stream, const pl_job *job);

/** Whether n of n_elements are so many that they are spoken of. */
int pl_layers_are_many(int64_t n, int64_t n_elements);

#endif
