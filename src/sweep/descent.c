/* descent: lower the regularised energy of a patch by L-BFGS (Nocedal 1980), with the nodes' own
 * Hessians as the first guess of the inverse one. */
#include "sweep/patch.h"

#include "base/memory.h"
#include "star/direction.h"

#include <math.h>
#include <string.h>

enum { HISTORY = 12, SLOTS = HISTORY + 1 }; /* pairs; one slot more is for one that is on trial */

/** How long to try. */
typedef struct patience {
    double first_epsilon; /* at least, relative to what is inverted most */
    int epsilons;         /* at most */
    int iterations;       /* for each, at most; or until */
    double calm_fall;     /* some in a row have brought no more than this, relative */
    double visits;        /* of link facets, in all: some 2e7 a second on one core */
} patience;

static const patience PATIENCE[] = {
    [PL_QUICK] = {0, 100, 100, 1e-4, 1e8},
    [PL_PATIENT] = {1, 200, 1000, 1e-6, 1.5e9}, /* meets shears of ten times a domain's width */
};
enum { CALM_ITERATIONS = 3, BACKTRACKS = 20 };
/* However large the patch, it gets so many evaluations. */
enum { LEAST_EVALUATIONS = 100 };
/* Sufficient decrease. */
#define ARMIJO 1e-4
/* An epsilon this far below what is still inverted helps no more. */
#define EPSILON_IN_VAIN 0.02
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

/** The minimisation under way. */
typedef struct descent {
    pl_patch p;
    double *start, *position, *gradient, *direction, *last_gradient;
    pl_star_slope *slope; /* [n_stars] */
    pair pairs[SLOTS];
    int n_pairs, newest;
    int keep;     /* nothing may become tangled again */
    int64_t left; /* evaluations */
} descent;

static void energy_chunk(void *context, int64_t begin, int64_t end, int thread) {
    descent *m = context;
    const planish_plan *plan = m->p.t->run->plan;
    m->p.t->partial[begin / PL_TANGLE_CHUNK] = plan->kernel->guarded->energy[plan->dim - 2](
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
    pl_parallel_for(plan->threads, plan->stars.n_stars, PL_TANGLE_CHUNK, energy_chunk, m);
    pl_tangle_total(t, (plan->stars.n_stars + PL_TANGLE_CHUNK - 1) / PL_TANGLE_CHUNK);
    pl_patch_for(&m->p, slope_chunk, m);
}

/** direction = B^-1 direction, B the nodes' own Hessians. */
static void precondition_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const descent *m = context;
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

static const pair *pair_of(const descent *m, int age) {
    return &m->pairs[(m->newest + SLOTS - age) % SLOTS];
}

static void find_direction(descent *m) {
    const pl_patch *p = &m->p;
    double weight[HISTORY], *d = m->direction;
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

static void remember(descent *m) {
    const pl_patch *p = &m->p;
    const int at = (m->newest + 1) % SLOTS;
    pair *q = &m->pairs[at];
    pl_patch_combine(p, q->s, m->position, -1, m->start);
    pl_patch_combine(p, q->y, m->gradient, -1, m->last_gradient);
    q->sy = pl_patch_product(p, q->s, q->y);
    if (!(q->sy > CURVATURE_LEAST *
                      sqrt(pl_patch_product(p, q->s, q->s) * pl_patch_product(p, q->y, q->y))))
        return;
    m->newest = at;
    m->n_pairs += m->n_pairs < HISTORY;
}

/** Put the nodes step along the direction from start, but not out of their bounds. */
static void place(descent *m, double step) {
    pl_patch_combine(&m->p, m->position, m->start, step, m->direction);
    pl_patch_admit(&m->p, m->position, m->start);
}

/** One iteration; 0 if the energy could not be lowered. */
static int iterate(descent *m, pl_sweep_tally *tally) {
    pl_tangle *t = m->p.t;
    const double before = t->energy.sum;
    double step = 1;
    find_direction(m);
    const double slope = pl_patch_product(&m->p, m->gradient, m->direction);
    pl_patch_take(&m->p, m->start, t->run->plan->coordinates);
    pl_patch_combine(&m->p, m->last_gradient, m->gradient, 0, m->gradient);
    for (int i = 0; slope < 0 && i < BACKTRACKS && !tally->stopped; i++) {
        place(m, step);
        evaluate(m);
        m->left--;
        tally->visits += m->p.n;
        tally->stopped = pl_run_after_colour(t->run, tally->colours);
        const double after = m->keep && t->energy.tangled > 0 ? INFINITY : t->energy.sum;
        if (after < before + ARMIJO * slope * step) {
            remember(m);
            return 1;
        }
        const double rise = after - before - slope * step;
        const double next = rise < INFINITY ? -0.5 * slope * step * step / rise : 0;
        step = fmin(fmax(next, 0.1 * step), 0.5 * step);
    }
    pl_patch_combine(&m->p, m->position, m->start, 0, m->start);
    pl_patch_admit(&m->p, m->position, m->start);
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
    if (!pl_patch_create(t, N + 2 * SLOTS, &m->p) || !m->slope)
        return 0;
    for (int i = 0; i < N; i++)
        *vectors[i] = pl_patch_vector(&m->p, i);
    for (int i = 0; i < SLOTS; i++)
        m->pairs[i] =
            (pair){pl_patch_vector(&m->p, N + 2 * i), pl_patch_vector(&m->p, N + 2 * i + 1), 0};
    return 1;
}

/** How many evaluations of so many visits in all. */
static int64_t evaluations_of(const descent *m, double visits) {
    const pl_stars *stars = &m->p.t->run->plan->stars;
    double facets = 1;
    for (int64_t i = 0; i < m->p.n; i++)
        facets += (double)(stars->link_offset[m->p.star[i] + 1] - stars->link_offset[m->p.star[i]]);
    return (int64_t)fmax(visits / facets, LEAST_EVALUATIONS);
}

static void descent_destroy(descent *m) {
    pl_patch_destroy(&m->p);
    pl_free(m->slope);
}

int pl_patch_solve(pl_tangle *t, pl_patience wanted) {
    descent m;
    int stopped = 0;
    if (descent_create(t, &m)) {
        m.left = evaluations_of(&m, PATIENCE[wanted].visits);
        stopped = solve(&m, &PATIENCE[wanted]);
    }
    descent_destroy(&m);
    return stopped;
}

int pl_patch_mend(pl_tangle *t) {
    descent m;
    int stopped = 0;
    if (descent_create(t, &m)) {
        m.keep = 1;
        m.left = evaluations_of(&m, PATIENCE[PL_QUICK].visits);
        t->asked.epsilon = fmax(t->energy.least, MENDING_EPSILON);
        evaluate(&m);
        stopped = descend(&m, MENDING_ITERATIONS, MENDING_FALL);
    }
    descent_destroy(&m);
    return stopped;
}
