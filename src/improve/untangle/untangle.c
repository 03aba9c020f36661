/* untangle: the ladder that makes a tangled mesh valid, from gentle to strong (docs/algorithm.md).
 *
 * Every rung works on a patch around what is still tangled, beginning with the best mesh so far,
 * and what it reaches counts only if fewer elements are tangled then and no more are inverted.
 */
#include "improve/improve.h"
#include "improve/untangle/return.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "improve/lbfgs.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/** How long the patch is tried as one problem. */
typedef enum patience { NOT_AT_ALL = 0, QUICK, PATIENT } patience;

/** One rung: what is done about the elements that are still tangled. */
typedef struct rung {
    int rings;      /* of elements around the tangled ones, whose nodes may move too */
    int push_offs;  /* sweeps of the paper's push-off, at most */
    int centre;     /* 1: the patch's nodes go to the mean of their neighbours first */
    int sweeps;     /* of the regularised energy, at most */
    patience solve; /* then the patch as one problem */
} rung;

/* Elements that are inverted, or flat. The first rung does it in most cases. A mesh that is valid
 * but for rounding gets the first ones only. */
static const rung LADDER[] = {
    {.rings = 0, .centre = 1, .sweeps = 1},
    {.rings = 2, .sweeps = 10},
    {.rings = 0, .push_offs = 10},
    {.rings = 4, .centre = 1, .sweeps = 4},
    {.rings = 16, .centre = 1, .sweeps = 4},
    {.rings = PL_ALL_RINGS, .centre = 1, .sweeps = 4},
    {.rings = 8, .solve = QUICK},
    {.rings = PL_ALL_RINGS, .centre = 1, .solve = QUICK},
    {.rings = PL_ALL_RINGS, .solve = QUICK},
    {.rings = PL_ALL_RINGS, .centre = 1, .solve = PATIENT},
    {.rings = PL_ALL_RINGS, .solve = PATIENT},
};
enum { N_RUNGS = sizeof LADDER / sizeof *LADDER, N_RUNGS_IF_VALID = 3 };

/* Elements that the sweeps' push-offs have left below their minimum volume: it may be too much to
 * ask for. */
static const rung LADDER_OF_VOLUMES[] = {
    {.rings = 2, .sweeps = 10},
    {.rings = 8, .solve = QUICK},
};
enum { N_RUNGS_OF_VOLUMES = sizeof LADDER_OF_VOLUMES / sizeof *LADDER_OF_VOLUMES };

/* Cells that are invalid inside with positive corners, which coefficients as rows mend. */
static const rung LADDER_OF_ROUNDS[] = {
    {.rings = 0, .sweeps = 10},    {.rings = 1, .sweeps = 10},
    {.rings = 3, .sweeps = 10},    {.rings = 4, .solve = QUICK},
    {.rings = 16, .solve = QUICK}, {.rings = PL_ALL_RINGS, .solve = QUICK},
};
enum { N_RUNGS_OF_ROUNDS = sizeof LADDER_OF_ROUNDS / sizeof *LADDER_OF_ROUNDS };
/* A rung may invalidate cells beside; these get rows and it is climbed again, at most so often, and
 * until so many climbs in a row have left no fewer. */
enum { CLIMBS_OF_RUNG = 12, VAIN_CLIMBS = 3 };

/* Rings of elements around tangled ones that are evened out after these were solved. */
enum { EVENED_RINGS = 40 };
/* Push-offs end when so many sweeps in a row have left no fewer elements tangled. */
enum { VAIN_PUSH_OFFS = 3 };
/* What push-offs bring elements without a minimum volume to, relative to the volume wanted. */
#define PUSH_OFF_VOLUME 1e-6

/* ---- epsilon ------------------------------------------------------------------------------- */

/* The first epsilon, by the least measure; the least, at first and at last; by how much the energy
 * counts as having fallen at least. The last is the value of the article. */
#define EPSILON_BY_LEAST 0.4
#define EPSILON_AT_FIRST 0.02
#define EPSILON_AT_LAST  1e-9
#define LEAST_FALL       0.1

/** Set the first epsilon, from the least measure; most: a multiple of what is inverted most that it
 *  is at least. */
static void set_first_epsilon(pl_tangle *t, double most) {
    t->asked.epsilon = 1;
    pl_tangle_measure(t, NULL);
    t->asked.epsilon =
        fmax(fmax(EPSILON_AT_FIRST, -EPSILON_BY_LEAST * t->energy.least), -most * t->energy.least);
}

/** Set the next epsilon; before: the energy with the last one, before the nodes moved. By the
 *  schedule of Garanzha et al. (2021, section 3.2), which reaches validity in finitely many steps
 *  if each lowers the energy by a fixed part. */
static void set_next_epsilon(pl_tangle *t, double before) {
    const double epsilon = t->asked.epsilon, least = t->energy.least;
    const double fall = fmax(1 - pl_tangle_energy(t) / before, LEAST_FALL);
    const double s = sqrt(least * least + epsilon * epsilon);
    const double part = least >= 0 ? fall : fall * s / (s - least);
    t->asked.epsilon = fmax(epsilon * (1 - part), EPSILON_AT_LAST);
}

/* ---- sweeps -------------------------------------------------------------------------------- */

static void begin_sweep(pl_run *r) {
    pl_run_begin_sweep(r);
    r->result->untangling_sweeps++;
}

/** Sweep the problem over its stars once; not 0 if cut short. */
static int sweep(pl_run *r, const pl_star_problem *problem) {
    pl_sweep_tally tally = {0};
    begin_sweep(r);
    pl_sweep(r->plan, &r->plan->interior, problem, PLANISH_METHOD_PLANISH, pl_run_after_colour, r,
             &tally);
    pl_run_measure(r);
    return pl_run_end_sweep(r, &tally);
}

/** Sweep the regularised energy. */
static int regularised_sweeps(pl_tangle *t, int most) {
    int stopped = 0;
    if (most == 0)
        return 0;
    set_first_epsilon(t, 0);
    pl_tangle_measure(t, NULL);
    for (int i = 0; i < most && t->energy.tangled > 0 && !stopped; i++) {
        const double before = pl_tangle_energy(t);
        stopped = sweep(t->run, &t->problem);
        pl_tangle_measure(t, NULL);
        if (t->energy.tangled == 0)
            break;
        set_next_epsilon(t, before);
        pl_tangle_measure(t, NULL);
    }
    return stopped;
}

/** Move the patch's nodes to the mean of their neighbours, as one sweep; not 0 if cut short. */
static int centre_patch(pl_tangle *t) {
    pl_run *r = t->run;
    pl_patch p;
    int stopped = 0;
    if (pl_patch_create(r, &t->problem, t->in_patch, PL_CENTRE_VECTORS, &p)) {
        pl_sweep_tally tally = {.colours = pl_plan_colours(r->plan)};
        begin_sweep(r);
        pl_patch_centre(&p, &tally);
        pl_run_measure(r);
        stopped = pl_run_end_sweep(r, &tally);
    }
    pl_patch_destroy(&p);
    return stopped;
}

/* ---- push-off ------------------------------------------------------------------------------ */

/** Minimum volumes of push-offs for elements without one: next to nothing, by the sizes wanted. */
typedef struct small_volumes {
    const pl_tangle *t;
    double *volume; /* [link facets of all stars] */
} small_volumes;

static void small_volumes_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const small_volumes *f = context;
    const planish_plan *plan = f->t->run->plan;
    const int dim = plan->dim;
    (void)thread;
    for (int64_t s = begin; s < end; s++) {
        const double h = f->t->size[plan->interior.centre[s]];
        const double volume = PUSH_OFF_VOLUME * h * h * (dim == 3 ? h : 1) / (dim == 3 ? 6 : 2);
        for (int64_t i = plan->interior.stars.link_offset[s];
             i < plan->interior.stars.link_offset[s + 1]; i++)
            f->volume[i] = f->t->link_skip && f->t->link_skip[i] ? 0 : volume;
    }
}

/** Push off (the paper's case 3) the nodes of tangled elements, as often as it helps. */
static int push_offs(pl_tangle *t, int most) {
    planish_plan *plan = t->run->plan;
    struct pl_watch *watch = plan->scratch.watch;
    int stopped = 0, vain = 0;
    pl_star_guard guard = t->guard;
    pl_star_problem problem = t->problem;
    small_volumes f = {t, NULL};
    if (most > 0 && !(guard.min_volume > 0) && !guard.link_min_volume) {
        f.volume = pl_alloc(plan->interior.stars.link_offset[plan->interior.stars.n_stars],
                            sizeof *f.volume);
        if (!f.volume)
            return 0;
        pl_parallel_for(plan->threads, plan->interior.stars.n_stars, PL_CHUNK_STARS,
                        small_volumes_chunk, &f);
        guard.link_min_volume = f.volume;
    }
    problem.guard = &guard;
    problem.untangling = NULL;
    if (plan->work.corner) /* what becomes of the inside is judged after the rung */
        plan->scratch.watch = NULL;
    for (int i = 0; i < most && t->n_tangled > 0 && vain < VAIN_PUSH_OFFS && !stopped; i++) {
        const int64_t before = t->n_tangled;
        pl_tangle_mark(t, 0);
        memcpy(plan->scratch.changed, t->in_patch, (size_t)plan->work.n_nodes);
        stopped = sweep(t->run, &problem);
        pl_tangle_find(t);
        vain = t->n_tangled < before ? 0 : vain + 1;
    }
    plan->scratch.watch = watch;
    pl_free(f.volume);
    return stopped;
}

/* ---- the patch as one problem --------------------------------------------------------------- */

/** Limits of a solution. */
static const struct {
    double first_epsilon; /* at least, relative to what is inverted most */
    int epsilons;         /* at most */
    int iterations;       /* for each, at most; or until */
    double calm_fall;     /* some in a row have brought no more than this, relative */
    double visits;        /* of link facets, in all: some 2e7 a second on one core */
} PATIENCE[] = {
    [QUICK] = {0, 100, 100, 1e-4, 1e8},
    [PATIENT] = {1, 200, 1000, 1e-6, 1.5e9}, /* meets shears of ten times a domain's width */
};
enum { CALM_ITERATIONS = 3 };
/* A further row takes as long as so many link facets. */
enum { FACETS_PER_ROW = 10 };
/* However large the patch, it gets so many evaluations. */
enum { LEAST_EVALUATIONS = 100 };
/* An epsilon this far below what is still inverted helps no more. */
#define EPSILON_IN_VAIN 0.02
/* Evening out ends when an iteration brings less than this. */
enum { EVENING_ITERATIONS = 500 };
#define EVENING_FALL    1e-4
#define EVENING_EPSILON 1e-6

/** The minimisation under way. */
typedef struct descent {
    pl_lbfgs m;
    pl_tangle *t;
    int keep;     /* nothing may become tangled again */
    int64_t most; /* evaluations */
} descent;

/** Compute the patch's energy, and its slopes: a pl_lbfgs_function. */
static double energy_of_patch(void *context, double enough, pl_star_slope *slope) {
    const descent *d = context;
    (void)enough;
    pl_tangle_measure(d->t, slope);
    return d->keep && d->t->energy.tangled > 0 ? INFINITY : pl_tangle_energy(d->t);
}

/** Iterate with one epsilon, as one sweep; not 0 if cut short. */
static int descend(descent *d, int most, double calm_fall) {
    pl_run *r = d->t->run;
    pl_sweep_tally tally = {.colours = pl_plan_colours(r->plan)};
    int calm = 0;
    begin_sweep(r);
    for (int i = 0; i < most && d->m.evaluations < d->most && calm < CALM_ITERATIONS; i++) {
        const double before = d->m.value;
        if (tally.stopped || (!d->keep && d->t->energy.tangled == 0) ||
            !pl_lbfgs_iterate(&d->m, &tally))
            break;
        calm = d->m.value > (1 - calm_fall) * before ? calm + 1 : 0;
    }
    tally.stars.evaluations = tally.stars.visits;
    pl_run_measure(r);
    return pl_run_end_sweep(r, &tally);
}

/** Lower the energy of the patch by L-BFGS for falling epsilons until nothing is tangled; or, to
 *  even out, lower it further, but let nothing become tangled again: the sweeps that follow are
 *  slow to even out what the barriers of a solution have left over many elements. Not 0 if it was
 *  cut short; without memory it does nothing. */
static int solve_patch(pl_tangle *t, patience how, int evens_out) {
    const pl_stars *stars = &t->run->plan->interior.stars;
    descent d = {.t = t, .keep = evens_out};
    int64_t facets = 0;
    int stopped = 0;
    if (!pl_lbfgs_create(t->run, &t->problem, t->in_patch, energy_of_patch, &d, &d.m)) {
        pl_lbfgs_destroy(&d.m);
        return 0;
    }
    for (int64_t i = 0; i < d.m.p.n; i++) {
        const int32_t star = d.m.p.star[i];
        facets += stars->link_offset[star + 1] - stars->link_offset[star];
        if (t->problem.more && t->problem.has_more[star])
            facets += FACETS_PER_ROW * t->problem.max_more;
    }
    pl_parts_add(&facets, 1);
    d.most = (int64_t)fmax(PATIENCE[how].visits / (double)(facets + 1), LEAST_EVALUATIONS);
    if (evens_out) {
        t->asked.epsilon = fmax(t->energy.least, EVENING_EPSILON);
        pl_lbfgs_begin(&d.m);
        stopped = descend(&d, EVENING_ITERATIONS, EVENING_FALL);
    } else {
        set_first_epsilon(t, PATIENCE[how].first_epsilon);
        pl_lbfgs_begin(&d.m);
    }
    const int n_epsilons = evens_out ? 0 : PATIENCE[how].epsilons;
    for (int i = 0; i < n_epsilons && t->energy.tangled > 0 && d.m.evaluations < d.most; i++) {
        const double before = pl_tangle_energy(t);
        stopped = descend(&d, PATIENCE[how].iterations, PATIENCE[how].calm_fall);
        if (stopped || t->asked.epsilon < -EPSILON_IN_VAIN * t->energy.least)
            break;
        set_next_epsilon(t, before);
        pl_lbfgs_begin(&d.m);
    }
    pl_lbfgs_destroy(&d.m);
    return stopped;
}

/* ---- the ladder ---------------------------------------------------------------------------- */

/** Do what the rung says to the elements that are still tangled; not 0 if cut short. */
static int climb_rung(pl_tangle *t, const rung *step) {
    pl_tangle_mark(t, 0);
    if (t->n_patch == 0) /* their nodes are all held */
        return 0;
    pl_tangle_mark(t, step->rings);
    if (step->centre && centre_patch(t))
        return 1;
    pl_tangle_find_sizes(t);
    if (push_offs(t, step->push_offs) || regularised_sweeps(t, step->sweeps))
        return 1;
    if (step->solve == NOT_AT_ALL || (t->is_inside && t->n_patch == t->n_in_vain))
        return 0;
    if (solve_patch(t, step->solve, 0))
        return 1;
    t->n_in_vain = t->energy.tangled > 0 ? t->n_patch : 0;
    if (t->energy.tangled > 0)
        return 0;
    pl_tangle_mark(t, step->rings > EVENED_RINGS ? step->rings : EVENED_RINGS);
    return solve_patch(t, QUICK, 1);
}

/** Do what the rung says in rounds: cells that it has left invalid inside get rows, and it is climbed
 *  again from there. Not 0 if cut short. */
static int climb_in_rounds(pl_tangle *t, const rung *step) {
    int64_t fewest = INT64_MAX;
    for (int i = 0, vain = 0; i < CLIMBS_OF_RUNG && vain < VAIN_CLIMBS; i++) {
        int64_t n_new = 0;
        if (climb_rung(t, step))
            return 1;
        pl_tangle_find(t);
        if (!t->is_inside || t->n_tangled == 0 || pl_tangle_add_rows(t, &n_new, NULL) || n_new == 0)
            return 0;
        vain = t->n_tangled < fewest ? 0 : vain + 1;
        fewest = t->n_tangled < fewest ? t->n_tangled : fewest;
        t->n_in_vain = 0;
    }
    return 0;
}

/** Climb the n rungs of ladder, each a trial that shows; not 0 if cut short. The result of a rung
 *  stands if fewer cells are tangled after it, and no more inverted, but for cells inside where rounds
 *  follow. In a mesh that was valid F and the worst RR must not have risen either, unless it is volumes
 *  that count (raises). */
static int climb(pl_tangle *t, int raises, const rung *ladder, int n) {
    pl_run *r = t->run;
    int stopped = 0;
    for (int i = 0; i < n && t->n_tangled > 0 && !stopped; i++) {
        const double objective = pl_run_objective(r);
        const int64_t n_tangled = t->n_tangled;
        pl_trial trial;
        pl_trial_begin(r, 0, t->before, &trial);
        stopped = climb_in_rounds(t, &ladder[i]);
        pl_tangle_find(t);
        const pl_objective_sums *before = &trial.standing, *now = &r->sums;
        const int has_rounds = r->plan->work.corner && !t->is_inside && !raises; /* after these */
        const int is_no_worse =
            now->inverted <= before->inverted || (has_rounds && pl_tangled(now) < 1);
        const int is_taken =
            t->n_tangled < n_tangled && is_no_worse &&
            (pl_tangled(before) > 0 || t->is_inside || raises ||
             (now->radius_max <= before->radius_max && pl_run_objective(r) <= objective));
        pl_trial_end(&trial, is_taken);
        if (is_taken)
            t->n_in_vain = 0;
        else
            pl_tangle_find(t);
    }
    return stopped;
}

/** Let elements be as bad as they are: what repairs one inside may worsen others. */
static void allow_worst(pl_run *r) {
    const pl_star_limits now = pl_run_worst_limits(r, 1);
    pl_star_limits *limits = &r->limits_at_start;
    limits->rr2 = fmax(limits->rr2, now.rr2);
    limits->acuteness = fmax(limits->acuteness, now.acuteness);
    limits->rr2_blunt = fmin(limits->rr2_blunt, now.rr2_blunt);
    r->worst_at_start = fmax(r->worst_at_start, r->sums.radius_max);
}

/** Mend cells that are invalid inside. *stopped: as climb returns. */
static int climb_for_inside(pl_tangle *t, int *stopped, planish_error *error) {
    const double inverted = t->run->sums.inverted;
    int64_t n_new;
    int status = pl_tangle_begin_rounds(t, error);
    if (status)
        return status;
    pl_tangle_find(t);
    pl_log(PLANISH_LOG_DETAIL, "untangling %" PRId64 " cells inside", t->n_tangled);
    status = pl_tangle_add_rows(t, &n_new, error);
    if (!status)
        *stopped = climb(t, 0, LADDER_OF_ROUNDS, N_RUNGS_OF_ROUNDS);
    if (t->run->sums.inverted < inverted)
        allow_worst(t->run);
    if (!status && t->n_tangled > 0)
        pl_tangle_return(t);
    return status;
}

/** Climb ladder, and then that of rounds; where more is inverted in the end than before, go back to where it
 *  began. */
static int climb_ladder(pl_run *r, int raises, const rung *ladder, int n, planish_error *error) {
    const int sweeps = r->result->untangling_sweeps;
    const double inverted = r->sums.inverted;
    pl_tangle t;
    int status = pl_tangle_create(r, raises, &t, error);
    const int climbs = !status && !t.stopped && t.queue;
    int stopped = 0;
    r->phase = PLANISH_PHASE_UNTANGLE;
    r->stop = t.stopped ? (planish_stop)t.stopped : PLANISH_STOP_CONVERGED;
    t.problem.untangling = &t.asked;
    if (climbs)
        stopped = climb(&t, raises, ladder, n);
    if (climbs && !raises && t.n_tangled > 0 && pl_tangled(&r->sums) > 0)
        pl_tangle_return(&t);
    if (climbs && !raises && !stopped && pl_tangle_has_rounds(&t))
        status = climb_for_inside(&t, &stopped, error);
    if (climbs && r->sums.inverted > inverted) {
        memcpy(r->plan->scratch.coordinates, t.begin,
               (size_t)(r->plan->work.n_nodes * r->plan->dim) * sizeof *t.begin);
        pl_run_measure(r);
    }
    r->phase = PLANISH_PHASE_SMOOTH;
    pl_tangle_destroy(&t);
    if (!status && r->result->untangling_sweeps > sweeps) {
        pl_run_measure(r);
        pl_run_prepare(r);
    }
    return status;
}

int pl_run_untangle(pl_run *r, planish_error *error) {
    const int64_t inverted = (int64_t)pl_tangled(&r->sums);
    pl_log(PLANISH_LOG_DETAIL, "untangling %" PRId64 " elements", inverted);
    return climb_ladder(r, 0, LADDER, inverted > 0 ? N_RUNGS : N_RUNGS_IF_VALID, error);
}

int pl_run_raise_volumes(pl_run *r, planish_error *error) {
    pl_log(PLANISH_LOG_DETAIL, "raising %" PRId64 " elements to their minimum volume",
           (int64_t)r->sums.below);
    return climb_ladder(r, 1, LADDER_OF_VOLUMES, N_RUNGS_OF_VOLUMES, error);
}
