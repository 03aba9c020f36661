/* heights: how long the uprights of columns are to be. Internal to shape.
 *
 *   pl_columns_smooth_heights     those of the input, smoothed
 *   pl_columns_average            means over elements and over uprights
 */
#ifndef PL_SHAPE_HEIGHTS_H
#define PL_SHAPE_HEIGHTS_H

#include "shape/columns.h"

/** Fill height: from the input, smoothed. */
int pl_columns_smooth_heights(pl_columns *c, int threads, planish_error *error);

/** Put the means over the uprights of each element of value [n_uprights] in of_cell [n_cells], and
 *  over the elements of each upright of these back in value: rounds times. The mean is
 *  sqrt(sum x / sum 1 / x), nearly the geometric one; values that are not above 0 do not count.
 *  Errors: _MEMORY. */
int pl_columns_average(const pl_columns *c, int rounds, double *value, double *of_cell,
                       planish_error *error);

#endif
