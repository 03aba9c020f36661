/* lbfgs: L-BFGS (Nocedal, Mathematics of Computation 35, 1980) over the nodes of a patch. */
#include "improve/lbfgs.h"

#include "base/memory.h"
#include "star/kernel_direction.h"

#include <math.h>
#include <string.h>

enum { BACKTRACKS = 20 };
/* Sufficient decrease. */
#define ARMIJO 1e-4
/* A pair whose curvature is below this, relative, is forgotten. */
#define CURVATURE_LEAST 1e-10

static void slope_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const pl_lbfgs *m = context;
    const int dim = m->p.dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < dim; d++)
            m->gradient[i * dim + d] = m->slope[m->p.star[i]].gradient[d];
}

/** Compute the value where the nodes are, and the gradient if it is at most enough. */
static void evaluate(pl_lbfgs *m, double enough) {
    m->value = m->function(m->context, enough, m->slope);
    m->evaluations++;
    if (m->value <= enough)
        pl_patch_for(&m->p, slope_chunk, m);
}

void pl_lbfgs_begin(pl_lbfgs *m) {
    m->n_pairs = 0;
    evaluate(m, INFINITY);
}

/** Set direction to B^-1 direction; B: the nodes' own Hessians. */
static void precondition_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const pl_lbfgs *m = context;
    const int dim = m->p.dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double *v = m->direction + i * dim, y[3];
        factors f = {.pivot = {0}};
        if (!factorise_shifted(m->slope[m->p.star[i]].hessian, &f, dim)) {
            memset(v, 0, (size_t)dim * sizeof *v);
            continue;
        }
        substitute_forward(&f, v, y, dim);
        substitute_back(&f, y, v, dim);
    }
}

static const pl_lbfgs_pair *pair_of(const pl_lbfgs *m, int age) {
    return &m->pairs[(m->newest + PL_LBFGS_SLOTS - age) % PL_LBFGS_SLOTS];
}

static void find_direction(pl_lbfgs *m) {
    const pl_patch *p = &m->p;
    double weight[PL_LBFGS_PAIRS], *d = m->direction;
    pl_patch_combine(p, d, m->gradient, -2, m->gradient);
    for (int i = 0; i < m->n_pairs; i++) {
        weight[i] = pl_patch_product(p, pair_of(m, i)->s, d) / pair_of(m, i)->sy;
        pl_patch_combine(p, d, d, -weight[i], pair_of(m, i)->y);
    }
    pl_patch_for(p, precondition_chunk, m);
    for (int i = m->n_pairs - 1; i >= 0; i--) {
        const double change = pl_patch_product(p, pair_of(m, i)->y, d) / pair_of(m, i)->sy;
        pl_patch_combine(p, d, d, weight[i] - change, pair_of(m, i)->s);
    }
}

/** Remember the last step and what it did to the gradient, unless its curvature is next to 0. */
static void remember(pl_lbfgs *m) {
    const pl_patch *p = &m->p;
    const int at = (m->newest + 1) % PL_LBFGS_SLOTS;
    pl_lbfgs_pair *q = &m->pairs[at];
    pl_patch_combine(p, q->s, m->position, -1, m->start);
    pl_patch_combine(p, q->y, m->gradient, -1, m->last_gradient);
    q->sy = pl_patch_product(p, q->s, q->y);
    if (!(q->sy > CURVATURE_LEAST *
                      sqrt(pl_patch_product(p, q->s, q->s) * pl_patch_product(p, q->y, q->y))))
        return;
    m->newest = at;
    m->n_pairs += m->n_pairs < PL_LBFGS_PAIRS;
}

int pl_lbfgs_iterate(pl_lbfgs *m, pl_sweep_tally *tally) {
    pl_run *r = m->p.run;
    const double before = m->value;
    double step = 1;
    find_direction(m);
    const double slope = pl_patch_product(&m->p, m->gradient, m->direction);
    pl_patch_take(&m->p, m->start, r->plan->scratch.coordinates);
    pl_patch_combine(&m->p, m->last_gradient, m->gradient, 0, m->gradient);
    for (int i = 0; slope < 0 && i < BACKTRACKS && !tally->stopped; i++) {
        const double enough = before + ARMIJO * slope * step;
        pl_patch_combine(&m->p, m->position, m->start, step, m->direction);
        pl_patch_admit(&m->p, m->position, m->start);
        evaluate(m, enough);
        tally->stars.visits += m->p.n_all;
        tally->stopped = pl_run_ask_all(r, tally->colours, m->p.n);
        if (m->value < enough) {
            remember(m);
            return 1;
        }
        const double rise = m->value - before - slope * step;
        const double next = rise < INFINITY ? -0.5 * slope * step * step / rise : 0;
        step = fmin(fmax(next, 0.1 * step), 0.5 * step);
    }
    pl_patch_put(&m->p, r->plan->scratch.coordinates, m->start);
    evaluate(m, INFINITY);
    return 0;
}

int pl_lbfgs_create(pl_run *run, const pl_star_problem *problem, const uint8_t *in_patch,
                    pl_lbfgs_function *function, void *context, pl_lbfgs *m) {
    double **vectors[] = {&m->start, &m->position, &m->gradient, &m->direction, &m->last_gradient};
    enum { N = sizeof vectors / sizeof *vectors };
    *m = (pl_lbfgs){.function = function,
                    .context = context,
                    .slope = pl_alloc(run->plan->interior.stars.n_stars, sizeof *m->slope)};
    if (!pl_patch_create(run, problem, in_patch, N + 2 * PL_LBFGS_SLOTS, &m->p) || !m->slope)
        return 0;
    for (int i = 0; i < N; i++)
        *vectors[i] = pl_patch_vector(&m->p, i);
    for (int i = 0; i < PL_LBFGS_SLOTS; i++)
        m->pairs[i] = (pl_lbfgs_pair){pl_patch_vector(&m->p, N + 2 * i),
                                      pl_patch_vector(&m->p, N + 2 * i + 1), 0};
    return 1;
}

void pl_lbfgs_destroy(pl_lbfgs *m) {
    pl_patch_destroy(&m->p);
    pl_free(m->slope);
}
