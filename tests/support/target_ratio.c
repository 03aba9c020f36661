#include "support/target_ratio.h"

#include "geometry/cell.h"

#include <math.h>
#include <string.h>

typedef long double real;

static real determinant(int dim, real a[3][3]) {
    if (dim == 2)
        return a[0][0] * a[1][1] - a[0][1] * a[1][0];
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
           a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
}

/** Solve a x = b, of dimension dim, by Cramer's rule. */
static void solve(int dim, real a[3][3], const real *b, real *x) {
    const real whole = determinant(dim, a);
    for (int k = 0; k < dim; k++) {
        real with[3][3];
        memcpy(with, a, sizeof with);
        for (int i = 0; i < dim; i++)
            with[i][k] = b[i];
        x[k] = determinant(dim, with) / whole;
    }
}

/** Edges [edge][component] of corner c of an element whose nodes are at x. */
static void edges_of(const pl_cell_shape *shape, int c, const double *x, const int32_t *node,
                     real edge[3][3]) {
    const int dim = shape->dim;
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edge[j][d] =
                (real)x[node[shape->neighbour[c][j]] * dim + d] - (real)x[node[c] * dim + d];
}

/** What counts of a corner: mu^2 of T = A W^-1, whose rows solve W^T t = a with edges as rows, and its
 *  size by the weight of sizes. */
static real ratio_square(int dim, real a[3][3], real w[3][3], real weight) {
    const real tau = determinant(dim, a) / determinant(dim, w);
    real norm = 0;
    for (int d = 0; d < dim; d++) {
        real t[3], column[3];
        for (int j = 0; j < dim; j++)
            column[j] = a[j][d];
        solve(dim, w, column, t);
        for (int k = 0; k < dim; k++)
            norm += t[k] * t[k];
    }
    const real mu = dim == 3 ? norm / (3 * powl(tau, 2.0L / 3)) : norm / (2 * tau);
    return (1 - weight) * mu * mu + weight * (tau + 1 / tau) / 2;
}

real target_square_of(int type, const int32_t *node, const double *x, const double *reference,
                      double weight) {
    const pl_cell_shape *shape = pl_cell_type_of(type)->shape;
    real sum = 0;
    for (int c = 0; c < shape->n_measured; c++) {
        real a[3][3], w[3][3];
        edges_of(shape, c, x, node, a);
        edges_of(shape, c, reference, node, w);
        sum += ratio_square(shape->dim, a, w, (real)weight);
    }
    return sum / shape->n_measured;
}
