/* sides: parts of columns that rise from one wall. Internal to shape.
 *
 *   pl_columns_find_sides     cut columns where heights fall and rise again
 */
#ifndef PL_SHAPE_SIDES_H
#define PL_SHAPE_SIDES_H

#include "shape/columns.h"

/** Fill side and n_sides: layers on both sides of a surface make one column and two sides. length
 *  [n_uprights]: negative of those that point the other way. Errors: _MEMORY. */
int pl_columns_find_sides(pl_columns *c, const double *length, planish_error *error);

#endif
