/* pn: points of PN triangles and cubic arcs. */
#ifndef PL_SHAPE_PN_H
#define PL_SHAPE_PN_H

#include "shape/curved.h"

/** Compute where a place is: on the PN triangle with its unit normal, or on the cubic arc with its
 *  unit tangent. */
void pl_shape_point(const planish_shape *shape, int node_class, const pl_place *place,
                    double point[3], double direction[3]);

#endif
