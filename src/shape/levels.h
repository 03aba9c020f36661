/* levels: how high nodes are in columns of layers that simplices join. Internal to shape.
 *
 *   pl_columns_find_levels     level and is_level of simplices, and the uprights beside theirs
 */
#ifndef PL_SHAPE_LEVELS_H
#define PL_SHAPE_LEVELS_H

#include "shape/columns.h"

/** Fill level and is_level of the simplices of c, whose columns are known, and add the uprights beside
 *  theirs to upright. Errors: _MEMORY. */
int pl_columns_find_levels(pl_columns *c, planish_error *error);

#endif
