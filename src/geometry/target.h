/* target: the shape that a corner is wanted to have, where that is not the ideal one of its type.
 *
 * A = [e_1 .. e_dim] are a corner's edges from its first node, W those of the corner that is wanted.
 * T = A W^-1 maps W to A, and mu is the mean ratio of T (Knupp 2001):
 *
 *     mu = |T|^2 / (dim det(T)^(2 / dim)),   |T|^2 = E det(W)^(-2 / dim)
 *
 * With W = Q R, Q a rotation, |A W^-1| = |A R^-1|. So a target is the upper triangle of
 * V = det(W)^(1 / dim) R^-1, with det V = 1, and E = |A V|^2, det A = det T det W:
 *
 *     mu = E / (dim D^(2 / dim))
 *
 * as of a corner whose ideal determinant is 1. A turned, moved or scaled W is the same target. In a
 * metric (geometry/metric.h) E = |L A V|^2.
 *
 *   pl_target, pl_target_make       of the corner that is wanted
 *   pl_target_flaw                  why there is none
 *   pl_target_entry, _slopes        V, and V by nodes
 *   pl_target_energy, _energy_in    E, and E in a metric
 *   pl_target_square                what counts
 *   pl_target_weights               E by squared edges
 */
#ifndef PL_GEOMETRY_TARGET_H
#define PL_GEOMETRY_TARGET_H

#include "geometry/corner.h"
#include "geometry/metric.h"
#include "geometry/simplex.h"

/** Target of a corner: eight doubles, as kernels load them. */
typedef struct pl_target {
    double v[6];    /* V_11, V_12, V_13, V_22, V_23, V_33; in the plane V_11, V_12, V_22 */
    double unit;    /* 1 / det W */
    double measure; /* det W */
} pl_target;

/** Make the target of a corner whose edges are edges [dim][dim], sign times as oriented. Return 0 if its
 *  measure is not positive, or too small or large for a double. */
int pl_target_make(int dim, const double edges[3][3], double sign, pl_target *target);

/** Return what is wrong, as "is flat", with an element whose corner with edges [dim][dim] and that determinant has no
 *  target. */
const char *pl_target_flaw(int dim, const double edges[3][3], double determinant);

/** Entry of V, row <= column. */
PL_INLINE double pl_target_entry(int dim, const double v[6], int row, int column) {
    return v[row * dim - row * (row + 1) / 2 + column];
}

/** Fill slope [dim + 1][dim] so that T = sum_j x_j slope_j^T over the nodes x_j of the corner, wherever
 *  the origin is. Entries below V's diagonal are 0 before, and stay. */
PL_INLINE void pl_target_slopes(int dim, const double v[6], double slope[4][4]) {
    for (int c = 0; c < dim; c++) {
        double sum = 0;
        for (int j = 0; j <= c; j++) {
            slope[j + 1][c] = pl_target_entry(dim, v, j, c);
            sum += slope[j + 1][c];
        }
        slope[0][c] = -sum;
    }
}

/** Return E of edges [dim][dim]. */
PL_INLINE double pl_target_energy(int dim, const double edges[3][3], const double v[6]) {
    double energy = 0;
    for (int c = 0; c < dim; c++)
        for (int d = 0; d < dim; d++) {
            double t = 0;
            for (int j = 0; j <= c; j++)
                t += edges[j][d] * pl_target_entry(dim, v, j, c);
            energy += t * t;
        }
    return energy;
}

/** Return E of edges [dim][dim] in the metric that has l. */
PL_INLINE double pl_target_energy_in(int dim, const double edges[3][3], const double v[6],
                                     const double l[6]) {
    double of_metric[3][3];
    pl_metric_apply(dim, l, edges, of_metric);
    return pl_target_energy(dim, (const double(*)[3])of_metric, v);
}

/** Return the square of the ratio that counts, of a corner with E = energy and D = determinant > 0, whose
 *  target has unit in their scale: (1 - w) mu^2 + w (tau + 1 / tau) / 2, tau = det T, w the weight of
 *  sizes. */
PL_INLINE double pl_target_square(int dim, double energy, double determinant, double unit,
                                  double weight) {
    const double tau = determinant * unit;
    const double square = pl_mean_square(dim, energy, determinant);
    return weight > 0 ? (1 - weight) * square + weight / 2 * (tau + 1 / tau) : square;
}

/** Fill weight with what E has of the squared edges: of those from the corner to its neighbours, then of
 *  those between these, as pl_corner_form.weight. */
void pl_target_weights(int dim, const pl_target *target, double weight[6]);

#endif
