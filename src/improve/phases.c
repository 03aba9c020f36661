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

static int was_cut_short(const pl_run *r) {
    return r->stop == PLANISH_STOP_INTERRUPTED || r->stop == PLANISH_STOP_TIME_LIMIT;
}

/** Sweep; and if that leaves elements below their minimum volume, raise these and sweep again. */
static int sweep_and_raise(pl_run *r, planish_error *error) {
    const int before = r->result->untangling_sweeps;
    pl_run_sweeps(r);
    if (r->options->method != PLANISH_METHOD_PLANISH || r->guard.star.keep_below ||
        r->plan->interior.n_all == 0 || r->stop != PLANISH_STOP_CONVERGED)
        return PLANISH_OK;
    const int status = pl_run_raise_volumes(r, error);
    if (!status && r->result->untangling_sweeps > before && !was_cut_short(r))
        pl_run_sweeps(r);
    return status;
}

/** Undo bringing elements up if it has left no fewer of them below: it has only made the mesh
 * worse. Sweep once more from the start, without; or if there is no time for that and more are
 * below, go back to the start. */
static int give_up_failed_raise(pl_run *r, planish_error *error) {
    const pl_objective_sums *start = &r->sums_at_start;
    const int over = was_cut_short(r) || pl_run_sweeps_left(r) <= 0;
    (void)error;
    if (r->plain || r->options->method != PLANISH_METHOD_PLANISH)
        return PLANISH_OK;
    pl_run_measure(r);
    if (start->below == 0 || r->sums.below < start->below || r->sums.inverted < start->inverted)
        return PLANISH_OK;
    if (over && r->sums.below == start->below)
        return PLANISH_OK;
    pl_plan_order(r->plan, r->given, r->plan->coordinates);
    pl_run_measure(r);
    if (over)
        return PLANISH_OK;
    pl_run_prepare(r);
    r->guard.star.keep_below = 1;
    pl_run_sweeps(r);
    return PLANISH_OK;
}

/** Whether the angles, and the elements of followers, are looked at after the sweeps. */
static int looks_at_angles(const pl_run *r) {
    return r->limits_at_start.acuteness < INFINITY || pl_run_has_followers(r);
}

/** Put back angles smaller than any of the mesh as it came, and sweep with that as a limit. */
static int keep_angles(pl_run *r, planish_error *error) {
    pl_run_measure(r);
    if (!looks_at_angles(r))
        return PLANISH_OK;
    const int status = pl_run_put_back_angles(r, error);
    if (status || r->result->put_back == 0 || was_cut_short(r) ||
        !(r->limits_at_start.acuteness < INFINITY))
        return status;
    pl_run_prepare(r);
    r->uncounted_sweeps = r->sweep;
    r->problem.limits.acuteness = r->limits_at_start.acuteness * PL_LIMIT_MARGIN;
    r->problem.limits.rr2_blunt = pl_blunt_ratio_square(r->plan->dim, r->problem.limits.acuteness);
    pl_run_sweeps(r);
    pl_run_measure(r);
    return pl_run_put_back_angles(r, error);
}

static int keep_angles_of_worst(pl_run *r, planish_error *error) {
    return r->result->worst_sweeps > 0 && looks_at_angles(r) ? pl_run_put_back_angles(r, error)
                                                             : PLANISH_OK;
}

/** Find how near the nodes are to a constrained optimum. */
static int judge_optimality(pl_run *r, planish_error *error) {
    pl_star_optimality optimality = {0};
    planish_result *result = r->result;
    if (!r->guard.wanted || r->options->method != PLANISH_METHOD_PLANISH)
        return PLANISH_OK;
    r->factor = pl_guard_weigh(&r->guard, r->options, &r->sums);
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

/** Say so if the sweeps have converged with elements that cannot reach their minimum volume. */
static int find_infeasible(pl_run *r, planish_error *error) {
    const planish_plan *plan = r->plan;
    if (r->stop == PLANISH_STOP_CONVERGED &&
        r->sums_of_fixed.below > 0) /* no node of theirs is free */
        r->stop = PLANISH_STOP_INFEASIBLE;
    if (r->stop != PLANISH_STOP_CONVERGED || !(r->sums.below > 0))
        return PLANISH_OK;
    pl_infeasible found = {0, 0};
    pl_stop_check limit = pl_run_stop_check(r);
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

/* ---- the phases of a call ------------------------------------------------------------------- */

/* What a phase needs, as bits: nodes that move; time, as nothing has cut the call short; nodes that
 * may go anywhere. */
enum { NODES = 1, TIME = 2, INTERIOR = 4 };

int pl_run_phases(pl_run *r, planish_error *error) {
    static const struct {
        int needs;
        int (*run)(pl_run *r, planish_error *error);
    } phases[] = {
        {INTERIOR, pl_run_untangle},   {NODES | TIME, sweep_and_raise},
        {NODES, give_up_failed_raise}, {INTERIOR | TIME, pl_run_augmented},
        {NODES, keep_angles},          {NODES | TIME, pl_run_worst},
        {NODES, keep_angles_of_worst}, {0, judge_optimality},
        {0, find_infeasible},
    };
    const int64_t n_interior = r->plan->interior.n_all, n = n_interior + r->plan->sliding.n_all;
    int status = PLANISH_OK;
    r->guard.star.keep_below = !r->options->untangle;
    for (size_t i = 0; i < sizeof phases / sizeof *phases && !status; i++) {
        const int has =
            (n > 0 ? NODES : 0) | (n_interior > 0 ? INTERIOR : 0) | (was_cut_short(r) ? 0 : TIME);
        if ((phases[i].needs & ~has) == 0)
            status = phases[i].run(r, error);
    }
    return status;
}
