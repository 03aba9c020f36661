/* untangle: the ladder that makes a tangled mesh valid, from gentle to strong (docs/algorithm.md).
 *
 * Every rung works on a patch around what is still tangled, beginning with the best mesh so far,
 * and what it reaches counts only if fewer elements are tangled then and no more are inverted.
 */
#include "improve/improve.h"
#include "improve/untangle/tangle.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "improve/patch.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/** One rung: what is done about the elements that are still tangled. */
typedef struct measures {
    int rings;         /* of elements around the tangled ones, whose nodes may move too */
    int push_offs;     /* sweeps of the paper's push-off, at most */
    int centre;        /* 1: the patch's nodes go to the mean of their neighbours first */
    int sweeps;        /* of the regularised energy, at most */
    pl_patience solve; /* then the patch as one problem */
} measures;

/* Elements that are inverted, or flat. The first rung does it in most cases. A mesh that is valid
 * but for rounding gets the first ones only. */
static const measures LADDER[] = {
    {.rings = 0, .centre = 1, .sweeps = 1},
    {.rings = 2, .sweeps = 10},
    {.rings = 0, .push_offs = 10},
    {.rings = 4, .centre = 1, .sweeps = 4},
    {.rings = 16, .centre = 1, .sweeps = 4},
    {.rings = PL_ALL_RINGS, .centre = 1, .sweeps = 4},
    {.rings = 8, .solve = PL_QUICK},
    {.rings = PL_ALL_RINGS, .centre = 1, .solve = PL_QUICK},
    {.rings = PL_ALL_RINGS, .solve = PL_QUICK},
    {.rings = PL_ALL_RINGS, .centre = 1, .solve = PL_PATIENT},
    {.rings = PL_ALL_RINGS, .solve = PL_PATIENT},
};
enum { N_RUNGS = sizeof LADDER / sizeof *LADDER, N_RUNGS_IF_VALID = 3 };

/* Elements that the sweeps' push-offs have left below their minimum volume: it may be too much to
 * ask for. */
static const measures LADDER_OF_VOLUMES[] = {
    {.rings = 2, .sweeps = 10},
    {.rings = 8, .solve = PL_QUICK},
};
enum { N_RUNGS_OF_VOLUMES = sizeof LADDER_OF_VOLUMES / sizeof *LADDER_OF_VOLUMES };

/* Layers of elements around tangled ones that are repaired after these were solved. */
enum { REPAIRED_RINGS = 40 };
/* Push-offs end when so many sweeps in a row have left no fewer elements tangled. */
enum { VAIN_PUSH_OFFS = 3 };
/* What push-offs bring elements without a minimum volume to, relative to the volume wanted. */
#define PUSH_OFF_VOLUME 1e-6

/* RR^2 above it: an element may be so flat that its sign is nothing but rounding. */
#define FLAT_RR2 1e20

/* ---- epsilon ------------------------------------------------------------------------------- */

/* The first epsilon, by the least measure; the least, at first and at last; by how much the energy
 * counts as having fallen at least. The last is the value of the article. */
#define EPSILON_BY_LEAST 0.4
#define EPSILON_AT_FIRST 0.02
#define EPSILON_AT_LAST  1e-9
#define LEAST_FALL       0.1

double pl_first_epsilon(double least) {
    return fmax(EPSILON_AT_FIRST, -EPSILON_BY_LEAST * least);
}

/** The schedule of Garanzha et al. (2021, section 3.2), which reaches validity in finitely many
 *  steps if each lowers the energy by a fixed part. */
double pl_next_epsilon(double epsilon, double before, double after, double least) {
    const double fall = fmax(1 - after / before, LEAST_FALL);
    const double s = sqrt(least * least + epsilon * epsilon);
    const double part = least >= 0 ? fall : fall * s / (s - least);
    return fmax(epsilon * (1 - part), EPSILON_AT_LAST);
}

/* ---- sweeps -------------------------------------------------------------------------------- */

void pl_begin_untangling_sweep(pl_run *r) {
    pl_run_begin_sweep(r);
    r->result->untangling_sweeps++;
}

/** One sweep of the problem over its stars; not 0 if cut short. */
static int sweep(pl_run *r, const pl_star_problem *problem) {
    pl_begin_untangling_sweep(r);
    pl_sweep_tally tally = {0};
    pl_sweep(r->plan, &r->plan->interior, problem, PLANISH_METHOD_PLANISH, pl_run_after_colour, r,
             &tally);
    pl_run_measure(r);
    return pl_run_end_sweep(r, &tally);
}

/** Sweeps of the regularised energy. */
static int regularised_sweeps(pl_tangle *t, int most) {
    int stopped = 0;
    if (most == 0)
        return 0;
    t->asked.epsilon = 1;
    pl_tangle_measure(t);
    t->asked.epsilon = pl_first_epsilon(t->energy.least);
    pl_tangle_measure(t);
    for (int i = 0; i < most && t->energy.tangled > 0 && !stopped; i++) {
        const double before = pl_tangle_energy(t);
        stopped = sweep(t->run, &t->problem);
        pl_tangle_measure(t);
        if (t->energy.tangled == 0)
            break;
        t->asked.epsilon =
            pl_next_epsilon(t->asked.epsilon, before, pl_tangle_energy(t), t->energy.least);
        pl_tangle_measure(t);
    }
    return stopped;
}

/** Move the patch's nodes to the mean of their neighbours, as one sweep; not 0 if cut short. */
static int centre(pl_tangle *t) {
    pl_run *r = t->run;
    pl_patch p;
    int stopped = 0;
    if (pl_patch_create(r, &t->problem, t->in_patch, PL_CENTRE_VECTORS, &p)) {
        pl_sweep_tally tally = {.colours = pl_plan_colours(r->plan)};
        pl_begin_untangling_sweep(r);
        pl_patch_centre(&p, &tally);
        pl_run_measure(r);
        stopped = pl_run_end_sweep(r, &tally);
    }
    pl_patch_destroy(&p);
    return stopped;
}

/* ---- push-off ------------------------------------------------------------------------------ */

/** The floors of elements without a minimum volume: next to nothing, by the sizes wanted. */
typedef struct flooring {
    const pl_tangle *t;
    double *floor; /* [link facets of all stars] */
} flooring;

static void floor_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const flooring *f = context;
    const planish_plan *plan = f->t->run->plan;
    const int dim = plan->dim;
    (void)thread;
    for (int64_t s = begin; s < end; s++) {
        const double h = f->t->size[plan->interior.centre[s]];
        const double volume = PUSH_OFF_VOLUME * h * h * (dim == 3 ? h : 1) / (dim == 3 ? 6 : 2);
        for (int64_t i = plan->interior.stars.link_offset[s];
             i < plan->interior.stars.link_offset[s + 1]; i++)
            f->floor[i] = f->t->link_skip && f->t->link_skip[i] ? 0 : volume;
    }
}

/** The paper's case 3 at the nodes of tangled elements, as often as it helps. */
static int push_offs(pl_tangle *t, int most) {
    const planish_plan *plan = t->run->plan;
    int stopped = 0, vain = 0;
    pl_star_guard guard = t->guard;
    pl_star_problem problem = t->problem;
    flooring f = {t, NULL};
    if (most > 0 && !(guard.min_volume > 0) && !guard.link_min_volume) {
        f.floor = pl_alloc(plan->interior.stars.link_offset[plan->interior.stars.n_stars],
                           sizeof *f.floor);
        if (!f.floor)
            return 0;
        pl_parallel_for(plan->threads, plan->interior.stars.n_stars, PL_CHUNK_STARS, floor_chunk,
                        &f);
        guard.link_min_volume = f.floor;
    }
    problem.guard = &guard;
    problem.untangling = NULL;
    for (int i = 0; i < most && t->n_tangled > 0 && vain < VAIN_PUSH_OFFS && !stopped; i++) {
        const int64_t before = t->n_tangled;
        pl_tangle_mark(t, 0);
        memcpy(plan->changed, t->in_patch, (size_t)plan->work.n_nodes);
        stopped = sweep(t->run, &problem);
        pl_tangle_find(t);
        vain = t->n_tangled < before ? 0 : vain + 1;
    }
    pl_free(f.floor);
    return stopped;
}

/* ---- the ladder ---------------------------------------------------------------------------- */

/** The patch as one problem, and what is around it after that. */
static int solve(pl_tangle *t, const measures *rung) {
    if (pl_tangle_solve(t, rung->solve))
        return 1;
    if (t->energy.tangled > 0)
        return 0;
    pl_tangle_mark(t, rung->rings > REPAIRED_RINGS ? rung->rings : REPAIRED_RINGS);
    return pl_tangle_mend(t);
}

/** Not 0 if cut short. */
static int climb(pl_tangle *t, const measures *rung) {
    pl_tangle_mark(t, 0);
    if (t->n_patch == 0) /* their nodes are all held */
        return 0;
    pl_tangle_mark(t, rung->rings);
    if (rung->centre && centre(t))
        return 1;
    pl_tangle_find_sizes(t);
    if (push_offs(t, rung->push_offs) || regularised_sweeps(t, rung->sweeps))
        return 1;
    return rung->solve == PL_NOT_AT_ALL ? 0 : solve(t, rung);
}

/** Quality of the mesh when a rung began. */
typedef struct standing {
    int64_t tangled, inverted;
    double rr2, objective;
} standing;

static standing standing_of(const pl_tangle *t) {
    const pl_run *r = t->run;
    return (standing){t->n_tangled, pl_run_inverted(r), pl_run_limits(r, 1).rr2,
                      pl_run_objective(r)};
}

/** Whether a rung has won: fewer elements are tangled, and no more inverted. Of a mesh that was
 *  valid F and the worst RR must not have risen either, unless it is volumes that count. */
static int has_won(const standing *before, const standing *now, int volumes) {
    const int better = now->rr2 <= before->rr2 && now->objective <= before->objective;
    return now->tangled < before->tangled && now->inverted <= before->inverted &&
           (before->inverted > 0 || volumes || better);
}

static void climb_all(pl_tangle *t, int volumes, const measures *ladder, int n) {
    const planish_plan *plan = t->run->plan;
    const size_t size = (size_t)plan->work.n_nodes * (size_t)plan->dim * sizeof *t->best;
    int stopped = 0;
    t->problem.untangling = &t->asked;
    memcpy(t->best, plan->coordinates, size);
    for (int i = 0; i < n && t->n_tangled > 0 && !stopped; i++) {
        const standing before = standing_of(t);
        stopped = climb(t, &ladder[i]);
        pl_tangle_find(t);
        const standing now = standing_of(t);
        if (has_won(&before, &now, volumes)) {
            memcpy(t->best, plan->coordinates, size);
        } else {
            memcpy(plan->coordinates, t->best, size);
            pl_run_measure(t->run);
            pl_tangle_find(t);
        }
    }
}

/** Climb the n rungs of ladder. */
static int untangle(pl_run *r, int floors, const measures *ladder, int n, planish_error *error) {
    pl_tangle t;
    int status = pl_tangle_create(r, floors, &t, error);
    r->restoring = 1;
    r->stop = PLANISH_STOP_CONVERGED;
    if (t.stopped)
        r->stop = (planish_stop)t.stopped;
    else if (!status && t.n_tangled > 0)
        climb_all(&t, floors, ladder, n);
    if (!status && !t.stopped && !floors && t.n_tangled > 0 && pl_run_inverted(r) > 0)
        pl_tangle_return(&t);
    r->restoring = 0;
    pl_tangle_destroy(&t);
    return status;
}

/** Whether elements of the mesh as measured last are inverted, or so flat that they count as such.
 */
static int is_tangled(const pl_run *r) {
    return pl_run_inverted(r) > 0 || pl_run_limits(r, 1).rr2 > FLAT_RR2;
}

int pl_run_untangle(pl_run *r, planish_error *error) {
    if (!is_tangled(r))
        return PLANISH_OK;
    pl_log(PLANISH_LOG_DETAIL, "untangling %" PRId64 " elements", pl_run_inverted(r));
    return untangle(r, 0, LADDER, pl_run_inverted(r) > 0 ? N_RUNGS : N_RUNGS_IF_VALID, error);
}

int pl_run_raise_volumes(pl_run *r, planish_error *error) {
    if (pl_run_below(r) == 0)
        return PLANISH_OK;
    pl_log(PLANISH_LOG_DETAIL, "raising %" PRId64 " elements to their minimum volume",
           pl_run_below(r));
    return untangle(r, 1, LADDER_OF_VOLUMES, N_RUNGS_OF_VOLUMES, error);
}
