/* displaced: nodes that are not where their columns want them. Internal to shape.
 *
 *   pl_displaced_share     heights of rows that a node between them was displaced through
 *   pl_displaced_wall      whether a wall was moved at an end of a side
 */
#ifndef PL_SHAPE_DISPLACED_H
#define PL_SHAPE_DISPLACED_H

#include "shape/columns.h"

/** Share heights where a node inside a side was displaced through its neighbours: length [n_uprights], not
 *  above 0 of those that point the other way, and above 0 afterwards. is_shared [n_uprights] becomes 1 for
 *  those that were changed; others stay as they are. The sides are known. */
void pl_displaced_share(const pl_columns *c, double *length, uint8_t *is_shared);

/** Whether the node at an end of a column was displaced, and not the next one: the first row is off the rows
 *  inside, and the second one is not off by as much the other way. length as above, but above 0 also of a first
 *  row that is_turned. place: of the first upright; step: 1 or -1, the way inside. 0: there are too few
 *  rows to know. */
int pl_displaced_wall(const pl_columns *c, const double *length, int64_t side, int64_t place,
                      int step, int is_turned);

#endif
