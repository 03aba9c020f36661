/* sizes: how large elements should be around each node, from what they are now. */
#include "improve/untangle/tangle.h"

#include "base/memory.h"
#include "base/parts.h"
#include "geometry/cube_root.h"
#include "geometry/simplex.h"
#include "plan/ghosts.h"

#include <math.h>
#include <string.h>

/** Sizes being found; arrays over nodes, by inner numbers. Of ghosts there is what their processes
 *  find. */
typedef struct sizing {
    const planish_plan *plan;
    const uint8_t *is_ghost; /* NULL: there are none */
    double *sum;      /* of the measures (times dim!) of the node's elements; then its level */
    double *absolute; /* of their absolute values; then of levels around */
    int32_t *count;   /* elements of the node; then 1, or 0: nothing is known of it */
    int32_t *around;  /* levels in absolute */
    int of_largest;   /* exponent of the largest size */
    double scale;     /* of the lengths in here */
} sizing;

static int is_own(const sizing *s, int64_t node) {
    return !s->is_ghost || !s->is_ghost[node];
}

/* Sizes are averaged as numbers that grow nearly like their logarithms, made without libm: exponent
 * and mantissa side by side. Meshes may be graded by orders of magnitude. The exponents are counted
 * from that of the largest size, so that the scale of a mesh changes no bit. */
static double to_level(double size, int of_largest) {
    int exponent;
    double mantissa = frexp(size, &exponent);
    return exponent - of_largest + 2 * mantissa - 2;
}

static double from_level(double level, int of_largest) {
    double whole = floor(level);
    return ldexp(0.5 * (level - whole) + 0.5, (int)whole + 1 + of_largest);
}

/** measure^(1/dim), with the same bits at every scale. */
static double size_of(double measure, int dim) {
    int exponent, third;
    if (dim == 2)
        return sqrt(measure);
    double mantissa = frexp(measure, &exponent);
    third = (exponent - ((exponent % 3 + 3) % 3)) / 3;
    return ldexp(pl_cube_root(ldexp(mantissa, exponent - 3 * third)), third);
}

/** Add the measure of each element, positive in the mesh's orientation, to its nodes. */
static void add_measures(const sizing *s) {
    const planish_plan *plan = s->plan;
    const int dim = plan->dim;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        int32_t node[4] = {0};
        double e[3][3];
        for (int j = 0; j <= dim; j++)
            node[j] = pl_plan_inner(plan, i, j);
        const double *x0 = plan->scratch.coordinates + (int64_t)node[0] * dim;
        for (int j = 0; j < dim; j++)
            for (int d = 0; d < dim; d++)
                e[j][d] =
                    (plan->scratch.coordinates[(int64_t)node[j + 1] * dim + d] - x0[d]) * s->scale;
        double D = pl_determinant_of_edges(dim, (const double(*)[3])e);
        D = plan->work.sign ? D * plan->work.sign[i] : D;
        if (plan->work.corner) /* the measure of a simplex whose edges are as long */
            D *= plan->form[PL_KIND_SIMPLEX].determinant /
                 plan->form[pl_form_code(plan->work.corner[i], 0, 0)].determinant;
        for (int j = 0; j <= dim; j++) {
            s->sum[node[j]] += D;
            s->absolute[node[j]] += fabs(D);
            s->count[node[j]]++;
        }
    }
}

/* The measures around a node tell its size where their sum is more than this part of the sum of
 * their absolute values, and not next to nothing. */
#define TELLING       0.1
#define LEAST_MEASURE 0x1p-1000

/** Find levels of the nodes whose elements tell their sizes; returns of how many nodes nothing is
 *  known. */
static int64_t find_levels(sizing *s) {
    const int dim = s->plan->dim;
    const int64_t n = s->plan->work.n_nodes;
    const double of_regular = dim == 3 ? 1.4142135623730951 : 1.1547005383792515; /* edge 1 */
    double largest = 0;
    int64_t unknown = 0;
    for (int64_t i = 0; i < n; i++) {
        const double measure = s->count[i] > 0 ? s->sum[i] / s->count[i] * of_regular : 0;
        const int tells = measure > LEAST_MEASURE && s->sum[i] > TELLING * s->absolute[i];
        s->sum[i] = tells ? size_of(measure, dim) : 0;
    }
    pl_ghosts_update(s->plan, s->sum, sizeof *s->sum);
    for (int64_t i = 0; i < n; i++)
        largest = fmax(largest, s->sum[i]);
    pl_parts_largest(&largest, 1);
    frexp(largest, &s->of_largest);
    for (int64_t i = 0; i < n; i++) {
        unknown += s->count[i] > 0 && !(s->sum[i] > 0) && is_own(s, i);
        s->count[i] = s->sum[i] > 0;
        s->sum[i] = s->sum[i] > 0 ? to_level(s->sum[i], s->of_largest) : 0;
    }
    pl_parts_add(&unknown, 1);
    return unknown;
}

/** Give nodes of which nothing is known the mean level of the known nodes of their elements, one
 *  ring of them at a time; returns how many this one had. */
static int64_t spread_levels(const sizing *s) {
    const planish_plan *plan = s->plan;
    int64_t grown = 0;
    memset(s->absolute, 0, (size_t)plan->work.n_nodes * sizeof *s->absolute);
    memset(s->around, 0, (size_t)plan->work.n_nodes * sizeof *s->around);
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        int32_t node[4];
        for (int j = 0; j <= plan->dim; j++)
            node[j] = pl_plan_inner(plan, i, j);
        for (int j = 0; j <= plan->dim; j++)
            for (int k = 0; s->count[node[j]] == 0 && k <= plan->dim; k++) {
                s->absolute[node[j]] += s->count[node[k]] > 0 ? s->sum[node[k]] : 0;
                s->around[node[j]] += s->count[node[k]] > 0;
            }
    }
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        if (s->around[i] > 0 && is_own(s, i)) {
            s->sum[i] = s->absolute[i] / s->around[i];
            s->count[i] = 1;
            grown++;
        }
    pl_ghosts_update(plan, s->sum, sizeof *s->sum);
    pl_ghosts_update(plan, s->count, sizeof *s->count);
    pl_parts_add(&grown, 1);
    return grown;
}

/** Give the mean level of all to nodes that are too far from known ones. */
static void fill_levels(const sizing *s) {
    pl_sum sum = {.n_added = 0};
    int64_t n = 0;
    for (int64_t i = 0; i < s->plan->work.n_nodes; i++)
        if (s->count[i] > 0 && is_own(s, i)) {
            pl_sum_add(&sum, s->sum[i]);
            n++;
        }
    pl_parts_add_sums(&sum, 1);
    pl_parts_add(&n, 1);
    const double mean = n > 0 ? pl_sum_value(&sum) / (double)n : 0;
    for (int64_t i = 0; n > 0 && i < s->plan->work.n_nodes; i++)
        s->sum[i] = s->count[i] > 0 ? s->sum[i] : mean;
}

/** Return how large the mesh is in units of its targets, 1 where sizes have a weight. */
static double size_by_targets(const planish_plan *plan, double scale) {
    const int dim = plan->dim;
    pl_sum measure = {.n_added = 0}, wanted = {.n_added = 0};
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        const double *x[4] = {NULL};
        double e[3][3] = {{0}};
        for (int j = 0; j <= dim; j++)
            x[j] = plan->scratch.coordinates + (int64_t)pl_plan_inner(plan, i, j) * dim;
        pl_edges(dim, x, e);
        for (int j = 0; j < dim; j++)
            for (int d = 0; d < dim; d++)
                e[j][d] *= scale;
        pl_sum_add(&measure, (plan->work.sign ? plan->work.sign[i] : 1) *
                                 pl_determinant_of_edges(dim, (const double(*)[3])e));
        pl_sum_add(&wanted, scale * scale * (dim == 3 ? scale : 1) / plan->work.target[i].unit);
    }
    const double size = pl_sum_value(&measure) / pl_sum_value(&wanted);
    return size > 0 && isfinite(size) && !(plan->work.size_weight > 0) ? size : 1;
}

/* Each ring costs a look at all elements. */
enum { MOST_SPREADS = 64 };

void pl_tangle_find_sizes(pl_tangle *t) {
    const int64_t n = t->run->plan->work.n_nodes;
    sizing s = {.plan = t->run->plan,
                .is_ghost = t->is_ghost,
                .scale = t->scale,
                .sum = pl_alloc_zero(n, sizeof *s.sum),
                .absolute = pl_alloc_zero(n, sizeof *s.absolute),
                .count = pl_alloc_zero(n, sizeof *s.count),
                .around = pl_alloc(n, sizeof *s.around)};
    if (s.sum && s.absolute && s.count && s.around) {
        add_measures(&s);
        int64_t left = find_levels(&s), grown = 1;
        for (int i = 0; i < MOST_SPREADS && left > 0 && grown > 0; i++, left -= grown)
            grown = spread_levels(&s);
        if (left > 0)
            fill_levels(&s);
        for (int64_t i = 0; i < n; i++)
            t->size[i] = from_level(s.sum[i], s.of_largest) / t->scale;
        if (s.plan->work.target)
            t->asked.target_size = size_by_targets(s.plan, t->scale);
    }
    pl_free(s.sum);
    pl_free(s.absolute);
    pl_free(s.count);
    pl_free(s.around);
}
