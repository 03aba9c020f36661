/* kernel_direction: a direction of descent from the gradient and Hessian of a star. Plain scalar
 * arithmetic.
 *
 *   newton_direction, fletcher_reeves_direction                     directions
 *   factorise, factorise_shifted, substitute_forward, _back         L D L^T of a Hessian
 *   invert                                                          inverse of a Hessian
 *   packed, dot, curvature                                          entries and products
 */
#ifndef PL_STAR_KERNEL_DIRECTION_H
#define PL_STAR_KERNEL_DIRECTION_H

#include <math.h>

/* First shift of an indefinite Hessian, relative to its largest entry; then times 8 each. */
#define SHIFT_FIRST  0x1p-7
#define SHIFT_FACTOR 8.0
enum { SHIFT_TRIALS = 8 }; /* the last shift exceeds any negative eigenvalue many times */
/* A pivot below this fraction of the largest entry counts as not positive. */
#define PIVOT_FLOOR 0x1p-40

/** Index of entry (i, j), i <= j, of a symmetric matrix stored by rows of its upper triangle. */
static inline int packed(int i, int j, int dim) {
    return i * dim - i * (i - 1) / 2 + (j - i);
}

/** L D L^T of a matrix: l unit lower triangular, D by its diagonal and that of its inverse. */
typedef struct factors {
    double l[3][3], pivot[3], inverse[3];
} factors;

/** Factorise hessian + shift I; 0 if a pivot is not above floor. */
static inline int factorise(const double *hessian, double shift, double floor, factors *f,
                            const int dim) {
    for (int i = 0; i < dim; i++) {
        double d = hessian[packed(i, i, dim)] + shift;
        for (int k = 0; k < i; k++)
            d -= f->l[i][k] * f->l[i][k] * f->pivot[k];
        if (!(d > floor))
            return 0;
        f->pivot[i] = d;
        f->inverse[i] = 1 / d;
        for (int j = i + 1; j < dim; j++) {
            double e = hessian[packed(i, j, dim)];
            for (int k = 0; k < i; k++)
                e -= f->l[i][k] * f->l[j][k] * f->pivot[k];
            f->l[j][i] = e * f->inverse[i];
        }
    }
    return 1;
}

/** Compute y = L^-1 b. */
static inline void substitute_forward(const factors *f, const double *b, double *y, const int dim) {
    for (int i = 0; i < dim; i++) {
        y[i] = b[i];
        for (int k = 0; k < i; k++)
            y[i] -= f->l[i][k] * y[k];
    }
}

/** Compute x = L^-T D^-1 y. */
static inline void substitute_back(const factors *f, const double *y, double *x, const int dim) {
    for (int i = dim - 1; i >= 0; i--) {
        x[i] = y[i] * f->inverse[i];
        for (int k = i + 1; k < dim; k++)
            x[i] -= f->l[k][i] * x[k];
    }
}

/** Scalar product of a and b [dim]. */
static inline double dot(const double *a, const double *b, const int dim) {
    double sum = a[0] * b[0];
    for (int d = 1; d < dim; d++)
        sum += a[d] * b[d];
    return sum;
}

/** Return v^T hessian v. */
static inline double curvature(const double *hessian, const double *v, const int dim) {
    double sum = 0;
    for (int i = 0; i < dim; i++)
        for (int j = 0; j < dim; j++)
            sum += v[i] * v[j] * hessian[i <= j ? packed(i, j, dim) : packed(j, i, dim)];
    return sum;
}

/** Factorise the Hessian, shifted by multiples of the identity until it is positive definite; 0 if
 *  even that fails (entries not finite, or all zero). */
static inline int factorise_shifted(const double *hessian, factors *f, const int dim) {
    double largest = 0;
    for (int i = 0; i < dim; i++) {
        double entry = fabs(hessian[packed(i, i, dim)]);
        largest = entry > largest ? entry : largest;
    }
    double floor = largest * PIVOT_FLOOR;
    if (factorise(hessian, 0, floor, f, dim))
        return 1;
    double shift = largest * SHIFT_FIRST;
    for (int trial = 0; trial < SHIFT_TRIALS; trial++, shift *= SHIFT_FACTOR)
        if (factorise(hessian, shift, floor, f, dim))
            return 1;
    return 0;
}

/** Newton direction -hessian^-1 gradient, the Hessian shifted if need be; 0 if that fails. */
static inline int newton_direction(const double *gradient, const double *hessian, double *direction,
                                   const int dim) {
    factors f = {.pivot = {0}};
    double b[3], y[3];
    if (!factorise_shifted(hessian, &f, dim))
        return 0;
    for (int d = 0; d < dim; d++)
        b[d] = -gradient[d];
    substitute_forward(&f, b, y, dim);
    substitute_back(&f, y, direction, dim);
    return 1;
}

/** The inverse of a positive definite Hessian of three coordinates, by cofactors; 0 if it is not.
 */
static inline int invert(const double *h, double *inverse) {
    const double xx = h[3] * h[5] - h[4] * h[4], xy = h[2] * h[4] - h[1] * h[5];
    const double xz = h[1] * h[4] - h[2] * h[3], zz = h[0] * h[3] - h[1] * h[1];
    const double determinant = h[0] * xx + h[1] * xy + h[2] * xz;
    if (!(h[0] > 0 && zz > 0 && determinant > 0))
        return 0;
    const double factor = 1 / determinant;
    inverse[0] = xx * factor;
    inverse[1] = xy * factor;
    inverse[2] = xz * factor;
    inverse[3] = (h[0] * h[5] - h[2] * h[2]) * factor;
    inverse[4] = (h[1] * h[2] - h[0] * h[4]) * factor;
    inverse[5] = zz * factor;
    return 1;
}

/** Memory of conjugate directions from one iteration of a star to the next. */
typedef struct conjugate {
    double direction[3]; /* S^(q-1) */
    double gradient2;    /* |grad F|^2 of the last iteration, 0: none */
} conjugate;

/** Equation 3 of the paper: S = -grad F + beta S^(q-1), beta = |grad F|^2 / |last grad F|^2;
 * steepest descent at first and where that is no descent. The length is that of a Newton step along
 * S where the curvature is positive, else that of the star. */
static inline int fletcher_reeves_direction(const double *gradient, const double *hessian,
                                            double size2, conjugate *memory, double *direction,
                                            const int dim) {
    double gradient2 = dot(gradient, gradient, dim);
    if (!(gradient2 > 0) || !(gradient2 < INFINITY))
        return 0;
    double beta = memory->gradient2 > 0 ? gradient2 / memory->gradient2 : 0;
    for (int d = 0; d < dim; d++)
        direction[d] = -gradient[d] + beta * memory->direction[d];
    if (!(dot(gradient, direction, dim) < 0))
        for (int d = 0; d < dim; d++)
            direction[d] = -gradient[d];
    memory->gradient2 = gradient2;
    for (int d = 0; d < dim; d++)
        memory->direction[d] = direction[d];
    double bend = curvature(hessian, direction, dim);
    double length = bend > 0 ? -dot(gradient, direction, dim) / bend
                             : sqrt(size2 / dot(direction, direction, dim));
    for (int d = 0; d < dim; d++)
        direction[d] *= length;
    return 1;
}

#endif
