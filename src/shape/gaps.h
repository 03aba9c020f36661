/* gaps: sheets of a surface that are near one another. */
#ifndef PL_SHAPE_GAPS_H
#define PL_SHAPE_GAPS_H

#include "shape/curved.h"

/** Find the facets that are nearer to another one across a gap than both tolerances together:
 *  is_near [n_facets] becomes 1 for them, 0 for others. tolerance [n_facets]: how far each may
 *  move, in the shape's units. may_leave [n_facets]: 0 for a facet that stays on the shape; pairs
 *  of such facets do not count. NULL: all may leave. is_open: the surface bounds no elements, and
 *  both its sides count. Errors: _MEMORY. */
int pl_shape_find_gaps(const planish_shape *shape, const float *tolerance, const uint8_t *may_leave,
                       int is_open, int threads, uint8_t *is_near, planish_error *error);

#endif
