/* kernel_foldover: the regularised energy of a star with inverted elements, or corners.
 *
 * The energy of foldover-free maps (Garanzha, Kaporin, Kudryavtseva, Protais, Ray, Sokolov 2021):
 * of an element with the measure D and the sum E of its squared edges, seen from the regular one of
 * measure D* and edge h,
 *
 *     u = (D - floor) / D*     chi = (u + sqrt(u^2 + epsilon^2)) / 2     T = E / (sum h^2)
 *     f = T chi^(-2/dim) + (1 + (D / D*)^2) / (2 chi)
 *
 * Of a corner D* and E are those of the ideal corner with the edge h, and E is weighted as its form says;
 * or with targets D* is that of the target (geometry/target.h) times a factor of the whole mesh.
 * f counts by the corner's share in its element, further rows by their weight.
 * It is finite and smooth for inverted elements, too, and becomes a barrier as epsilon falls to 0.
 * Symbols as in docs/algorithm.md.
 *
 *   untangling_init    gather a star
 *   energy_at          its energy
 */
#ifndef PL_STAR_KERNEL_FOLDOVER_H
#define PL_STAR_KERNEL_FOLDOVER_H

#include "star/kernel_local.h"

/* D of the regular element with edges of 1: sqrt(2)/2 of six volumes, sqrt(3)/2 of two areas. */
#define REGULAR_MEASURE_3D 0.70710678118654752
#define REGULAR_MEASURE_2D 0.86602540378443865

/** Set the columns of facet i from the edge that is wanted. E of a corner has the root of its form's
 *  factor in it: it is the power 2 / dim of D* where the corner is ideal. */
static inline void set_target(const star *s, int64_t i, double h, const int dim) {
    double measure = dim == 3 ? REGULAR_MEASURE_3D : REGULAR_MEASURE_2D, unit = 1;
    if (has_forms(s)) {
        measure = s->forms[s->form[i]].determinant;
        unit = dim == 3 ? pl_cube_root(measure) : measure;
        unit = dim == 3 ? unit * unit : unit;
    }
    *entry(s, INVERSE_TARGET, i) = 1 / ((dim == 3 ? measure * h : measure) * h * h);
    *entry(s, INVERSE_EDGE2, i) = 1 / (h * h) / unit;
}

/** Set the columns of all facets of the star of index from their targets. E is the power 2 / dim of D*
 *  where mu is 1. Not inlined: few meshes have targets. */
PL_NOINLINE void set_targets(const star *s, const pl_star_problem *problem, int64_t index,
                             const int dim) {
    const int64_t first = problem->link_offset[index];
    for (int64_t i = 0; i < s->n_facets; i++) {
        double measure = problem->untangling->target_size *
                         problem->target[problem->link_element[first + i]].measure;
        for (int d = 0; d < dim; d++)
            measure *= s->scale;
        const double root = dim == 3 ? pl_cube_root(measure) : measure;
        *entry(s, INVERSE_TARGET, i) = 1 / measure;
        *entry(s, INVERSE_EDGE2, i) = 1 / (dim == 3 ? root * root : root);
    }
}

/** Set the columns of a further row, which is facet i. The ideal determinant follows from the factor,
 *  which is w^(4/3) / 9, or w^2 / 4. */
static inline void set_row_target(const star *s, const pl_star_row *row, int64_t i, const int dim) {
    const double h = row->size * s->scale, root = sqrt(row->factor);
    const double measure = dim == 3 ? 3 * root * sqrt(3 * root) : 2 * root;
    *entry(s, INVERSE_TARGET, i) = 1 / ((dim == 3 ? measure * h : measure) * h * h);
    *entry(s, INVERSE_EDGE2, i) = 1 / (dim * root * h * h);
    *entry(s, SHARE, i) = PL_SHARES * row->share;
}

/** Gather the star of index for untangling, with its node at place, and for each facet the wanted
 *  size and the coefficients of the patch. Elements that cannot be helped get no weight. */
static inline void untangling_init(local *here, const pl_star_problem *problem, int64_t index,
                                   const double *place, double *scratch, int64_t *evaluations,
                                   const int dim) {
    const pl_star_untangling *u = problem->untangling;
    const int64_t first = problem->link_offset[index];
    const int32_t node = problem->node[index];
    local_init(here, problem, index, place, NULL, scratch, evaluations, 1, dim);
    const star *s = &here->s;
    for (int64_t i = 0; i < s->padded; i++) {
        const int64_t facet = i < s->n_facets ? first + i : first;
        if (i >= s->n_facets && i < s->n_facets + s->n_more)
            continue;
        double size = u->size[node];
        int movers = u->in_patch[node];
        for (int j = 0; j < dim; j++) {
            const int32_t other = node_of_facet(s, i, j, dim);
            size += u->size[other];
            movers += u->in_patch[other];
        }
        double h = size / (dim + 1) * s->scale;
        set_target(s, i, h, dim);
        *entry(s, SHARE, i) = movers > 0 ? (double)PL_SHARES / movers : 0;
        if (u->link_skip && u->link_skip[facet])
            *entry(s, WEIGHT, i) = 0;
        if (has_forms(s) && !(*entry(s, WEIGHT, i) > 0))
            *entry(s, IS_FACET, i) = 0;
    }
    if (problem->target)
        set_targets(s, problem, index, dim);
    const pl_star_row *row = (const pl_star_row *)(const void *)scratch;
    for (int64_t r = 0; r < s->n_more; r++)
        set_row_target(s, &row[r], s->n_facets + r, dim);
}

/* ---- the energy ---------------------------------------------------------------------------- */

/** The energy of a star. */
typedef struct regularised {
    double sum;    /* over the star's elements */
    double shared; /* the same with each element's share of the node */
    double least;  /* smallest u */
    double tangled;
} regularised;

/** Pack of elements: f and its derivatives by u and by T. */
typedef struct barrier {
    lanes value, of_t, of_u, of_uu, of_tu;
} barrier;

/** Compute f and its derivatives. With s = sqrt(u^2 + epsilon^2), chi' = chi / s, so that (chi^-p)'
 * = -p chi^-p / s and (chi^-p)'' = p chi^-p (p + u / s) / s^2. measure = D / D*. Curvature along u
 * that is negative is left out. */
PL_INLINE barrier barrier_of(lanes u, lanes measure, lanes T, double epsilon, const int dim) {
    const lanes zero = lanes_of(0), half = lanes_of(0.5), one = lanes_of(1), two = lanes_of(2);
    const lanes p = lanes_of(2.0 / dim), e2 = lanes_of(epsilon * epsilon);
    lanes s = lanes_sqrt(u * u + e2);
    lanes_mask positive = lanes_greater(u, zero);
    lanes chi = half * lanes_select(positive, u + s, e2 / lanes_select(positive, one, s - u));
    lanes inverse_s = one / s, slant = u * inverse_s, inverse, power;
    if (dim == 3) {
        lanes root = lanes_inverse_cube_root(chi);
        power = root * root;
        inverse = power * root;
    } else {
        power = inverse = one / chi;
    }
    lanes q = one + measure * measure;
    lanes bend =
        T * power * p * (p + slant) * (inverse_s * inverse_s) +
        half * inverse *
            (two - lanes_of(4) * measure * inverse_s + q * (one + slant) * (inverse_s * inverse_s));
    return (barrier){.value = T * power + half * q * inverse,
                     .of_t = power,
                     .of_u = half * inverse * (two * measure - q * inverse_s) -
                             T * power * p * inverse_s,
                     .of_uu = lanes_max(bend, zero),
                     .of_tu = zero - power * p * inverse_s};
}

/** Multiply f and its derivatives by weight. */
PL_INLINE void weigh(barrier *b, lanes weight) {
    b->value *= weight;
    b->of_t *= weight;
    b->of_u *= weight;
    b->of_uu *= weight;
    b->of_tu *= weight;
}

/** T of a pack, and its derivatives: gradient, and the Hessian, this times the unit matrix, or L^T L. */
typedef struct squares {
    lanes T, gradient[3], bend;
} squares;

/** Find T of the pack at facet i, whose edge column is times edge2. */
PL_INLINE squares squares_at(const star *s, int64_t i, const lanes *x, lanes edge2,
                             const int of_corners, const int has_metric, const int dim) {
    squares t;
    if (of_corners) {
        const corners c = corners_at(s, i, x, 0, has_metric, dim);
        t.T = c.E * edge2;
        t.bend = lanes_of(2) * c.c * edge2;
        for (int d = 0; d < dim; d++)
            t.gradient[d] = t.bend * c.pull[d];
        return t;
    }
    const edges e = edges_at(s, i, x, 0, dim);
    const lanes of_edges = edge2 * lanes_of(dim == 3 ? 1.0 / 6 : 1.0 / 3);
    t.T = sum_of(e.square, n_edges(dim)) * of_edges;
    t.bend = lanes_of(2 * dim) * of_edges;
    for (int d = 0; d < dim; d++) {
        t.gradient[d] = e.at[0][d];
        for (int c = 1; c < dim; c++)
            t.gradient[d] += e.at[c][d];
        t.gradient[d] *= lanes_of(2) * of_edges;
    }
    return t;
}

/** The energy of a star of corners, or of simplices. */
PL_INLINE regularised energy_of(const star *s, double epsilon, const double *position,
                                derivatives *out, const int of_corners, const int has_metric,
                                const int derive, const int dim) {
    const lanes x[3] = {lanes_of(position[0]), lanes_of(position[1]),
                        lanes_of(dim == 3 ? position[2] : 0)};
    const lanes zero = lanes_of(0);
    lanes sum[PL_PACKS], shared[PL_PACKS], least[PL_PACKS], tangled[PL_PACKS];
    slopes slope;
    memset(&slope, 0, sizeof slope);
    for (int k = 0; k < PL_PACKS; k++) {
        sum[k] = shared[k] = tangled[k] = zero;
        least[k] = lanes_of(-INFINITY);
    }
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            const int64_t j = i + k * PL_PACK;
            const lanes weight = load(s, WEIGHT, j), share = load(s, SHARE, j);
            const lanes target = load(s, INVERSE_TARGET, j);
            const lanes_mask counts = lanes_greater(weight, zero);
            const lanes floor = load(s, FLOOR, j);
            const squares t =
                squares_at(s, j, x, load(s, INVERSE_EDGE2, j), of_corners, has_metric, dim);
            aspect a;
            measure_pack(s, j, x, &a, of_corners, dim);
            const lanes u = (a.D - floor) * target;
            barrier b = barrier_of(u, a.D * target, t.T, epsilon, dim);
            if (of_corners)
                weigh(&b, weight);
            const lanes_mask sound =
                lanes_greater(a.D, floor) & lanes_greater(a.D * a.D, load(s, ROUNDING, j) * a.aa);
            sum[k] += lanes_select(counts, b.value, zero);
            shared[k] += lanes_select(counts, b.value * share, zero);
            least[k] = lanes_max(lanes_select(counts, zero - u, lanes_of(-INFINITY)), least[k]);
            tangled[k] += lanes_select(counts & ~sound, share, zero);
            slope.size2[k] += a.aa * (of_corners ? load(s, IS_FACET, j) : weight);
            if (!derive)
                continue;
            const lanes *gt = t.gradient;
            lanes gu[3], m[6];
            for (int d = 0; d < dim; d++) {
                gu[d] = a.n[d] * target;
                slope.g[d][k] += lanes_select(counts, b.of_t * gt[d] + b.of_u * gu[d], zero);
            }
            if (has_metric)
                square_of_metric(s, j, m, dim);
            for (int r = 0, c = 0; r < dim; r++)
                for (int q = r; q < dim; q++, c++) {
                    lanes entry =
                        b.of_uu * (gu[r] * gu[q]) + b.of_tu * (gt[r] * gu[q] + gu[r] * gt[q]);
                    if (has_metric)
                        entry += t.bend * b.of_t * m[c];
                    else if (r == q)
                        entry += t.bend * b.of_t;
                    slope.h[c][k] += lanes_select(counts, entry, zero);
                }
        }
    if (derive)
        slopes_result(&slope, s, 1, 1, out, dim);
    return (regularised){lanes_sum(sum), lanes_sum(shared) / PL_SHARES, -lanes_largest(least),
                         lanes_sum(tangled)};
}

/** The star's energy at position, and its derivatives if derive. */
static inline regularised energy_at(const star *s, double epsilon, const double *position,
                                    derivatives *out, const int derive, const int dim) {
    return !has_forms(s)   ? energy_of(s, epsilon, position, out, 0, 0, derive, dim)
           : s->has_metric ? energy_of(s, epsilon, position, out, 1, 1, derive, dim)
                           : energy_of(s, epsilon, position, out, 1, 0, derive, dim);
}

#endif
