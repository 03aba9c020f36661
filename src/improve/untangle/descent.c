/* descent: lower the regularised energy of a patch by L-BFGS. */
#include "improve/lbfgs.h"
#include "improve/untangle/tangle.h"

#include "base/parts.h"

#include <math.h>

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
enum { CALM_ITERATIONS = 3 };
/* However large the patch, it gets so many evaluations. */
enum { LEAST_EVALUATIONS = 100 };
/* An epsilon this far below what is still inverted helps no more. */
#define EPSILON_IN_VAIN 0.02
/* The repair ends when an iteration gains less than this. */
enum { MENDING_ITERATIONS = 500 };
#define MENDING_FALL   1e-4
#define REPAIR_EPSILON 1e-6

/** The minimisation under way. */
typedef struct descent {
    pl_lbfgs m;
    pl_tangle *t;
    int keep;     /* nothing may become tangled again */
    int64_t most; /* evaluations */
} descent;

/** Chunks of stars under way. */
typedef struct energies {
    pl_tangle *t;
    pl_star_slope *slope;
} energies;

static void energy_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const energies *e = context;
    const planish_plan *plan = e->t->run->plan;
    pl_star_energy found = plan->kernel->guarded->energy[plan->dim - 2](
        &e->t->problem, begin, end, plan->scratch + plan->scratch_stride * thread,
        e->slope + begin);
    pl_tangle_add(e->t, thread, &found);
}

/** The patch's energy, and its slopes. */
static double energy_of_patch(void *context, double enough, pl_star_slope *slope) {
    const descent *d = context;
    energies e = {d->t, slope};
    (void)enough;
    pl_tangle_total(d->t, energy_chunk, &e);
    return d->keep && d->t->energy.tangled > 0 ? INFINITY : pl_tangle_energy(d->t);
}

static int has_patience(const descent *d) {
    return d->m.evaluations < d->most;
}

/** Iterations with one epsilon, as one sweep; not 0 if cut short. */
static int descend(descent *d, int most, double calm_fall) {
    pl_tangle *t = d->t;
    pl_run *r = t->run;
    pl_sweep_tally tally = {.colours = pl_plan_colours(r->plan)};
    int calm = 0;
    pl_begin_untangling_sweep(r);
    for (int i = 0; i < most && has_patience(d) && calm < CALM_ITERATIONS && !tally.stopped; i++) {
        const double before = d->m.value;
        if ((!d->keep && t->energy.tangled == 0) || !pl_lbfgs_iterate(&d->m, &tally))
            break;
        calm = d->m.value > (1 - calm_fall) * before ? calm + 1 : 0;
    }
    tally.evaluations = tally.visits;
    pl_run_measure(r);
    return pl_run_end_sweep(r, &tally);
}

static int solve(descent *d, const patience *how) {
    pl_tangle *t = d->t;
    int stopped = 0;
    t->asked.epsilon = 1;
    pl_tangle_measure(t);
    t->asked.epsilon =
        fmax(pl_first_epsilon(t->energy.least), -how->first_epsilon * t->energy.least);
    pl_lbfgs_begin(&d->m);
    for (int i = 0; i < how->epsilons && t->energy.tangled > 0 && has_patience(d); i++) {
        const double before = pl_tangle_energy(t);
        stopped = descend(d, how->iterations, how->calm_fall);
        if (stopped || t->asked.epsilon < -EPSILON_IN_VAIN * t->energy.least)
            return stopped;
        t->asked.epsilon =
            pl_next_epsilon(t->asked.epsilon, before, pl_tangle_energy(t), t->energy.least);
        pl_lbfgs_begin(&d->m);
    }
    return 0;
}

/** How many evaluations of so many visits in all. */
static int64_t evaluations_of(const descent *d, double visits) {
    const pl_stars *stars = &d->t->run->plan->interior.stars;
    const pl_patch *p = &d->m.p;
    int64_t facets = 0;
    for (int64_t i = 0; i < p->n; i++)
        facets += stars->link_offset[p->star[i] + 1] - stars->link_offset[p->star[i]];
    pl_parts_add(&facets, 1);
    return (int64_t)fmax(visits / (double)(facets + 1), LEAST_EVALUATIONS);
}

int pl_tangle_solve(pl_tangle *t, pl_patience wanted) {
    descent d = {.t = t};
    int stopped = 0;
    if (pl_lbfgs_create(t->run, &t->problem, t->in_patch, energy_of_patch, &d, &d.m)) {
        d.most = evaluations_of(&d, PATIENCE[wanted].visits);
        stopped = solve(&d, &PATIENCE[wanted]);
    }
    pl_lbfgs_destroy(&d.m);
    return stopped;
}

int pl_tangle_mend(pl_tangle *t) {
    descent d = {.t = t, .keep = 1};
    int stopped = 0;
    if (pl_lbfgs_create(t->run, &t->problem, t->in_patch, energy_of_patch, &d, &d.m)) {
        d.most = evaluations_of(&d, PATIENCE[PL_QUICK].visits);
        t->asked.epsilon = fmax(t->energy.least, REPAIR_EPSILON);
        pl_lbfgs_begin(&d.m);
        stopped = descend(&d, MENDING_ITERATIONS, MENDING_FALL);
    }
    pl_lbfgs_destroy(&d.m);
    return stopped;
}
