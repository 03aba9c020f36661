/* mixing: Anderson's acceleration, by normal equations. */
#include "improve/mixing.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/sum.h"

#include <math.h>

enum { CHUNK = 8192, DEPTH = PL_MIXING_DEPTH };

/* What is added to the diagonal, relative: steps may be nearly parallel. */
#define SHIFT 1e-10

int pl_mixing_create(int64_t n, int threads, pl_mixing *m) {
    *m = (pl_mixing){.n = n, .threads = threads};
    m->room = pl_alloc(n * (2 * DEPTH + 2), sizeof *m->room);
    if (!m->room)
        return 0;
    m->residual = m->room;
    m->end = m->room + n;
    for (int i = 0; i < DEPTH; i++) {
        m->d_residual[i] = m->room + (2 * i + 2) * n;
        m->d_end[i] = m->room + (2 * i + 3) * n;
    }
    return 1;
}

void pl_mixing_destroy(pl_mixing *m) {
    pl_free(m->room);
}

void pl_mixing_forget(pl_mixing *m) {
    m->n_steps = m->n_pairs = m->next = 0;
}

/* ---- vectors ----------------------------------------------------------------------------------- */

/** A step being noted. */
typedef struct noting {
    pl_mixing *m;
    const double *x;
    const double *end;
} noting;

static void note_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const noting *s = context;
    pl_mixing *m = s->m;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const double residual = s->end[i] - s->x[i];
        if (m->n_steps > 0) {
            m->d_residual[m->next][i] = residual - m->residual[i];
            m->d_end[m->next][i] = s->end[i] - m->end[i];
        }
        m->residual[i] = residual;
        m->end[i] = s->end[i];
    }
}

/** Product under way. */
typedef struct product {
    const double *a, *b;
    pl_sum sum; /* shared */
} product;

static void product_chunk(void *context, int64_t begin, int64_t end, int thread) {
    product *p = context;
    pl_sum sum = {.n_added = 0};
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        pl_sum_add(&sum, p->a[i] * p->b[i]);
    pl_sum_merge(&p->sum, &sum);
}

/** Scalar product, the same for any number of threads. */
static double multiply(const pl_mixing *m, const double *a, const double *b) {
    product p = {a, b, {.n_added = 0}};
    pl_parallel_for(m->threads, m->n, CHUNK, product_chunk, &p);
    return pl_sum_value(&p.sum);
}

/** Combination under way. */
typedef struct combination {
    const pl_mixing *m;
    const double *weight;
    double *end;
} combination;

static void combine_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const combination *c = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int k = 0; k < c->m->n_pairs; k++)
            c->end[i] -= c->weight[k] * c->m->d_end[k][i];
}

/* ---- least squares ----------------------------------------------------------------------------- */

/** Solve a w = b of order n by Gauss's elimination; a is symmetric and, with SHIFT, positive. 0 if it is
 *  not. */
static int solve(int n, double a[DEPTH][DEPTH], double w[DEPTH]) {
    for (int k = 0; k < n; k++) {
        if (!(a[k][k] > 0))
            return 0;
        for (int i = k + 1; i < n; i++) {
            const double f = a[i][k] / a[k][k];
            for (int j = k; j < n; j++)
                a[i][j] -= f * a[k][j];
            w[i] -= f * w[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++)
            w[k] -= a[k][j] * w[j];
        w[k] /= a[k][k];
    }
    return 1;
}

/** Find the weights of the pairs; 0: they tell nothing. */
static int find_weights(const pl_mixing *m, double weight[DEPTH]) {
    double a[DEPTH][DEPTH];
    for (int i = 0; i < m->n_pairs; i++) {
        weight[i] = multiply(m, m->d_residual[i], m->residual);
        for (int j = 0; j < m->n_pairs; j++)
            a[i][j] = m->product[i][j] * (i == j ? 1 + SHIFT : 1);
    }
    return m->n_pairs > 0 && solve(m->n_pairs, a, weight);
}

int pl_mixing_mix(pl_mixing *m, const double *x, double *end) {
    noting s = {m, x, end};
    pl_parallel_for(m->threads, m->n, CHUNK, note_chunk, &s);
    if (m->n_steps++ > 0) {
        m->n_pairs += m->n_pairs < DEPTH;
        for (int i = 0; i < m->n_pairs; i++)
            m->product[m->next][i] = m->product[i][m->next] =
                multiply(m, m->d_residual[m->next], m->d_residual[i]);
        m->next = (m->next + 1) % DEPTH;
    }
    double weight[DEPTH];
    if (!find_weights(m, weight))
        return 0;
    combination c = {m, weight, end};
    pl_parallel_for(m->threads, m->n, CHUNK, combine_chunk, &c);
    return 1;
}
