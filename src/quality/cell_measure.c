/* cell_measure: chunks of elements are handed to threads, which sort them by type into blocks. Sums
 * are exact (base/sum.h), so that no order of elements or threads shows in them. */
#include "quality/cell_measure.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/sum.h"
#include "geometry/cube_root.h"
#include "quality/certificate.h"
#include "quality/measure_block.h"

#include <math.h>
#include <string.h>

enum {
    LANES = PL_JACOBIAN_LANES,
    CHUNK = 1024 /* elements that one thread takes at a time */
};

/* An element is straight if its nodes are no farther off than this, in longest edges. */
static const double STRAIGHT = 1e-6;

/* Sizes of elements that are measured as they are. */
static const double SMALL = 0x1p-60, LARGE = 0x1p60;

/** Sums over the elements of one type. */
typedef struct type_sums {
    planish_cell_measures of; /* counts, least and largest values */
    pl_sum square, ratio;     /* of AR^2 and AR over the valid elements */
} type_sums;

/** Block of elements of one type, and their measures. */
typedef struct cell_block {
    const pl_jacobian_rule *rule;
    int n;                  /* elements; the other lanes repeat the first */
    int64_t element[LANES]; /* their numbers, */
    double sign[LANES];
    pl_jacobian_block jacobian;
    double square[LANES];          /* AR^2 */
    double scaled_jacobian[LANES]; /* least of the corners */
    double edge_ratio[LANES];
    int n_inverted_corners[LANES];
    int is_curved[LANES];
} cell_block;

/** A measurement under way. */
typedef struct measurement {
    const pl_cell_mesh *mesh;
    const pl_cell_rules *rules;
    type_sums *sums;      /* [threads][rules->n] */
    double *aspect_ratio; /* [n] or NULL */
    int64_t (*signs)[2];  /* [threads * rules->n] elements of negative and positive sign; or NULL */
} measurement;

static const int32_t *nodes_of(const pl_cell_mesh *mesh, int64_t element) {
    return mesh->cells->node + mesh->cells->offset[element];
}

static const double *place_of(const pl_cell_mesh *mesh, int32_t node) {
    return mesh->coordinates + (int64_t)node * mesh->dim;
}

/* ---- Gathering ------------------------------------------------------------------------------ */

/** Find the places of the nodes of an element, less that of the first. Mids that are missing are in
 *  the middle. Returns the largest component. */
static double gather_element(const pl_cell_mesh *mesh, const pl_jacobian_rule *rule,
                             const int32_t node[], double x[][3]) {
    const double *first = place_of(mesh, node[0]);
    double size = 0;
    for (int i = 0; i < rule->n_nodes; i++)
        for (int d = 0; d < mesh->dim; d++) {
            const uint8_t *pair = rule->type->between[i];
            x[i][d] = node[i] >= 0 ? place_of(mesh, node[i])[d] - first[d]
                                   : 0.5 * (x[pair[0]][d] + x[pair[1]][d]);
            size = pl_larger(fabs(x[i][d]), size);
        }
    return size;
}

/** Whether a node of the element at x is off the middle of its corners. */
static int is_curved(const pl_cell_mesh *mesh, const pl_jacobian_rule *rule, double x[][3],
                     double scale) {
    double longest = 0;
    for (int e = 0; e < rule->type->shape->n_edges; e++) {
        const uint8_t *edge = rule->type->shape->edge[e];
        double square = 0;
        for (int d = 0; d < mesh->dim; d++)
            square += (x[edge[1]][d] - x[edge[0]][d]) * (x[edge[1]][d] - x[edge[0]][d]);
        longest = pl_larger(square, longest);
    }
    const double limit = pl_larger(STRAIGHT * sqrt(longest), mesh->rounding * scale);
    for (int i = rule->type->shape->n_corners; i < rule->n_nodes; i++) {
        double square = 0;
        for (int d = 0; d < mesh->dim; d++) {
            double sum = 0;
            int n = 0;
            for (int c = 0; c < rule->type->shape->n_corners; c++)
                if (rule->straight[i] >> c & 1) {
                    sum += x[c][d];
                    n++;
                }
            square += (x[i][d] - sum / n) * (x[i][d] - sum / n);
        }
        if (square > limit * limit)
            return 1;
    }
    return 0;
}

/** Put an element into lane l of b. Elements whose size is out of range are scaled to about 1. */
static void gather_lane(const pl_cell_mesh *mesh, int64_t element, int l, cell_block *b) {
    const pl_jacobian_rule *rule = b->rule;
    const int32_t *node = nodes_of(mesh, element);
    double x[PL_CELL_NODES][3];
    const double size = gather_element(mesh, rule, node, x);
    int exponent = 0;
    if (size > 0 && (size < SMALL || size > LARGE) && size <= DBL_MAX)
        frexp(size, &exponent);
    const double scale = ldexp(1, -pl_scale_exponent(exponent));
    for (int i = 0; i < rule->n_nodes; i++)
        for (int d = 0; d < mesh->dim; d++) {
            /* Differences of nodes are exact to a rounding only if nothing was subtracted before. */
            const int as_it_is = rule->n_control_terms == 0 && node[i] >= 0;
            const double from = as_it_is ? place_of(mesh, node[i])[d] : x[i][d];
            b->jacobian.x[i][d][l] = from * scale;
            x[i][d] *= scale;
        }
    b->element[l] = element;
    b->is_curved[l] = rule->n_control_terms > 0 && is_curved(mesh, rule, x, scale);
}

/* ---- Corners ---------------------------------------------------------------------------------- */

/** Sign of det J at a corner of lane l, exactly. */
static int exact_corner_sign(const pl_cell_mesh *mesh, const cell_block *b, int corner, int l) {
    const pl_jacobian_rule *rule = b->rule;
    const int32_t *node = nodes_of(mesh, b->element[l]);
    const double *vertex[4] = {place_of(mesh, node[corner])};
    for (int j = 0; j < mesh->dim; j++)
        vertex[j + 1] = place_of(mesh, node[rule->type->shape->neighbour[corner][j]]);
    return (int)b->sign[l] * pl_measure_sign(mesh->dim, vertex);
}

/** Squared mean ratio of the ideal corner's kind: E over dim det^(2/dim), both relative to it. */
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
    const double d = fabs(determinant) / shape->determinant;
    if (dim == 2)
        return e * e / (4 * d * d);
    const double root = pl_cube_root(d);
    return e * e / (9 * root * root * root * root);
}

/** Measure the corners of all lanes, whatever their signs: of det J <= 0 AR is no number. */
PL_INLINE void measure_corners(const pl_cell_mesh *mesh, cell_block *b, const int dim) {
    const pl_cell_shape *shape = b->rule->type->shape;
    for (int l = 0; l < LANES; l++) {
        b->square[l] = 0;
        b->scaled_jacobian[l] = INFINITY;
        b->n_inverted_corners[l] = 0;
    }
    for (int c = 0; c < shape->n_measured; c++)
        for (int l = 0; l < LANES; l++) {
            double edges[3][3], product = 1;
            for (int j = 0; j < dim; j++) {
                for (int d = 0; d < dim; d++)
                    edges[j][d] = b->jacobian.x[shape->neighbour[c][j]][d][l] - b->jacobian.x[c][d][l];
                product *= sqrt(pl_dot(dim, edges[j], edges[j]));
            }
            const double determinant = b->sign[l] * pl_determinant_of_edges(dim, edges);
            const double error =
                (dim == 3 ? PL_ERROR_3D : PL_ERROR_2D) * pl_permanent_bound(dim, edges);
            const int sign = fabs(determinant) > error ? (determinant > 0 ? 1 : -1)
                                                       : exact_corner_sign(mesh, b, c, l);
            b->n_inverted_corners[l] += sign <= 0;
            const double scaled =
                product > 0 ? determinant / product / shape->determinant : 0;
            b->scaled_jacobian[l] = pl_smaller(scaled, b->scaled_jacobian[l]);
            b->square[l] += sign > 0 ? mean_ratio_square(shape, edges, determinant, dim) : NAN;
        }
    for (int l = 0; l < LANES; l++)
        b->square[l] /= shape->n_measured;
}

static void measure_edges(cell_block *b, int dim) {
    const pl_cell_shape *shape = b->rule->type->shape;
    double longest[LANES] = {0}, shortest[LANES];
    for (int l = 0; l < LANES; l++)
        shortest[l] = INFINITY;
    for (int e = 0; e < shape->n_edges; e++)
        for (int l = 0; l < LANES; l++) {
            double square = 0;
            for (int d = 0; d < dim; d++) {
                const double difference = b->jacobian.x[shape->edge[e][1]][d][l] -
                                          b->jacobian.x[shape->edge[e][0]][d][l];
                square += difference * difference;
            }
            longest[l] = pl_larger(square, longest[l]);
            shortest[l] = pl_smaller(square, shortest[l]);
        }
    for (int l = 0; l < LANES; l++)
        b->edge_ratio[l] = sqrt(longest[l] / shortest[l]);
}

/* ---- Sums ----------------------------------------------------------------------------------- */

static void add_lane(const measurement *m, const cell_block *b, int l, type_sums *sums) {
    planish_cell_measures *of = &sums->of;
    const int64_t element = b->element[l];
    const pl_validity validity = pl_validity_of_lane(
        b->rule, &b->jacobian, l, nodes_of(m->mesh, element), m->mesh->coordinates, b->sign[l]);
    const int is_valid = validity == PL_VALID;
    const double ratio = is_valid ? sqrt(b->square[l]) : 0;
    of->n_elements++;
    of->n_inverted += validity == PL_INVALID;
    of->n_uncertified += validity == PL_UNCERTIFIED;
    of->n_inverted_corners += b->n_inverted_corners[l];
    of->n_curved += b->is_curved[l];
    of->min_scaled_jacobian = pl_smaller(b->scaled_jacobian[l], of->min_scaled_jacobian);
    of->max_edge_ratio = pl_larger(b->edge_ratio[l], of->max_edge_ratio);
    if (b->is_curved[l])
        of->min_jacobian_ratio =
            pl_smaller(b->jacobian.least[l] / b->jacobian.mean[l], of->min_jacobian_ratio);
    if (m->aspect_ratio)
        m->aspect_ratio[element] = ratio;
    if (!is_valid)
        return;
    pl_sum_add(&sums->square, b->square[l]);
    pl_sum_add(&sums->ratio, ratio);
    if (ratio > of->max_aspect_ratio ||
        (ratio == of->max_aspect_ratio && element < of->worst_element)) {
        of->max_aspect_ratio = ratio;
        of->worst_element = element;
    }
}

static void measure_block(const measurement *m, cell_block *b, type_sums *sums) {
    const int n = b->n;
    for (int l = n; l < LANES; l++) /* something to compute with */
        gather_lane(m->mesh, b->element[0], l, b);
    pl_jacobian_evaluate(b->rule, b->sign, &b->jacobian);
    if (m->mesh->dim == 3)
        measure_corners(m->mesh, b, 3);
    else
        measure_corners(m->mesh, b, 2);
    measure_edges(b, m->mesh->dim);
    for (int l = 0; l < n; l++)
        add_lane(m, b, l, sums);
    b->n = 0;
}

static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const measurement *m = context;
    cell_block b;
    for (int r = 0; r < m->rules->n; r++) { /* one type after the other */
        b.rule = m->rules->rule[r];
        b.n = 0;
        for (int l = 0; l < LANES; l++)
            b.sign[l] = m->rules->sign[r];
        type_sums *sums = &m->sums[thread * m->rules->n + r];
        for (int64_t i = begin; i < end; i++) {
            if (m->mesh->cells->type[i] != b.rule->type->type)
                continue;
            gather_lane(m->mesh, i, b.n++, &b);
            if (b.n == LANES)
                measure_block(m, &b, sums);
        }
        if (b.n > 0)
            measure_block(m, &b, sums);
    }
    for (int64_t i = begin; m->aspect_ratio && i < end; i++)
        if (m->rules->index[m->mesh->cells->type[i]] < 0)
            m->aspect_ratio[i] = 0;
}

static const type_sums NO_SUMS = {.of = {.worst_element = -1,
                                         .min_scaled_jacobian = INFINITY,
                                         .min_jacobian_ratio = 1}};

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
    const double n_valid = (double)(of.n_elements - of.n_inverted - of.n_uncertified);
    if (n_valid > 0) {
        of.rms_aspect_ratio = sqrt(pl_sum_value(&sums->square) / n_valid);
        of.mean_aspect_ratio = pl_sum_value(&sums->ratio) / n_valid;
    }
    if (of.n_elements == 0)
        of.min_scaled_jacobian = 0;
    return of;
}

int pl_measure_cells(const pl_cell_mesh *mesh, const pl_cell_rules *rules, int threads,
                     planish_cell_quality *quality, double *aspect_ratio) {
    const int n_threads = pl_thread_count(threads), n_sums = n_threads * rules->n;
    type_sums all = NO_SUMS, *sums = pl_alloc(n_sums, sizeof *sums);
    measurement m = {.mesh = mesh, .rules = rules, .sums = sums, .aspect_ratio = aspect_ratio};
    if (!sums)
        return PLANISH_ERROR_MEMORY;
    for (int i = 0; i < n_sums; i++)
        sums[i] = NO_SUMS;
    pl_parallel_for(n_threads, mesh->cells->n, CHUNK, measure_chunk, &m);
    memset(quality, 0, sizeof *quality);
    quality->n_types = rules->n;
    for (int r = 0; r < rules->n; r++) {
        type_sums of_type = NO_SUMS;
        for (int t = 0; t < n_threads; t++)
            merge(&sums[t * rules->n + r], &of_type);
        quality->type[r] = rules->rule[r]->type->type;
        quality->by_type[r] = result_of(&of_type);
        merge(&of_type, &all);
    }
    quality->all = result_of(&all);
    pl_free(sums);
    return PLANISH_OK;
}

/* ---- Rules ----------------------------------------------------------------------------------- */

/** Count the signs of elements, each by its corners together. */
static void count_signs(void *context, int64_t begin, int64_t end, int thread) {
    const measurement *m = context;
    for (int64_t i = begin; i < end; i++) {
        const int r = m->rules->index[m->mesh->cells->type[i]];
        if (r < 0)
            continue;
        const pl_cell_shape *shape = m->rules->rule[r]->type->shape;
        const int32_t *node = nodes_of(m->mesh, i);
        double sum = 0;
        for (int c = 0; c < shape->n_measured; c++) {
            double edges[3][3];
            for (int j = 0; j < shape->dim; j++)
                pl_subtract(shape->dim, place_of(m->mesh, node[shape->neighbour[c][j]]),
                            place_of(m->mesh, node[c]), edges[j]);
            sum += pl_determinant_of_edges(shape->dim, edges);
        }
        if (sum != 0)
            m->signs[thread * m->rules->n + r][sum > 0]++;
    }
}

int pl_cell_rules_make(const pl_cell_mesh *mesh, int threads, pl_cell_rules *rules) {
    const int n_threads = pl_thread_count(threads);
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
    measurement m = {.mesh = mesh, .rules = rules};
    m.signs = pl_alloc_zero((int64_t)n_threads * rules->n, sizeof *m.signs);
    if (!m.signs)
        return PLANISH_ERROR_MEMORY;
    pl_parallel_for(n_threads, mesh->cells->n, CHUNK, count_signs, &m);
    for (int r = 0; r < rules->n; r++) {
        int64_t surplus = 0; /* of positive ones */
        for (int t = 0; t < n_threads; t++)
            surplus += m.signs[t * rules->n + r][1] - m.signs[t * rules->n + r][0];
        rules->sign[r] = surplus >= 0 ? 1 : -1;
    }
    pl_free(m.signs);
    return PLANISH_OK;
}

void pl_cell_rules_free(pl_cell_rules *rules) {
    for (int r = 0; r < rules->n; r++)
        pl_free(rules->rule[r]);
    rules->n = 0;
}
