/* worst: a last phase for the worst elements, which an average does not care for.
 *
 * The measure's limit falls in stages. In each only stars that hold something above it are visited,
 * to minimise a high power of the measure, which is next to its maximum; the worklist begins with
 * the nodes of the elements above and follows what moves. A stage that leaves no fewer elements
 * above, or makes F rise by more than is allowed, is undone.
 */
#include "improve/improve.h"
#include "improve/joint.h"
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

/* What the limit of a measure (RR, or 1 / sin of an angle; mu of a corner, or 1 / SJ) has above 1
 * falls by this factor from stage to stage, */
#define STAGE_FACTOR 0.9
/* from the worst there is, but no more than this, to this. */
#define STAGE_MOST  1e4
#define STAGE_LEAST 1.05
enum { STAGE_SWEEPS = 20, HALVINGS = 3 };
/* A stage ends when no more than one star in so many improves. */
enum { FEW = 50 };

/** Stages under way. */
typedef struct stages {
    pl_run *run;
    uint8_t *state;        /* [n_elements] */
    double *before;        /* [n_nodes][dim] where a stage started */
    double most;           /* F, */
    double most_of_cell;   /* and with corners AR^2 of a cell */
    pl_star_limits limits; /* of all elements, in all stages */
} stages;

/** Whether angles, or scaled Jacobians, are meant, not ratios. */
static int is_of_angle(const pl_run *r) {
    return r->options->worst == PLANISH_WORST_ANGLE ||
           r->options->worst == PLANISH_WORST_SCALED_JACOBIAN;
}

/** Find the elements above limit, a square; how many of them have a free node. */
static int64_t find_bad(const stages *p, double limit) {
    const planish_plan *plan = p->run->plan;
    const uint8_t *is_counted = plan->work.is_counted, *mobility = plan->work.mobility;
    const int of_angle = is_of_angle(p->run), corners = plan->dim + 1;
    const double ratio = of_angle ? INFINITY : sqrt(limit), acuteness = of_angle ? limit : INFINITY;
    int64_t n = 0;
    const pl_view all = pl_view_of_all_elements(&plan->work);
    if (all.corner)
        pl_find_worse_corners(&all, plan->scratch.to_measure, ratio, acuteness, INFINITY,
                              plan->threads, p->state);
    else
        pl_find_worse(&all, plan->scratch.to_measure, ratio, acuteness, plan->threads, p->state);
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        n += p->state[i] == PL_WORSE && (!is_counted || is_counted[i]) &&
             pl_any_moves(mobility, plan->work.elements + i * corners, corners);
    pl_parts_add(&n, 1);
    return n;
}

/** The objective of stages, one of pl_star_worst. */
static int objective_of_stages(const pl_run *r) {
    return r->options->worst == PLANISH_WORST_ANGLE             ? PL_WORST_ANGLE
           : r->options->worst == PLANISH_WORST_SCALED_JACOBIAN ? PL_WORST_JACOBIAN
                                                                : PL_WORST_RATIO;
}

/** Try a stage: sweep stars with something above limit, a square, beginning with the nodes of the
 *  elements above. *failed: F rose too much in it. The stage stands if not, and if fewer elements
 *  are above the limit. Not 0 if it was cut short. */
static int try_stage(stages *p, double limit, int *failed) {
    pl_run *r = p->run;
    const planish_plan *plan = r->plan;
    const int64_t n_bad = find_bad(p, limit);
    int64_t most = 0;
    int stopped = 0;
    pl_trial trial;
    *failed = 0;
    if (n_bad == 0)
        return 0;
    memset(plan->scratch.changed, 0, (size_t)plan->work.n_nodes);
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        for (int j = 0; p->state[i] == PL_WORSE && j <= plan->dim; j++)
            plan->scratch.changed[pl_plan_inner(plan, i, j)] = 1;
    pl_trial_begin(r, 1, p->before, &trial);
    r->phase = PLANISH_PHASE_WORST;
    r->guard.star.objective = objective_of_stages(r);
    r->guard.star.worst_limit = limit;
    r->guard.star.ratio_weight = 1;
    r->guard.star.volume_weight = 0;
    r->guard.star.keep_below = 1;
    r->problem.guard = &r->guard.star;
    r->problem.calm = r->problem.rr2_skip = 0;
    r->problem.limits = p->limits;
    for (int i = 0; i < STAGE_SWEEPS && !stopped; i++) {
        pl_sweep_tally tally = {0};
        pl_run_begin_sweep(r);
        pl_run_sweep_colours(r, &tally);
        stopped = pl_run_end_sweep(r, &tally);
        r->result->worst_sweeps++;
        most = tally.stars.visits > most ? tally.stars.visits : most;
        if (tally.stars.improved * FEW <= most)
            break;
    }
    pl_run_measure(r);
    *failed = !(pl_run_objective(r) <= p->most && r->sums.radius_max <= p->most_of_cell);
    pl_trial_end(&trial, !*failed && find_bad(p, limit) < n_bad);
    return stopped;
}

/** Lower the limit stage by stage. */
static void run_stages(stages *p) {
    const pl_star_limits worst = pl_run_worst_limits(p->run, 1);
    double reached = sqrt(is_of_angle(p->run) ? worst.acuteness : worst.rr2), refused = 1;
    reached = fmin(reached, STAGE_MOST);
    for (int failures = 0; failures <= HALVINGS && reached > STAGE_LEAST;) {
        const double next =
            failures == 0 ? 1 + (reached - 1) * STAGE_FACTOR : (reached + refused) / 2;
        int failed;
        if (try_stage(p, next * next, &failed))
            return;
        if (failed)
            refused = next;
        else
            reached = next;
        failures += failures > 0 || failed;
    }
}

/** Worst value of the mesh as the caller wants to know it: RR, or degrees; mu, or SJ. */
static double worst_of(const pl_run *r) {
    const double degrees = 57.295779513082320877; /* of a radian */
    const pl_star_limits now = pl_run_worst_limits(r, 1);
    if (!is_of_angle(r) || !(now.acuteness > 0))
        return sqrt(now.rr2);
    if (r->options->worst == PLANISH_WORST_SCALED_JACOBIAN)
        return 1 / sqrt(now.acuteness);
    return asin(1 / sqrt(now.acuteness)) * degrees;
}

static int64_t find_for_joint(void *p, double limit) { return find_bad(p, limit); }

int pl_run_worst(pl_run *r, planish_error *error) {
    const planish_plan *plan = r->plan;
    const double objective = pl_run_objective(r), before = worst_of(r);
    stages p = {.run = r,
                .most = objective * (1 + r->options->worst_rise),
                .most_of_cell = plan->work.corner ? r->sums.radius_max : INFINITY,
                .limits = pl_run_worst_limits(r, PL_LIMIT_MARGIN),
                .state = pl_alloc(plan->work.n_elements, sizeof *p.state),
                .before = pl_alloc(plan->work.n_nodes * plan->dim, sizeof *p.before)};
    int status = p.state && p.before ? PLANISH_OK : pl_fail_memory(error, "the worst elements");
    pl_log(PLANISH_LOG_DETAIL, "improving the worst elements");
    if (!status && !getenv("NOSTAGES"))
        run_stages(&p);
    if (!status)
        pl_joint_run(r, p.state, p.most, find_for_joint, &p);
    if (r->result->worst_sweeps > 0) {
        r->result->objective_of_worst = objective;
        r->result->worst_before = before;
        r->result->worst_after = worst_of(r);
    }
    pl_free(p.state);
    pl_free(p.before);
    return status;
}
