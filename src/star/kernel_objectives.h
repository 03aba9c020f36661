/* kernel_objectives: the objective of every kind, with minimum volumes, for the guarded kernel.
 *
 * Over a star: f = ratio_weight sum AR^2 + volume_weight sum g^2, g = 1 - D / floor; its
 * derivatives; and how far elements are below their floor. One body serves both dimensions and
 * all aspect ratios. kernel_radius_ratio.h has the radius ratio alone, faster. Formulas:
 * docs/algorithm.md.
 *
 *   mean_ratio, edge_ratio, radius_ratio, worst_ratio, worst_angle_2d, _3d    a pack's measures
 *   corner_mean_ratio, worst_jacobian                                         and those of corners
 *   measure_pack, measure_at, aspect_at, volume_constraint                    a pack
 *   guarded_at                                                                a star
 */
#ifndef PL_STAR_KERNEL_OBJECTIVES_H
#define PL_STAR_KERNEL_OBJECTIVES_H

#include "geometry/inline.h"
#include "geometry/simplex.h"
#include "star/kernel_mean.h"

/* AR^2 of the mean ratio is E^2 D^(-4/3) times this, or E^2 D^-2; E the sum of the squared edges.
 */
#define MEAN_FACTOR_3D (2.5198420997897464 / 144) /* 2^(4/3) / 144 */
#define MEAN_FACTOR_2D (1.0 / 12)

/* The largest and smallest of the squared edges are smoothed to means of this power's power of 2.
 */
enum { SHARPNESS = PL_EDGE_SHARPNESS };

/* Facets without a floor: their g is never active. */
#define NEVER_ACTIVE (-1e30)

/* The worst count by this power's power of 2 of what they are. */
enum { WORST_POWER = 5 };
#define WORST_EXPONENT ((double)(1 << WORST_POWER))
/* An element that adds less than this to the sum has no part in its derivatives. */
#define NEXT_TO_NOTHING 0x1p-900

_Static_assert(PL_WORST_RATIO == 3, "aspect_at and guarded_sums_of know each objective by name");

/* Measures of corners, beside the objectives. */
enum { CORNER_MEAN_RATIO = PL_WORST_JACOBIAN + 1, CORNER_EDGE_RATIO, CORNER_WORST_RATIO };

/** Whether a measure is one of corners. */
static inline int is_of_corners(int kind) {
    return kind >= PL_WORST_JACOBIAN;
}

/** Whether only the worst values count in an objective. */
static inline int is_of_worst(int kind) {
    return kind == PL_WORST_RATIO || kind == PL_WORST_ANGLE || kind == PL_WORST_JACOBIAN;
}

/** Pack of elements at x. */
typedef struct aspect {
    lanes D, inverse_d, aa; /* aa = |x - p0|^2 */
    lanes square;           /* AR^2 */
    lanes n[3];             /* grad D */
    lanes l[3], h[6];       /* grad AR^2 and hess AR^2, divided by AR^2 */
} aspect;

/** Objective of a star besides its position. */
typedef struct question {
    int objective;        /* as that of pl_star_guard */
    double inverse_limit; /* 1 / worst_limit */
    double ratio_weight, volume_weight;
    double penalty; /* rho of the augmented Lagrangian, 0: none */
} question;

/* ---- edges -------------------------------------------------------------------------------- */

/** The vectors and squared lengths of an element's edges: first those at x, dim of them. */
typedef struct edges {
    lanes at[3][3];  /* x - p_i */
    lanes square[6]; /* of these, then of the link's own */
} edges;

/** Find the edges of the pack's elements at facet i, with the node at x [dim]. is_sharp: the link's
 *  own edges from its nodes. As differences of those at x short ones lose their digits, which sums
 *  of the squares do not mind. */
PL_INLINE edges edges_at(const star *s, int64_t i, const lanes *x, const int is_sharp,
                         const int dim) {
    static const uint8_t columns[3][3] = {{P0X, P0Y, P0Z}, {P1X, P1Y, P1Z}, {P2X, P2Y, P2Z}};
    edges e;
    for (int j = 0; j < dim; j++) {
        e.square[j] = lanes_of(0);
        for (int d = 0; d < dim; d++) {
            e.at[j][d] = x[d] - load(s, columns[j][d], i);
            e.square[j] += e.at[j][d] * e.at[j][d];
        }
    }
    for (int j = 0, k = dim; j < dim; j++)
        for (int other = j + 1; other < dim; other++, k++) {
            e.square[k] = lanes_of(0);
            for (int d = 0; d < dim; d++) {
                lanes difference = is_sharp
                                       ? load(s, columns[other][d], i) - load(s, columns[j][d], i)
                                       : e.at[other][d] - e.at[j][d];
                e.square[k] += difference * difference;
            }
        }
    return e;
}

/** Sum of a [n]. */
PL_INLINE lanes sum_of(const lanes *a, int n) {
    lanes sum = a[0];
    for (int k = 1; k < n; k++)
        sum += a[k];
    return sum;
}

/** Square a so many times. */
PL_INLINE lanes squared(lanes a, int times) {
    for (int i = 0; i < times; i++)
        a *= a;
    return a;
}

/** Number of edges of an element. */
static inline int n_edges(const int dim) {
    return dim == 3 ? 6 : 3;
}

/* ---- mean ratio ---------------------------------------------------------------------------- */

/** Compute AR^2 = c E^2 D^-k, k = 4/3 or 2: l = 2 grad E / E - k n / D,
 *  hess AR^2 / AR^2 = l l^T + 2 (hess E / E - grad E grad E^T / E^2) + k n n^T / D^2. */
PL_INLINE void mean_ratio(const star *s, int64_t i, const lanes *x, aspect *a, const int derive,
                          const int dim) {
    edges e = edges_at(s, i, x, 0, dim);
    const lanes sum = sum_of(e.square, n_edges(dim));
    if (dim == 3) {
        lanes root = lanes_inverse_cube_root(a->D), root2 = root * root;
        a->square = sum * sum * (root2 * root2) * lanes_of(MEAN_FACTOR_3D);
    } else {
        a->square = sum * sum * (a->inverse_d * a->inverse_d) * lanes_of(MEAN_FACTOR_2D);
    }
    if (!derive)
        return;
    const lanes power = lanes_of(dim == 3 ? 4.0 / 3 : 2), inverse = lanes_of(1) / sum;
    lanes gs[3], gd[3];
    for (int d = 0; d < dim; d++) {
        gs[d] = e.at[0][d];
        for (int j = 1; j < dim; j++)
            gs[d] += e.at[j][d];
        gs[d] = lanes_of(2) * gs[d] * inverse;
        gd[d] = a->n[d] * a->inverse_d;
        a->l[d] = lanes_of(2) * gs[d] - power * gd[d];
    }
    for (int r = 0, k = 0; r < dim; r++)
        for (int c = r; c < dim; c++, k++) {
            a->h[k] = a->l[r] * a->l[c] - lanes_of(2) * (gs[r] * gs[c]) + power * (gd[r] * gd[c]);
            if (r == c)
                a->h[k] += lanes_of(4 * dim) * inverse;
        }
}

/* ---- edge ratio ---------------------------------------------------------------------------- */

/** Add the derivatives of (1/q) log sum (square_k)^(sign q) to l and h, q = 2^SHARPNESS: with the
 *  shares w_k = share_k / total of the edges at x and c_k = sign grad square_k / square_k,
 *  l = sum w_k c_k, hess = sum w_k (sign hess square_k / square_k + (q - sign) c_k c_k^T) - q l
 *  l^T.
 */
PL_INLINE void smoothed_extreme(const edges *e, const lanes *share, lanes total, double sign,
                                aspect *a, const int dim) {
    const double q = (double)(1 << SHARPNESS);
    lanes own[3] = {lanes_of(0), lanes_of(0), lanes_of(0)};
    for (int j = 0; j < dim; j++) {
        lanes w = share[j] / total, inverse = lanes_of(1) / e->square[j], c[3];
        for (int d = 0; d < dim; d++) {
            c[d] = lanes_of(2 * sign) * e->at[j][d] * inverse;
            own[d] += w * c[d];
        }
        for (int r = 0, k = 0; r < dim; r++)
            for (int t = r; t < dim; t++, k++) {
                a->h[k] += w * lanes_of(q - sign) * (c[r] * c[t]);
                if (r == t)
                    a->h[k] += w * lanes_of(2 * sign) * inverse;
            }
    }
    for (int r = 0, k = 0; r < dim; r++) {
        a->l[r] += own[r];
        for (int t = r; t < dim; t++, k++)
            a->h[k] -= lanes_of(q) * (own[r] * own[t]);
    }
}

/** Compute AR^2 = (mean of square^q)^(1/q) (mean of square^-q)^(1/q): longest^2 / shortest^2,
 * smoothed. of_corners: over the edges that their elements have. */
PL_INLINE void edge_ratio(const star *s, int64_t i, const lanes *x, aspect *a, const int of_corners,
                          const int derive, const int dim) {
    const int n = n_edges(dim);
    edges e = edges_at(s, i, x, 1, dim);
    lanes longest = e.square[0], shortest = e.square[0], large[6], small[6];
    lanes share = lanes_of(1.0 / n);
    if (of_corners) {
        longest = lanes_of(0);
        shortest = lanes_of(INFINITY);
        share = load(s, EDGE_SHARE, i);
    }
    for (int k = of_corners ? 0 : 1; k < n; k++) {
        lanes large_one = e.square[k], small_one = large_one;
        if (of_corners) {
            const lanes_mask is_edge = lanes_greater(load(s, IS_EDGE + k, i), lanes_of(0));
            large_one = lanes_select(is_edge, large_one, lanes_of(0));
            small_one = lanes_select(is_edge, small_one, lanes_of(INFINITY));
        }
        longest = lanes_max(large_one, longest);
        shortest = lanes_min(small_one, shortest);
    }
    lanes to_longest = lanes_of(1) / longest;
    for (int k = 0; k < n; k++) {
        large[k] = squared(e.square[k] * to_longest, SHARPNESS);
        small[k] = squared(shortest / e.square[k], SHARPNESS);
        if (!of_corners)
            continue;
        const lanes_mask is_edge = lanes_greater(load(s, IS_EDGE + k, i), lanes_of(0));
        large[k] = lanes_select(is_edge, large[k], lanes_of(0));
        small[k] = lanes_select(is_edge, small[k], lanes_of(0));
    }
    lanes of_large = sum_of(large, n), of_small = sum_of(small, n);
    lanes means = of_large * share * (of_small * share);
    for (int k = 0; k < SHARPNESS; k++)
        means = lanes_sqrt(means);
    a->square = longest / shortest * means;
    if (!derive)
        return;
    for (int k = 0; k < 3; k++)
        a->l[k] = lanes_of(0);
    for (int k = 0; k < 6; k++)
        a->h[k] = lanes_of(0);
    smoothed_extreme(&e, large, of_large, 1, a, dim);
    smoothed_extreme(&e, small, of_small, -1, a, dim);
    for (int r = 0, k = 0; r < dim; r++)
        for (int t = r; t < dim; t++, k++)
            a->h[k] += a->l[r] * a->l[t];
}

/* ---- corners ------------------------------------------------------------------------------- */

/** Make l and h, which are those of mu^2 = shape, the ones of the ratio with sizes. */
PL_INLINE void mix_in_size(const star *s, int64_t i, const corners *t, lanes shape, lanes inverse_d,
                           aspect *a, const int dim) {
    const lanes inverse = lanes_of(1) / a->square;
    const lanes of_shape = lanes_of(1 - s->size_weight) * (shape * inverse);
    const size_slopes size = size_slopes_of(s, i, inverse, inverse_d);
    for (int d = 0; d < dim; d++)
        a->l[d] = of_shape * a->l[d] + size.rate * t->n[d];
    for (int r = 0, k = 0; r < dim; r++)
        for (int c = r; c < dim; c++, k++)
            a->h[k] = of_shape * a->h[k] + size.curve * (t->n[r] * t->n[c]);
}

/** Compute mu^2 of a pack of corners, and with derive its derivatives (kernel_mean.h). */
PL_INLINE void corner_mean_ratio(const star *s, int64_t i, const lanes *x, aspect *a,
                                 const int derive, const int dim) {
    const corners t = corners_at(s, i, x, 0, s->has_metric, dim);
    const double power = mean_power(dim);
    lanes inverse_d;
    const lanes shape = mean_of(&t, &inverse_d, dim);
    a->square = s->size_weight > 0 ? sized_ratio(s, i, &t, shape, inverse_d) : shape;
    if (!derive)
        return;
    const lanes p = (t.c + t.c) / t.E, of_n = lanes_of(power) * a->inverse_d;
    const lanes bend = lanes_of(power * (1 - power)) * (a->inverse_d * a->inverse_d);
    lanes z[3], m[6];
    for (int d = 0; d < dim; d++) {
        z[d] = p * t.pull[d] - of_n * t.n[d];
        a->l[d] = z[d] + p * t.pull[d];
    }
    for (int r = 0, k = 0; r < dim; r++)
        for (int c = r; c < dim; c++, k++) {
            a->h[k] = lanes_of(2) * (z[r] * z[c]) + bend * (t.n[r] * t.n[c]);
            if (r == c && !s->has_metric)
                a->h[k] += p + p;
        }
    if (s->has_metric)
        square_of_metric(s, i, m, dim);
    for (int k = 0; s->has_metric && k < dim * (dim + 1) / 2; k++)
        a->h[k] += (p + p) * m[k];
    if (s->size_weight > 0)
        mix_in_size(s, i, &t, shape, inverse_d, a, dim);
}

/** Product of the squares of the edges at vertex v: 0 is x, j + 1 is p_j. */
PL_INLINE lanes edges_at_vertex(const edges *e, int v, const int dim) {
    lanes product = e->square[v > 0 ? v - 1 : 0];
    for (int j = 1; j < dim && v == 0; j++)
        product *= e->square[j];
    for (int j = 0, k = dim; j < dim; j++)
        for (int other = j + 1; other < dim; other++, k++)
            if (v == j + 1 || v == other + 1)
                product *= e->square[k];
    return product;
}

/** Compute the sum of (1 / (limit SJ^2))^q over the corners that an element has among its nodes, all
 *  of a simplex: q times the logarithm of the squared edges of the corner that lead to x, less that
 *  of D^2. S = square / D^2: l = sum 2 e / |e|^2 - 2 n / D,
 *  hess log S = sum (2 I / |e|^2 - 4 e e^T / |e|^4) + 2 n n^T / D^2. */
PL_INLINE void worst_jacobian(const star *s, int64_t i, const lanes *x, aspect *a,
                              double inverse_limit, const int derive, const int dim) {
    const edges e = edges_at(s, i, x, 0, dim);
    const lanes q = lanes_of(WORST_EXPONENT);
    const lanes S = load(s, JACOBIAN, i) * (a->inverse_d * a->inverse_d);
    lanes term[4];
    a->square = lanes_of(0);
    for (int v = 0; v <= dim; v++) {
        term[v] = load(s, IS_CORNER + v, i) *
                  squared(S * edges_at_vertex(&e, v, dim) * lanes_of(inverse_limit), WORST_POWER);
        a->square += term[v];
    }
    if (!derive)
        return;
    lanes gd[3], inverse[3];
    for (int d = 0; d < dim; d++) {
        gd[d] = a->n[d] * a->inverse_d;
        inverse[d] = lanes_of(1) / e.square[d];
        a->l[d] = lanes_of(0);
    }
    for (int k = 0; k < dim * (dim + 1) / 2; k++)
        a->h[k] = lanes_of(0);
    const lanes of_square = lanes_select(lanes_greater(a->square, lanes_of(NEXT_TO_NOTHING)),
                                         q / a->square, lanes_of(0));
    for (int v = 0; v <= dim; v++) {
        const lanes share = term[v] * of_square;
        const int from = v > 0 ? v - 1 : 0, to = v > 0 ? v : dim; /* edges that lead to x */
        lanes l[3];
        for (int d = 0; d < dim; d++) {
            l[d] = -gd[d];
            for (int j = from; j < to; j++)
                l[d] += e.at[j][d] * inverse[j];
            l[d] *= lanes_of(2);
            a->l[d] += share * l[d];
        }
        for (int r = 0, k = 0; r < dim; r++)
            for (int c = r; c < dim; c++, k++) {
                lanes bend = gd[r] * gd[c];
                for (int j = from; j < to; j++) {
                    bend -= lanes_of(2) * (e.at[j][r] * inverse[j]) * (e.at[j][c] * inverse[j]);
                    if (r == c)
                        bend += inverse[j];
                }
                a->h[k] += share * (lanes_of(2) * bend + q * (l[r] * l[c]));
            }
    }
}

/* ---- radius ratio -------------------------------------------------------------------------- */

/** Gradient g and Hessian h of the surface term: adds those of |m|, m = e x r with r = x - p, e the
 *  edge from p. inverse: 1 / |m|. */
PL_INLINE void add_area(vec3 m, vec3 e, lanes inverse, vec3 *g, lanes h[6]) {
    vec3 u = vec3_cross(vec3_scaled(m, inverse), e);
    lanes ee = vec3_dot(e, e);
    *g = vec3_plus(*g, u);
    h[0] += (ee - e.x * e.x - u.x * u.x) * inverse;
    h[1] -= (e.x * e.y + u.x * u.y) * inverse;
    h[2] -= (e.x * e.z + u.x * u.z) * inverse;
    h[3] += (ee - e.y * e.y - u.y * u.y) * inverse;
    h[4] -= (e.y * e.z + u.y * u.z) * inverse;
    h[5] += (ee - e.z * e.z - u.z * u.z) * inverse;
}

/** Compute RR^2 of a pack of tetrahedra, and with derive its derivatives. */
PL_INLINE void radius_ratio_3d(const star *s, int64_t i, vec3 x, aspect *a, const int derive) {
    const lanes one = lanes_of(1);
    vec3 r[3], e[3], m[3];
    lanes area[3];
    edges_from(s, i, x, r);
    link_edges_from(s, i, e);
    tetrahedra t = tetrahedra_at(s, i, x, areas_from(r, e, m, area));
    lanes q = t.s * (a->inverse_d * a->inverse_d);
    a->square = t.N * (q * q) * lanes_of(RR2_FACTOR_3D);
    if (!derive)
        return;
    vec3 gs = {lanes_of(0), lanes_of(0), lanes_of(0)};
    lanes h[6], inverse_s = one / t.s;
    for (int k = 0; k < 6; k++)
        h[k] = lanes_of(0);
    for (int j = 0; j < 3; j++)
        add_area(m[j], e[j], one / area[j], &gs, h);
    coefficients f = coefficients_of(&t, a->inverse_d, one / t.N, one);
    vec3 l = log_derivatives_3d(&f, t.c, t.n, vec3_scaled(gs, inverse_s), one, a->h);
    for (int k = 0; k < 6; k++)
        a->h[k] += h[k] * (lanes_of(2) * inverse_s);
    for (int d = 0; d < 3; d++)
        a->h[packed(d, d, 3)] += f.trace;
    a->l[0] = l.x;
    a->l[1] = l.y;
    a->l[2] = l.z;
}

/** Compute RR^2 of a pack, and with derive its derivatives. */
PL_INLINE void radius_ratio(const star *s, int64_t i, const lanes *x, aspect *a, const int derive,
                            const int dim) {
    if (dim == 3) {
        radius_ratio_3d(s, i, (vec3){x[0], x[1], x[2]}, a, derive);
    } else {
        triangles t = triangles_at(s, i, x[0], x[1]);
        lanes rr = t.L * (t.a * t.b) * (t.L + (t.a + t.b)) * (a->inverse_d * a->inverse_d);
        a->square = rr * rr * lanes_of(RR2_FACTOR_2D);
        if (derive)
            log_derivatives_2d(s, i, &t, a->inverse_d, a->l, a->h);
    }
}

/* ---- the worst ------------------------------------------------------------------------------- */

/** Compute (RR^2 / limit)^q, or of corners (mu^2 / limit)^q: l = q times that of the ratio,
 *  hess = q hess log ratio + q^2 its l l^T. */
PL_INLINE void worst_ratio(const star *s, int64_t i, const lanes *x, aspect *a,
                           double inverse_limit, const int of_corners, const int derive,
                           const int dim) {
    const lanes q = lanes_of(WORST_EXPONENT),
                more = lanes_of(WORST_EXPONENT * (WORST_EXPONENT - 1));
    if (of_corners)
        corner_mean_ratio(s, i, x, a, derive, dim);
    else
        radius_ratio(s, i, x, a, derive, dim);
    a->square = squared(a->square * lanes_of(inverse_limit), WORST_POWER);
    if (!derive)
        return;
    for (int r = 0, k = 0; r < dim; r++)
        for (int c = r; c < dim; c++, k++)
            a->h[k] = q * a->h[k] + more * (a->l[r] * a->l[c]);
    for (int r = 0; r < dim; r++)
        a->l[r] *= q;
}

/** An angle's part of the sum: S = (1 / (limit sin^2))^q, and l = grad log (1 / sin^2). */
typedef struct worst_part {
    lanes S, l[3];
} worst_part;

/** Add weight times hess log of a square |v|^2, whose log-gradient is g, to h: of a distance
 *  hess = 2 I, of an area's m (v = m) 2 (|e|^2 I - e e^T). */
PL_INLINE void add_log_square(const lanes *g, const lanes *e, lanes ee, lanes inverse, lanes weight,
                              lanes *h, const int dim) {
    const lanes twice = lanes_of(2) * inverse;
    for (int r = 0, k = 0; r < dim; r++)
        for (int c = r; c < dim; c++, k++) {
            lanes bend = -(g[r] * g[c]);
            if (e)
                bend -= twice * (e[r] * e[c]);
            if (r == c)
                bend += twice * ee;
            h[k] += weight * bend;
        }
}

/** Derivatives of the sum of n parts from those of the logarithms: h holds the sum of
 *  S hess log (1 / sin^2) then. */
PL_INLINE void finish_worst(const worst_part *part, int n, aspect *a, const int dim) {
    const lanes q = lanes_of(WORST_EXPONENT),
                inverse = lanes_select(lanes_greater(a->square, lanes_of(NEXT_TO_NOTHING)),
                                       lanes_of(1) / a->square, lanes_of(0));
    for (int r = 0; r < dim; r++)
        a->l[r] = lanes_of(0);
    for (int k = 0; k < dim * (dim + 1) / 2; k++)
        a->h[k] *= q * inverse;
    for (int p = 0; p < n; p++) {
        const lanes share = part[p].S * inverse * q;
        for (int r = 0, k = 0; r < dim; r++) {
            a->l[r] += share * part[p].l[r];
            for (int c = r; c < dim; c++, k++)
                a->h[k] += share * q * (part[p].l[r] * part[p].l[c]);
        }
    }
}

/** Triangles: sin^2 of the angle between two edges is D^2 by the squares of both. */
PL_INLINE void worst_angle_2d(const star *s, int64_t i, const lanes *x, aspect *a,
                              lanes inverse_limit, const int derive) {
    const edges e = edges_at(s, i, x, 0, 2);
    const lanes scale = inverse_limit * (a->inverse_d * a->inverse_d);
    static const uint8_t ends[3][2] = {{0, 1}, {0, 2}, {1, 2}};
    worst_part part[3];
    a->square = lanes_of(0);
    for (int p = 0; p < 3; p++) {
        part[p].S = squared(e.square[ends[p][0]] * e.square[ends[p][1]] * scale, WORST_POWER);
        a->square += part[p].S;
    }
    if (!derive)
        return;
    lanes g[3][2], n[2], weight[3] = {part[0].S + part[1].S, part[0].S + part[2].S, lanes_of(0)};
    for (int r = 0; r < 2; r++) {
        n[r] = lanes_of(2) * a->n[r] * a->inverse_d;
        for (int j = 0; j < 2; j++)
            g[j][r] = lanes_of(2) * e.at[j][r] / e.square[j];
        g[2][r] = lanes_of(0);
        for (int p = 0; p < 3; p++)
            part[p].l[r] = g[ends[p][0]][r] + g[ends[p][1]][r] - n[r];
    }
    for (int r = 0, k = 0; r < 2; r++)
        for (int c = r; c < 2; c++, k++)
            a->h[k] = lanes_of(0.5) * (n[r] * n[c]) * a->square;
    for (int j = 0; j < 2; j++)
        add_log_square(g[j], NULL, lanes_of(1), lanes_of(1) / e.square[j], weight[j], a->h, 2);
    finish_worst(part, 3, a, 2);
}

/** Tetrahedra: 1 / sin^2 of the angle at an edge of length e, between faces of normals m and m', is
 *  |m|^2 |m'|^2 / (D^2 e^2). Edges at x lie between faces j - 1 and j, edges of the link between
 *  face j and the link's facet. */
PL_INLINE void worst_angle_3d(const star *s, int64_t i, const lanes *x, aspect *a,
                              lanes inverse_limit, const int derive) {
    const lanes scale = inverse_limit * (a->inverse_d * a->inverse_d), nn = load(s, NN, i);
    vec3 r[3], m[3], e[3];
    lanes mm[3], ee[3], rr[3];
    worst_part part[6];
    edges_from(s, i, (vec3){x[0], x[1], x[2]}, r);
    link_edges_from(s, i, e);
    for (int j = 0; j < 3; j++) {
        m[j] = vec3_cross(e[j], r[j]);
        mm[j] = vec3_dot(m[j], m[j]);
        ee[j] = vec3_dot(e[j], e[j]);
        rr[j] = vec3_dot(r[j], r[j]);
    }
    a->square = lanes_of(0);
    for (int j = 0; j < 3; j++) {
        part[j].S = squared(mm[(j + 2) % 3] * mm[j] / rr[j] * scale, WORST_POWER);
        part[3 + j].S = squared(mm[j] * nn / ee[j] * scale, WORST_POWER);
        a->square += part[j].S + part[3 + j].S;
    }
    if (!derive)
        return;
    lanes of_face[3][3], of_edge[3][3], n[3], edge[3][3];
    for (int d = 0; d < 3; d++)
        n[d] = lanes_of(2) * a->n[d] * a->inverse_d;
    for (int j = 0; j < 3; j++) {
        const vec3 slope = vec3_scaled(vec3_cross(m[j], e[j]), lanes_of(2) / mm[j]);
        const vec3 way = vec3_scaled(r[j], lanes_of(2) / rr[j]);
        const lanes face[3] = {slope.x, slope.y, slope.z}, at[3] = {way.x, way.y, way.z};
        const lanes own[3] = {e[j].x, e[j].y, e[j].z};
        memcpy(of_face[j], face, sizeof face);
        memcpy(of_edge[j], at, sizeof at);
        memcpy(edge[j], own, sizeof own);
    }
    for (int d = 0; d < 3; d++)
        for (int j = 0; j < 3; j++) {
            part[j].l[d] = of_face[(j + 2) % 3][d] + of_face[j][d] - of_edge[j][d] - n[d];
            part[3 + j].l[d] = of_face[j][d] - n[d];
        }
    for (int p = 0, k = 0; p < 3; p++)
        for (int c = p; c < 3; c++, k++)
            a->h[k] = lanes_of(0.5) * (n[p] * n[c]) * a->square;
    for (int j = 0; j < 3; j++) {
        const lanes weight = part[j].S + part[(j + 1) % 3].S + part[3 + j].S;
        add_log_square(of_face[j], edge[j], ee[j], lanes_of(1) / mm[j], weight, a->h, 3);
        add_log_square(of_edge[j], NULL, lanes_of(1), lanes_of(1) / rr[j], -part[j].S, a->h, 3);
    }
    finish_worst(part, 6, a, 3);
}

/* ---- one pack ------------------------------------------------------------------------------ */

/** Compute D, its gradient and 1 / D of a pack, with the node at x [dim]. */
PL_INLINE void measure_pack(const star *s, int64_t i, const lanes *x, aspect *a,
                            const int of_corners, const int dim) {
    static const uint8_t first[3] = {P0X, P0Y, P0Z};
    find_normal(s, i, a->n, dim);
    a->D = of_corners ? load(s, BASE, i) : lanes_of(0);
    a->aa = lanes_of(0);
    for (int d = 0; d < dim; d++) {
        lanes from = x[d] - load(s, first[d], i);
        a->D += from * a->n[d];
        a->aa += from * from;
    }
    a->inverse_d = lanes_of(1) / a->D;
}

/** Compute D, its gradient and 1 / D of a pack, whatever the star has. */
PL_INLINE void measure_at(const star *s, int64_t i, const lanes *x, aspect *a, const int dim) {
    measure_pack(s, i, x, a, has_forms(s), dim);
}

/** Compute the measure of kind for a pack, with the node at x [dim], and with derive its
 *  derivatives. */
PL_INLINE void aspect_at(const star *s, int64_t i, const lanes *x, aspect *a, const question *q,
                         const int kind, const int derive, const int dim) {
    measure_pack(s, i, x, a, is_of_corners(kind), dim);
    if (kind == PLANISH_OBJECTIVE_RADIUS_RATIO)
        radius_ratio(s, i, x, a, derive, dim);
    else if (kind == PL_WORST_RATIO)
        worst_ratio(s, i, x, a, q->inverse_limit, 0, derive, dim);
    else if (kind == PL_WORST_ANGLE && dim == 3)
        worst_angle_3d(s, i, x, a, lanes_of(q->inverse_limit), derive);
    else if (kind == PL_WORST_ANGLE)
        worst_angle_2d(s, i, x, a, lanes_of(q->inverse_limit), derive);
    else if (kind == PLANISH_OBJECTIVE_MEAN_RATIO)
        mean_ratio(s, i, x, a, derive, dim);
    else if (kind == CORNER_MEAN_RATIO)
        corner_mean_ratio(s, i, x, a, derive, dim);
    else if (kind == CORNER_WORST_RATIO)
        worst_ratio(s, i, x, a, q->inverse_limit, 1, derive, dim);
    else if (kind == PL_WORST_JACOBIAN)
        worst_jacobian(s, i, x, a, q->inverse_limit, derive, dim);
    else
        edge_ratio(s, i, x, a, kind == CORNER_EDGE_RATIO, derive, dim);
}

/** Return g = 1 - D / floor of a pack. */
PL_INLINE lanes volume_constraint(const star *s, int64_t i, lanes D) {
    lanes inverse = load(s, INVERSE_FLOOR, i);
    return lanes_select(lanes_greater(inverse, lanes_of(0)), lanes_of(1) - D * inverse,
                        lanes_of(NEVER_ACTIVE));
}

/* Least slack, relative to the floor: an element on its floor blocks moves that take it below. */
#define SLACK_LEAST 1e-12
/* The fraction of the way to a barrier that is gone at most; a floor may be reached. */
#define FLOOR_FRACTION 0.9

/* ---- a star -------------------------------------------------------------------------------- */

/** Accumulators besides those of accumulator. */
typedef struct guarded_accumulator {
    accumulator ratios;
    lanes volumes[PL_PACKS];   /* sum of g^2 */
    lanes penalties[PL_PACKS]; /* sum of max(0, lambda / rho + g)^2 */
    lanes shortfall[PL_PACKS]; /* sum of max(0, g)^2 */
    lanes largest_g[PL_PACKS];
    slopes slope;
} guarded_accumulator;

/** Add the volumes of a pack to the function, and to its derivatives -slope n and bend n n^T.
 *  With a penalty rho, rho / 2 max(0, lambda / rho + g)^2 stands for the constraint g <= 0:
 *  nothing else reads its value of g then. */
PL_INLINE void add_volumes(guarded_accumulator *t, int k, const star *s, int64_t i,
                           const question *q, lanes *g, lanes weight, lanes *slope, lanes *bend) {
    const lanes inverse = load(s, INVERSE_FLOOR, i), zero = lanes_of(0);
    lanes constraint = *g, above = lanes_max(*g, zero);
    t->volumes[k] += constraint * constraint * (weight * lanes_of(q->volume_weight > 0));
    *slope = lanes_of(2 * q->volume_weight) * constraint;
    *bend = lanes_of(2 * q->volume_weight);
    if (q->penalty > 0) {
        lanes shifted = lanes_max(load(s, SHIFT, i) + constraint, zero), rho = lanes_of(q->penalty);
        t->penalties[k] += shifted * shifted * weight;
        *slope += rho * shifted;
        *bend += lanes_select(lanes_greater(shifted, zero), rho, zero);
        *g = lanes_of(NEVER_ACTIVE);
        above = zero;
    }
    *slope *= weight * inverse;
    *bend *= weight * inverse * inverse;
    t->shortfall[k] += above * above * weight;
    t->largest_g[k] = lanes_max(*g, t->largest_g[k]);
}

/** Add the derivatives of a pack; elements that are not positive have no part in them. */
PL_INLINE void add_guarded(guarded_accumulator *t, int k, const question *q, const aspect *a,
                           lanes weight, lanes slope, lanes bend, const int with_hessian,
                           const int dim) {
    lanes_mask positive = lanes_greater(a->D, lanes_of(0));
    lanes ratio = a->square * weight * lanes_of(q->ratio_weight);
    for (int r = 0, c = 0; r < dim; r++) {
        t->slope.g[r][k] += lanes_select(positive, ratio * a->l[r], lanes_of(0));
        t->slope.g[r][k] -= slope * a->n[r];
        for (int e = r; with_hessian && e < dim; e++, c++) {
            t->slope.h[c][k] += lanes_select(positive, ratio * a->h[c], lanes_of(0));
            t->slope.h[c][k] += bend * (a->n[r] * a->n[e]);
        }
    }
}

/** Sum for one objective, as guarded_at does, which is constant where this is inlined. What only the
 *  Hessian needs falls away without it. */
PL_INLINE objective guarded_sums(const star *s, const question *q, const double *position,
                                 derivatives *out, const int kind, const int derive,
                                 const int dim) {
    const lanes x[3] = {lanes_of(position[0]), lanes_of(position[1]),
                        lanes_of(dim == 3 ? position[2] : 0)};
    const int with_hessian = derive != PL_GRADIENT_ALONE;
    guarded_accumulator t;
    accumulator_init(&t.ratios);
    for (int k = 0; k < PL_PACKS; k++) {
        t.volumes[k] = t.penalties[k] = t.shortfall[k] = lanes_of(0);
        t.largest_g[k] = lanes_of(NEVER_ACTIVE);
    }
    if (derive) /* values keep all of t in registers: cleared at once it would be in memory */
        memset(&t.slope, 0, sizeof t.slope);
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            int64_t j = i + k * PL_PACK;
            aspect a;
            aspect_at(s, j, x, &a, q, kind, derive, dim);
            lanes weight = load(s, WEIGHT, j), g = volume_constraint(s, j, a.D), slope, bend;
            accumulate(&t.ratios, k, a.square, weight, a.D, a.inverse_d * a.inverse_d,
                       load(s, ROUNDING, j) * a.aa);
            add_volumes(&t, k, s, j, q, &g, weight, &slope, &bend);
            if (!derive)
                continue;
            store(s, GVALUE, j, g);
            const lanes floor = q->penalty > 0 ? lanes_of(0) : load(s, FLOOR, j);
            const lanes slack = lanes_max(a.D - floor, lanes_of(SLACK_LEAST) * floor);
            store(s, RATE, j,
                  lanes_select(lanes_greater(floor, lanes_of(0)), lanes_of(FLOOR_FRACTION) / slack,
                               a.inverse_d));
            add_guarded(&t, k, q, &a, weight, slope, bend, with_hessian, dim);
            t.slope.size2[k] += a.aa * (is_of_corners(kind) ? load(s, IS_FACET, j) : weight);
        }
    if (derive)
        slopes_result(&t.slope, s, 1, with_hessian, out, dim);
    objective f = accumulator_result(&t.ratios, 1);
    f.error *= is_of_worst(q->objective) ? WORST_EXPONENT : 1;
    f.sum = q->ratio_weight * f.sum + q->volume_weight * lanes_sum(t.volumes) +
            0.5 * q->penalty * lanes_sum(t.penalties);
    f.shortfall = lanes_sum(t.shortfall);
    f.largest_g = lanes_largest(t.largest_g);
    return f;
}

/** Sum over corners as guarded_at does, inlined where derive and dim are constant. */
PL_INLINE objective corner_sums_of(const star *s, const question *q, const double *position,
                                   derivatives *out, const int derive, const int dim) {
    if (q->objective == PLANISH_OBJECTIVE_EDGE_RATIO)
        return guarded_sums(s, q, position, out, CORNER_EDGE_RATIO, derive, dim);
    if (q->objective == PL_WORST_RATIO)
        return guarded_sums(s, q, position, out, CORNER_WORST_RATIO, derive, dim);
    if (q->objective == PL_WORST_JACOBIAN)
        return guarded_sums(s, q, position, out, PL_WORST_JACOBIAN, derive, dim);
    return guarded_sums(s, q, position, out, CORNER_MEAN_RATIO, derive, dim);
}

/** Sum as guarded_at does, inlined where derive and dim are constant. */
PL_INLINE objective guarded_sums_of(const star *s, const question *q, const double *position,
                                    derivatives *out, const int derive, const int dim) {
    if (q->objective == PLANISH_OBJECTIVE_RADIUS_RATIO)
        return guarded_sums(s, q, position, out, PLANISH_OBJECTIVE_RADIUS_RATIO, derive, dim);
    if (q->objective == PLANISH_OBJECTIVE_MEAN_RATIO)
        return guarded_sums(s, q, position, out, PLANISH_OBJECTIVE_MEAN_RATIO, derive, dim);
    if (q->objective == PLANISH_OBJECTIVE_EDGE_RATIO)
        return guarded_sums(s, q, position, out, PLANISH_OBJECTIVE_EDGE_RATIO, derive, dim);
    if (q->objective == PL_WORST_RATIO)
        return guarded_sums(s, q, position, out, PL_WORST_RATIO, derive, dim);
    return guarded_sums(s, q, position, out, PL_WORST_ANGLE, derive, dim);
}

/* Values have a function of their own: in one with derivatives, what only these need would take the
 * registers of values, too. And so have corners. */
/** Value of the objective with the node at position. */
PL_NOINLINE objective guarded_value(const star *s, const question *q, const double *position,
                                    const int dim) {
    return dim == 3 ? guarded_sums_of(s, q, position, NULL, 0, 3)
                    : guarded_sums_of(s, q, position, NULL, 0, 2);
}

/** Value of the objective of corners with the node at position. */
PL_NOINLINE objective corner_value(const star *s, const question *q, const double *position,
                                   const int dim) {
    return dim == 3 ? corner_sums_of(s, q, position, NULL, 0, 3)
                    : corner_sums_of(s, q, position, NULL, 0, 2);
}

/** Value of the objective with the node at position; fills out with the derivatives. */
PL_NOINLINE objective guarded_derivatives(const star *s, const question *q, const double *position,
                                          derivatives *out, const int dim) {
    return dim == 3 ? guarded_sums_of(s, q, position, out, 1, 3)
                    : guarded_sums_of(s, q, position, out, 1, 2);
}

/** Value of the objective of corners with the node at position; fills out with the derivatives. */
PL_NOINLINE objective corner_derivatives(const star *s, const question *q, const double *position,
                                         derivatives *out, const int dim) {
    return dim == 3 ? corner_sums_of(s, q, position, out, 1, 3)
                    : corner_sums_of(s, q, position, out, 1, 2);
}

/** Whether the Hessian of a star in space can be kept: the function is that of one ratio alone. */
static inline int has_gradient_alone(const question *q) {
    return (q->objective == PLANISH_OBJECTIVE_RADIUS_RATIO ||
            q->objective == PLANISH_OBJECTIVE_MEAN_RATIO) &&
           !(q->volume_weight > 0) && !(q->penalty > 0);
}

/** Value of the objective in space, of which has_gradient_alone, with the node at position; fills out
 *  with the derivatives but for the Hessian. */
PL_NOINLINE objective guarded_gradient(const star *s, const question *q, const double *position,
                                       derivatives *out) {
    if (has_forms(s))
        return guarded_sums(s, q, position, out, CORNER_MEAN_RATIO, PL_GRADIENT_ALONE, 3);
    if (q->objective == PLANISH_OBJECTIVE_MEAN_RATIO)
        return guarded_sums(s, q, position, out, PLANISH_OBJECTIVE_MEAN_RATIO, PL_GRADIENT_ALONE,
                            3);
    return guarded_sums(s, q, position, out, PLANISH_OBJECTIVE_RADIUS_RATIO, PL_GRADIENT_ALONE, 3);
}

/** The function of the star at position, and its derivatives if derive. Then the columns GVALUE and
 *  RATE are set, too: RATE to 1 / D, or 0.9 / (D - floor), see limiting_rate. PL_GRADIENT_ALONE:
 *  without the Hessian, if has_gradient_alone. */
static inline objective guarded_at(const star *s, const question *q, const double *position,
                                   derivatives *out, const int derive, const int dim) {
    if (derive == PL_GRADIENT_ALONE && dim == 3 && has_gradient_alone(q))
        return guarded_gradient(s, q, position, out);
    if (has_forms(s))
        return derive ? corner_derivatives(s, q, position, out, dim)
                      : corner_value(s, q, position, dim);
    return derive ? guarded_derivatives(s, q, position, out, dim)
                  : guarded_value(s, q, position, dim);
}

#endif
