/* patch: vectors over the nodes of a patch. */
#include "improve/patch.h"

#include "base/memory.h"
#include "base/parts.h"

#include <string.h>

int pl_patch_create(pl_run *run, const pl_star_problem *problem, const uint8_t *in_patch,
                    int n_vectors, pl_patch *p) {
    const planish_plan *plan = run->plan;
    const int64_t n_stars = plan->interior.stars.n_stars;
    *p = (pl_patch){.run = run, .problem = problem, .dim = plan->dim};
    for (int64_t s = 0; s < n_stars; s++)
        p->n += !in_patch || in_patch[plan->interior.centre[s]];
    p->star = pl_alloc(p->n, sizeof *p->star);
    p->vectors = pl_alloc_zero(p->n * p->dim * n_vectors, sizeof *p->vectors);
    p->field = pl_alloc_zero(plan->work.n_nodes * p->dim, sizeof *p->field);
    if (!p->star || !p->vectors || !p->field)
        return 0;
    for (int64_t s = 0, i = 0; s < n_stars; s++)
        if (!in_patch || in_patch[plan->interior.centre[s]])
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
    pl_parallel_for(p->run->plan->threads, p->n, PL_PATCH_CHUNK, body, context);
}

/** An operation on vectors under way. */
typedef struct operation {
    const pl_patch *p;
    double *a;
    const double *b, *c;
    double factor;
    pl_sum *sum; /* shared */
} operation;

static void product_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    const int dim = o->p->dim;
    pl_sum sum = {{0}, 0, 0, 0, 0};
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double of_node = 0;
        for (int d = 0; d < dim; d++)
            of_node += o->b[i * dim + d] * o->c[i * dim + d];
        pl_sum_add(&sum, of_node);
    }
    pl_sum_share(o->sum, &sum);
}

double pl_patch_product(const pl_patch *p, const double *b, const double *c) {
    pl_sum sum = {{0}, 0, 0, 0, 0};
    operation o = {p, NULL, b, c, 0, &sum};
    pl_patch_for(p, product_chunk, &o);
    pl_parts_add_sums(&sum, 1);
    return pl_sum_value(&sum);
}

static void combine_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    (void)thread;
    for (int64_t i = begin * o->p->dim; i < end * o->p->dim; i++)
        o->a[i] = o->b[i] + o->factor * o->c[i];
}

void pl_patch_combine(const pl_patch *p, double *a, const double *b, double factor,
                      const double *c) {
    operation o = {p, a, b, c, factor, NULL};
    pl_patch_for(p, combine_chunk, &o);
}

static void scale_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    (void)thread;
    for (int64_t i = begin * o->p->dim; i < end * o->p->dim; i++)
        o->a[i] = 0 + o->factor * o->b[i];
}

void pl_patch_scale(const pl_patch *p, double *a, double factor, const double *b) {
    operation o = {p, a, b, NULL, factor, NULL};
    pl_patch_for(p, scale_chunk, &o);
}

static void take_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    const int dim = o->p->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        memcpy(o->a + i * dim, o->b + pl_patch_node(o->p, i) * dim, (size_t)dim * sizeof *o->a);
}

void pl_patch_take(const pl_patch *p, double *a, const double *field) {
    operation o = {p, a, field, NULL, 0, NULL};
    pl_patch_for(p, take_chunk, &o);
}

static void update_ghosts(const pl_patch *p, double *field) {
    pl_ghosts_update(p->run->plan, field, p->dim * (int64_t)sizeof *field);
}

static void put_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    const int dim = o->p->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        memcpy(o->a + pl_patch_node(o->p, i) * dim, o->b + i * dim, (size_t)dim * sizeof *o->a);
}

void pl_patch_put(const pl_patch *p, double *field, const double *a) {
    operation o = {p, field, a, NULL, 0, NULL};
    pl_patch_for(p, put_chunk, &o);
    update_ghosts(p, field);
}

static void admit_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    double *coordinates = o->p->run->plan->coordinates;
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
    operation o = {p, x, start, NULL, 0, NULL};
    pl_patch_for(p, admit_chunk, &o);
    update_ghosts(p, p->run->plan->coordinates);
}
