/* cell_measure: chunks of elements are handed to threads, which sort them by type into blocks. Sums
 * are exact (base/sum.h), so that no order of elements or threads shows in them. */
#include "quality/cell_measure.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/sum.h"
#include "geometry/cube_root.h"
#include "geometry/target.h"
#include "quality/certificate.h"
#include "quality/bends.h"
#include "quality/measure_block.h"

#include <math.h>
#include <string.h>

enum {
    LANES = PL_JACOBIAN_LANES,
    CHUNK = 1024 /* elements that one thread takes at a time */
};

/* Elements in this range are measured as they are, others scaled by a power of two. */
static const double SMALL = 0x1p-40, LARGE = 0x1p40;

typedef double pack[LANES];

/** Sums over the elements of one type. */
typedef struct type_sums {
    planish_cell_measures of; /* counts, least and largest values */
    int64_t n_ratios;         /* elements that have an AR */
    pl_sum square, ratio;     /* of AR^2 and AR over these */
} type_sums;

/** Block of elements of one type, and their measures. */
typedef struct cell_block {
    const pl_jacobian_rule *rule;
    int n;                      /* elements; the other lanes repeat the first */
    int64_t element[LANES];     /* their numbers, */
    const int32_t *node[LANES]; /* nodes */
    pack sign;
    pl_jacobian_block jacobian;
    int exponent[LANES]; /* places are multiplied by 2^-exponent */
    pl_bends bends;      /* of elements of order 2 */
    pack edge_ratio;
    pack is_certain;      /* 1: the signs of all corners are right; 0: look at them one by one */
    pack square;          /* AR^2, if no corner is inverted */
    pack scaled_jacobian; /* least of the corners */
    pack n_inverted_corners;
    pack is_curved;
} cell_block;

/** A measurement under way. */
typedef struct measurement {
    const pl_cell_mesh *mesh;
    const pl_cell_rules *rules;
    type_sums *sums; /* [threads][rules->n] */
    planish_cell_values values;
    int failed;     /* no memory; shared by threads */
    int64_t flawed; /* lowest element with a corner that has no target; shared */
} measurement;

static const double *place_of(const pl_cell_mesh *mesh, int32_t node) {
    return mesh->coordinates + (int64_t)node * mesh->dim;
}

/* ---- Gathering ------------------------------------------------------------------------------ */

/** Put the mids of lane l that are missing in the middle. */
static void fill_missing(const pl_cell_mesh *mesh, int l, cell_block *b) {
    double(*const x)[3][LANES] = b->jacobian.x;
    for (int i = 0; i < b->rule->n_nodes; i++)
        for (int d = 0; d < mesh->dim && b->node[l][i] < 0; d++) {
            const uint8_t *pair = b->rule->type->between[i];
            x[i][d][l] = 0.5 * (x[pair[0]][d][l] + x[pair[1]][d][l]);
        }
}

/** Scale lane l, whose largest difference to the first node is size, to a size of about 1. */
static void scale_lane(const pl_cell_mesh *mesh, double size, int l, cell_block *b) {
    enum { OVERFLOWN = 1000 };
    double(*const x)[3][LANES] = b->jacobian.x;
    const int n = b->rule->n_nodes, is_relative = b->rule->n_control_terms > 0;
    int exponent = OVERFLOWN;
    if (size <= DBL_MAX)
        frexp(size, &exponent);
    b->exponent[l] = exponent = pl_scale_exponent(exponent);
    for (int i = 0; i < n; i++)
        for (int d = 0; d < mesh->dim; d++) {
            if (size <= DBL_MAX) {
                x[i][d][l] = ldexp(x[i][d][l], -exponent);
            } else if (b->node[l][i] >= 0) { /* before differences are taken */
                const double place = ldexp(place_of(mesh, b->node[l][i])[d], -exponent);
                const double first = ldexp(place_of(mesh, b->node[l][0])[d], -exponent);
                x[i][d][l] = is_relative ? place - first : place;
            }
        }
    fill_missing(mesh, l, b);
}

/** Find the places of the nodes of all lanes, those of order 2 less that of the first node: linear
 *  elements have exact coordinates, so that differences are rounded once. */
PL_INLINE void gather(const pl_cell_mesh *mesh, cell_block *b, const int dim) {
    double(*const x)[3][LANES] = b->jacobian.x;
    const int n = b->rule->n_nodes, is_relative = b->rule->n_control_terms > 0;
    int n_missing = 0;
    pack size = {0};
    for (int l = 0; l < LANES; l++)
        for (int i = 0; i < n; i++) {
            const int32_t node = b->node[l][i];
            const double *place = place_of(mesh, node >= 0 ? node : b->node[l][0]);
            n_missing += node < 0;
            for (int d = 0; d < dim; d++)
                x[i][d][l] = place[d];
        }
    double first[3][LANES];
    memcpy(first, x[0], sizeof first);
    for (int i = 0; is_relative && i < n; i++)
        for (int d = 0; d < dim; d++)
            for (int l = 0; l < LANES; l++)
                x[i][d][l] -= first[d][l];
    for (int l = 0; n_missing > 0 && l < LANES; l++)
        fill_missing(mesh, l, b);
    memcpy(first, x[0], sizeof first);
    for (int i = 1; i < n; i++)
        for (int d = 0; d < dim; d++) {
            pack place;
            memcpy(place, x[i][d], sizeof place);
            for (int l = 0; l < LANES; l++)
                size[l] = pl_larger(fabs(place[l] - first[d][l]), size[l]);
        }
    for (int l = 0; l < LANES; l++) {
        b->exponent[l] = 0;
        if (size[l] > 0 && (size[l] < SMALL || size[l] > LARGE))
            scale_lane(mesh, size[l], l, b);
    }
}

/* ---- Edges ----------------------------------------------------------------------------------- */

PL_INLINE void measure_edges(cell_block *b, const int dim) {
    const pl_cell_shape *shape = b->rule->type->shape;
    pack longest = {0}, shortest;
    double from[3][LANES], to[3][LANES];
    for (int l = 0; l < LANES; l++)
        shortest[l] = INFINITY;
    for (int e = 0; e < shape->n_edges; e++) {
        memcpy(from, b->jacobian.x[shape->edge[e][0]], sizeof from);
        memcpy(to, b->jacobian.x[shape->edge[e][1]], sizeof to);
        for (int l = 0; l < LANES; l++) {
            const double x = to[0][l] - from[0][l], y = to[1][l] - from[1][l];
            const double z = dim == 3 ? to[2][l] - from[2][l] : 0;
            const double square = dim == 3 ? x * x + y * y + z * z : x * x + y * y;
            longest[l] = pl_larger(square, longest[l]);
            shortest[l] = pl_smaller(square, shortest[l]);
        }
    }
    for (int l = 0; l < LANES; l++) {
        b->edge_ratio[l] = sqrt(longest[l] / shortest[l]);
    }
}

/* ---- Corners ---------------------------------------------------------------------------------- */

/** Copy the places of corner c [0] and its neighbours, as loops over lanes become vectors only with
 *  arrays of their own. */
PL_INLINE void find_corner(const cell_block *b, int c, double corner[4][3][LANES], const int dim) {
    const uint8_t *neighbour = b->rule->type->shape->neighbour[c];
    for (int j = 0; j <= dim; j++)
        memcpy(corner[j], b->jacobian.x[j > 0 ? neighbour[j - 1] : c], sizeof corner[j]);
}

/** Edges of a corner in lane l. */
PL_INLINE void find_edges(double corner[4][3][LANES], int l, double edges[3][3], const int dim) {
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edges[j][d] = corner[j + 1][d][l] - corner[0][d][l];
}

/** Square of the mean ratio from E and D (geometry/corner.h), however small D > 0 is. */
PL_INLINE double ratio_square(double e, double d, const int dim) {
    if (dim == 2)
        return e * e / (4 * d * d);
    const double root = pl_cube_root(d);
    return e * e / (9 * root * root * root * root);
}

/** Square of a corner's mean ratio (docs/measures.md), with the determinant D > 0 of edges. */
PL_INLINE double mean_ratio_square(const pl_cell_shape *shape, double edges[3][3],
                                   double determinant, const int dim) {
    double e = 0;
    for (int j = 0; j < dim; j++)
        e += shape->to_corner[j] * pl_dot(dim, edges[j], edges[j]);
    for (int pair = 0; pair < (dim == 3 ? 3 : 1); pair++) {
        double between[3];
        pl_subtract(dim, edges[(pair + 3) / 2], edges[pair / 2], between); /* 01, 02, 12 */
        e += shape->between[pair] * pl_dot(dim, between, between);
    }
    return ratio_square(e, determinant / shape->determinant, dim);
}

/** Target of a corner, in a metric. */
typedef struct wanted_corner {
    pl_target target;
    pl_metric metric;
} wanted_corner;

/** Find the targets of the corners of lane l; 0: one has none. */
static int find_targets(const pl_cell_mesh *mesh, const cell_block *b, int l, wanted_corner *w) {
    for (int c = 0; c < b->rule->type->shape->n_measured; c++) {
        if (!mesh->target(mesh->targets, b->element[l], c, &w[c].target, &w[c].metric))
            return 0;
    }
    return 1;
}

/** Measure the corners of all lanes. */
PL_INLINE void measure_corners(cell_block *b, const int dim) {
    const pl_cell_shape *shape = b->rule->type->shape;
    const pl_cell_shape ideal = *shape;
    const double share = 1.0 / shape->n_measured;
    double corner[4][3][LANES];
    pack sign, is_certain, sum, n_inverted, least;
    for (int l = 0; l < LANES; l++) {
        sign[l] = b->sign[l];
        is_certain[l] = 1;
        sum[l] = n_inverted[l] = 0;
        least[l] = INFINITY;
    }
    for (int c = 0; c < shape->n_measured; c++) {
        find_corner(b, c, corner, dim);
        for (int l = 0; l < LANES; l++) {
            double edges[3][3], squares = 1;
            find_edges(corner, l, edges, dim);
            for (int j = 0; j < dim; j++)
                squares *= pl_dot(dim, edges[j], edges[j]);
            const double determinant = sign[l] * pl_determinant_of_edges(dim, edges);
            const double error =
                (dim == 3 ? PL_ERROR_3D : PL_ERROR_2D) * pl_permanent_bound(dim, edges);
            const double square = mean_ratio_square(&ideal, edges, fabs(determinant), dim);
            const double scaled = determinant / (sqrt(squares) * ideal.determinant);
            is_certain[l] = fabs(determinant) > error ? is_certain[l] : 0;
            n_inverted[l] += determinant > 0 ? 0 : 1;
            sum[l] += square;
            least[l] = pl_smaller(scaled, least[l]);
        }
    }
    for (int l = 0; l < LANES; l++) {
        b->is_certain[l] = is_certain[l];
        b->n_inverted_corners[l] = n_inverted[l];
        b->scaled_jacobian[l] = least[l];
        b->square[l] = sum[l] * share;
    }
}

/** E of a corner's edges. */
PL_INLINE double energy_of(const pl_cell_mesh *mesh, const wanted_corner *w,
                           const double edges[3][3]) {
    return mesh->has_metric ? pl_target_energy_in(mesh->dim, edges, w->target.v, w->metric.l)
                            : pl_target_energy(mesh->dim, edges, w->target.v);
}

/** Measure lane l by the targets of its corners. Its determinants are certain. */
static void measure_by_targets(const pl_cell_mesh *mesh, int l, const wanted_corner *w,
                               cell_block *b) {
    const pl_cell_shape *shape = b->rule->type->shape;
    const int dim = mesh->dim;
    double sum = 0;
    for (int c = 0; c < shape->n_measured; c++) {
        double corner[4][3][LANES], edges[3][3] = {{0}};
        find_corner(b, c, corner, dim);
        find_edges(corner, l, edges, dim);
        sum += ratio_square(energy_of(mesh, &w[c], (const double(*)[3])edges),
                            fabs(pl_determinant_of_edges(dim, (const double(*)[3])edges)), dim);
    }
    b->square[l] = sum / shape->n_measured;
}

/** Measure the corners of lane l anew, with exact determinants; w [corners], or NULL. */
static void resolve_corners(const pl_cell_mesh *mesh, int l, const wanted_corner *w,
                            cell_block *b) {
    const pl_cell_shape *shape = b->rule->type->shape;
    const int dim = mesh->dim;
    double sum = 0, least = INFINITY;
    int n_inverted = 0;
    for (int c = 0; c < shape->n_measured; c++) {
        const double *vertex[4] = {place_of(mesh, b->node[l][c])};
        double corner[4][3][LANES], edges[3][3] = {{0}};
        int exponent;
        for (int j = 0; j < dim; j++)
            vertex[j + 1] = place_of(mesh, b->node[l][shape->neighbour[c][j]]);
        const double m = b->sign[l] * pl_certified_determinant(dim, vertex, &exponent);
        const double determinant = ldexp(m, exponent - dim * b->exponent[l]);
        double scaled = determinant / shape->determinant;
        find_corner(b, c, corner, dim);
        find_edges(corner, l, edges, dim);
        for (int j = 0; j < dim; j++)
            scaled /= sqrt(pl_dot(dim, edges[j], edges[j]));
        n_inverted += !(m > 0);
        sum +=
            !(m > 0) ? NAN
            : w ? ratio_square(energy_of(mesh, &w[c], (const double(*)[3])edges), determinant, dim)
                : mean_ratio_square(shape, edges, determinant, dim);
        least = pl_smaller(m != 0 ? scaled : 0, least);
    }
    b->n_inverted_corners[l] = n_inverted;
    b->square[l] = sum / shape->n_measured;
    b->scaled_jacobian[l] = least;
}

/** Measure all lanes, but for corners that are not certain. */
PL_INLINE void evaluate(const pl_cell_mesh *mesh, cell_block *b, const int dim) {
    gather(mesh, b, dim);
    measure_edges(b, dim);
    measure_corners(b, dim);
    if (b->rule->n_control_terms > 0)
        pl_find_bends(b->rule, &b->jacobian, &b->bends, dim);
}

PL_INLINE void inline_block(const pl_cell_mesh *mesh, cell_block *b) {
    if (mesh->dim == 3)
        evaluate(mesh, b, 3);
    else
        evaluate(mesh, b, 2);
}

/* With wider vectors, as in measure.c; the bits are the same. */
#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target("avx2"))) static void wide_block(const pl_cell_mesh *mesh, cell_block *b) {
    inline_block(mesh, b);
}
#endif

/** Evaluate b. The lanes past the last element have something to compute with. */
static void any_block(const pl_cell_mesh *mesh, cell_block *b) {
    for (int l = b->n; l < LANES; l++) {
        b->node[l] = b->node[0];
        b->sign[l] = b->sign[0];
    }
#if defined(__x86_64__) && defined(__GNUC__)
    if (__builtin_cpu_supports("avx2")) {
        wide_block(mesh, b);
        return;
    }
#endif
    inline_block(mesh, b);
}

/* ---- Sums ----------------------------------------------------------------------------------- */

static planish_cell_state state_of(pl_validity validity) {
    return validity == PL_VALID     ? PLANISH_CELL_STATE_VALID
           : validity == PL_INVALID ? PLANISH_CELL_STATE_INVERTED
                                    : PLANISH_CELL_STATE_UNCERTIFIED;
}

/** Return the least coefficient of lane l over the absolute mean of all: below 0 also where the mean
 *  is. 1 if it is not curved. */
static double jacobian_ratio(const cell_block *b, int l) {
    const double least = b->jacobian.least[l], mean = fabs(b->jacobian.mean[l]);
    if (!(b->is_curved[l] > 0))
        return 1;
    return mean > 0 ? least / mean : least < 0 ? -INFINITY : 0;
}

/** Give the caller the values of lane l. */
static void give_values(const planish_cell_values *v, const cell_block *b, int l,
                        planish_cell_state state, double aspect_ratio) {
    const int64_t i = b->element[l];
    if (v->state)
        v->state[i] = (uint8_t)state;
    if (v->is_curved)
        v->is_curved[i] = b->is_curved[l] > 0;
    if (v->aspect_ratio)
        v->aspect_ratio[i] = aspect_ratio;
    if (v->scaled_jacobian)
        v->scaled_jacobian[i] = b->scaled_jacobian[l];
    if (v->jacobian_ratio)
        v->jacobian_ratio[i] = jacobian_ratio(b, l);
    if (v->edge_ratio)
        v->edge_ratio[i] = b->edge_ratio[l];
}

/** Give 0 for an element that does not count. */
static void give_none(const planish_cell_values *v, int64_t i) {
    double *const measure[] = {v->aspect_ratio, v->scaled_jacobian, v->jacobian_ratio,
                               v->edge_ratio};
    if (v->state)
        v->state[i] = PLANISH_CELL_STATE_NONE;
    if (v->is_curved)
        v->is_curved[i] = 0;
    for (size_t k = 0; k < sizeof measure / sizeof *measure; k++)
        if (measure[k])
            measure[k][i] = 0;
}

static int is_lane_curved(const measurement *m, const cell_block *b, int l, pl_validity validity) {
    return b->rule->n_control_terms > 0 &&
           pl_is_curved(&b->bends, &b->jacobian, l, ldexp(m->mesh->rounding, -b->exponent[l]),
                        validity == PL_VALID);
}

static void add_lane(measurement *m, cell_block *b, int l, type_sums *sums) {
    planish_cell_measures *of = &sums->of;
    const int64_t element = b->element[l];
    const pl_validity validity =
        pl_validity_of_lane(b->rule, &b->jacobian, l, b->node[l], m->mesh->coordinates, b->sign[l]);
    b->is_curved[l] = is_lane_curved(m, b, l, validity);
    const int has_ratio = validity == PL_VALID && b->n_inverted_corners[l] == 0;
    const double ratio = has_ratio ? sqrt(b->square[l]) : 0;
    if (validity == PL_OUT_OF_MEMORY)
        __atomic_store_n(&m->failed, 1, __ATOMIC_RELAXED);
    of->n_elements++;
    of->n_inverted += validity == PL_INVALID;
    of->n_uncertified += validity == PL_UNCERTIFIED;
    of->n_inverted_corners += (int64_t)b->n_inverted_corners[l];
    of->n_curved += (int64_t)b->is_curved[l];
    of->min_scaled_jacobian = pl_smaller(b->scaled_jacobian[l], of->min_scaled_jacobian);
    of->max_edge_ratio = pl_larger(b->edge_ratio[l], of->max_edge_ratio);
    of->min_jacobian_ratio = pl_smaller(jacobian_ratio(b, l), of->min_jacobian_ratio);
    give_values(&m->values, b, l, state_of(validity), ratio);
    if (!has_ratio)
        return;
    sums->n_ratios++;
    pl_sum_add(&sums->square, b->square[l]);
    pl_sum_add(&sums->ratio, ratio);
    if (ratio > of->max_aspect_ratio ||
        (ratio == of->max_aspect_ratio && element < of->worst_element)) {
        of->max_aspect_ratio = ratio;
        of->worst_element = element;
    }
}

static void measure_block(measurement *m, cell_block *b, type_sums *sums) {
    any_block(m->mesh, b);
    pl_jacobian_evaluate(b->rule, b->sign, &b->jacobian);
    for (int l = 0; l < b->n; l++) {
        wanted_corner wanted[PL_CELL_CORNERS];
        const int has_targets = m->mesh->target != NULL;
        if (has_targets && !find_targets(m->mesh, b, l, wanted))
            pl_lower_to(&m->flawed, b->element[l]);
        else if (b->is_certain[l] == 0)
            resolve_corners(m->mesh, l, has_targets ? wanted : NULL, b);
        else if (has_targets)
            measure_by_targets(m->mesh, l, wanted, b);
        add_lane(m, b, l, sums);
    }
    b->n = 0;
}

static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    measurement *m = context;
    const planish_cells *cells = m->mesh->cells;
    cell_block b;
    for (int r = 0; r < m->rules->n; r++) { /* one type after the other */
        type_sums *sums = &m->sums[thread * m->rules->n + r];
        b.rule = m->rules->rule[r];
        b.n = 0;
        for (int64_t i = begin; i < end; i++) {
            if (cells->type[i] != b.rule->type->type)
                continue;
            b.element[b.n] = i;
            b.sign[b.n] = m->mesh->sign[i];
            b.node[b.n++] = cells->node + cells->offset[i];
            if (b.n == LANES)
                measure_block(m, &b, sums);
        }
        if (b.n > 0)
            measure_block(m, &b, sums);
    }
    for (int64_t i = begin; i < end; i++)
        if (m->rules->index[m->mesh->cells->type[i]] < 0)
            give_none(&m->values, i);
}

static const type_sums NO_SUMS = {
    .of = {.worst_element = -1, .min_scaled_jacobian = INFINITY, .min_jacobian_ratio = 1}};

/** Add a part to the sums of all. */
static void merge(const type_sums *part, type_sums *all) {
    planish_cell_measures *of = &all->of;
    const planish_cell_measures *more = &part->of;
    pl_sum square = part->square, ratio = part->ratio;
    of->n_elements += more->n_elements;
    of->n_inverted += more->n_inverted;
    of->n_uncertified += more->n_uncertified;
    of->n_inverted_corners += more->n_inverted_corners;
    of->n_curved += more->n_curved;
    all->n_ratios += part->n_ratios;
    of->min_scaled_jacobian = pl_smaller(more->min_scaled_jacobian, of->min_scaled_jacobian);
    of->min_jacobian_ratio = pl_smaller(more->min_jacobian_ratio, of->min_jacobian_ratio);
    of->max_edge_ratio = pl_larger(more->max_edge_ratio, of->max_edge_ratio);
    if (more->max_aspect_ratio > of->max_aspect_ratio ||
        (more->max_aspect_ratio == of->max_aspect_ratio && more->worst_element < of->worst_element))
        of->worst_element = more->worst_element;
    of->max_aspect_ratio = pl_larger(more->max_aspect_ratio, of->max_aspect_ratio);
    pl_sum_merge(&all->square, &square);
    pl_sum_merge(&all->ratio, &ratio);
}

static planish_cell_measures result_of(const type_sums *sums) {
    planish_cell_measures of = sums->of;
    const double n_ratios = (double)sums->n_ratios;
    if (n_ratios > 0) {
        of.rms_aspect_ratio = sqrt(pl_sum_value(&sums->square) / n_ratios);
        of.mean_aspect_ratio = pl_sum_value(&sums->ratio) / n_ratios;
    }
    if (of.n_elements == 0)
        of.min_scaled_jacobian = 0;
    return of;
}

/** Sum over all threads of what each has of type r. */
static type_sums sums_of(const measurement *m, int n_threads, int r) {
    type_sums all = NO_SUMS;
    for (int t = 0; t < n_threads; t++)
        merge(&m->sums[t * m->rules->n + r], &all);
    return all;
}

int pl_measure_cells(const pl_cell_mesh *mesh, const pl_cell_rules *rules, int threads,
                     planish_cell_quality *quality, const planish_cell_values *values,
                     int64_t *flawed) {
    const int n_threads = pl_thread_count(threads);
    measurement m = {.mesh = mesh, .rules = rules, .flawed = INT64_MAX};
    if (values)
        m.values = *values;
    type_sums all = NO_SUMS;
    m.sums = pl_alloc((int64_t)n_threads * rules->n, sizeof *m.sums);
    if (!m.sums)
        return PLANISH_ERROR_MEMORY;
    for (int i = 0; i < n_threads * rules->n; i++)
        m.sums[i] = NO_SUMS;
    pl_parallel_for(n_threads, mesh->cells->n, CHUNK, measure_chunk, &m);
    *flawed = m.flawed;
    if (m.failed || m.flawed < INT64_MAX) {
        pl_free(m.sums);
        return m.failed ? PLANISH_ERROR_MEMORY : PLANISH_ERROR_MESH;
    }
    memset(quality, 0, sizeof *quality);
    quality->n_types = rules->n;
    for (int r = 0; r < rules->n; r++) {
        const type_sums of_type = sums_of(&m, n_threads, r);
        quality->type[r] = rules->rule[r]->type->type;
        quality->by_type[r] = result_of(&of_type);
        merge(&of_type, &all);
    }
    quality->all = result_of(&all);
    pl_free(m.sums);
    return PLANISH_OK;
}

/* ---- Rules ----------------------------------------------------------------------------------- */

int pl_cell_rules_make(const pl_cell_mesh *mesh, pl_cell_rules *rules) {
    uint8_t is_there[UINT8_MAX + 1] = {0};
    memset(rules, 0, sizeof *rules);
    memset(rules->index, -1, sizeof rules->index);
    for (int64_t i = 0; i < mesh->cells->n; i++)
        is_there[mesh->cells->type[i]] = 1;
    for (int type = 0; type <= UINT8_MAX; type++) {
        const pl_cell_type *of = is_there[type] ? pl_cell_type_of(type) : NULL;
        if (!of || of->shape->dim != mesh->dim)
            continue;
        pl_jacobian_rule *rule = rules->rule[rules->n] = pl_alloc(1, sizeof *rule);
        if (!rule)
            return PLANISH_ERROR_MEMORY;
        pl_jacobian_rule_make(of, rule);
        rules->index[type] = (int8_t)rules->n++;
    }
    return PLANISH_OK;
}

void pl_cell_rules_free(pl_cell_rules *rules) {
    for (int r = 0; r < rules->n; r++)
        pl_free(rules->rule[r]);
    rules->n = 0;
}
