/* vectors: of three numbers, and classes of indices that are joined. Internal to shape. */
#ifndef PL_SHAPE_VECTORS_H
#define PL_SHAPE_VECTORS_H

#include "geometry/simplex.h"

#include <math.h>
#include <stdint.h>

/** b - a of dim numbers, the third 0 in 2-D. */
static inline void pl_from_to(int dim, const double *a, const double *b, double *v) {
    for (int d = 0; d < 3; d++)
        v[d] = d < dim ? b[d] - a[d] : 0;
}

/** Length of v [3]. */
static inline double pl_length(const double *v) {
    return sqrt(pl_dot(3, v, v));
}

/** The lowest member of i's class; parent [n] is that of each index, or itself. */
static inline int32_t pl_class_of(int32_t *parent, int32_t i) {
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

/** Join the classes of i and j; the smallest index names a class. */
static inline void pl_join(int32_t *parent, int32_t i, int32_t j) {
    const int32_t a = pl_class_of(parent, i), b = pl_class_of(parent, j);
    parent[a > b ? a : b] = a < b ? a : b;
}

#endif
