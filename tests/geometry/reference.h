/* reference: all measures of an element from textbook formulas in long double, or where
 * REFERENCE_IN_QUAD is defined with 113 bits, sharing nothing with src/geometry. For tests;
 * elements are positive. */
#ifndef TEST_GEOMETRY_REFERENCE_H
#define TEST_GEOMETRY_REFERENCE_H

#include <math.h>

#ifdef REFERENCE_IN_QUAD
#include <quadmath.h>
__extension__ typedef __float128 real;
#define REAL(function) function##q
#else
typedef long double real;
#define REAL(function) function##l
#endif

/** The measures, in the order of planish_quality's spreads; angles in degrees. */
typedef struct reference {
    real radius_ratio, circumradius_to_edge, edge_to_inradius, edge_ratio, mean_ratio,
        scaled_jacobian, smallest_angle, largest_angle;
} reference;

static inline real reference_distance(int dim, const double *a, const double *b) {
    real square = 0;
    for (int d = 0; d < dim; d++)
        square += ((real)b[d] - (real)a[d]) * ((real)b[d] - (real)a[d]);
    return REAL(sqrt)(square);
}

/** Edges at vertex v [dim + 1], as columns that keep the orientation. */
static inline void reference_edges(int dim, const double *const v[], int at, real e[3][3]) {
    static const int others[2][4][3] = {{{1, 2}, {2, 0}, {0, 1}},
                                        {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[d][j] = (real)v[others[dim - 2][at][j]][d] - (real)v[at][d];
}

static inline real reference_determinant(int dim, const real m[3][3]) {
    if (dim == 2)
        return m[0][0] * m[1][1] - m[0][1] * m[1][0];
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/** Area of a triangle in space by the cross product. */
static inline real reference_area(const double *a, const double *b, const double *c) {
    real square = 0;
    for (int d = 0; d < 3; d++) {
        const int i = (d + 1) % 3, j = (d + 2) % 3;
        const real n = ((real)b[i] - (real)a[i]) * ((real)c[j] - (real)a[j]) -
                       ((real)b[j] - (real)a[j]) * ((real)c[i] - (real)a[i]);
        square += n * n;
    }
    return REAL(sqrt)(square) / 2;
}

/** Distance of vertex 0 from the point c with 2 e_j . c = |e_j|^2, by Cramer. */
static inline real reference_circumradius(int dim, const double *const v[]) {
    real e[3][3], c2 = 0;
    reference_edges(dim, v, 0, e);
    for (int i = 0; i < dim; i++) {
        real m[3][3];
        for (int j = 0; j < dim; j++)
            for (int d = 0; d < dim; d++) {
                const real length = reference_distance(dim, v[0], v[j + 1]);
                m[j][d] = d == i ? length * length / 2 : e[d][j];
            }
        const real c = reference_determinant(dim, m) / reference_determinant(dim, e);
        c2 += c * c;
    }
    return REAL(sqrt)(c2);
}

/** dim times the measure by the measure of the boundary. */
static inline real reference_inradius(int dim, const double *const v[]) {
    real e[3][3];
    reference_edges(dim, v, 0, e);
    const real determinant = reference_determinant(dim, e);
    if (dim == 2)
        return determinant /
               (reference_distance(2, v[0], v[1]) + reference_distance(2, v[1], v[2]) +
                reference_distance(2, v[2], v[0]));
    return determinant / 2 /
           (reference_area(v[0], v[1], v[2]) + reference_area(v[0], v[1], v[3]) +
            reference_area(v[0], v[2], v[3]) + reference_area(v[1], v[2], v[3]));
}

/** dim det(T)^(2/dim) / |T|^2, T = A W^-1 the map from the regular element (Knupp). */
static inline real reference_mean_ratio(int dim, const double *const v[]) {
    const real s3 = REAL(sqrt)(3), s6 = REAL(sqrt)(6);
    /* W^-1 of edges (1, 0, 0), (1/2, sqrt(3)/2, 0), (1/2, sqrt(3)/6, sqrt(6)/3) */
    const real inverse[3][3] = {{1, -1 / s3, -1 / s6}, {0, 2 / s3, -1 / s6}, {0, 0, 3 / s6}};
    real a[3][3], t[3][3] = {{0}}, norm = 0;
    reference_edges(dim, v, 0, a);
    for (int i = 0; i < dim; i++)
        for (int j = 0; j < dim; j++) {
            for (int k = 0; k < dim; k++)
                t[i][j] += a[i][k] * inverse[k][j];
            norm += t[i][j] * t[i][j];
        }
    return dim * REAL(pow)(reference_determinant(dim, t), (real)2 / dim) / norm;
}

/** Least over the vertices of D / product of the edges there, by that of the regular element. */
static inline real reference_scaled_jacobian(int dim, const double *const v[]) {
    real least = 2;
    for (int at = 0; at <= dim; at++) {
        real e[3][3], product = 1;
        reference_edges(dim, v, at, e);
        for (int j = 0; j <= dim; j++)
            product *= j == at ? 1 : reference_distance(dim, v[at], v[j]);
        least = REAL(fmin)(least, reference_determinant(dim, e) / product);
    }
    return least * (dim == 3 ? REAL(sqrt)(2) : 2 / REAL(sqrt)(3));
}

/** At the edge (in the plane: the vertex) i j, between what points from it to k and to l. */
static inline real reference_angle(int dim, const double *const v[], int i, int j, int k, int l) {
    real e[3], p[3], q[3], ee = 0, ep = 0, eq = 0, pp = 0, qq = 0;
    for (int d = 0; d < dim; d++) {
        e[d] = (real)v[j][d] - (real)v[i][d];
        p[d] = (real)v[k][d] - (real)v[i][d];
        q[d] = (real)v[l][d] - (real)v[i][d];
        ee += e[d] * e[d];
        ep += e[d] * p[d];
        eq += e[d] * q[d];
    }
    for (int d = 0; d < dim; d++) {
        p[d] -= dim == 3 ? ep / ee * e[d] : 0;
        q[d] -= dim == 3 ? eq / ee * e[d] : 0;
    }
    for (int d = 0; d < dim; d++) {
        pp += p[d] * p[d];
        qq += q[d] * q[d];
    }
    real sum = 0, difference = 0; /* Kahan: no loss near 0 and 180 degrees */
    for (int d = 0; d < dim; d++) {
        const real a = p[d] / REAL(sqrt)(pp), b = q[d] / REAL(sqrt)(qq);
        sum += (a + b) * (a + b);
        difference += (a - b) * (a - b);
    }
    return 2 * REAL(atan2)(REAL(sqrt)(difference), REAL(sqrt)(sum)) * (180 / REAL(acos)(-1));
}

static inline void reference_angles(int dim, const double *const v[], reference *r) {
    static const int plane[3][4] = {{0, 1, 1, 2}, {1, 2, 2, 0}, {2, 0, 0, 1}};
    static const int space[6][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2},
                                    {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}};
    r->smallest_angle = 180;
    r->largest_angle = 0;
    for (int i = 0; i < (dim == 3 ? 6 : 3); i++) {
        const int *n = dim == 3 ? space[i] : plane[i];
        const real angle = reference_angle(dim, v, n[0], n[1], n[2], n[3]);
        r->smallest_angle = REAL(fmin)(r->smallest_angle, angle);
        r->largest_angle = REAL(fmax)(r->largest_angle, angle);
    }
}

static inline reference reference_of(int dim, const double *const v[]) {
    reference r;
    real longest = 0, shortest = INFINITY;
    for (int i = 0; i < dim; i++)
        for (int j = i + 1; j <= dim; j++) {
            const real length = reference_distance(dim, v[i], v[j]);
            longest = REAL(fmax)(longest, length);
            shortest = REAL(fmin)(shortest, length);
        }
    const real circumradius = reference_circumradius(dim, v), inradius = reference_inradius(dim, v);
    r.radius_ratio = circumradius / (dim * inradius);
    r.circumradius_to_edge =
        circumradius / longest * (dim == 3 ? 4 / REAL(sqrt)(6) : REAL(sqrt)(3));
    r.edge_to_inradius = longest / inradius / (dim == 3 ? 2 * REAL(sqrt)(6) : 2 * REAL(sqrt)(3));
    r.edge_ratio = longest / shortest;
    r.mean_ratio = reference_mean_ratio(dim, v);
    r.scaled_jacobian = reference_scaled_jacobian(dim, v);
    reference_angles(dim, v, &r);
    return r;
}

#endif
