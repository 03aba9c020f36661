/* augmented: past the places where minimum volumes block every node by itself.
 *
 * An element on its minimum volume belongs to several nodes. Each may be at its own constrained
 * optimum while all of them moving together could lower F: sweeps of feasible directions end there.
 * The augmented Lagrangian (Hestenes, Powell 1969; docs/algorithm.md) has no such places: volumes
 * may be below their minimum volume meanwhile, for a price that its multipliers raise from sweep to
 * sweep. So this is a trial: on the plan's coordinates, with the mesh as it stands put by. It ends
 * with ordinary sweeps, and the result is taken only if it is better in every respect that was
 * promised.
 */
#include "improve/improve.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "plan/ghosts.h"

#include <string.h>

enum { MOST_SWEEPS = 40 };
/* rho, in units of AR^2 by g^2. */
#define PENALTY 100.0
/* Multipliers have converged where no lambda / rho changes by more. */
#define CONVERGED 1e-3
/* RR^2 of an element depends a little on the node that it is seen from. */
#define LIMIT_NOISE 1e-9
/* By how much the elements that are left below may be lower than before, relative. */
#define LOWER 1e-3

/** One update of the multipliers. */
typedef struct shift_update {
    const pl_run *run;
    int wake;
    double largest; /* change; shared */
} shift_update;

static void update_chunk(void *context, int64_t begin, int64_t end, int thread) {
    shift_update *u = context;
    const planish_plan *plan = u->run->plan;
    pl_raise_double(&u->largest,
                    pl_star_update_shifts(&u->run->problem, plan->dim, u->wake, begin, end,
                                          pl_star_scratch_of(&u->run->problem, thread)));
}

/** Update the multipliers of all elements; returns the largest change. */
static double update_shifts(const pl_run *r, int wake) {
    const int64_t n = r->plan->interior.stars.n_stars;
    shift_update u = {r, wake, 0};
    pl_parallel_for(r->plan->threads, n, PL_CHUNK_STARS, update_chunk, &u);
    pl_parts_largest(&u.largest, 1);
    return u.largest;
}

/** Wake the stars of nodes that the trial has moved, and those around them. */
static void wake_moved(const planish_plan *plan, const double *before) {
    const int dim = plan->dim;
    for (int64_t s = 0; s < plan->interior.stars.n_stars; s++) {
        const int64_t at = (int64_t)plan->interior.centre[s] * dim;
        if (memcmp(plan->scratch.coordinates + at, before + at, (size_t)dim * sizeof *before) == 0)
            continue;
        plan->scratch.changed[plan->interior.centre[s]] = 1;
        for (int64_t i = plan->interior.stars.ring_offset[s];
             i < plan->interior.stars.ring_offset[s + 1]; i++)
            plan->scratch.changed[plan->interior.stars.ring[i]] = 1;
    }
    pl_ghosts_wake(plan, before);
}

/** Whether the mesh is better in every respect that is promised; elements that are left below
 * cannot be helped, but must not be lower either. A trial that was cut off does not count, whatever
 * it has reached: more sweeps must not give less. */
static int is_better(const pl_run *r, const pl_trial *trial) {
    const pl_objective_sums *now = &r->sums, *standing = &trial->standing;
    return r->stop == PLANISH_STOP_CONVERGED && pl_run_sweeps_left(r) > 0 &&
           now->below <= standing->below && now->inverted <= standing->inverted &&
           (now->below == 0 || now->shortfall <= (1 + LOWER) * standing->shortfall) &&
           pl_run_is_within(r, trial->problem.limits.rr2 * (1 + LIMIT_NOISE),
                            trial->problem.limits.acuteness * (1 + LIMIT_NOISE)) &&
           (!r->plan->work.corner || now->radius_max <= standing->radius_max) &&
           pl_run_objective(r) < pl_objective_of_all(r->options, standing);
}

/** Sweep the augmented Lagrangian around where a minimum volume is in force, then as usual; returns
 *  whether the mesh was taken. before: memory for the coordinates, shift: for the multipliers. */
static int try_augmented(pl_run *r, double *before, double *shift) {
    const planish_plan *plan = r->plan;
    const int first = r->sweep;
    int whole = 1; /* not cut short */
    int64_t visits = 1;
    double change = 1;
    pl_trial trial;
    pl_run_measure(r); /* what was tracked will not do to compare with */
    pl_trial_begin(r, 1, before, &trial);
    r->stop = PLANISH_STOP_MAX_SWEEPS;
    memset(plan->scratch.changed, 0, (size_t)plan->work.n_nodes);
    r->guard.star.penalty = PENALTY;
    r->guard.star.link_shift = shift;
    update_shifts(r, 1);
    while (whole && visits > 0 && change > CONVERGED && r->sweep - first < MOST_SWEEPS &&
           pl_run_sweeps_left(r) > 0) {
        whole = !pl_run_sweep(r, &visits);
        change = update_shifts(r, 0);
    }
    r->guard.star.penalty = 0;
    if (whole) {
        wake_moved(plan, before);
        pl_run_measure(r);
        r->guard.star.strict = 1; /* or F would fall at the cost of the volumes' tolerance */
        pl_run_sweeps(r);
    }
    pl_run_measure(r);
    const int is_taken = is_better(r, &trial);
    pl_trial_end(&trial, is_taken);
    if (!is_taken && r->stop == PLANISH_STOP_MAX_SWEEPS)
        r->stop = PLANISH_STOP_CONVERGED;
    return is_taken;
}

int pl_run_augmented(pl_run *r, planish_error *error) {
    const planish_plan *plan = r->plan;
    const int64_t n_links = plan->interior.stars.link_offset[plan->interior.stars.n_stars];
    pl_star_optimality optimality = {0};
    (void)error;
    /* A minimum volume holds F up somewhere where its multiplier is positive. */
    if (!r->problem.guard || pl_optimality(plan, &plan->interior, &r->problem, &optimality, NULL) ||
        !(optimality.multiplier > 0))
        return PLANISH_OK;
    double *before = pl_alloc(plan->work.n_nodes * plan->dim, sizeof *before);
    double *shift = pl_alloc_zero(n_links, sizeof *shift);
    if (before && shift && try_augmented(r, before, shift))
        pl_run_sweeps(r); /* to show the improvement */
    pl_free(before);
    pl_free(shift);
    return PLANISH_OK;
}
