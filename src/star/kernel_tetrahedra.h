/* kernel_tetrahedra: RR^2 of a pack of tetrahedra of a star, and its logarithmic derivatives.
 *
 *   tetrahedra_at, edges_from, link_edges_from     a pack with its node at x
 *   areas_from, areas_at                           its surface
 *   rr2_of, half_gradient_of                       RR^2 and its gradient
 *   coefficients_of, log_derivatives_3d            logarithmic derivatives
 */
#ifndef PL_STAR_KERNEL_TETRAHEDRA_H
#define PL_STAR_KERNEL_TETRAHEDRA_H

#include "star/kernel_facets.h"

/** Pack of tetrahedra at x. */
typedef struct tetrahedra {
    vec3 a, n, c;   /* x - p0, the link facet's normal, x - its circumcentre */
    lanes aa, D, k; /* |a|^2, 6 V, |c|^2 - rho^2 with rho the facet's circumradius */
    lanes nn, ww;   /* |n|^2, 4 rho^2 */
    lanes nk, wD;   /* nn k, ww D */
    lanes N, s;     /* (12 V R)^2 = nn k^2 + ww D^2, twice the surface */
} tetrahedra;

/** Edges from the node: x - p0, x - p1, x - p2. For the guarded kernel, which has p1 and p2. */
PL_INLINE void edges_from(const star *s, int64_t i, vec3 x, vec3 r[3]) {
    r[0] = vec3_minus(x, vec3_load(s, P0X, P0Y, P0Z, i));
    r[1] = vec3_minus(x, vec3_load(s, P1X, P1Y, P1Z, i));
    r[2] = vec3_minus(x, vec3_load(s, P2X, P2Y, P2Z, i));
}

/** The link's own edges, from each of its nodes to the next. From the nodes: as differences of the
 *  edges at x short ones would lose their digits, and with them what is made of them. */
PL_INLINE void link_edges_from(const star *s, int64_t i, vec3 e[3]) {
    const vec3 p[3] = {vec3_load(s, P0X, P0Y, P0Z, i), vec3_load(s, P1X, P1Y, P1Z, i),
                       vec3_load(s, P2X, P2Y, P2Z, i)};
    for (int j = 0; j < 3; j++)
        e[j] = vec3_minus(p[(j + 1) % 3], p[j]);
}

/** Normals m of the faces at x and their lengths; returns the sum of these, the faces' areas times
 *  two. Each tetrahedron by itself: the plain form of kernel_link_edges.h. */
PL_INLINE lanes areas_from(const vec3 r[3], const vec3 e[3], vec3 m[3], lanes area[3]) {
    for (int j = 0; j < 3; j++) {
        m[j] = vec3_cross(e[j], r[j]);
        area[j] = lanes_sqrt(vec3_dot(m[j], m[j]));
    }
    return (area[0] + area[1]) + area[2];
}

/** Sum of the areas of the faces at the node, of the pack at facet i. */
PL_INLINE lanes areas_at(const star *s, int64_t i, vec3 x) {
    vec3 r[3], e[3], m[3];
    lanes area[3];
    edges_from(s, i, x, r);
    link_edges_from(s, i, e);
    return areas_from(r, e, m, area);
}

/** Return the pack of tetrahedra at facet i; areas: of their faces at x, times two. */
PL_INLINE tetrahedra tetrahedra_at(const star *s, int64_t i, vec3 x, lanes areas) {
    tetrahedra t;
    vec3 from_centre = vec3_load(s, OX, OY, OZ, i); /* to p0 */
    t.a = vec3_minus(x, vec3_load(s, P0X, P0Y, P0Z, i));
    t.n = vec3_load(s, NX, NY, NZ, i);
    t.c = vec3_plus(t.a, from_centre);
    t.aa = vec3_dot(t.a, t.a);
    t.D = vec3_dot(t.a, t.n);
    t.k = t.aa + lanes_of(2) * vec3_dot(t.a, from_centre);
    t.nn = load(s, NN, i);
    t.ww = load(s, WW, i);
    t.nk = t.nn * t.k;
    t.wD = t.ww * t.D;
    t.N = t.nk * t.k + t.wD * t.D;
    t.s = load(s, LENGTH, i) + areas;
    return t;
}

/** RR^2 of a pack, but for a constant factor. It overflows where D is below 2^-256 (facets of 1e-38
 *  of the star's size); where it does not, ROUNDING |x - p0|^2 has not underflowed either, whatever
 *  the scale, and certain is right. */
PL_INLINE lanes rr2_of(const tetrahedra *t, lanes inverse_d2) {
    return t->N * (t->s * t->s) * (inverse_d2 * inverse_d2);
}

/** Half of its gradient, times weight; S = grad s. Without the Hessian there is nothing to divide
 * by but D^2, which RR^2 needs anyway:
 *
 *      grad RR^2 / 2 = [2 nn k s^2 c + (ww D s^2 - 2 N s^2 / D) n + N s S] / D^4
 */
PL_INLINE vec3 half_gradient_of(const tetrahedra *t, vec3 S, lanes inverse_d2, lanes weight) {
    const lanes ss = t->s * t->s, Nss = t->N * ss, factor = inverse_d2 * inverse_d2 * weight;
    const lanes of_c = (t->nk + t->nk) * ss, of_S = t->N * t->s;
    const lanes of_n = t->wD * ss - (Nss + Nss) * (t->D * inverse_d2);
    return (vec3){factor * ((of_c * t->c.x + of_S * S.x) + of_n * t->n.x),
                  factor * ((of_c * t->c.y + of_S * S.y) + of_n * t->n.y),
                  factor * ((of_c * t->c.z + of_S * S.z) + of_n * t->n.z)};
}

/** Scalar coefficients of the derivatives of one pack. */
typedef struct coefficients {
    lanes of_c, of_n;          /* of grad N / N - 4 n / D in c and n */
    lanes of_cc, of_cn, of_nn; /* of the Hessian's form of c and n, times weight, see below */
    lanes trace;               /* and of its multiple of I */
} coefficients;

/** Return the coefficients: grad N / N = A c + B n, A = 4 nn k / N, B = 2 ww D / N, and
 *  hess N / N = (8 nn c c^T + 2 ww n n^T) / N + A I. With y = grad N / N - 2 n / D, the form is
 *  hess N / N - A I - 2 y y^T - 4 n n^T / D^2. */
PL_INLINE coefficients coefficients_of(const tetrahedra *t, lanes inverse_d, lanes inverse_n,
                                       lanes weight) {
    const lanes two = lanes_of(2), twice = two * weight;
    const lanes nn = t->nn * (two * inverse_n), ww = t->ww * (two * inverse_n);
    const lanes A = two * (nn * t->k), b = ww * t->D - two * inverse_d;
    return (coefficients){.of_c = A,
                          .of_n = b - two * inverse_d,
                          .of_cc = twice * (two * nn - A * A),
                          .of_cn = twice * (A * b),
                          .of_nn = weight * ww - twice * (b * b + two * (inverse_d * inverse_d)),
                          .trace = weight * A};
}

/** The log-derivatives of one pack: gradient l of log RR^2 and, times weight, the Hessian h of RR^2
 *  divided by RR^2, but for 2 hess s / s and the multiple of I. gs: grad s / s. With
 *  l = grad N / N + 2 gs - 4 n / D and z = l - gs
 *
 *  l l^T + hess log N + 2 (hess s / s - gs gs^T) + 4 n n^T / D^2
 *      = 2 z z^T + (the form of c and n) + A I + 2 hess s / s */
PL_INLINE vec3 log_derivatives_3d(const coefficients *f, vec3 c, vec3 n, vec3 gs, lanes weight,
                                  lanes h[6]) {
    const vec3 z = {(f->of_c * c.x + f->of_n * n.x) + gs.x, (f->of_c * c.y + f->of_n * n.y) + gs.y,
                    (f->of_c * c.z + f->of_n * n.z) + gs.z};
    const vec3 v = vec3_scaled(z, weight + weight);
    const vec3 cc = vec3_minus(vec3_scaled(c, f->of_cc), vec3_scaled(n, f->of_cn));
    const vec3 nn = vec3_minus(vec3_scaled(n, f->of_nn), vec3_scaled(c, f->of_cn));
    h[0] = z.x * v.x + (c.x * cc.x + n.x * nn.x);
    h[1] = z.x * v.y + (c.x * cc.y + n.x * nn.y);
    h[2] = z.x * v.z + (c.x * cc.z + n.x * nn.z);
    h[3] = z.y * v.y + (c.y * cc.y + n.y * nn.y);
    h[4] = z.y * v.z + (c.y * cc.z + n.y * nn.z);
    h[5] = z.z * v.z + (c.z * cc.z + n.z * nn.z);
    return vec3_plus(z, gs);
}

#endif
