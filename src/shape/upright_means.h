/* upright_means: means over the elements at the uprights of columns. Internal to shape.
 *
 *   pl_columns_sum_heights        sums of heights over the corners at each upright
 *   pl_columns_measure_heights    heights as they are
 *   pl_columns_average            means over elements and over uprights
 */
#ifndef PL_SHAPE_UPRIGHT_MEANS_H
#define PL_SHAPE_UPRIGHT_MEANS_H

#include "shape/columns.h"

/** Sums of an upright over the corners at it that decide on layers: of heights, negative of inverted
 *  corners; how many there are; of cosines between the upright and edges along the layer; and how many are
 *  not above 0. */
enum {
    PL_UPRIGHT_HEIGHTS,
    PL_UPRIGHT_CORNERS,
    PL_UPRIGHT_COSINES,
    PL_UPRIGHT_INVERTED,
    PL_UPRIGHT_SUMS
};

/** Return the sums of the uprights at c->mesh->coordinates: [n_uprights][PL_UPRIGHT_SUMS], owned by the
 *  caller; NULL: no memory. */
double *pl_columns_sum_heights(const pl_columns *c);

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
