/* derivatives: RR^2 and its derivatives with respect to one vertex, written for reading: what the
 * kernels of src/star compute for many facets at once. For tests.
 */
#ifndef TEST_GEOMETRY_DERIVATIVES_H
#define TEST_GEOMETRY_DERIVATIVES_H

#include "geometry/simplex.h"

/** Value and derivatives of a function of the vertex x. */
typedef struct pl_derivatives {
    double value;
    double gradient[3];   /* [dim] */
    double hessian[3][3]; /* [dim][dim], symmetric */
} pl_derivatives;

/** Constants of a link facet while x moves: D = n . a and the circumcentre p0 + alpha / (2 D)
 *  with alpha = |a|^2 n + M a, where a = x - p0. */
typedef struct pl_opposite_facet {
    double n[3];    /* [dim] dD/dx */
    double m[3][3]; /* [dim][dim] M: [w]x in space, |b|^2 times a quarter turn in the plane */
} pl_opposite_facet;

/** Return the constants of the link facet with vertices facet [dim]. */
static inline pl_opposite_facet pl_facet_of(int dim, const double *const facet[]) {
    pl_opposite_facet f = {{0}, {{0}}};
    double b[3] = {0}, c[3] = {0}, w[3];
    pl_subtract(dim, facet[1], facet[0], b);
    double b2 = pl_dot(dim, b, b);
    if (dim == 2) {
        f.n[0] = -b[1];
        f.n[1] = b[0];
        f.m[0][1] = b2;
        f.m[1][0] = -b2;
        return f;
    }
    pl_subtract(dim, facet[2], facet[0], c);
    double c2 = pl_dot(dim, c, c);
    pl_cross(b, c, f.n);
    for (int d = 0; d < 3; d++)
        w[d] = b2 * c[d] - c2 * b[d];
    for (int d = 0; d < 3; d++) {
        int next = (d + 1) % 3, last = (d + 2) % 3;
        f.m[d][next] = -w[last];
        f.m[d][last] = w[next];
    }
    return f;
}

/** Return N = |alpha|^2 = (2 R D)^2 and its derivatives, with J = dalpha/dx = 2 n a^T + M: grad N =
 * 2 J^T alpha, hess N = 2 J^T J + 4 (alpha . n) I. */
static inline pl_derivatives pl_circumradius_derivatives(int dim, const pl_opposite_facet *f,
                                                         const double a[]) {
    double alpha[3], j[3][3];
    double a2 = pl_dot(dim, a, a);
    for (int r = 0; r < dim; r++) {
        alpha[r] = a2 * f->n[r] + pl_dot(dim, f->m[r], a);
        for (int s = 0; s < dim; s++)
            j[r][s] = 2 * f->n[r] * a[s] + f->m[r][s];
    }
    pl_derivatives n = {.value = pl_dot(dim, alpha, alpha)};
    double diagonal = 4 * pl_dot(dim, alpha, f->n);
    for (int s = 0; s < dim; s++) {
        for (int r = 0; r < dim; r++)
            n.gradient[s] += 2 * j[r][s] * alpha[r];
        for (int t = 0; t < dim; t++) {
            for (int r = 0; r < dim; r++)
                n.hessian[s][t] += 2 * j[r][s] * j[r][t];
            n.hessian[s][t] += s == t ? diagonal : 0;
        }
    }
    return n;
}

/** Add weight times the distance of x from a line through p along the unit vector e, or from the
 *  point p (e = 0): grad h = u, hess h = (I - e e^T - u u^T) / h. */
static inline void pl_add_distance(int dim, double weight, const double x[], const double p[],
                                   const double e[], pl_derivatives *sum) {
    double u[3];
    pl_subtract(dim, x, p, u);
    double along = pl_dot(dim, u, e);
    for (int d = 0; d < dim; d++)
        u[d] -= along * e[d];
    double h = sqrt(pl_dot(dim, u, u));
    sum->value += weight * h;
    for (int d = 0; d < dim; d++)
        u[d] /= h;
    for (int s = 0; s < dim; s++) {
        sum->gradient[s] += weight * u[s];
        for (int t = 0; t < dim; t++)
            sum->hessian[s][t] += weight / h * ((s == t) - e[s] * e[t] - u[s] * u[t]);
    }
}

/** Return S and its derivatives: the facet's own measure, constant, and those of the facets at x:
 * half an edge times the distance of x from it, or the distances from the ends. */
static inline pl_derivatives pl_surface_derivatives(int dim, const double n[], const double x[],
                                                    const double *const facet[]) {
    double own = sqrt(pl_dot(dim, n, n));
    pl_derivatives s = {.value = dim == 3 ? own / 2 : own};
    for (int i = 0; i < dim; i++) {
        double e[3] = {0}, weight = 1;
        if (dim == 3) {
            pl_subtract(dim, facet[(i + 1) % 3], facet[i], e);
            double length = sqrt(pl_dot(dim, e, e));
            for (int d = 0; d < dim; d++)
                e[d] /= length;
            weight = length / 2;
        }
        pl_add_distance(dim, weight, x, facet[i], e, &s);
    }
    return s;
}

/** RR^2 and its derivatives with respect to vertex x; facet [dim] are pointers to the other
 *  vertices, so oriented that D = (x - p0) . ((p1 - p0) x (p2 - p0)), or (p1 - p0) x (x - p0).
 *  From the derivatives of the logarithm: RR^2 = N S^2 / (c D^4) (docs/algorithm.md). */
static inline pl_derivatives pl_radius_ratio_derivatives(int dim, const double x[],
                                                         const double *const facet[]) {
    double a[3] = {0}, l[3];
    pl_subtract(dim, x, facet[0], a);
    pl_opposite_facet f = pl_facet_of(dim, facet);
    pl_derivatives n = pl_circumradius_derivatives(dim, &f, a);
    pl_derivatives s = pl_surface_derivatives(dim, f.n, x, facet);
    pl_shape shape = {
        .determinant = pl_dot(dim, a, f.n), .circumradius_square = n.value, .facet_sum = s.value};
    double d = shape.determinant;
    pl_derivatives rr = {.value = pl_radius_ratio_square_of_shape(dim, &shape)};
    for (int i = 0; i < dim; i++) {
        l[i] = n.gradient[i] / n.value + 2 * s.gradient[i] / s.value - 4 * f.n[i] / d;
        rr.gradient[i] = rr.value * l[i];
    }
    for (int i = 0; i < dim; i++) {
        for (int j = 0; j < dim; j++) {
            double of_n =
                n.hessian[i][j] / n.value - n.gradient[i] / n.value * (n.gradient[j] / n.value);
            double of_s =
                s.hessian[i][j] / s.value - s.gradient[i] / s.value * (s.gradient[j] / s.value);
            double of_d = f.n[i] / d * (f.n[j] / d);
            rr.hessian[i][j] = rr.value * (of_n + 2 * of_s + 4 * of_d + l[i] * l[j]);
        }
    }
    return rr;
}

#endif
