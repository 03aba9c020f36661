/* heights: how high the uprights of columns are, and are to be. Internal to shape.
 *
 *   pl_columns_find_heights       those of the input, and what the growth tells of others
 *   pl_columns_measure_heights    as they are
 *   pl_columns_average            means over elements and over uprights
 */
#ifndef PL_SHAPE_HEIGHTS_H
#define PL_SHAPE_HEIGHTS_H

#include "shape/columns.h"

/** Fill height, leans, is_told and is_moved: from the input, and if is_smooth smoothed along the rows. Errors:
 *  _MEMORY. */
int pl_columns_find_heights(pl_columns *c, int is_smooth, planish_error *error);

/** Measure the heights of the uprights at c->mesh->coordinates: height [n_uprights], negative of inverted
 *  ones, NAN of those of simplices whose levels are not known. Errors: _MEMORY. */
int pl_columns_measure_heights(const pl_columns *c, double *height, planish_error *error);

/** Put the means over the uprights of each element of value [n_uprights] in of_cell [n_cells], and
 *  over the elements of each upright of these back in value: rounds times. The mean is
 *  sqrt(sum x / sum 1 / x), nearly the geometric one; values that are not above 0 do not count.
 *  Errors: _MEMORY. */
int pl_columns_average(const pl_columns *c, int rounds, double *value, double *of_cell,
                       planish_error *error);

#endif
