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

#include <math.h>

/* ---- conditions ------------------------------------------------------------------------------ */

/* What may be true when the turn of a phase has come, as bits. */
enum {
    MOVABLE = 1 << 0,       /* some node moves */
    INTERIOR = 1 << 1,      /* some node may go anywhere */
    TIME = 1 << 2,          /* nothing has cut the call short */
    CONVERGED = 1 << 3,     /* the last sweeps have converged, or there were none */
    SWEEPS_LEFT = 1 << 4,   /* options allow more */
    VISITS = 1 << 5,        /* the method visits stars; others take averages */
    GUARDED = 1 << 6,       /* options ask for more than the plain problem */
    UNTANGLES = 1 << 7,     /* options want it */
    TANGLED = 1 << 8,       /* an element is inverted, or flat; or a cell inside */
    BELOW = 1 << 9,         /* an element with a movable node is below its minimum volume, */
    BELOW_FIXED = 1 << 10,  /* or one without; */
    BELOW_BEFORE = 1 << 11, /* or one was at the start */
    ANGLES = 1 << 12,       /* the smallest angle, the elements of followers, the validity of
                               elements of order 2, or the shape must be kept */
    WORST = 1 << 13,        /* options want the worst elements to be improved, */
    WORST_SWEPT = 1 << 14,  /* and sweeps have done so */
    CURVED = 1 << 15,       /* there are curved elements, and options want their mids to move; */
    INSIDE = 1 << 16        /* some are invalid with positive corners */
};

/* RR^2, or mu^2 of a corner, above it: an element may be so flat that its sign is nothing but
 * rounding. */
#define FLAT_RR2 1e20
#define FLAT_MU2 1e16

static int may_be_flat(const pl_run *r) {
    return r->sums.corner_max > FLAT_MU2 ||
           (!r->plan->work.corner && r->sums.radius_max > FLAT_RR2);
}

static int was_cut_short(const pl_run *r) {
    return r->stop == PLANISH_STOP_INTERRUPTED || r->stop == PLANISH_STOP_TIME_LIMIT;
}

/** Return the conditions that hold. */
static int conditions_of(const pl_run *r) {
    const planish_plan *plan = r->plan;
    const planish_options *o = r->options;
    const struct {
        int holds, bit;
    } all[] = {
        {plan->interior.n_all + plan->sliding.n_all > 0, MOVABLE},
        {plan->interior.n_all > 0, INTERIOR},
        {!was_cut_short(r), TIME},
        {r->stop == PLANISH_STOP_CONVERGED, CONVERGED},
        {pl_run_sweeps_left(r) > 0, SWEEPS_LEFT},
        {o->method == PLANISH_METHOD_PLANISH, VISITS},
        {r->guard.wanted, GUARDED},
        {o->untangle, UNTANGLES},
        {pl_tangled(&r->sums) >= 1 || may_be_flat(r) || (plan->work.corner && r->sums.inside > 0),
         TANGLED},
        {r->sums.below > 0, BELOW},
        {r->sums_of_fixed.below > 0, BELOW_FIXED},
        {r->sums_at_start.below > 0, BELOW_BEFORE},
        {r->limits_at_start.acuteness < INFINITY || pl_run_has_followers(r) ||
             ((pl_watch_is_on(&r->watch) || r->skin.shape) && o->method == PLANISH_METHOD_PLANISH),
         ANGLES},
        {o->worst != PLANISH_WORST_NONE, WORST},
        {r->result->worst_sweeps > 0, WORST_SWEPT},
        {r->watch.n_curved > 0 && o->curve_quality > 0, CURVED},
        {r->sums.inside > 0, INSIDE},
    };
    int found = 0;
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        found |= all[i].holds ? all[i].bit : 0;
    return found;
}

/* ---- phases of a few lines ------------------------------------------------------------------- */

/** Count the cells that are not valid, or 0 without curved ones, of which corners may say so. */
static int64_t count_invalid(const pl_run *r) {
    const int64_t n = r->watch.n_curved > 0 ? pl_view_cells(&r->plan->work) : 0;
    int64_t n_invalid = 0;
    for (int64_t cell = 0; cell < n; cell++)
        n_invalid += pl_watch_decide(&r->watch, cell) != PL_VALID;
    return n_invalid;
}

/** Run a ladder. Curved cells may be valid though their corners alone would be inverted: what makes more
 *  of them invalid is undone. */
static int climb(pl_run *r, int (*ladder)(pl_run *r, planish_error *error), planish_error *error) {
    const int64_t n_invalid = count_invalid(r), n = r->plan->work.n_nodes * r->plan->dim;
    double *before = r->watch.n_curved > 0 ? pl_alloc(n, sizeof *before) : NULL;
    pl_trial trial;
    if (r->watch.n_curved > 0 && !before)
        return pl_fail_memory(error, "curved elements");
    if (before)
        pl_trial_begin(r, 0, before, &trial);
    const int status = ladder(r, error);
    if (before && count_invalid(r) <= n_invalid) { /* with the limits that it has found */
        trial.problem = r->problem;
        trial.guard = r->guard.star;
        trial.phase = r->phase;
        pl_trial_end(&trial, 1);
    } else if (before) {
        pl_trial_end(&trial, 0);
    }
    pl_free(before);
    return status;
}

static int untangle(pl_run *r, planish_error *error) {
    return climb(r, pl_run_untangle, error);
}

static int sweep(pl_run *r, planish_error *error) {
    if (r->plan->sizes)
        return pl_run_sized_sweeps(r, error);
    pl_run_sweeps(r);
    return PLANISH_OK;
}

static int raise_and_sweep(pl_run *r, planish_error *error) {
    const int before = r->result->untangling_sweeps;
    const int status = climb(r, pl_run_raise_volumes, error);
    if (!status && r->result->untangling_sweeps > before && !was_cut_short(r))
        pl_run_sweeps(r);
    return status;
}

/** Undo bringing elements up if it has left no fewer of them below: it has only made the mesh
 * worse. Sweep once more from the start, without; or if there is no time for that and more are
 * below, go back to the start. */
static int undo_failed_raise(pl_run *r, planish_error *error) {
    const pl_objective_sums *start = &r->sums_at_start;
    const int over = was_cut_short(r) || pl_run_sweeps_left(r) <= 0;
    (void)error;
    pl_run_measure(r);
    if (r->sums.below < start->below || r->sums.inverted < start->inverted ||
        (over && r->sums.below == start->below))
        return PLANISH_OK;
    pl_plan_order(r->plan, r->given, r->plan->scratch.coordinates);
    pl_run_measure(r);
    if (over)
        return PLANISH_OK;
    pl_run_prepare(r);
    r->guard.star.keep_below = 1;
    pl_run_sweeps(r);
    return PLANISH_OK;
}

static int measure(pl_run *r, planish_error *error) {
    (void)error;
    if (r->plan->sizes)
        pl_plan_fit_sizes(r->plan, r->plan->scratch.coordinates, r->plan->inner);
    pl_run_measure(r);
    return PLANISH_OK;
}

/** Put back angles smaller than any of the mesh as it came, and sweep with that as a limit. */
static int keep_angles(pl_run *r, planish_error *error) {
    const int status = pl_run_put_back_angles(r, error);
    if (status || r->result->n_put_back == 0 || was_cut_short(r) ||
        !(r->limits_at_start.acuteness < INFINITY))
        return status;
    pl_run_prepare(r);
    r->uncounted_sweeps = r->sweep;
    r->problem.limits.acuteness = r->limits_at_start.acuteness * PL_LIMIT_MARGIN;
    r->problem.limits.rr2_blunt = pl_run_blunt(r, r->problem.limits.acuteness);
    pl_run_sweeps(r);
    pl_run_measure(r);
    return pl_run_put_back_angles(r, error);
}

/** Find how near the nodes are to a constrained optimum. */
static int judge_optimality(pl_run *r, planish_error *error) {
    pl_star_optimality optimality = {0};
    planish_result *result = r->result;
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

/** Fixed elements stay as they are. */
static int say_infeasible(pl_run *r, planish_error *error) {
    (void)error;
    r->stop = PLANISH_STOP_INFEASIBLE;
    return PLANISH_OK;
}

/** Look for proofs that elements cannot reach their minimum volume. */
static int prove_infeasible(pl_run *r, planish_error *error) {
    const planish_plan *plan = r->plan;
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

/** One phase of a call. */
typedef struct phase {
    const char *name;
    int when;                                    /* the conditions: all must hold */
    int (*run)(pl_run *r, planish_error *error); /* Errors: _MEMORY */
} phase;

/* A phase takes its own result or undoes it, by a pl_trial or as its function says. */
static const phase PHASES[] = {
    /* taken: each rung that leaves fewer elements tangled */
    {"untangle", INTERIOR | VISITS | UNTANGLES | TANGLED, untangle},
    /* taken: each cluster of elements of which fewer are invalid */
    {"mend curved elements", VISITS | UNTANGLES | TIME | CURVED | INSIDE, pl_run_mend_curved},
    {"sweep", MOVABLE | TIME, sweep},
    /* taken: each rung that leaves fewer elements below */
    {"raise volumes", INTERIOR | VISITS | UNTANGLES | CONVERGED | BELOW, raise_and_sweep},
    /* taken: the sweeps since the start, if they leave fewer elements below; else others */
    {"undo a failed raise", MOVABLE | VISITS | GUARDED | UNTANGLES | BELOW_BEFORE,
     undo_failed_raise},
    /* taken: if F is lower, and nothing that was promised is worse */
    {"augmented Lagrangian", INTERIOR | VISITS | GUARDED | CONVERGED | SWEEPS_LEFT,
     pl_run_augmented},
    {"measure", MOVABLE, measure},
    /* taken: where no element is worse than the worst one at the start */
    {"keep the smallest angle", MOVABLE | ANGLES, keep_angles},
    /* taken: each stage that leaves fewer elements above its limit */
    {"worst elements", MOVABLE | TIME | WORST, pl_run_worst},
    {"keep the smallest angle of these", MOVABLE | ANGLES | WORST_SWEPT, pl_run_put_back_angles},
    /* taken: where no element becomes invalid */
    {"improve curved elements", VISITS | TIME | CURVED, pl_run_improve_curved},
    /* the mesh stays; only the result is completed */
    {"optimality", VISITS | GUARDED, judge_optimality},
    {"infeasible fixed elements", CONVERGED | BELOW_FIXED, say_infeasible},
    {"infeasible elements", CONVERGED | BELOW, prove_infeasible},
};

int pl_run_phases(pl_run *r, planish_error *error) {
    int status = PLANISH_OK;
    r->guard.star.keep_below = !r->options->untangle;
    for (const phase *p = PHASES; !status && p < PHASES + sizeof PHASES / sizeof *PHASES; p++)
        if ((p->when & ~conditions_of(r)) == 0)
            status = p->run(r, error);
    return status;
}
