/* kernel_acute: whether an element of a star has an angle that is too small (geometry/angle.h), or a
 * corner a scaled Jacobian that is.
 *
 *   has_acute_angle         the answer for a star
 *   acute_3d, acute_2d      the answer for a pack of elements
 *   acute_between           the answer for two facets of each
 *   has_small_jacobian      the answer for the corners of a star
 */
#ifndef PL_STAR_KERNEL_ACUTE_H
#define PL_STAR_KERNEL_ACUTE_H

#include "star/kernel_tetrahedra.h"

/** Lanes in which the facets with these normals enclose an angle that is acute (cosine > 0) and of
 *  larger acuteness than the limit; limit: times D^2, square: of their common edge. */
PL_INLINE lanes_mask acute_between(lanes cosine, lanes of_one, lanes of_other, lanes limit,
                                   lanes square) {
    return lanes_greater(cosine, lanes_of(0)) & lanes_greater(of_one * of_other, limit * square);
}

/** Mask of the tetrahedra of the pack at facet i that have too small an angle, with the node at
 *  position. */
PL_INLINE lanes_mask acute_3d(const star *s, int64_t i, const double *position, lanes limit,
                              const int guarded) {
    const vec3 x = {lanes_of(position[0]), lanes_of(position[1]), lanes_of(position[2])};
    const vec3 n = vec3_load(s, NX, NY, NZ, i); /* inwards, m outwards */
    const lanes nn = load(s, NN, i);
    vec3 r[3], m[3];
    lanes mm[3];
    if (guarded)
        edges_from(s, i, x, r);
    for (int j = 0; j < 3 && !guarded; j++) { /* the ring is still where it was gathered */
        lanes p[PL_ROW];
        points_to_columns(s->spare, s->facet + 3 * i + j, 3, p);
        r[j] = vec3_minus(x, (vec3){p[0], p[1], p[2]});
    }
    for (int j = 0; j < 3; j++) {
        m[j] = vec3_cross(r[j], r[(j + 1) % 3]);
        mm[j] = vec3_dot(m[j], m[j]);
    }
    const lanes D = vec3_dot(r[0], n), most = limit * (D * D);
    lanes_mask any = lanes_greater(lanes_of(0), lanes_of(0));
    for (int j = 0; j < 3; j++) {
        const int next = (j + 1) % 3;
        const vec3 e = vec3_minus(r[j], r[next]);
        any |= acute_between(vec3_dot(m[j], n), mm[j], nn, most, vec3_dot(e, e));
        any |= acute_between(-vec3_dot(m[j], m[next]), mm[j], mm[next], most,
                             vec3_dot(r[next], r[next]));
    }
    return any;
}

/** Mask of the triangles of the pack at facet i that have too small an angle, with the node at
 *  position. */
PL_INLINE lanes_mask acute_2d(const star *s, int64_t i, const double *position, lanes limit) {
    const lanes x = lanes_of(position[0]), y = lanes_of(position[1]), one = lanes_of(1);
    const lanes ax = x - load(s, P0X, i), ay = y - load(s, P0Y, i);
    const lanes bx = x - load(s, P1X, i), by = y - load(s, P1Y, i);
    const lanes ex = ax - bx, ey = ay - by; /* from p0 to p1 */
    const lanes aa = ax * ax + ay * ay, bb = bx * bx + by * by, ee = ex * ex + ey * ey;
    const lanes D = ex * ay - ey * ax, most = limit * (D * D);
    return acute_between(ax * bx + ay * by, aa, bb, most, one) |
           acute_between(ax * ex + ay * ey, aa, ee, most, one) |
           acute_between(-(bx * ex + by * ey), bb, ee, most, one);
}

/** Whether an angle of the star is of larger acuteness than limit. Not inlined: it is seldom asked
 *  for. */
PL_NOINLINE int has_acute_angle(const star *s, const double *position, double limit,
                                const int guarded, const int dim) {
    lanes_mask any = lanes_greater(lanes_of(0), lanes_of(0));
    for (int64_t i = 0; i < s->padded; i += PL_PACK)
        any |= dim == 3 ? acute_3d(s, i, position, lanes_of(limit), guarded)
                        : acute_2d(s, i, position, lanes_of(limit));
    return lanes_any_set(any);
}

/* ---- scaled Jacobians ---------------------------------------------------------------------- */

/** Node j of facet i, where x is the node of the star. */
static inline void corner_node(const star *s, int64_t i, int j, const int guarded, double *p,
                               const int dim) {
    static const uint8_t first[3][3] = {{P0X, P0Y, P0Z}, {P1X, P1Y, P1Z}, {P2X, P2Y, P2Z}};
    const double *row = s->spare + s->facet[i * dim + j]; /* the ring, if it is still there */
    for (int d = 0; d < dim; d++)
        p[d] = guarded || dim == 2 ? *entry(s, first[j][d], i) : row[d];
}

/** Whether 1 / SJ^2 of a corner is above limit with the node at position. SJ is D by the lengths of
 *  the corner's dim edges and by the ideal corner's determinant; all nodes of a simplex are corners.
 *  Not inlined: it is seldom asked for. */
PL_NOINLINE int has_small_jacobian(const star *s, const double *position, double limit,
                                   const int guarded, const int dim) {
    int found = 0;
    for (int64_t i = 0; i < s->n_facets; i++) {
        const pl_corner_form *f = &s->forms[s->form[i]];
        const int is_simplex = pl_corner_kind((uint8_t)s->form[i]) == PL_KIND_SIMPLEX;
        double p[4][3], D = *entry(s, BASE, i);
        memcpy(p[dim], position, (size_t)dim * sizeof *position);
        for (int j = 0; j < dim; j++)
            corner_node(s, i, j, guarded, p[j], dim);
        for (int d = 0; d < dim; d++)
            D += (position[d] - p[0][d]) * (dim == 3 ? *entry(s, NX + d, i)
                                            : d      ? p[1][0] - p[0][0]
                                                     : p[0][1] - p[1][1]);
        for (int v = 0; v <= dim; v++) { /* p_v, or x */
            double squares = f->determinant * f->determinant;
            if (!is_simplex && v != (f->corner < 0 ? dim : f->corner))
                continue;
            for (int j = 0; j <= dim; j++) {
                double square = 0;
                for (int d = 0; d < dim; d++)
                    square += (p[j][d] - p[v][d]) * (p[j][d] - p[v][d]);
                squares *= j != v ? square : 1;
            }
            found |= squares > limit * (D * D);
        }
    }
    return found;
}

#endif
