/* patch: all nodes of a patch at once.
 *
 * Sweeps move one node at a time and even out what is wrong within a few elements; where much is
 * tangled, or a boundary has moved far, all nodes have to give way together. Vectors are over the
 * patch's nodes in visiting order, [n][dim]; sums are of fixed chunks, so that the bits do not
 * depend on the threads.
 */
#include "sweep/tangle.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "star/direction.h"

#include <math.h>
#include <string.h>

enum {
    CHUNK = 256, /* nodes, or stars */
    HISTORY = 12 /* pairs of L-BFGS */
};

/** A patch; arrays are owned. */
typedef struct patch {
    pl_tangle *t;
    int dim;
    int64_t n;
    int32_t *star;   /* [n] */
    double *vectors; /* what the caller of patch_create asked for */
    double *field;   /* [n_nodes][dim] by inner numbers, 0 outside of the patch */
    double *partial; /* [chunks] */
} patch;

static int patch_create(pl_tangle *t, int n_vectors, patch *p) {
    const planish_plan *plan = t->run->plan;
    *p = (patch){.t = t, .dim = plan->dim, .n = t->n_patch};
    p->star = pl_alloc(p->n, sizeof *p->star);
    p->vectors = pl_alloc_zero(p->n * p->dim * n_vectors, sizeof *p->vectors);
    p->field = pl_alloc_zero(plan->n_nodes * p->dim, sizeof *p->field);
    p->partial = pl_alloc(p->n / CHUNK + 1, sizeof *p->partial);
    if (!p->star || !p->vectors || !p->field || !p->partial)
        return 0;
    for (int64_t s = 0, i = 0; s < plan->stars.n_stars; s++)
        if (t->in_patch[plan->centre[s]])
            p->star[i++] = (int32_t)s;
    return 1;
}

static void patch_destroy(patch *p) {
    pl_free(p->star);
    pl_free(p->vectors);
    pl_free(p->field);
    pl_free(p->partial);
}

static double *vector(const patch *p, int i) {
    return p->vectors + p->n * p->dim * i;
}

static int64_t node_of(const patch *p, int64_t i) {
    return p->t->run->plan->centre[p->star[i]];
}

/* ---- vectors ------------------------------------------------------------------------------- */

/** An operation on vectors under way. */
typedef struct operation {
    const patch *p;
    double *a;
    const double *b, *c;
    double factor;
} operation;

static double product_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    double sum = 0;
    (void)thread;
    for (int64_t i = begin * o->p->dim; i < end * o->p->dim; i++)
        sum += o->b[i] * o->c[i];
    return sum;
}

static double product(const patch *p, const double *b, const double *c) {
    operation o = {p, NULL, b, c, 0};
    return pl_parallel_sum(p->t->run->plan->threads, p->n, CHUNK, product_chunk, &o, p->partial);
}

static void combine_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    (void)thread;
    for (int64_t i = begin * o->p->dim; i < end * o->p->dim; i++)
        o->a[i] = o->b[i] + o->factor * o->c[i];
}

/** a = b + factor c. */
static void combine(const patch *p, double *a, const double *b, double factor, const double *c) {
    operation o = {p, a, b, c, factor};
    pl_parallel_for(p->t->run->plan->threads, p->n, CHUNK, combine_chunk, &o);
}

static void take_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    const int dim = o->p->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        memcpy(o->a + i * dim, o->b + node_of(o->p, i) * dim, (size_t)dim * sizeof *o->a);
}

/** a from an array over nodes. */
static void take(const patch *p, double *a, const double *field) {
    operation o = {p, a, field, NULL, 0};
    pl_parallel_for(p->t->run->plan->threads, p->n, CHUNK, take_chunk, &o);
}

static void put_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    const int dim = o->p->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        memcpy(o->a + node_of(o->p, i) * dim, o->b + i * dim, (size_t)dim * sizeof *o->a);
}

/** An array over nodes from a. */
static void put(const patch *p, double *field, const double *a) {
    operation o = {p, field, a, NULL, 0};
    pl_parallel_for(p->t->run->plan->threads, p->n, CHUNK, put_chunk, &o);
}

/* ---- centre -------------------------------------------------------------------------------- */

/* Conjugate gradients end when the residual has fallen to this fraction, or after so many steps. */
#define CENTRED 1e-4
enum { CENTRE_STEPS = 1000 };

/** a = sum over the neighbours of (b of the node - b of the neighbour), b an array over nodes. */
static void difference_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    const pl_stars *stars = &o->p->t->run->plan->stars;
    const int dim = o->p->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t star = o->p->star[i];
        const double *mine = o->b + node_of(o->p, i) * dim;
        double sum[3] = {0, 0, 0};
        for (int64_t k = stars->ring_offset[star]; k < stars->ring_offset[star + 1]; k++)
            for (int d = 0; d < dim; d++)
                sum[d] += mine[d] - o->b[(int64_t)stars->ring[k] * dim + d];
        memcpy(o->a + i * dim, sum, (size_t)dim * sizeof *o->a);
    }
}

static void difference(const patch *p, double *a, const double *field) {
    operation o = {p, a, field, NULL, 0};
    pl_parallel_for(p->t->run->plan->threads, p->n, CHUNK, difference_chunk, &o);
}

/** a = b / number of neighbours. */
static void share_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    const int64_t *offset = o->p->t->run->plan->stars.ring_offset;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < o->p->dim; d++)
            o->a[i * o->p->dim + d] = o->b[i * o->p->dim + d] /
                                      (double)(offset[o->p->star[i] + 1] - offset[o->p->star[i]]);
}

static void share(const patch *p, double *a, const double *b) {
    operation o = {p, a, b, NULL, 0};
    pl_parallel_for(p->t->run->plan->threads, p->n, CHUNK, share_chunk, &o);
}

/** Solve sum over the neighbours of (x_i - x_j) = 0, preconditioned by the diagonal. */
static int centre(const patch *p, pl_sweep_tally *tally) {
    pl_run *r = p->t->run;
    double *x = vector(p, 0), *residual = vector(p, 1), *z = vector(p, 2), *way = vector(p, 3);
    double *image = vector(p, 4);
    take(p, x, r->plan->coordinates);
    difference(p, residual, r->plan->coordinates);
    combine(p, residual, image, -1, residual); /* image is still 0 */
    share(p, z, residual);
    combine(p, way, z, 0, z);
    double square = product(p, residual, z), goal = CENTRED * CENTRED * square;
    for (int i = 0; i < CENTRE_STEPS && square > goal && !tally->stopped; i++) {
        put(p, p->field, way);
        difference(p, image, p->field);
        const double step = square / product(p, way, image), last = square;
        if (!(step > 0) || !(step < INFINITY))
            break;
        combine(p, x, x, step, way);
        combine(p, residual, residual, -step, image);
        share(p, z, residual);
        square = product(p, residual, z);
        combine(p, way, z, square / last, way);
        tally->visits += p->n;
        tally->stopped = pl_run_after_colour(r, r->plan->n_colours);
    }
    put(p, r->plan->coordinates, x);
    return tally->stopped;
}

int pl_patch_centre(pl_tangle *t) {
    pl_run *r = t->run;
    patch p;
    int stopped = 0;
    if (patch_create(t, 5, &p)) {
        pl_sweep_tally tally = {.colours = r->plan->n_colours};
        pl_begin_untangling_sweep(r);
        centre(&p, &tally);
        if (!tally.stopped) { /* once more node by node, which keeps the bounds */
            t->asked.to_centre = 1;
            const pl_sweep_tally last =
                pl_sweep(r->plan, &t->problem, PLANISH_METHOD_PLANISH, pl_run_after_colour, r);
            t->asked.to_centre = 0;
            tally.visits += last.visits;
            tally.stopped = last.stopped;
        }
        pl_run_measure(r);
        stopped = pl_run_end_sweep(r, &tally);
    }
    patch_destroy(&p);
    return stopped;
}

/* ---- L-BFGS -------------------------------------------------------------------------------- */

/** How long to try. */
typedef struct patience {
    double first_epsilon; /* at least, relative to what is inverted most */
    int epsilons;         /* at most */
    int iterations;       /* for each, at most; or until */
    double calm_fall;     /* some in a row have brought no more than this, relative */
} patience;

static const patience PATIENCE[] = {
    [PL_QUICK] = {0, 100, 100, 1e-4},
    [PL_PATIENT] = {1, 200, 1000, 1e-6}, /* meets shears of ten times the width of the domain */
};
enum { CALM_ITERATIONS = 3, BACKTRACKS = 20 };
/* In all, nodes times iterations are at most the first, but iterations at least the second. */
enum { MOST_VISITS = 300000000, LEAST_ITERATIONS = 1000 };
/* Sufficient decrease. */
#define ARMIJO 1e-4
/* An epsilon this far below what is still inverted helps no more. */
#define EPSILON_IN_VAIN 1e-3
/* Mending ends when an iteration brings less than this. */
enum { MENDING_ITERATIONS = 500 };
#define MENDING_FALL    1e-4
#define MENDING_EPSILON 1e-6
/* A pair whose curvature is below this, relative, is forgotten. */
#define CURVATURE_LEAST 1e-10

/** A step s and what it did to the gradient, y. */
typedef struct pair {
    double *s, *y;
    double sy; /* s . y */
} pair;

/** The minimisation (Nocedal 1980), with the nodes' own Hessians as the first guess. */
typedef struct descent {
    patch p;
    double *start, *position, *gradient, *direction, *last_gradient;
    pl_star_slope *slope; /* [n_stars] */
    pair pairs[HISTORY];
    int n_pairs, newest;
    int keep;     /* nothing may become tangled again */
    int64_t left; /* iterations */
} descent;

static void energy_chunk(void *context, int64_t begin, int64_t end, int thread) {
    descent *m = context;
    const planish_plan *plan = m->p.t->run->plan;
    m->p.t->partial[begin / CHUNK] = plan->kernel->guarded->energy[plan->dim - 2](
        &m->p.t->problem, begin, end, plan->scratch + plan->scratch_stride * thread,
        m->slope + begin);
}

static void slope_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const descent *m = context;
    const int dim = m->p.dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < dim; d++)
            m->gradient[i * dim + d] = m->slope[m->p.star[i]].gradient[d];
}

/** Energy and slopes where the nodes are. */
static void evaluate(descent *m) {
    pl_tangle *t = m->p.t;
    const planish_plan *plan = t->run->plan;
    pl_parallel_for(plan->threads, plan->stars.n_stars, CHUNK, energy_chunk, m);
    pl_tangle_total(t, (plan->stars.n_stars + CHUNK - 1) / CHUNK);
    pl_parallel_for(plan->threads, m->p.n, CHUNK, slope_chunk, m);
}

/** direction = B^-1 direction, B the nodes' own Hessians. */
static void precondition_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const descent *m = context;
    const int dim = m->p.dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double *v = m->direction + i * dim, y[3];
        factors f = {{{0}}, {0}};
        if (!factorise_shifted(m->slope[m->p.star[i]].hessian, &f, dim)) {
            memset(v, 0, (size_t)dim * sizeof *v);
            continue;
        }
        substitute_forward(&f, v, y, dim);
        substitute_back(&f, y, v, dim);
    }
}

static const pair *pair_of(const descent *m, int age) {
    return &m->pairs[(m->newest + HISTORY - age) % HISTORY];
}

static void find_direction(descent *m) {
    const patch *p = &m->p;
    double weight[HISTORY], *d = m->direction;
    combine(p, d, m->gradient, -2, m->gradient);
    for (int i = 0; i < m->n_pairs; i++) {
        weight[i] = product(p, pair_of(m, i)->s, d) / pair_of(m, i)->sy;
        combine(p, d, d, -weight[i], pair_of(m, i)->y);
    }
    pl_parallel_for(p->t->run->plan->threads, p->n, CHUNK, precondition_chunk, m);
    for (int i = m->n_pairs - 1; i >= 0; i--) {
        const double change = product(p, pair_of(m, i)->y, d) / pair_of(m, i)->sy;
        combine(p, d, d, weight[i] - change, pair_of(m, i)->s);
    }
}

static void remember(descent *m) {
    const patch *p = &m->p;
    const int at = m->n_pairs > 0 ? (m->newest + 1) % HISTORY : 0;
    pair *q = &m->pairs[at];
    combine(p, q->s, m->position, -1, m->start);
    combine(p, q->y, m->gradient, -1, m->last_gradient);
    q->sy = product(p, q->s, q->y);
    if (!(q->sy > CURVATURE_LEAST * sqrt(product(p, q->s, q->s) * product(p, q->y, q->y))))
        return;
    m->newest = at;
    m->n_pairs += m->n_pairs < HISTORY;
}

static void place_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const descent *m = context;
    const pl_tangle *t = m->p.t;
    const int dim = m->p.dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t node = node_of(&m->p, i);
        double *x = m->position + i * dim;
        if (!pl_star_admit(&t->problem, (int32_t)node, dim, x))
            memcpy(x, m->start + i * dim, (size_t)dim * sizeof *x);
        memcpy(t->run->plan->coordinates + node * dim, x, (size_t)dim * sizeof *x);
    }
}

/** Put the nodes step along the direction from start, but not out of their bounds. */
static void place(descent *m, double step) {
    combine(&m->p, m->position, m->start, step, m->direction);
    pl_parallel_for(m->p.t->run->plan->threads, m->p.n, CHUNK, place_chunk, m);
}

/** One iteration; 0 if the energy could not be lowered. */
static int iterate(descent *m, pl_sweep_tally *tally) {
    pl_tangle *t = m->p.t;
    const double before = t->energy.sum;
    double step = 1;
    find_direction(m);
    const double slope = product(&m->p, m->gradient, m->direction);
    take(&m->p, m->start, t->run->plan->coordinates);
    combine(&m->p, m->last_gradient, m->gradient, 0, m->gradient);
    for (int i = 0; slope < 0 && i < BACKTRACKS; i++) {
        place(m, step);
        evaluate(m);
        tally->visits += m->p.n;
        const double after = m->keep && t->energy.tangled > 0 ? INFINITY : t->energy.sum;
        if (after < before + ARMIJO * slope * step) {
            remember(m);
            return 1;
        }
        const double rise = after - before - slope * step;
        const double next = rise < INFINITY ? -0.5 * slope * step * step / rise : 0;
        step = fmin(fmax(next, 0.1 * step), 0.5 * step);
    }
    place(m, 0);
    evaluate(m);
    return 0;
}

/** Iterations with one epsilon, as one sweep; not 0 if cut short. */
static int descend(descent *m, int most, double calm_fall) {
    pl_tangle *t = m->p.t;
    pl_run *r = t->run;
    pl_sweep_tally tally = {.colours = r->plan->n_colours};
    int calm = 0;
    m->n_pairs = 0;
    pl_begin_untangling_sweep(r);
    for (int i = 0; i < most && m->left > 0 && calm < CALM_ITERATIONS && !tally.stopped; i++) {
        const double before = t->energy.sum;
        if ((!m->keep && t->energy.tangled == 0) || !iterate(m, &tally))
            break;
        calm = t->energy.sum > (1 - calm_fall) * before ? calm + 1 : 0;
        m->left--;
        tally.stopped = pl_run_after_colour(r, tally.colours);
    }
    tally.evaluations = tally.visits;
    pl_run_measure(r);
    return pl_run_end_sweep(r, &tally);
}

static int solve(descent *m, const patience *how) {
    pl_tangle *t = m->p.t;
    int stopped = 0;
    t->asked.epsilon = 1;
    evaluate(m);
    t->asked.epsilon =
        fmax(pl_first_epsilon(t->energy.least), -how->first_epsilon * t->energy.least);
    evaluate(m);
    for (int i = 0; i < how->epsilons && t->energy.tangled > 0 && m->left > 0; i++) {
        const double before = t->energy.sum;
        stopped = descend(m, how->iterations, how->calm_fall);
        if (stopped || t->asked.epsilon < -EPSILON_IN_VAIN * t->energy.least)
            return stopped;
        t->asked.epsilon =
            pl_next_epsilon(t->asked.epsilon, before, t->energy.sum, t->energy.least);
        evaluate(m);
    }
    return 0;
}

static int descent_create(pl_tangle *t, descent *m) {
    double **vectors[] = {&m->start, &m->position, &m->gradient, &m->direction, &m->last_gradient};
    enum { N = sizeof vectors / sizeof *vectors };
    *m = (descent){.slope = pl_alloc(t->run->plan->stars.n_stars, sizeof *m->slope)};
    if (!patch_create(t, N + 2 * HISTORY, &m->p) || !m->slope)
        return 0;
    for (int i = 0; i < N; i++)
        *vectors[i] = vector(&m->p, i);
    for (int i = 0; i < HISTORY; i++)
        m->pairs[i] = (pair){vector(&m->p, N + 2 * i), vector(&m->p, N + 2 * i + 1), 0};
    m->left = MOST_VISITS / m->p.n;
    m->left = m->left > LEAST_ITERATIONS ? m->left : LEAST_ITERATIONS;
    return 1;
}

static void descent_destroy(descent *m) {
    patch_destroy(&m->p);
    pl_free(m->slope);
}

int pl_patch_solve(pl_tangle *t, pl_patience wanted) {
    descent m;
    int stopped = 0;
    if (descent_create(t, &m))
        stopped = solve(&m, &PATIENCE[wanted]);
    descent_destroy(&m);
    return stopped;
}

int pl_patch_mend(pl_tangle *t) {
    descent m;
    int stopped = 0;
    if (descent_create(t, &m)) {
        m.keep = 1;
        t->asked.epsilon = fmax(t->energy.least, MENDING_EPSILON);
        evaluate(&m);
        stopped = descend(&m, MENDING_ITERATIONS, MENDING_FALL);
    }
    descent_destroy(&m);
    return stopped;
}
