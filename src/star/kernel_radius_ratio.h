/* kernel_radius_ratio: sum of RR^2 over a star, its gradient and Hessian, at any position of the
 * node.
 *
 * Formulas and symbols: docs/algorithm.md. In 3-D RR^2 = N s^2 / (36 D^4), in 2-D
 * RR^2 = (L d e (L + d + e) / (4 D^2))^2 with D twice the area; the constant factors 1/36 and 1/16
 * are applied to the sums.
 *
 *   value_2d, value_3d, derivatives_2d, derivatives_3d         a star
 *   accumulator_init, accumulate, accumulator_result           sums over the packs: values
 *   slopes, slopes_result                                      and derivatives
 *   triangles_at, log_derivatives_2d                           a pack of triangles
 */
#ifndef PL_STAR_KERNEL_RADIUS_RATIO_H
#define PL_STAR_KERNEL_RADIUS_RATIO_H

#include "star/kernel_direction.h"
#include "star/kernel_link_edges.h"
#include "star/kernel_tetrahedra.h"

#define RR2_FACTOR_3D (1.0 / 36.0)
#define RR2_FACTOR_2D (1.0 / 16.0)

/** The objective at a position. */
typedef struct objective {
    double sum, max; /* of RR^2 */
    double error;    /* relative, of sum and max: what the rounding of D can have done, see below */
    int positive;    /* all D > 0 */
    int certain;     /* all D > 0 beyond doubt of rounding */
    double shortfall, largest_g; /* sum of max(0, g)^2, and the largest g; guarded only */
} objective;

/* The relative error of RR^2 ~ N / D^4 is at most that of D, sqrt(ROUNDING) |x - p0| / D, times
 * this: 4 for D^4, and N is at least as well known, because |alpha| = 2 D R with R >= |x - p0| / 2.
 * Areas are not in it: that of a face at x, |e x r|, is known to 2^-53 |e| |r| / |e x r|, which is
 * more than that of D where an edge at x is very short and the elements around it are not flat. */
#define ERROR_FACTOR 8

/** Derivatives of the sum: gradient, Hessian (xx xy xz yy yz zz; 2-D: xx xy yy), and the mean
 *  square distance of x from the first nodes of the facets, the star's size squared. */
typedef struct derivatives {
    double gradient[3], hessian[6];
    double size2;
} derivatives;

/** Accumulators of PL_LANES lanes of the objective. */
typedef struct accumulator {
    lanes sum[PL_PACKS], max[PL_PACKS], error2[PL_PACKS];
    lanes_mask positive[PL_PACKS];
} accumulator;

/** Set the accumulators to 0, and all lanes to positive. */
PL_INLINE void accumulator_init(accumulator *t) {
    for (int k = 0; k < PL_PACKS; k++) {
        t->sum[k] = t->max[k] = t->error2[k] = lanes_of(0);
        t->positive[k] = lanes_greater(lanes_of(1), lanes_of(0));
    }
}

/** Take in one pack: inverse_d2 = 1 / D^2, rounding = ROUNDING |x - p0|^2. */
PL_INLINE void accumulate(accumulator *t, int k, lanes rr2, lanes weight, lanes D, lanes inverse_d2,
                          lanes rounding) {
    t->sum[k] += rr2 * weight;
    t->max[k] = lanes_max(rr2, t->max[k]);
    t->error2[k] = lanes_max(rounding * inverse_d2, t->error2[k]);
    t->positive[k] &= lanes_greater(D, lanes_of(0));
}

/** Return the objective from the accumulators, times factor. Inlined, the accumulators stay in
 *  registers. */
PL_INLINE objective accumulator_result(const accumulator *t, double factor) {
    const double error2 = lanes_largest(t->error2);
    objective f = {lanes_sum(t->sum) * factor,
                   lanes_largest(t->max) * factor,
                   ERROR_FACTOR * sqrt(error2),
                   1,
                   1,
                   0,
                   0};
    for (int k = 0; k < PL_PACKS; k++)
        f.positive &= lanes_all_set(t->positive[k]);
    f.certain = f.positive && error2 < 1;
    return f;
}

/** Sums of the derivatives in PL_LANES lanes, and of |x - p0|^2. */
typedef struct slopes {
    lanes g[3][PL_PACKS], h[6][PL_PACKS], size2[PL_PACKS];
} slopes;

/** Set the derivatives of star s from the sums: gradient and Hessian times these factors; of_hessian
 *  0: there is none. */
PL_INLINE void slopes_result(const slopes *t, const star *s, double of_gradient, double of_hessian,
                             derivatives *out, const int dim) {
    for (int c = 0; c < dim; c++)
        out->gradient[c] = lanes_sum(t->g[c]) * of_gradient;
    for (int c = 0; of_hessian > 0 && c < dim * (dim + 1) / 2; c++)
        out->hessian[c] = lanes_sum(t->h[c]) * of_hessian;
    out->size2 = lanes_sum(t->size2) / (double)s->n_facets;
}

/* ---- tetrahedra --------------------------------------------------------------------------- */

/** Value of the objective of a star of tetrahedra with the node at position. */
PL_INLINE objective value_3d(const star *s, const double *position, const int guarded) {
    vec3 x = {lanes_of(position[0]), lanes_of(position[1]), lanes_of(position[2])};
    accumulator total;
    accumulator_init(&total);
    if (!guarded)
        find_areas(s, x);
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            int64_t j = i + k * PL_PACK;
            tetrahedra t = tetrahedra_at(s, j, x, guarded ? areas_at(s, j, x) : sum_areas(s, j));
            lanes inverse_d2 = lanes_of(1) / (t.D * t.D);
            accumulate(&total, k, rr2_of(&t, inverse_d2), load(s, WEIGHT, j), t.D, inverse_d2,
                       load(s, ROUNDING, j) * t.aa);
        }
    return accumulator_result(&total, RR2_FACTOR_3D);
}

/** Sums over the facets under way. */
typedef struct sums_3d {
    accumulator values;
    slopes slope;
    lanes trace[PL_PACKS];
} sums_3d;

/** Add g of a pack to the gradient. */
PL_INLINE void add_gradient_3d(sums_3d *sums, int k, vec3 g) {
    sums->slope.g[0][k] += g.x;
    sums->slope.g[1][k] += g.y;
    sums->slope.g[2][k] += g.z;
}

/** Add a pack's values; returns RR^2 times its weight. */
PL_INLINE lanes add_values_3d(const star *s, int64_t i, int k, const tetrahedra *t,
                              lanes inverse_d2, sums_3d *sums) {
    const lanes rr2 = rr2_of(t, inverse_d2), weight = load(s, WEIGHT, i);
    accumulate(&sums->values, k, rr2, weight, t->D, inverse_d2, load(s, ROUNDING, i) * t->aa);
    sums->slope.size2[k] += t->aa * weight;
    store(s, RATE, i, t->D * inverse_d2);
    return rr2 * weight;
}

/** Values, and half of the gradient without the Hessian. */
PL_INLINE void add_half_gradients_3d(const star *s, vec3 x, sums_3d *sums) {
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            int64_t j = i + k * PL_PACK;
            tetrahedra t = tetrahedra_at(s, j, x, load(s, AREAS, j));
            lanes inverse_d2 = lanes_of(1) / (t.D * t.D);
            add_values_3d(s, j, k, &t, inverse_d2, sums);
            add_gradient_3d(
                sums, k,
                half_gradient_of(&t, vec3_load(s, SX, SY, SZ, j), inverse_d2, load(s, WEIGHT, j)));
        }
}

/** First pass for both derivatives: values, and what gradient and Hessian are made of, into
 * columns. In a loop by itself, since its divisions take long: more facets are under way then. */
PL_INLINE void prepare_derivatives_3d(const star *s, vec3 x, sums_3d *sums) {
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            int64_t j = i + k * PL_PACK;
            tetrahedra t = tetrahedra_at(s, j, x, load(s, AREAS, j));
            lanes inverse_d2 = lanes_of(1) / (t.D * t.D), inverse_d = t.D * inverse_d2;
            lanes inverse_sn = lanes_of(1) / (t.s * t.N), inverse_s = t.N * inverse_sn;
            lanes rr2 = add_values_3d(s, j, k, &t, inverse_d2, sums);
            coefficients f = coefficients_of(&t, inverse_d, t.s * inverse_sn, rr2);
            const vec3 gs = vec3_scaled(vec3_load(s, SX, SY, SZ, j), inverse_s);
            sums->trace[k] += f.trace;
            store(s, RR2, j, rr2);
            store(s, OF_S, j, lanes_of(2) * (rr2 * inverse_s));
            store(s, OF_C, j, f.of_c);
            store(s, OF_N, j, f.of_n);
            store(s, OF_CC, j, f.of_cc);
            store(s, OF_CN, j, f.of_cn);
            store(s, OF_NN, j, f.of_nn);
            vec3_store(s, CX, j, t.c);
            vec3_store(s, SX, j, gs);
        }
}

/** Second pass: the derivatives, but for the bends of the faces. */
PL_INLINE void add_derivatives_3d(const star *s, sums_3d *sums) {
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            int64_t j = i + k * PL_PACK;
            coefficients f = {load(s, OF_C, j),  load(s, OF_N, j),  load(s, OF_CC, j),
                              load(s, OF_CN, j), load(s, OF_NN, j), lanes_of(0)};
            lanes h[6], rr2 = load(s, RR2, j);
            vec3 l =
                log_derivatives_3d(&f, vec3_load(s, CX, CY, CZ, j), vec3_load(s, NX, NY, NZ, j),
                                   vec3_load(s, SX, SY, SZ, j), rr2, h);
            add_gradient_3d(sums, k, vec3_scaled(l, rr2));
            for (int c = 0; c < 6; c++)
                sums->slope.h[c][k] += h[c];
        }
    for (int k = 0; k < PL_PACKS; k++)
        for (int d = 0; d < 3; d++)
            sums->slope.h[packed(d, d, 3)][k] += sums->trace[k];
}

/** Find the derivatives of a star of tetrahedra. with_hessian 0: out->hessian is not set; the
 * gradient is by another formula, and differs by rounding. */
PL_INLINE objective derivatives_3d(const star *s, const double *position, derivatives *out,
                                   const int with_hessian) {
    vec3 x = {lanes_of(position[0]), lanes_of(position[1]), lanes_of(position[2])};
    sums_3d sums;
    memset(&sums, 0, sizeof sums);
    accumulator_init(&sums.values);
    find_slopes(s, x, with_hessian);
    if (with_hessian) {
        prepare_derivatives_3d(s, x, &sums);
        add_derivatives_3d(s, &sums);
        add_bends(s, sums.slope.h);
    } else {
        add_half_gradients_3d(s, x, &sums);
    }
    slopes_result(&sums.slope, s, (with_hessian ? 1 : 2) * RR2_FACTOR_3D,
                  with_hessian ? RR2_FACTOR_3D : 0, out, 3);
    return accumulator_result(&sums.values, RR2_FACTOR_3D);
}

/* ---- triangles ---------------------------------------------------------------------------- */

/** Pack of triangles at x. */
typedef struct triangles {
    lanes ax, ay, bx, by;     /* x - p0, x - p1 */
    lanes aa, bb, a, b, L, D; /* their squares and lengths, the facet's length, twice the area */
} triangles;

/** Compute the pack of triangles at facet i, with the node at (x, y). */
PL_INLINE triangles triangles_at(const star *s, int64_t i, lanes x, lanes y) {
    triangles t;
    t.ax = x - load(s, P0X, i);
    t.ay = y - load(s, P0Y, i);
    t.bx = x - load(s, P1X, i);
    t.by = y - load(s, P1Y, i);
    t.aa = t.ax * t.ax + t.ay * t.ay;
    t.bb = t.bx * t.bx + t.by * t.by;
    t.a = lanes_sqrt(t.aa);
    t.b = lanes_sqrt(t.bb);
    t.L = load(s, LENGTH, i);
    t.D = (load(s, P1X, i) - load(s, P0X, i)) * t.ay - (load(s, P1Y, i) - load(s, P0Y, i)) * t.ax;
    return t;
}

/** Value of the objective of a star of triangles with the node at position. */
static inline objective value_2d(const star *s, const double *position) {
    lanes x = lanes_of(position[0]), y = lanes_of(position[1]);
    accumulator total;
    accumulator_init(&total);
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            int64_t j = i + k * PL_PACK;
            triangles t = triangles_at(s, j, x, y);
            lanes inverse_d = lanes_of(1) / t.D, inverse_d2 = inverse_d * inverse_d;
            lanes rr = t.L * (t.a * t.b) * (t.L + (t.a + t.b)) * inverse_d2;
            accumulate(&total, k, rr * rr, load(s, WEIGHT, j), t.D, inverse_d2,
                       load(s, ROUNDING, j) * t.aa);
        }
    return accumulator_result(&total, RR2_FACTOR_2D);
}

/** Find the derivatives of a pack. With a, b the distances to the ends, p = L + a + b and D twice
 * the area, log RR^2 = 2 (log a + log b + log p - 2 log D) + const: l = 2 (A + B + (ua + ub) / p -
 * 2 n / D), hess RR^2 / RR^2 = l l^T + 2 (hess log a + hess log b + hess log p + 2 n n^T / D^2),
 * where A = (x - p0) / a^2, ua = (x - p0) / a, hess log a = I / a^2 - 2 A A^T, and hess log p = ((I
 * - ua ua^T) / a + (I - ub ub^T) / b) / p - (ua + ub)(ua + ub)^T / p^2. */
PL_INLINE void log_derivatives_2d(const star *s, int64_t i, const triangles *t, lanes inverse_d,
                                  lanes l[2], lanes h[3]) {
    const lanes one = lanes_of(1), two = lanes_of(2);
    lanes ia = one / t->a, ib = one / t->b, ip = one / (t->L + (t->a + t->b));
    lanes uax = t->ax * ia, uay = t->ay * ia, ubx = t->bx * ib, uby = t->by * ib;
    lanes px = (uax + ubx) * ip, py = (uay + uby) * ip;
    lanes nx = (load(s, P0Y, i) - load(s, P1Y, i)) * inverse_d;
    lanes ny = (load(s, P1X, i) - load(s, P0X, i)) * inverse_d;
    l[0] = two * (uax * ia + ubx * ib + px - two * nx);
    l[1] = two * (uay * ia + uby * ib + py - two * ny);
    lanes ia2 = ia * ia, ib2 = ib * ib, iap = ia * ip, ibp = ib * ip;
    lanes trace = ia2 + ib2 + iap + ibp;
    lanes ca = two * ia2 + iap, cb = two * ib2 + ibp;
#define LOG_HESSIAN(i, j)                                                                          \
    (two * (n##i * n##j) - (ca * (ua##i * ua##j) + cb * (ub##i * ub##j)) - p##i * p##j)
    h[0] = l[0] * l[0] + two * (trace + LOG_HESSIAN(x, x));
    h[1] = l[0] * l[1] + two * LOG_HESSIAN(x, y);
    h[2] = l[1] * l[1] + two * (trace + LOG_HESSIAN(y, y));
#undef LOG_HESSIAN
}

/** Value of the objective of a star of triangles with the node at position; fills out with the
 *  derivatives. */
static inline objective derivatives_2d(const star *s, const double *position, derivatives *out) {
    lanes x = lanes_of(position[0]), y = lanes_of(position[1]);
    accumulator total;
    accumulator_init(&total);
    slopes sums;
    memset(&sums, 0, sizeof sums);
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            int64_t j = i + k * PL_PACK;
            triangles t = triangles_at(s, j, x, y);
            lanes weight = load(s, WEIGHT, j);
            lanes inverse_d = lanes_of(1) / t.D;
            lanes inverse_d2 = inverse_d * inverse_d;
            lanes rr = t.L * (t.a * t.b) * (t.L + (t.a + t.b)) * inverse_d2;
            lanes rr2 = rr * rr;
            store(s, RATE, j, inverse_d);
            accumulate(&total, k, rr2, weight, t.D, inverse_d2, load(s, ROUNDING, j) * t.aa);
            lanes l[2], hessian[3];
            log_derivatives_2d(s, j, &t, inverse_d, l, hessian);
            rr2 *= weight;
            for (int c = 0; c < 2; c++)
                sums.g[c][k] += rr2 * l[c];
            for (int c = 0; c < 3; c++)
                sums.h[c][k] += rr2 * hessian[c];
            sums.size2[k] += t.aa * weight;
        }
    slopes_result(&sums, s, RR2_FACTOR_2D, RR2_FACTOR_2D, out, 2);
    return accumulator_result(&total, RR2_FACTOR_2D);
}

#endif
