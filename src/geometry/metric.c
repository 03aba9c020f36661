/* metric: sizes by Jacobi's rotations, and L by Givens's. Made of + - * / and roots alone, so that the
 * bits are the same everywhere. */
#include "geometry/metric.h"

#include "geometry/cube_root.h"
#include "geometry/simplex.h"

#include <math.h>
#include <string.h>

/* Rotations double the number of right digits once these are few. */
enum { MOST_ROUNDS = 30 };

/** A symmetric matrix on its way to a diagonal one, and the eigenvectors as columns. */
typedef struct diagonal {
    int dim;
    double a[3][3], vector[3][3];
} diagonal;

/** Rotate so that the entry (p, q) becomes 0 (Golub & Van Loan 2013, 8.5.2). */
static void rotate(diagonal *d, int p, int q) {
    const double apart = (d->a[q][q] - d->a[p][p]) / (2 * d->a[p][q]);
    const double tangent = (apart >= 0 ? 1 : -1) / (fabs(apart) + sqrt(1 + apart * apart));
    const double cosine = 1 / sqrt(1 + tangent * tangent), sine = tangent * cosine;
    for (int k = 0; k < d->dim; k++) {
        const double left = d->a[k][p], right = d->a[k][q];
        d->a[k][p] = cosine * left - sine * right;
        d->a[k][q] = sine * left + cosine * right;
    }
    for (int k = 0; k < d->dim; k++) {
        const double upper = d->a[p][k], lower = d->a[q][k];
        const double left = d->vector[k][p], right = d->vector[k][q];
        d->a[p][k] = cosine * upper - sine * lower;
        d->a[q][k] = sine * upper + cosine * lower;
        d->vector[k][p] = cosine * left - sine * right;
        d->vector[k][q] = sine * left + cosine * right;
    }
    d->a[p][q] = d->a[q][p] = 0;
}

/** Whether the entry (p, q) counts beside those on the diagonal. */
static int counts(const diagonal *d, int p, int q) {
    const double size = fabs(d->a[p][q]);
    return size > 0x1p-54 * fabs(d->a[p][p]) || size > 0x1p-54 * fabs(d->a[q][q]);
}

/** Make the matrix diagonal. */
static void diagonalise(int dim, const double *m, double scale, diagonal *d) {
    *d = (diagonal){.dim = dim};
    for (int r = 0; r < dim; r++) {
        for (int c = 0; c < dim; c++)
            d->a[r][c] = m[pl_symmetric_at(r, c)] * scale;
        d->vector[r][r] = 1;
    }
    for (int round = 0, n = 1; n > 0 && round < MOST_ROUNDS; round++) {
        n = 0;
        for (int p = 0; p < dim; p++)
            for (int q = p + 1; q < dim; q++)
                if (counts(d, p, q)) {
                    rotate(d, p, q);
                    n++;
                }
    }
}

/** Return the largest absolute entry, or infinity where one is not finite. */
static double largest_entry(int n, const double *m) {
    double largest = 0;
    for (int k = 0; k < n; k++)
        largest = isfinite(m[k]) ? fmax(largest, fabs(m[k])) : INFINITY;
    return largest;
}

pl_metric pl_metric_identity(int dim) {
    return dim == 3 ? (pl_metric){{1, 0, 0, 1, 0, 1, 0, 0}} : (pl_metric){{1, 0, 1}};
}

int pl_metric_sizes(int dim, const double *m, double *h, double *least, double *most) {
    const double largest = largest_entry(pl_symmetric_count(dim), m);
    double length[3], unit;
    diagonal d;
    int exponent;
    if (!(largest > 0 && isfinite(largest)))
        return 0;
    frexp(largest, &exponent);
    exponent = pl_scale_exponent(exponent + (exponent & 1)); /* even: the root is a power, too */
    diagonalise(dim, m, ldexp(1, -exponent), &d);
    unit = ldexp(1, -exponent / 2);
    *least = INFINITY;
    *most = 0;
    for (int k = 0; k < dim; k++) {
        if (!(d.a[k][k] > 0))
            return 0;
        length[k] = unit / sqrt(d.a[k][k]);
        *least = fmin(*least, length[k]);
        *most = fmax(*most, length[k]);
    }
    memset(h, 0, (size_t)pl_symmetric_count(dim) * sizeof *h);
    for (int c = 0; c < dim; c++)
        for (int r = 0; r <= c; r++)
            for (int k = 0; k < dim; k++)
                h[pl_symmetric_at(r, c)] += d.vector[r][k] * length[k] * d.vector[c][k];
    return 1;
}

/** Turn columns p and q of a so that the entry (q, p) becomes 0. */
static void turn_columns(int dim, double a[3][3], int p, int q) {
    const double length = sqrt(a[q][p] * a[q][p] + a[q][q] * a[q][q]);
    const double cosine = a[q][q] / length, sine = a[q][p] / length;
    for (int k = 0; k < dim; k++) {
        const double left = a[k][p], right = a[k][q];
        a[k][p] = cosine * left - sine * right;
        a[k][q] = sine * left + cosine * right;
    }
    a[q][p] = 0;
}

/** Fill r with the upper triangle of H = R Q, Q a rotation. */
static void find_triangle(int dim, const double *h, double r[3][3]) {
    for (int i = 0; i < dim; i++)
        for (int j = 0; j < dim; j++)
            r[i][j] = h[pl_symmetric_at(i, j)];
    for (int q = dim - 1; q > 0; q--)
        for (int p = 0; p < q; p++)
            turn_columns(dim, r, p, q);
}

/* M = H^-2 = R^-T R^-1, so L = R^-1 but for its determinant. Turning loses nothing of thin metrics, which
 * minors would. */
double pl_metric_make(int dim, const double *h, pl_metric *metric) {
    double r[3][3] = {{0}};
    find_triangle(dim, h, r);
    if (dim == 2) {
        const double det = r[0][0] * r[1][1], unit = sqrt(det);
        *metric = (pl_metric){{unit / r[0][0], -r[0][1] / det * unit, unit / r[1][1]}};
        return det;
    }
    const double det = r[0][0] * r[1][1] * r[2][2], unit = pl_cube_root(det);
    const double l11 = unit / r[0][0], l22 = unit / r[1][1], l33 = unit / r[2][2];
    const double l12 = -l11 * (r[0][1] / r[1][1]), l23 = -l22 * (r[1][2] / r[2][2]);
    const double l13 = -(l11 * r[0][2] + l12 * r[1][2]) / r[2][2];
    *metric = (pl_metric){{l11, l12, l13, l22, l23, l33, 0, 0}};
    return det;
}
