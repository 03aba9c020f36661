/* kernel_mean: sum of mu^2, the squared mean ratios of corners, over a star, its gradient and Hessian;
 * and the ratio that a kernel's stars have: this one where facets have forms (geometry/corner.h),
 * else the radius ratio.
 *
 * mu^2 = E^2 D^-k, k = 4/3, in 2-D 2, with E = c |x - o|^2 + e0, in which the root of the form's factor
 * is, and D affine in x. With f = x - o, n = grad D and p = 2 c / E
 *
 *     grad mu^2 / mu^2 = 2 p f - k n / D = z + p f,    z = p f - k n / D
 *     hess mu^2 / mu^2 = 2 z z^T + k (1 - k) n n^T / D^2 + 2 p I
 *
 * which is positive definite: |affine|^2 / affine^(k / 2) is convex, and so is its square. In a metric
 * E = c |L (x - o)|^2 + e0, f = L^T L (x - o), and L^T L is in the place of I. Where sizes
 * have a weight w, a corner counts by (1 - w) mu^2 + w (tau + 1 / tau) / 2, tau = D / det W its size
 * in units of its target's: convex, too.
 *
 *   corners, corners_at, mean_of                  a pack of corners
 *   sized_ratio, counted_ratio, size_slopes, add_size   and what their sizes add
 *   find_roots                                    roots of all packs
 *   mean_value, mean_derivatives                  a star
 *   value_at, derivatives_at                      a star, by the ratio of its kernel
 */
#ifndef PL_STAR_KERNEL_MEAN_H
#define PL_STAR_KERNEL_MEAN_H

#include "star/kernel_radius_ratio.h"

/** Pack of corners at x. */
typedef struct corners {
    lanes n[3], pull[3]; /* grad D; f, grad E = 2 c f */
    lanes aa, D, c, E;   /* |x - p0|^2 */
    lanes root;          /* in space: D^(-1/3) */
} corners;

/** Set n [dim] to grad D of the pack at facet i. */
PL_INLINE void find_normal(const star *s, int64_t i, lanes *n, const int dim) {
    if (dim == 3) {
        for (int d = 0; d < 3; d++)
            n[d] = load(s, NX + d, i);
    } else {
        n[0] = load(s, P0Y, i) - load(s, P1Y, i);
        n[1] = load(s, P1X, i) - load(s, P0X, i);
    }
}

/** Return D of the pack at facet i, whose gradient is n, with the node at x [dim]. */
PL_INLINE lanes determinant_at(const star *s, int64_t i, const lanes *x, const lanes *n,
                               const int dim) {
    static const uint8_t first[3] = {P0X, P0Y, P0Z};
    lanes D = load(s, BASE, i);
    for (int d = 0; d < dim; d++)
        D += (x[d] - load(s, first[d], i)) * n[d];
    return D;
}

/** Make f of x - o, in the metrics of the pack at facet i. Returns |L (x - o)|^2. */
PL_INLINE lanes pull_in_metric(const star *s, int64_t i, lanes f[3], const int dim) {
    lanes y[3], square = lanes_of(0);
    for (int r = 0, k = METRIC; r < dim; r++) {
        y[r] = lanes_of(0);
        for (int c = r; c < dim; c++, k++)
            y[r] += load(s, k, i) * f[c];
        square += y[r] * y[r];
    }
    for (int c = 0; c < dim; c++)
        f[c] = lanes_of(0);
    for (int r = 0, k = METRIC; r < dim; r++)
        for (int c = r; c < dim; c++, k++)
            f[c] += load(s, k, i) * y[r];
    return square;
}

/** Fill m with the upper triangle of L^T L of the pack at facet i. */
PL_INLINE void square_of_metric(const star *s, int64_t i, lanes m[6], const int dim) {
    for (int k = 0; k < dim * (dim + 1) / 2; k++)
        m[k] = lanes_of(0);
    for (int r = 0, first = METRIC; r < dim; first += dim - r, r++)
        for (int a = r; a < dim; a++)
            for (int b = a; b < dim; b++)
                m[packed(a, b, dim)] += load(s, first + a - r, i) * load(s, first + b - r, i);
}

/** Find the pack of corners at facet i, with the node at x [dim]. has_roots: after find_roots. */
PL_INLINE corners corners_at(const star *s, int64_t i, const lanes *x, const int has_roots,
                             const int has_metric, const int dim) {
    static const uint8_t first[3] = {P0X, P0Y, P0Z};
    corners t;
    lanes square = lanes_of(0);
    find_normal(s, i, t.n, dim);
    t.aa = lanes_of(0);
    t.D = has_roots ? load(s, DETERMINANT, i) : determinant_at(s, i, x, t.n, dim);
    for (int d = 0; d < dim; d++) {
        const lanes a = x[d] - load(s, first[d], i);
        t.pull[d] = a + load(s, OX + d, i);
        t.aa += a * a;
        square += t.pull[d] * t.pull[d];
    }
    if (has_metric)
        square = pull_in_metric(s, i, t.pull, dim);
    t.c = load(s, FORM_C, i);
    t.E = t.c * square + load(s, FORM_E0, i);
    if (dim == 3)
        t.root = has_roots ? load(s, ROOT, i) : lanes_inverse_cube_root(t.D);
    return t;
}

/** Fill the columns DETERMINANT and ROOT of corners in space, with the node at x. In a loop by itself:
 *  roots take long, and more of them are under way then. */
PL_INLINE void find_roots(const star *s, const lanes *x) {
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        const lanes n[3] = {load(s, NX, i), load(s, NY, i), load(s, NZ, i)};
        const lanes D = determinant_at(s, i, x, n, 3);
        store(s, DETERMINANT, i, D);
        store(s, ROOT, i, lanes_inverse_cube_root(D));
    }
}

/** Return mu^2 of a pack, and 1 / D. */
PL_INLINE lanes mean_of(const corners *t, lanes *inverse_d, const int dim) {
    if (dim == 2) {
        *inverse_d = lanes_of(1) / t->D;
        return t->E * t->E * (*inverse_d * *inverse_d);
    }
    const lanes root2 = t->root * t->root;
    *inverse_d = root2 * t->root;
    return t->E * t->E * (root2 * root2);
}

/** Return the ratio of a pack with mu^2 = square that counts where sizes have a weight. */
PL_INLINE lanes sized_ratio(const star *s, int64_t i, const corners *t, lanes square,
                            lanes inverse_d) {
    const lanes tau = t->D * load(s, UNIT, i), inverse = inverse_d * load(s, WANTED, i);
    return lanes_of(1 - s->size_weight) * square + lanes_of(s->size_weight / 2) * (tau + inverse);
}

/** Return mu^2 of a pack, or with sizes its replacement, and 1 / D. */
PL_INLINE lanes counted_ratio(const star *s, int64_t i, const corners *t, lanes *inverse_d,
                              const int dim) {
    const lanes square = mean_of(t, inverse_d, dim);
    return s->size_weight > 0 ? sized_ratio(s, i, t, square, *inverse_d) : square;
}

/** The exponent k of D. */
static inline double mean_power(const int dim) {
    return dim == 3 ? 4.0 / 3 : 2;
}

/** Value of the objective of a star with the node at position. */
PL_INLINE objective mean_value(const star *s, const double *position, const int has_metric,
                               const int dim) {
    const lanes x[3] = {lanes_of(position[0]), lanes_of(position[1]),
                        lanes_of(dim == 3 ? position[2] : 0)};
    accumulator total;
    accumulator_init(&total);
    if (dim == 3)
        find_roots(s, x);
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            const int64_t j = i + k * PL_PACK;
            const corners t = corners_at(s, j, x, dim == 3, has_metric, dim);
            lanes inverse_d;
            const lanes square = counted_ratio(s, j, &t, &inverse_d, dim);
            accumulate(&total, k, square, load(s, WEIGHT, j), t.D, inverse_d * inverse_d,
                       load(s, ROUNDING, j) * t.aa);
        }
    return accumulator_result(&total, 1);
}

/** Add the derivatives of the pack at facet i with mu^2 = square; trace: what the Hessian's diagonal has
 *  more without a metric. */
PL_INLINE void add_mean(const star *s, int64_t i, slopes *slope, lanes *trace, int k,
                        const corners *t, lanes square, lanes inverse_d, const int with_hessian,
                        const int has_metric, const int dim) {
    const double power = mean_power(dim);
    const lanes p = (t->c + t->c) / t->E, of_n = lanes_of(power) * inverse_d;
    const lanes twice = square + square;
    const lanes bend = lanes_of(power * (1 - power)) * (square * (inverse_d * inverse_d));
    lanes z[3], v[3], m[3];
    for (int d = 0; d < dim; d++) {
        const lanes pull = p * t->pull[d];
        z[d] = pull - of_n * t->n[d];
        slope->g[d][k] += square * (z[d] + pull);
        v[d] = twice * z[d];
        m[d] = bend * t->n[d];
    }
    if (!with_hessian)
        return;
    if (has_metric) {
        lanes of_metric[6];
        square_of_metric(s, i, of_metric, dim);
        for (int h = 0; h < dim * (dim + 1) / 2; h++)
            slope->h[h][k] += twice * p * of_metric[h];
    } else {
        *trace += twice * p;
    }
    for (int r = 0, h = 0; r < dim; r++)
        for (int c = r; c < dim; c++, h++)
            slope->h[h][k] += z[r] * v[c] + t->n[r] * m[c];
}

/** Derivatives of the sizes of a pack by D, times factor. */
typedef struct size_slopes {
    lanes rate, curve;
} size_slopes;

PL_INLINE size_slopes size_slopes_of(const star *s, int64_t i, lanes factor, lanes inverse_d) {
    const lanes bend = load(s, WANTED, i) * (inverse_d * inverse_d);
    const lanes half = lanes_of(s->size_weight / 2) * factor;
    return (size_slopes){half * (load(s, UNIT, i) - bend), (half + half) * (bend * inverse_d)};
}

/** Add the derivatives of the sizes of a pack, times factor. */
PL_INLINE void add_size(const star *s, int64_t i, slopes *slope, int k, const corners *t,
                        lanes factor, lanes inverse_d, const int with_hessian, const int dim) {
    const size_slopes size = size_slopes_of(s, i, factor, inverse_d);
    for (int d = 0; d < dim; d++)
        slope->g[d][k] += size.rate * t->n[d];
    for (int r = 0, h = 0; with_hessian && r < dim; r++)
        for (int c = r; c < dim; c++, h++)
            slope->h[h][k] += size.curve * (t->n[r] * t->n[c]);
}

/** Find the derivatives of a star with the node at position. with_hessian 0: out->hessian is not set. */
PL_INLINE objective mean_derivatives(const star *s, const double *position, derivatives *out,
                                     const int with_hessian, const int has_metric, const int dim) {
    const lanes x[3] = {lanes_of(position[0]), lanes_of(position[1]),
                        lanes_of(dim == 3 ? position[2] : 0)};
    accumulator total;
    slopes slope;
    lanes trace[PL_PACKS];
    accumulator_init(&total);
    memset(&slope, 0, sizeof slope);
    memset(trace, 0, sizeof trace);
    if (dim == 3)
        find_roots(s, x);
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            const int64_t j = i + k * PL_PACK;
            const corners t = corners_at(s, j, x, dim == 3, has_metric, dim);
            const lanes weight = load(s, WEIGHT, j);
            lanes inverse_d;
            const lanes square = mean_of(&t, &inverse_d, dim);
            lanes ratio = square, of_shape = weight;
            if (s->size_weight > 0) {
                ratio = sized_ratio(s, j, &t, square, inverse_d);
                of_shape = lanes_of(1 - s->size_weight) * weight;
                add_size(s, j, &slope, k, &t, weight, inverse_d, with_hessian, dim);
            }
            store(s, RATE, j, inverse_d);
            accumulate(&total, k, ratio, weight, t.D, inverse_d * inverse_d,
                       load(s, ROUNDING, j) * t.aa);
            slope.size2[k] += t.aa * load(s, IS_FACET, j);
            add_mean(s, j, &slope, &trace[k], k, &t, square * of_shape, inverse_d, with_hessian,
                     has_metric, dim);
        }
    for (int k = 0; with_hessian && !has_metric && k < PL_PACKS; k++)
        for (int d = 0; d < dim; d++)
            slope.h[packed(d, d, dim)][k] += trace[k];
    slopes_result(&slope, s, 1, with_hessian, out, dim);
    return accumulator_result(&total, 1);
}

/** mean_value in a metric. Not inlined: few meshes have one. */
PL_NOINLINE objective value_in_metric(const star *s, const double *position, const int dim) {
    return dim == 3 ? mean_value(s, position, 1, 3) : mean_value(s, position, 1, 2);
}

/** mean_derivatives in a metric. */
PL_NOINLINE objective derivatives_in_metric(const star *s, const double *position, derivatives *out,
                                            const int with_hessian, const int dim) {
    return dim == 3 ? mean_derivatives(s, position, out, with_hessian, 1, 3)
                    : mean_derivatives(s, position, out, with_hessian, 1, 2);
}

/* ---- either -------------------------------------------------------------------------------- */

/** Value of the objective. guarded: the star was gathered for the guarded kernel. */
PL_INLINE objective value_at(const star *s, const double *position, const int guarded,
                             const int dim) {
    if (has_forms(s))
        return s->has_metric ? value_in_metric(s, position, dim) : mean_value(s, position, 0, dim);
    return dim == 3 ? value_3d(s, position, guarded) : value_2d(s, position);
}

/** Find the derivatives of the objective. with_hessian 0: out->hessian need not be set. */
PL_INLINE objective derivatives_at(const star *s, const double *position, derivatives *out,
                                   const int with_hessian, const int dim) {
    if (has_forms(s))
        return s->has_metric ? derivatives_in_metric(s, position, out, with_hessian, dim)
                             : mean_derivatives(s, position, out, with_hessian, 0, dim);
    return dim == 3 ? derivatives_3d(s, position, out, with_hessian)
                    : derivatives_2d(s, position, out);
}

#endif
