/* heights: how high the uprights of columns are, and are to be. Internal to shape.
 *
 *   pl_columns_find_heights       those of the input, and what the growth tells of others
 */
#ifndef PL_SHAPE_HEIGHTS_H
#define PL_SHAPE_HEIGHTS_H

#include "shape/columns.h"

/** Fill side, height, leans, told and is_moved: from the input, and if is_smooth smoothed along the rows. Errors:
 *  _MEMORY. */
int pl_columns_find_heights(pl_columns *c, int is_smooth, planish_error *error);

#endif
