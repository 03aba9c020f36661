/* walk: the nearest place on a shape, from another one of the same patch or curve. */
#ifndef PL_SHAPE_WALK_H
#define PL_SHAPE_WALK_H

#include "shape/curved.h"

/** Set place to the nearest one to point, on straight triangles or edges, on the way from place->at
 *  downhill: never across a feature; of a curve never beyond its corners. node_class: of the node whose
 *  place it is. Returns the distance. */
double pl_shape_walk(const planish_shape *shape, int node_class, const double point[3],
                     pl_place *place);

/** Return the place where a node was first; of a corner at is -1. */
pl_place pl_shape_first_place(const planish_shape *shape, int32_t node);

#endif
