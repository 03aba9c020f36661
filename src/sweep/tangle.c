/* tangle: find what is tangled, what of that cannot be helped, how large elements should be there,
 * and the patch of nodes around it. */
#include "sweep/tangle.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/cube_root.h"

#include <math.h>
#include <string.h>

enum { CHUNK_STARS = 256 };

/* ---- elements ------------------------------------------------------------------------------ */

void pl_tangle_find(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    const pl_objective_problem problem = pl_run_objective_problem(t->run);
    pl_run_measure(t->run); /* brings the coordinates up to date */
    t->n_tangled = pl_find_tangled(&problem, t->state);
    for (int64_t i = 0; t->hopeless && i < plan->n_elements; i++)
        if (t->hopeless[i] && t->state[i] == PL_TANGLED) {
            t->state[i] = PL_HOPELESS;
            t->n_tangled--;
        }
}

static int find_hopeless(pl_tangle *t, planish_error *error) {
    const planish_plan *plan = t->run->plan;
    int64_t n = 0;
    uint8_t *part = NULL;
    pl_star_problem problem = t->run->problem;
    problem.guard = &t->run->guard.star;
    int status = pl_mark_infeasible(plan, &problem, t->state, &n, &part, error);
    if (status || n == 0) {
        pl_free(part);
        return status;
    }
    t->link_skip = part;
    for (int64_t i = 0; i < plan->stars.link_offset[plan->stars.n_stars]; i++)
        part[i] = part[i] == PL_PART_GIVEN_UP;
    t->hopeless = pl_alloc(plan->n_elements, sizeof *t->hopeless);
    if (!t->hopeless)
        return pl_fail_memory(error, "the elements that cannot be mended");
    for (int64_t i = 0; i < plan->n_elements; i++)
        t->hopeless[i] = t->state[i] == PLANISH_VOLUME_INFEASIBLE;
    pl_tangle_find(t);
    return PLANISH_OK;
}

/* ---- sizes --------------------------------------------------------------------------------- */

/* Sizes are averaged as numbers that grow nearly like their logarithms, made without libm: exponent
 * and mantissa side by side. Meshes may be graded by orders of magnitude. */
static double to_level(double size) {
    int exponent;
    double mantissa = frexp(size, &exponent);
    return exponent + 2 * mantissa - 2;
}

static double from_level(double level) {
    double whole = floor(level);
    return ldexp(0.5 * (level - whole) + 0.5, (int)whole + 1);
}

/** Measures (times dim!) of the elements around each node, by inner numbers. */
typedef struct sizing {
    double *sum;      /* [n] of the measures; then the level of the size */
    double *absolute; /* [n] of their absolute values; then a sum of levels */
    int32_t *count;   /* [n] elements; then 0: nothing is known of the node, or 1 */
    int32_t *around;  /* [n] how many levels were added */
} sizing;

/** D of an element, positive in the mesh's orientation; node: inner numbers of its nodes. */
static double measure_of(const planish_plan *plan, int64_t element, const int32_t *node) {
    const int dim = plan->dim;
    const double *x0 = plan->coordinates + (int64_t)node[0] * dim;
    double e[3][3];
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = plan->coordinates[(int64_t)node[j + 1] * dim + d] - x0[d];
    const double D = dim == 2 ? e[0][0] * e[1][1] - e[0][1] * e[1][0]
                              : e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
                                    e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                                    e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    return plan->sign ? D * plan->sign[element] : D;
}

static void inner_nodes(const planish_plan *plan, int64_t element, int32_t *node) {
    for (int j = 0; j <= plan->dim; j++)
        node[j] = plan->inner[plan->elements[element * (plan->dim + 1) + j]];
}

static void add_measures(const planish_plan *plan, sizing *s) {
    for (int64_t i = 0; i < plan->n_elements; i++) {
        int32_t node[4];
        inner_nodes(plan, i, node);
        const double D = measure_of(plan, i, node);
        for (int j = 0; j <= plan->dim; j++) {
            s->sum[node[j]] += D;
            s->absolute[node[j]] += fabs(D);
            s->count[node[j]]++;
        }
    }
}

/** One layer more of nodes is known, from the elements they share with known ones; 0 if none. */
static int spread(const planish_plan *plan, sizing *s) {
    int grown = 0;
    memset(s->around, 0, (size_t)plan->n_nodes * sizeof *s->around);
    for (int64_t i = 0; i < plan->n_elements; i++) {
        int32_t node[4];
        inner_nodes(plan, i, node);
        for (int j = 0; j <= plan->dim; j++)
            for (int k = 0; s->count[node[j]] == 0 && k <= plan->dim; k++)
                if (s->count[node[k]] > 0) {
                    s->absolute[node[j]] = s->around[node[j]] > 0 ? s->absolute[node[j]] : 0;
                    s->absolute[node[j]] += s->sum[node[k]];
                    s->around[node[j]]++;
                }
    }
    for (int64_t i = 0; i < plan->n_nodes; i++)
        if (s->around[i] > 0) {
            s->sum[i] = s->absolute[i] / s->around[i];
            s->count[i] = grown = 1;
        }
    return grown;
}

/* The measures around a node say something of the size there where their sum is more than this
 * part of the sum of their absolute values. */
#define TELLING 0.1

static void find_sizes(pl_tangle *t, sizing *s) {
    const planish_plan *plan = t->run->plan;
    const double regular = plan->dim == 3 ? 1.4142135623730951 : 1.1547005383792515;
    int64_t unknown = 0;
    add_measures(plan, s);
    for (int64_t i = 0; i < plan->n_nodes; i++) {
        const double mean = s->count[i] > 0 ? s->sum[i] / s->count[i] * regular : 0;
        const int tells = mean > 0x1p-1000 && s->sum[i] > TELLING * s->absolute[i];
        const double size = !tells ? 1 : plan->dim == 3 ? pl_cube_root(mean) : sqrt(mean);
        unknown += s->count[i] > 0 && !tells;
        s->count[i] = tells;
        s->sum[i] = to_level(size);
    }
    while (unknown > 0 && spread(plan, s))
        ;
    for (int64_t i = 0; i < plan->n_nodes; i++)
        t->size[i] = from_level(s->sum[i]);
}

int pl_tangle_find_sizes(pl_tangle *t) {
    const int64_t n = t->run->plan->n_nodes;
    sizing s = {.sum = pl_alloc_zero(n, sizeof *s.sum),
                .absolute = pl_alloc_zero(n, sizeof *s.absolute),
                .count = pl_alloc_zero(n, sizeof *s.count),
                .around = pl_alloc_zero(n, sizeof *s.around)};
    const int memory = s.sum && s.absolute && s.count && s.around;
    if (memory)
        find_sizes(t, &s);
    pl_free(s.sum);
    pl_free(s.absolute);
    pl_free(s.count);
    pl_free(s.around);
    return memory;
}

/* ---- the patch ----------------------------------------------------------------------------- */

static int is_held(const pl_tangle *t, int64_t node) {
    return pl_star_is_held(&t->run->guard.star, (int32_t)node, t->run->plan->dim);
}

void pl_tangle_mark(pl_tangle *t, int layers) {
    const planish_plan *plan = t->run->plan;
    memset(t->in_patch, 0, (size_t)plan->n_nodes);
    for (int64_t i = 0; i < plan->n_elements; i++)
        for (int j = 0; t->state[i] == PL_TANGLED && j <= plan->dim; j++)
            t->in_patch[plan->inner[plan->elements[i * (plan->dim + 1) + j]]] = 1;
    for (int layer = 0, grown = 1; layer < layers && grown; layer++) {
        grown = 0;
        for (int64_t s = 0; s < plan->stars.n_stars; s++) {
            uint8_t *mine = &t->in_patch[plan->centre[s]];
            for (int64_t i = plan->stars.ring_offset[s];
                 !*mine && i < plan->stars.ring_offset[s + 1]; i++)
                if (t->in_patch[plan->stars.ring[i]] == 1)
                    *mine = 2, grown = 1;
        }
        for (int64_t i = 0; i < plan->n_nodes; i++)
            t->in_patch[i] = t->in_patch[i] != 0;
    }
    t->n_patch = 0;
    for (int64_t i = 0; i < plan->n_nodes; i++) {
        uint8_t *mine = &t->in_patch[plan->inner[i]];
        *mine = *mine && plan->is_free[i] && !is_held(t, plan->inner[i]);
        t->n_patch += *mine;
    }
}

/* ---- energy -------------------------------------------------------------------------------- */

static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const pl_tangle *t = context;
    const planish_plan *plan = t->run->plan;
    t->partial[begin / CHUNK_STARS] = plan->kernel->guarded->energy[plan->dim - 2](
        &t->problem, begin, end, plan->scratch + plan->scratch_stride * thread, NULL);
}

void pl_tangle_total(pl_tangle *t, int64_t n_chunks) {
    t->energy = (pl_star_energy){0, INFINITY, 0};
    for (int64_t i = 0; i < n_chunks; i++) {
        t->energy.sum += t->partial[i].sum;
        t->energy.least = fmin(t->energy.least, t->partial[i].least);
        t->energy.tangled += t->partial[i].tangled;
    }
}

void pl_tangle_measure(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    const int64_t n = plan->stars.n_stars;
    pl_parallel_for(plan->threads, n, CHUNK_STARS, measure_chunk, t);
    pl_tangle_total(t, (n + CHUNK_STARS - 1) / CHUNK_STARS);
}

/* ---- all of it ----------------------------------------------------------------------------- */

int pl_tangle_create(pl_run *r, pl_tangle *t, planish_error *error) {
    const planish_plan *plan = r->plan;
    *t = (pl_tangle){.run = r};
    t->state = pl_alloc(plan->n_elements, sizeof *t->state);
    if (!t->state)
        return pl_fail_memory(error, "the tangled elements");
    pl_tangle_find(t);
    int status = t->n_tangled > 0 ? find_hopeless(t, error) : PLANISH_OK;
    if (status || t->n_tangled == 0)
        return status;
    t->in_patch = pl_alloc_zero(plan->n_nodes, sizeof *t->in_patch);
    t->size = pl_alloc(plan->n_nodes, sizeof *t->size);
    t->partial = pl_alloc(plan->stars.n_stars / CHUNK_STARS + 1, sizeof *t->partial);
    if (!t->in_patch || !t->size || !t->partial)
        return pl_fail_memory(error, "untangling");
    t->problem = r->problem;
    t->problem.guard = &r->guard.star;
    return PLANISH_OK;
}

void pl_tangle_destroy(pl_tangle *t) {
    pl_free(t->state);
    pl_free(t->hopeless);
    pl_free(t->in_patch);
    pl_free(t->size);
    pl_free(t->link_skip);
    pl_free(t->partial);
    *t = (pl_tangle){0};
}
