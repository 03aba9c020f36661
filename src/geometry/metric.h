/* metric: lengths that depend on the direction.
 *
 * A metric is a symmetric positive definite matrix M. The length of an edge e in it is the root of
 * e^T M e. An element with edges of length 1 is thin in the directions of M's large eigenvalues.
 * Its sizes H = M^(-1/2) have the same eigenvectors, and the edge lengths along these as
 * eigenvalues. Means of sizes are sizes again, and of those that are the same in all directions,
 * plain means.
 *
 * A corner with the edges A that is to be ideal in a metric has T = L A V in the place of A V
 * (geometry/target.h), where L is the upper triangle of M = det(M)^(1 / dim) L^T L, so that det L = 1.
 *
 * Symmetric matrices stand as m11, m12, m22, m13, m23, m33; in the plane as m11, m12, m22.
 *
 *   pl_symmetric_at, pl_symmetric_count    entries of symmetric matrices
 *   pl_metric_sizes                        H of M
 *   pl_metric, pl_metric_make              L of H
 *   pl_metric_apply                        L times edges
 */
#ifndef PL_GEOMETRY_METRIC_H
#define PL_GEOMETRY_METRIC_H

#include "geometry/inline.h"

enum { PL_MOST_SYMMETRIC = 6 }; /* in space */

/** Entries of a symmetric matrix. */
PL_INLINE int pl_symmetric_count(int dim) {
    return dim * (dim + 1) / 2;
}

/** Place of entry (row, column) of a symmetric matrix. */
PL_INLINE int pl_symmetric_at(int row, int column) {
    const int low = row < column ? row : column, high = row < column ? column : row;
    return high * (high + 1) / 2 + low;
}

/** L of a metric: upper triangle by rows as V of pl_target; then 0, for kernels that load rows. */
typedef struct pl_metric {
    double l[8];
} pl_metric;

/** The metric in which lengths are the usual ones. */
pl_metric pl_metric_identity(int dim);

/** Fill h with the sizes of the metric m, and least and most with the smallest and largest one.
 *  Return 0 if m is not positive definite and finite. */
int pl_metric_sizes(int dim, const double *m, double *h, double *least, double *most);

/** Make the metric of the sizes h. Returns det h, in which the measure of an element is to be. */
double pl_metric_make(int dim, const double *h, pl_metric *metric);

/** Fill of_metric with L times the edges [dim][dim]. */
PL_INLINE void pl_metric_apply(int dim, const double l[6], const double edges[3][3],
                               double of_metric[3][3]) {
    for (int j = 0; j < dim; j++)
        for (int r = 0, k = 0; r < dim; r++) {
            of_metric[j][r] = 0;
            for (int c = r; c < dim; c++, k++)
                of_metric[j][r] += l[k] * edges[j][c];
        }
}

#endif
