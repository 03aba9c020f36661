/* copies: nodes that a file gives more than once, with the same coordinates. */
#ifndef PL_IO_CORE_COPIES_H
#define PL_IO_CORE_COPIES_H

#include "io/core/model.h"

/** Make one node of all that have the same number: model->place_node. Fails if their coordinates
 *  differ. Only for readers that have nothing but xyz, hold and node_number of nodes yet. */
int io_unite_copies(io_model *model, planish_error *error);

/** The coordinates of places in the file, as many as are written of each: nodes where each has one,
 *  else *owned, to be released by pl_free. */
int io_copies_places(const io_model *model, const double *nodes, int threads, const double **places,
                     double **owned, planish_error *error);

#endif
