/* distance: how far a surface that has moved is off the first one, and the first one off it. */
#ifndef PL_SHAPE_DISTANCE_H
#define PL_SHAPE_DISTANCE_H

#include "shape/curved.h"

/** Proved distances of a surface that has moved. Lengths are in the shape's units. */
typedef struct pl_shape_distance {
    double there;           /* no point of the new surface is farther off the first one, */
    double back;            /* and none of the first one off the new one; infinite: not proved */
    double there_h, back_h; /* the largest of the same in units of pl_shape_edge */
    int64_t n_unproved;     /* facets of either without a bound: their coordinates are not finite */
    double sharpest;        /* cosine between facets at a smooth edge: the least */
} pl_shape_distance;

/** Measure the surface whose nodes are at x [n_nodes][3], in the shape's units; place [n_nodes]: of
 *  nodes on patches and curves where they are, at -1 where not known. Same bits on any number of
 *  threads. Errors: _MEMORY. */
int pl_shape_measure(const planish_shape *shape, const double (*x)[3], const pl_place *place,
                     int threads, pl_shape_distance *distance, planish_error *error);

/** Return the cosine of the largest angle between facets at edges that are not features. */
double pl_shape_sharpest(const planish_shape *shape, int threads);

#endif
