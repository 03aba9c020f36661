/* patch: vectors over the nodes of a patch, and its nodes to the mean of their neighbours. */
#include "improve/patch.h"

#include "base/memory.h"
#include "base/parts.h"
#include "plan/ghosts.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 256 }; /* nodes that one thread takes at a time */
/* Conjugate gradients end when the residual has fallen to this fraction, or after so many steps. */
#define CENTRED 1e-4
enum { CENTRE_STEPS = 1000 };

int pl_patch_create(pl_run *run, const pl_star_problem *problem, const uint8_t *in_patch,
                    int n_vectors, pl_patch *p) {
    const planish_plan *plan = run->plan;
    const int64_t n_stars = plan->interior.stars.n_stars;
    *p = (pl_patch){.run = run, .problem = problem, .dim = plan->dim};
    for (int64_t s = 0; s < n_stars; s++)
        p->n += in_patch[plan->interior.centre[s]] != 0;
    p->star = pl_alloc(p->n, sizeof *p->star);
    p->vectors = pl_alloc_zero(p->n * p->dim * n_vectors, sizeof *p->vectors);
    p->field = pl_alloc_zero(plan->work.n_nodes * p->dim, sizeof *p->field);
    if (!p->star || !p->vectors || !p->field)
        return 0;
    for (int64_t s = 0, i = 0; s < n_stars; s++)
        if (in_patch[plan->interior.centre[s]])
            p->star[i++] = (int32_t)s;
    p->n_all = p->n;
    pl_parts_add(&p->n_all, 1);
    return 1;
}

void pl_patch_destroy(pl_patch *p) {
    pl_free(p->star);
    pl_free(p->vectors);
    pl_free(p->field);
}

/* ---- vectors ------------------------------------------------------------------------------- */

void pl_patch_for(const pl_patch *p, pl_chunk_fn *body, void *context) {
    pl_parallel_for(p->run->plan->threads, p->n, CHUNK, body, context);
}

/** An operation on vectors under way. */
typedef struct vector_operation {
    const pl_patch *p;
    double *a;
    const double *b, *c;
    double factor;
    int to_field; /* else from it */
    pl_sum *sum;  /* shared */
} vector_operation;

static void product_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const vector_operation *o = context;
    const int dim = o->p->dim;
    pl_sum sum = {{0}, 0, 0, 0, 0};
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double of_node = 0;
        for (int d = 0; d < dim; d++)
            of_node += o->b[i * dim + d] * o->c[i * dim + d];
        pl_sum_add(&sum, of_node);
    }
    pl_sum_merge(o->sum, &sum);
}

double pl_patch_product(const pl_patch *p, const double *b, const double *c) {
    pl_sum sum = {{0}, 0, 0, 0, 0};
    vector_operation o = {.p = p, .b = b, .c = c, .sum = &sum};
    pl_patch_for(p, product_chunk, &o);
    pl_parts_add_sums(&sum, 1);
    return pl_sum_value(&sum);
}

static void combine_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const vector_operation *o = context;
    (void)thread;
    for (int64_t i = begin * o->p->dim; i < end * o->p->dim; i++)
        o->a[i] = (o->b ? o->b[i] : 0) + o->factor * o->c[i];
}

void pl_patch_combine(const pl_patch *p, double *a, const double *b, double factor,
                      const double *c) {
    vector_operation o = {.p = p, .a = a, .b = b, .c = c, .factor = factor};
    pl_patch_for(p, combine_chunk, &o);
}

/** Copy between a vector and an array over all nodes. */
static void copy_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const vector_operation *o = context;
    const int dim = o->p->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t at = i * dim, node = pl_patch_node(o->p, i) * dim;
        memcpy(o->a + (o->to_field ? node : at), o->b + (o->to_field ? at : node),
               (size_t)dim * sizeof *o->a);
    }
}

void pl_patch_take(const pl_patch *p, double *a, const double *field) {
    vector_operation o = {.p = p, .a = a, .b = field};
    pl_patch_for(p, copy_chunk, &o);
}

void pl_patch_put(const pl_patch *p, double *field, const double *a) {
    vector_operation o = {.p = p, .a = field, .b = a, .to_field = 1};
    pl_patch_for(p, copy_chunk, &o);
    pl_ghosts_update(p->run->plan, field, p->dim * (int64_t)sizeof *field);
}

static void admit_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const vector_operation *o = context;
    double *coordinates = o->p->run->plan->scratch.coordinates;
    const int dim = o->p->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t node = pl_patch_node(o->p, i);
        double *x = o->a + i * dim;
        if (!pl_star_admit(o->p->problem, (int32_t)node, dim, x))
            memcpy(x, o->b + i * dim, (size_t)dim * sizeof *x);
        memcpy(coordinates + node * dim, x, (size_t)dim * sizeof *x);
    }
}

void pl_patch_admit(const pl_patch *p, double *x, const double *start) {
    double *coordinates = p->run->plan->scratch.coordinates;
    vector_operation o = {.p = p, .a = x, .b = start};
    pl_patch_for(p, admit_chunk, &o);
    pl_ghosts_update(p->run->plan, coordinates, p->dim * (int64_t)sizeof *coordinates);
}

/* ---- to the mean of the neighbours ---------------------------------------------------------- */

/** Set a to the sum over the neighbours of (b of the node - b of the neighbour); b: an array over
 *  nodes. */
static void difference_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const vector_operation *o = context;
    const pl_stars *stars = &o->p->run->plan->interior.stars;
    const int dim = o->p->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t star = o->p->star[i];
        const double *mine = o->b + pl_patch_node(o->p, i) * dim;
        double sum[3] = {0, 0, 0};
        for (int64_t k = stars->ring_offset[star]; k < stars->ring_offset[star + 1]; k++)
            for (int d = 0; d < dim; d++)
                sum[d] += mine[d] - o->b[(int64_t)stars->ring[k] * dim + d];
        memcpy(o->a + i * dim, sum, (size_t)dim * sizeof *o->a);
    }
}

static void difference(const pl_patch *p, double *a, const double *field) {
    vector_operation o = {.p = p, .a = a, .b = field};
    pl_patch_for(p, difference_chunk, &o);
}

/** Set a to b / number of neighbours. */
static void divide_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const vector_operation *o = context;
    const int64_t *offset = o->p->run->plan->interior.stars.ring_offset;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < o->p->dim; d++)
            o->a[i * o->p->dim + d] = o->b[i * o->p->dim + d] /
                                      (double)(offset[o->p->star[i] + 1] - offset[o->p->star[i]]);
}

static void divide_by_neighbours(const pl_patch *p, double *a, const double *b) {
    vector_operation o = {.p = p, .a = a, .b = b};
    pl_patch_for(p, divide_chunk, &o);
}

/** Solve sum over the neighbours of (x_i - x_j) = 0, preconditioned by the diagonal. All but start
 * is in the scale of the domain. */
void pl_patch_centre(const pl_patch *p, pl_sweep_tally *tally) {
    pl_run *r = p->run;
    const pl_box fixed = pl_box_of_fixed(r->plan);
    double *x = pl_patch_vector(p, 0), *residual = pl_patch_vector(p, 1),
           *z = pl_patch_vector(p, 2), *way = pl_patch_vector(p, 3);
    double *image = pl_patch_vector(p, 4), *start = pl_patch_vector(p, 5);
    pl_patch_take(p, start, r->plan->scratch.coordinates);
    /* Within the box of the fixed nodes: from far away the way back would be lost in rounding. */
    for (int64_t i = 0; i < p->n; i++)
        for (int d = 0; d < p->dim; d++)
            x[i * p->dim + d] = fmin(fmax(start[i * p->dim + d], fixed.lower[d]), fixed.upper[d]);
    pl_patch_put(p, r->plan->scratch.coordinates, x);
    difference(p, residual, r->plan->scratch.coordinates);
    pl_patch_combine(p, x, NULL, fixed.scale, x);
    pl_patch_combine(p, residual, NULL, -fixed.scale, residual);
    divide_by_neighbours(p, z, residual);
    pl_patch_combine(p, way, z, 0, z);
    double square = pl_patch_product(p, residual, z), goal = CENTRED * CENTRED * square;
    for (int i = 0; i < CENTRE_STEPS && square > goal && !tally->stopped; i++) {
        pl_patch_put(p, p->field, way);
        difference(p, image, p->field);
        const double step = square / pl_patch_product(p, way, image), last = square;
        if (!(step > 0) || !(step < INFINITY))
            break;
        pl_patch_combine(p, x, x, step, way);
        pl_patch_combine(p, residual, residual, -step, image);
        divide_by_neighbours(p, z, residual);
        square = pl_patch_product(p, residual, z);
        pl_patch_combine(p, way, z, square / last, way);
        tally->stars.visits += p->n_all;
        tally->stopped = pl_run_ask_all(r, pl_plan_colours(r->plan), p->n);
    }
    pl_patch_combine(p, x, NULL, 1 / fixed.scale, x);
    pl_patch_admit(p, x, start);
}
