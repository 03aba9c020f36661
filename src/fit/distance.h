/* distance: how far the surfaces of a fit are apart. */
#ifndef PL_FIT_DISTANCE_H
#define PL_FIT_DISTANCE_H

#include "fit/fit.h"

/** How far the surface of the mesh and the other one are apart. */
typedef struct pl_fit_distance {
    double there, back; /* no point of the mesh's surface is farther off the other one; and back */
    double there_h, back_h; /* in mean edges of the mesh's surface */
    int64_t n_unproved;     /* facets without a bound: their coordinates are not finite */
} pl_fit_distance;

/** Measure that of the mesh with nodes at points. Same bits on any number of threads. Errors: _MEMORY. */
int pl_fit_measure(const planish_fit *fit, const pl_points *points, pl_fit_distance *distance,
                   planish_error *error);

#endif
