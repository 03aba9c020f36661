/* phases: what a call of planish_smooth does, one phase after the other.
 *
 * In: a run that is measured. Out: its plan's coordinates, better or as they were. Most meshes need
 * the sweeps alone.
 */
#include "improve/improve.h"
#include "improve/untangle/proofs.h"

#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/angle.h"

#include <math.h>

/* See pl_star_problem.calm, as a part of the tolerance. Twice as much would save as much again, but
 * leave the gradient three times as large. */
#define CALM 0.5

void pl_run_prepare(pl_run *r) {
    const planish_plan *plan = r->plan;
    double worse = r->options->only_worse_than;
    r->problem = pl_plan_problem(plan);
    r->problem.direction = r->options->direction;
    r->problem.limits.rr2 = pl_run_limits(r, PL_LIMIT_MARGIN).rr2;
    /* In rings around bad elements good stars are meant, too. */
    r->problem.rr2_skip = plan->is_selective && r->options->rings > 0 ? 0 : worse * worse;
    r->problem.calm = plan->is_selective ? 0 : CALM * r->options->tolerance;
    r->problem.storage = pl_storage_of(r->options);
    r->problem.guard = r->guard.wanted ? &r->guard.star : NULL;
    if (!r->guard.wanted && r->options->direction == PLANISH_NEWTON)
        r->problem.kept = plan->kept;
    pl_run_begin_anew(r);
}

/** How near the nodes are to a constrained optimum. */
static int judge(pl_run *r, planish_error *error) {
    pl_star_optimality optimality = {0};
    planish_result *result = r->result;
    if (!r->guard.wanted || r->options->method != PLANISH_METHOD_PLANISH)
        return PLANISH_OK;
    r->factor = pl_guard_weigh(&r->guard, r->options, &r->worth.totals);
    const pl_star_problem sliding = pl_run_sliding_problem(r);
    pl_follow(r->plan, &sliding);
    int status = pl_optimality(r->plan, &r->plan->interior, &r->problem, &optimality, error);
    if (!status)
        status = pl_optimality(r->plan, &r->plan->sliding, &sliding, &optimality, error);
    if (status)
        return status;
    result->kkt_residual = optimality.n_stars > 0 ? optimality.residual : NAN;
    result->kkt_rms = optimality.n_stars > 0
                          ? pl_rms(pl_sum_value(&optimality.residual2), (double)optimality.n_stars)
                          : NAN;
    result->max_multiplier = optimality.multiplier * r->factor;
    result->n_active = optimality.n_active;
    return PLANISH_OK;
}

/** Say so if it has converged with elements that cannot reach their minimum volume. */
static int look_for_infeasible(pl_run *r, planish_error *error) {
    const planish_plan *plan = r->plan;
    if (r->stop == PLANISH_STOP_CONVERGED && r->rest.below > 0) /* no node of theirs is free */
        r->stop = PLANISH_STOP_INFEASIBLE;
    if (r->stop != PLANISH_STOP_CONVERGED || pl_run_below(r) == 0)
        return PLANISH_OK;
    pl_infeasible found = {0, 0};
    pl_limit limit = pl_run_limit(r);
    const pl_objective_problem problem = pl_run_objective_problem(r);
    uint8_t *state = pl_alloc(plan->work.n_elements, sizeof *state);
    int status = state ? PLANISH_OK : pl_fail_memory(error, "the states of the elements");
    if (state) {
        pl_find_below(&problem, state);
        status = pl_mark_infeasible(plan, &r->problem, state, &limit, &found, NULL, error);
    }
    pl_free(state);
    if (pl_parts_any(found.n > 0))
        r->stop = PLANISH_STOP_INFEASIBLE;
    return status;
}

static int was_cut_short(const pl_run *r) {
    return r->stop == PLANISH_STOP_INTERRUPTED || r->stop == PLANISH_STOP_TIME_LIMIT;
}

/** If bringing elements up has left no fewer of them below, it has only made the mesh worse: once
 *  more from the start, without; or if there is no time for that and more are below, back to it. */
static void give_up_failed_raise(pl_run *r) {
    planish_plan *plan = r->plan;
    const pl_objective_sums *start = &r->worth_at_start.totals;
    const int over = was_cut_short(r) || pl_run_sweeps_left(r) <= 0;
    if (r->plain || r->options->method != PLANISH_METHOD_PLANISH)
        return;
    pl_run_measure(r);
    if (start->below == 0 || r->worth.totals.below < start->below ||
        r->worth.totals.inverted < start->inverted)
        return;
    if (over && r->worth.totals.below == start->below)
        return;
    pl_plan_order(plan, r->outside, plan->coordinates);
    pl_run_measure(r);
    if (over)
        return;
    pl_run_prepare(r);
    r->guard.star.keep_below = 1;
    pl_run_sweeps(r);
}

/** All that moves many nodes together moves the interior's. */
static int has_interior(const pl_run *r) {
    return r->plan->interior.n_all > 0;
}

/** Do what of pl_run_untangle and the like; the mesh is then ready for sweeps. *done: there was
 *  something to do. */
static int untangle(pl_run *r, int (*what)(pl_run *, planish_error *), int *done,
                    planish_error *error) {
    const int before = r->result->untangling_sweeps;
    int status = what(r, error);
    *done = r->result->untangling_sweeps > before;
    if (!status && *done) {
        pl_run_measure(r);
        pl_run_prepare(r);
    }
    return status;
}

/** Sweeps; and if they leave elements below their minimum volume, stronger means and sweeps again.
 */
static int sweeps(pl_run *r, planish_error *error) {
    int done;
    pl_run_sweeps(r);
    if (r->options->method != PLANISH_METHOD_PLANISH || r->guard.star.keep_below ||
        !has_interior(r) || r->stop != PLANISH_STOP_CONVERGED)
        return PLANISH_OK;
    int status = untangle(r, pl_run_raise_volumes, &done, error);
    if (!status && done && !was_cut_short(r))
        pl_run_sweeps(r);
    return status;
}

/** Whether the angles, and the elements of followers, are looked at after the sweeps. */
static int looks_at_angles(const pl_run *r) {
    return r->at_start.acuteness < INFINITY || pl_run_has_followers(r);
}

/** Angles smaller than any of the mesh as it came go back, and are swept with that as a limit. */
static int keep_angles(pl_run *r, planish_error *error) {
    if (!looks_at_angles(r))
        return PLANISH_OK;
    int status = pl_run_put_back_angles(r, error);
    if (status || r->result->put_back == 0 || was_cut_short(r) ||
        !(r->at_start.acuteness < INFINITY))
        return status;
    pl_run_prepare(r);
    r->uncounted_sweeps = r->sweep;
    r->problem.limits.acuteness = r->at_start.acuteness * PL_LIMIT_MARGIN;
    r->problem.limits.rr2_blunt = pl_blunt_ratio_square(r->plan->dim, r->problem.limits.acuteness);
    pl_run_sweeps(r);
    pl_run_measure(r);
    return pl_run_put_back_angles(r, error);
}

/* ---- the phases of a call ------------------------------------------------------------------- */

static int wants_untangling(const pl_run *r) {
    return r->options->untangle && r->options->method == PLANISH_METHOD_PLANISH && has_interior(r);
}

static int phase_untangle(pl_run *r, planish_error *error) {
    int done;
    return untangle(r, pl_run_untangle, &done, error);
}

static int has_time(const pl_run *r) {
    return !was_cut_short(r);
}

static int phase_give_up(pl_run *r, planish_error *error) {
    (void)error;
    give_up_failed_raise(r);
    return PLANISH_OK;
}

static int wants_augmented(const pl_run *r) {
    return !was_cut_short(r) && has_interior(r);
}

static int phase_augmented(pl_run *r, planish_error *error) {
    (void)error;
    pl_run_augmented(r);
    return PLANISH_OK;
}

static int always(const pl_run *r) {
    (void)r;
    return 1;
}

static int phase_measure_and_keep_angles(pl_run *r, planish_error *error) {
    pl_run_measure(r);
    return keep_angles(r, error);
}

static int wants_worst(const pl_run *r) {
    return r->options->worst != PLANISH_WORST_NONE && !was_cut_short(r);
}

static int has_changed_worst(const pl_run *r) {
    return r->result->worst_sweeps > 0 && looks_at_angles(r);
}

static int has_nodes(const pl_run *r) {
    return r->plan->interior.n_all + r->plan->sliding.n_all > 0;
}

int pl_run_phases(pl_run *r, planish_error *error) {
    static const struct {
        int (*is_wanted)(const pl_run *r);
        int (*run)(pl_run *r, planish_error *error);
    } phases[] = {
        {wants_untangling, phase_untangle},
        {has_time, sweeps},      /* and raise elements that sweeps leave too small */
        {always, phase_give_up}, /* if raising volumes has only made the mesh worse */
        {wants_augmented, phase_augmented},
        {always, phase_measure_and_keep_angles},
        {wants_worst, pl_run_worst},
        {has_changed_worst, pl_run_put_back_angles},
    };
    int status = PLANISH_OK;
    r->worth_at_start = r->worth;
    r->guard.star.keep_below = !r->options->untangle;
    for (size_t i = 0; i < sizeof phases / sizeof *phases && has_nodes(r) && !status; i++)
        if (phases[i].is_wanted(r))
            status = phases[i].run(r, error);
    if (!status)
        status = judge(r, error);
    return status ? status : look_for_infeasible(r, error);
}
