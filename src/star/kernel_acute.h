/* kernel_acute: whether an element of a star has an angle that is too small (geometry/angle.h), a
 * corner a scaled Jacobian that is, or a simplex a radius ratio that is too large.
 *
 *   has_acute_angle         the answer for a star
 *   acute_3d, acute_2d      the answer for a pack of elements
 *   acute_between           the answer for two facets of each
 *   ratio_bound, may_exceed_ratio    a bound of RR^2 by mu^2
 *   exceeds_ratio           the answer for radius ratios, where visits lower mean ratios
 *   has_small_jacobian      the answer for the corners of a star
 */
#ifndef PL_STAR_KERNEL_ACUTE_H
#define PL_STAR_KERNEL_ACUTE_H

#include "star/kernel_mean.h"

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

/* ---- radius ratios ------------------------------------------------------------------------- */

/** RR^2 of a pack of simplices with mu^2 = square is at most this. Equality holds for the regular ones.
 *
 * Tetrahedra, RR <= mu^3: let S be the sum of the squared edges, V the volume, R the circumradius, A the
 * surface. 24 V R is four times the area of a triangle whose sides are the products of opposite edges,
 * the sum of which is at most S / 2: 24 V R <= sqrt(3) / 9 (S / 2)^2. A face with squared edges of sum
 * q has at most the area q / (4 sqrt(3)), hence A <= S / (2 sqrt(3)). So
 * RR = R A / (9 V) <= S^3 / (1728 9 V^2) = mu^3.
 *
 * Triangles, RR <= mu^2: with edges a, b, c and the area V, a b c <= (S / 3)^(3/2) and
 * (a + b + c)^2 <= 3 S, so RR = a b c (a + b + c) / (16 V^2) <= S^2 / (48 V^2) = mu^2. */
PL_INLINE lanes ratio_bound(lanes square, const int dim) {
    return dim == 3 ? square * square * square : square * square;
}

/** Whether simplices whose largest mu^2 is square may have an RR^2 above limit. */
static inline int may_exceed_ratio(double square, double limit, const int dim) {
    return !(lanes_get(ratio_bound(lanes_of(square), dim), 0) <= limit);
}

/** RR^2 of the tetrahedra of the pack at facet i, with the node at x, from the points of the ring, which
 *  is still where it was gathered. t: the pack at x. */
PL_INLINE lanes radius_ratio_of_points(const star *s, int64_t i, const corners *t, vec3 x,
                                       lanes inverse_d) {
    vec3 p[3], r[3], e[3], m[3];
    lanes area[3];
    for (int j = 0; j < 3; j++) {
        lanes column[PL_ROW];
        points_to_columns(s->spare, s->facet + 3 * i + j, 3, column);
        p[j] = (vec3){column[0], column[1], column[2]};
        r[j] = vec3_minus(x, p[j]);
    }
    for (int j = 0; j < 3; j++)
        e[j] = vec3_minus(p[(j + 1) % 3], p[j]);
    const vec3 b = e[0], c = vec3_minus(p[2], p[0]), n = {t->n[0], t->n[1], t->n[2]};
    const vec3 w = vec3_minus(vec3_scaled(c, vec3_dot(b, b)), vec3_scaled(b, vec3_dot(c, c)));
    const lanes nn = vec3_dot(n, n), areas = areas_from(r, e, m, area);
    const lanes k = nn * t->aa + vec3_dot(r[0], vec3_cross(n, w)); /* |n|^2 (|x - o|^2 - rho^2) */
    const lanes q = (lanes_sqrt(nn) + areas) * (inverse_d * inverse_d);
    return (k * k + vec3_dot(w, w) * (t->D * t->D)) / nn * (q * q) * lanes_of(RR2_FACTOR_3D);
}

/** Answer as exceeds_ratio does, inlined where dim is constant. */
PL_INLINE int exceeds_ratio_of(const star *s, const double *position, double limit, const int dim) {
    const lanes x[3] = {lanes_of(position[0]), lanes_of(position[1]),
                        lanes_of(dim == 3 ? position[2] : 0)};
    lanes_mask any = lanes_greater(lanes_of(0), lanes_of(0));
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        const corners t = corners_at(s, i, x, 0, 0, dim);
        lanes inverse_d, square;
        const lanes bound = ratio_bound(mean_of(&t, &inverse_d, dim), dim);
        const lanes_mask is_open = lanes_greater(bound, lanes_of(limit));
        if (!lanes_any_set(is_open))
            continue;
        if (dim == 3) {
            square = radius_ratio_of_points(s, i, &t, (vec3){x[0], x[1], x[2]}, inverse_d);
        } else {
            const triangles f = triangles_at(s, i, x[0], x[1]);
            const lanes rr = f.L * (f.a * f.b) * (f.L + (f.a + f.b)) * (inverse_d * inverse_d);
            square = rr * rr * lanes_of(RR2_FACTOR_2D);
        }
        any |= is_open & lanes_greater(square, lanes_of(limit));
    }
    return lanes_any_set(any);
}

/** Whether a simplex of the star has an RR^2 above limit with the node at position. Those whose bound
 *  is not above it are not looked at. Not inlined: it is seldom asked for. */
PL_NOINLINE int exceeds_ratio(const star *s, const double *position, double limit, const int dim) {
    return dim == 3 ? exceeds_ratio_of(s, position, limit, 3)
                    : exceeds_ratio_of(s, position, limit, 2);
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
