/* nearest: the nearest points of edges and triangles in space.
 *
 *   pl_nearest_on_edge, pl_nearest_on_triangle     to a point
 *   pl_nearest_edges                               of two edges
 *   pl_nearest_triangles                           of two triangles
 *   pl_quarter_triangle                            the four parts in which one is searched
 */
#ifndef PL_SHAPE_NEAREST_H
#define PL_SHAPE_NEAREST_H

#include "geometry/simplex.h"

/** Compute the weights of the point between a and b that is nearest to p. Returns the square of the
 *  distance. */
static inline double pl_nearest_on_edge(const double *p, const double *a, const double *b,
                                        double weight[2]) {
    double ab[3], ap[3], off[3];
    pl_subtract(3, b, a, ab);
    pl_subtract(3, p, a, ap);
    const double square = pl_dot(3, ab, ab), along = pl_dot(3, ap, ab);
    const double t = along > 0 ? (along < square ? along / square : 1) : 0;
    for (int d = 0; d < 3; d++)
        off[d] = ap[d] - t * ab[d];
    weight[0] = 1 - t;
    weight[1] = t;
    return pl_dot(3, off, off);
}

/** Compute the weights of the point of a triangle x that is nearest to p. Returns the square of the
 *  distance. */
static inline double pl_nearest_on_triangle(const double *p, const double *const x[3],
                                            double weight[3]) {
    double ab[3], ac[3], ap[3], normal[3], across[3];
    pl_subtract(3, x[1], x[0], ab);
    pl_subtract(3, x[2], x[0], ac);
    pl_subtract(3, p, x[0], ap);
    pl_cross(ab, ac, normal);
    const double square = pl_dot(3, normal, normal);
    pl_cross(ap, ac, across);
    const double b = pl_dot(3, across, normal);
    pl_cross(ab, ap, across);
    const double c = pl_dot(3, across, normal), a = square - b - c;
    if (a > 0 && b > 0 && c > 0) {
        const double off = pl_dot(3, ap, normal);
        weight[1] = b / square;
        weight[2] = c / square;
        weight[0] = 1 - weight[1] - weight[2];
        weight[0] = weight[0] > 0 ? weight[0] : 0;
        return off * off / square;
    }
    double best = INFINITY;
    for (int k = 0; k < 3; k++) {
        const int m = (k + 1) % 3;
        double w[2] = {1, 0};
        const double distance = pl_nearest_on_edge(p, x[k], x[m], w);
        if (!(distance < best))
            continue;
        best = distance;
        weight[k] = w[0];
        weight[m] = w[1];
        weight[(k + 2) % 3] = 0;
    }
    return best;
}

/** Compute way, from the nearest point of edge a to that of edge b. Returns its square. */
static inline double pl_nearest_edges(const double *const a[2], const double *const b[2],
                                      double way[3]) {
    double u[3], v[3], w[3], best = INFINITY;
    pl_subtract(3, a[1], a[0], u);
    pl_subtract(3, b[1], b[0], v);
    pl_subtract(3, b[0], a[0], w);
    const double uu = pl_dot(3, u, u), vv = pl_dot(3, v, v), uv = pl_dot(3, u, v);
    const double uw = pl_dot(3, u, w), vw = pl_dot(3, v, w), area = uu * vv - uv * uv;
    const double s = (uw * vv - vw * uv) / area, t = (uw * uv - vw * uu) / area;
    if (s > 0 && s < 1 && t > 0 && t < 1) {
        for (int d = 0; d < 3; d++)
            way[d] = w[d] + t * v[d] - s * u[d];
        return pl_dot(3, way, way);
    }
    for (int k = 0; k < 4; k++) { /* an end of one is nearest */
        const double *p = k < 2 ? a[k] : b[k - 2], *const *edge = k < 2 ? b : a;
        double weight[2] = {1, 0};
        const double square = pl_nearest_on_edge(p, edge[0], edge[1], weight);
        if (!(square < best))
            continue;
        best = square;
        for (int d = 0; d < 3; d++) {
            const double to = weight[0] * edge[0][d] + weight[1] * edge[1][d] - p[d];
            way[d] = k < 2 ? to : -to;
        }
    }
    return best;
}

/** Compute way, from the nearest point of triangle a to that of triangle b, which do not cross one
 *  another. Returns its square. */
static inline double pl_nearest_triangles(const double *const a[3], const double *const b[3],
                                          double way[3]) {
    double best = INFINITY;
    for (int i = 0; i < 6; i++) {
        const double *p = i < 3 ? a[i] : b[i - 3], *const *of = i < 3 ? b : a;
        double weight[3] = {1, 0, 0};
        const double square = pl_nearest_on_triangle(p, of, weight);
        if (!(square < best))
            continue;
        best = square;
        for (int d = 0; d < 3; d++) {
            const double to =
                weight[0] * of[0][d] + weight[1] * of[1][d] + weight[2] * of[2][d] - p[d];
            way[d] = i < 3 ? to : -to;
        }
    }
    for (int i = 0; i < 9; i++) {
        const double *const edge_a[2] = {a[i / 3], a[(i / 3 + 1) % 3]};
        const double *const edge_b[2] = {b[i % 3], b[(i % 3 + 1) % 3]};
        double other[3];
        const double square = pl_nearest_edges(edge_a, edge_b, other);
        if (!(square < best))
            continue;
        best = square;
        for (int d = 0; d < 3; d++)
            way[d] = other[d];
    }
    return best;
}

/** Divide a triangle x at the middles of its edges into four: one at each corner, and that in the middle. */
static inline void pl_quarter_triangle(const double x[3][3], double part[4][3][3]) {
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < 3; d++) {
            part[k][k][d] = x[k][d];
            part[k][(k + 1) % 3][d] = part[(k + 1) % 3][k][d] = part[3][k][d] =
                (x[k][d] + x[(k + 1) % 3][d]) / 2;
        }
}

#endif
