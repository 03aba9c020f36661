/* worst: a last phase for the worst elements, which an average does not care for.
 *
 * The measure's limit falls in stages. In each the elements above it are brought below: by steps of
 * patches (joint.h), all patches at once that have no cell in common, the worst elements first. Nodes that
 * patches do not move, those on surfaces and in periodic pairs, are moved by sweeps: only stars that
 * hold something above the limit are visited, to minimise a high power of the measure, which is next
 * to its maximum. A stage that neither improves the worst element nor leaves fewer elements above, or
 * makes F rise by more than is allowed, is undone. The phase has a budget of work, counted in evaluations and
 * visits, so that its end does not depend on the clock.
 */
#include "improve/gather.h"
#include "improve/improve.h"
#include "improve/joint_create.h"
#include "improve/joint_measures.h"
#include "improve/joint_patch.h"
#include "improve/joint_steps.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What the limit of a measure (RR, or 1 / sin of an angle; mu of a corner, or 1 / SJ) has above 1
 * falls by this factor from stage to stage, */
#define STAGE_FACTOR 0.9
/* from the worst there is, but no more than this, to this. */
#define STAGE_MOST  1e4
#define STAGE_LEAST 1.05
enum { STAGE_SWEEPS = 20, HALVINGS = 3, STEPS = 3 };
/* Nodes up to which a mesh is small: several ways are tried, for all of them take little time. */
enum { SMALL_MESH = 10000 };
/* Worst elements are the same within this, relative. */
#define SAME 1e-6
/* Stages of sweeps alone end after so many that have not made the worst element better by this part. */
enum { CALM_STAGES = 5 };
#define CALM 1e-3
/* The sweeps of a stage end when no more than one star in so many improves. */
enum { FEW = 50 };
/* Tries of one patch in a step; and of all stages together, where the worst element is at its limit: so
 * many, and one for each so many nodes. */
enum { TRIES = 60, TRIES_AT_LEAST = 100, NODES_PER_TRY = 250 };
/* Work of all patches, in evaluations of elements, each of which takes as long as a visit, roughly: at
 * most one for each visit before the phase; in small meshes WORK_AT_LEAST and WORK_EACH for each visit,
 * up to WORK_OF_SMALL. That is for the default worst_rise. A larger one gives as many times more, up to
 * MOST_TIMES. */
enum { WORK_AT_LEAST = 30000, WORK_EACH = 14, WORK_OF_SMALL = 150000, MOST_TIMES = 10 };
#define USUAL_RISE 0.01
/* A stage takes at most half of the work that is left; with less than this part the phase ends. */
#define WORK_LEFT (1.0 / 32)
/* The first try of a patch takes so much work for each node, roughly. */
enum { WORK_OF_NODE = 100 };
/* Visits of sweeps alone in a small mesh: so many for each visit before the phase, or so many. */
enum { VISITS_EACH = 2, VISITS_AT_LEAST = 200000 };

/** Stages under way. */
typedef struct stages {
    pl_run *run;
    uint8_t *state;        /* [n_elements] */
    double *before;        /* [n_nodes][dim] where a stage started */
    double most;           /* F, */
    double most_of_cell;   /* and with corners AR^2 of a cell */
    pl_star_limits limits; /* of all elements, in all stages */
    pl_joint joint;
    pl_gather gather; /* of a mesh in parts */
    int32_t round;
    pl_joint_patch *patch; /* [n_patches] of the stage */
    int64_t n_patches;
    pl_joint_patch **chosen; /* [n_chosen] of the round */
    int64_t n_chosen;
    int64_t tries;
    int64_t work, most_work; /* of all patches: evaluations of elements so far, and at most; */
    int64_t most_of_stage;   /* at the end of the stage */
    int64_t most_visits;     /* of the run, while sweeps alone are tried */
    int has_patches;         /* in the stages, */
    int has_sweeps;   /* and sweeps, after these; without they go as far as this many of such: */
    int n_steps;      /* and */
    int is_competing; /* not 0: no element becomes worse than the worst was before all stages; 0: than
                         before the stage */
    int64_t visits;   /* most of a sweep */
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

/* ---- patches -------------------------------------------------------------------------------- */

/** Order of patches: the worst first. */
static int compare_patches(const void *a, const void *b) {
    const pl_joint_patch *x = a, *y = b;
    if (x->value != y->value)
        return x->value < y->value ? -1 : 1;
    return pl_joint_compare(&x->of, &y->of);
}

/** Whether a cell of the patch's nodes has nodes of a patch of this round. */
static int is_near(const stages *p, const pl_joint_patch *patch) {
    const pl_joint_mesh *mesh = &p->joint.mesh;
    int any = 0;
    for (int i = 0; i < patch->n && !any; i++) {
        const pl_joint_star star = pl_joint_star_of(&p->joint, patch->node[i]);
        const int64_t *begin = star.stars->ring_offset + star.at;
        any = mesh->near[patch->node[i]] == p->round;
        for (int64_t k = begin[0]; k < begin[1] && !any; k++)
            any = mesh->moved[star.stars->ring[k]] == p->round;
    }
    return any;
}

/** Mark the patch's nodes as moved in this round, and all nodes of their cells as near. */
static void mark_patch(const stages *p, const pl_joint_patch *patch) {
    const pl_joint_mesh *mesh = &p->joint.mesh;
    for (int i = 0; i < patch->n; i++) {
        const pl_joint_star star = pl_joint_star_of(&p->joint, patch->node[i]);
        const int64_t *begin = star.stars->ring_offset + star.at;
        mesh->moved[patch->node[i]] = mesh->near[patch->node[i]] = p->round;
        for (int64_t k = begin[0]; k < begin[1]; k++)
            mesh->near[star.stars->ring[k]] = p->round;
    }
}

/** Choose the open patches of a round, the worst first: no cell has nodes of two of them, and there is
 *  work left for them. */
static void choose_patches(stages *p) {
    int64_t left = p->most_of_stage - p->work;
    p->n_chosen = 0;
    p->round++;
    for (int64_t i = 0; i < p->n_patches; i++) {
        pl_joint_patch *patch = &p->patch[i];
        if (patch->state == PL_JOINT_OPEN) {
            patch->value = pl_joint_value(&p->joint, &patch->seed);
            if (patch->value >= p->joint.wanted)
                patch->state = PL_JOINT_DONE;
        }
    }
    if (p->n_patches > 1)
        qsort(p->patch, (size_t)p->n_patches, sizeof *p->patch, compare_patches);
    for (int64_t i = 0; i < p->n_patches && left > 0; i++)
        if (p->patch[i].state == PL_JOINT_OPEN && !is_near(p, &p->patch[i])) {
            mark_patch(p, &p->patch[i]);
            left -= (int64_t)WORK_OF_NODE * p->patch[i].n;
            p->chosen[p->n_chosen++] = &p->patch[i];
        }
}

/** Whether other processes have parts of the mesh. */
static int is_in_parts(const stages *p) {
    return p->gather.joint != NULL;
}

static void improve_chosen(void *context, int64_t begin, int64_t end, int thread) {
    const stages *p = context;
    for (int64_t i = begin; i < end; i++)
        if (!is_in_parts(p) || pl_gather_is_own(&p->gather, p->chosen[i]))
            pl_joint_improve(&p->joint, thread, p->chosen[i]);
}

/** List the vertices [*n][dim + 1] of the elements that find_bad has found, in *node, the caller's to
 *  free. Return 0 if another process fails. */
static int list_elements(stages *p, int64_t n_bad, int32_t **node, int64_t *n) {
    const planish_plan *plan = p->run->plan;
    if (is_in_parts(p)) {
        pl_gather_begin(&p->gather);
        return pl_gather_elements(&p->gather, p->state, node, n);
    }
    *n = 0;
    *node = pl_alloc(n_bad * (plan->dim + 1), sizeof **node);
    for (int64_t i = 0; *node && i < plan->work.n_elements; i++) {
        const int32_t *corner = plan->work.elements + i * (plan->dim + 1);
        if (p->state[i] != PL_WORSE || !pl_any_moves(plan->work.mobility, corner, plan->dim + 1))
            continue;
        for (int v = 0; v <= plan->dim; v++)
            (*node)[*n * (plan->dim + 1) + v] = plan->inner[corner[v]];
        ++*n;
    }
    return 1;
}

/** List the patches of the stage: of the n_bad elements that find_bad has found; none without
 *  memory. Return 0 if another process fails. */
static int list_patches(stages *p, int64_t n_bad) {
    const int corners = p->run->plan->dim + 1;
    int32_t *node = NULL;
    int64_t n = 0;
    int is_fine = list_elements(p, n_bad, &node, &n);
    if (is_fine && node) {
        p->patch = pl_alloc(n, sizeof *p->patch);
        p->chosen = pl_alloc(n, sizeof *p->chosen);
    }
    const int has_room = !pl_parts_any(!p->patch || !p->chosen);
    for (int64_t i = 0; is_fine && has_room && i < n; i++)
        p->n_patches += pl_joint_seed(&p->joint, node + i * corners, &p->patch[p->n_patches]);
    pl_free(node);
    return is_fine;
}

/** Note which elements of the stage are at their limits. */
static void note_pinned(stages *p) {
    pl_joint *joint = &p->joint;
    int64_t n = joint->n_pinned;
    for (int64_t i = 0; i < p->n_patches; i++)
        n += p->patch[i].state == PL_JOINT_PINNED;
    pl_joint_pinned *pinned = n > joint->n_pinned ? pl_alloc(n, sizeof *pinned) : NULL;
    if (!pinned)
        return;
    if (joint->n_pinned > 0)
        memcpy(pinned, joint->pinned, (size_t)joint->n_pinned * sizeof *pinned);
    n = joint->n_pinned;
    for (int64_t i = 0; i < p->n_patches; i++)
        if (p->patch[i].state == PL_JOINT_PINNED) {
            pinned[n] = p->patch[i].of;
            pinned[n++].value = p->patch[i].value;
        }
    qsort(pinned, (size_t)n, sizeof *pinned, pl_joint_compare);
    pl_free(joint->pinned);
    joint->pinned = pinned;
    joint->n_pinned = n;
}

/** Improve the chosen patches; counted as a sweep. Not 0 if the run is to end. */
static int improve_round(stages *p) {
    pl_run *r = p->run;
    pl_sweep_tally tally = {0};
    pl_run_begin_sweep(r);
    pl_parallel_for(r->plan->threads, p->n_chosen, 1, improve_chosen, p);
    pl_follow(r->plan, &r->problem);
    tally.stars.visits = p->n_chosen;
    const int is_fine = !is_in_parts(p) || pl_gather_places(&p->gather, p->chosen, p->n_chosen);
    tally.stopped = is_fine ? pl_run_ask_all(r, 1, p->n_chosen) : PLANISH_STOP_INTERRUPTED;
    p->tries += p->n_chosen;
    for (int64_t i = 0; i < p->n_chosen; i++)
        p->work += p->chosen[i]->work;
    r->result->worst_sweeps++;
    return pl_run_end_sweep(r, &tally);
}

/** Bring the patches' elements below a limit, a square. Not 0 if the run is to end. */
static int improve_to(stages *p, double limit) {
    p->joint.wanted = pl_joint_value_of(p->run, limit);
    for (int64_t i = 0; i < p->n_patches; i++)
        if (p->patch[i].state == PL_JOINT_DONE)
            p->patch[i].state = PL_JOINT_OPEN;
    for (int i = 0; i < TRIES; i++) {
        if (is_in_parts(p) && !pl_gather_patches(&p->gather, p->patch, p->n_patches))
            return 1;
        choose_patches(p);
        if (p->n_chosen == 0)
            return 0;
        if (improve_round(p))
            return 1;
    }
    return 0;
}

/** Whether elements of the stage are at their limits. */
static int has_pinned(const stages *p) {
    int any = 0;
    for (int64_t i = 0; i < p->n_patches; i++)
        any |= p->patch[i].state != PL_JOINT_DONE;
    return any;
}

/** Bring elements from a limit to another one, *to, by patches: in steps, because a patch that goes far
 *  at once leaves its neighbours less. The last step is the first in which an element is at its limit;
 *  *to becomes its limit. Not 0 if it was cut short. */
static int improve_patches(stages *p, double from, int64_t n_bad, double *to) {
    const double most = *to;
    int stopped = 0;
    p->joint.wanted = pl_joint_value_of(p->run, most * most);
    if (!list_patches(p, n_bad))
        return 1;
    for (int i = 1; i <= p->n_steps && !stopped && (i == 1 || !has_pinned(p)); i++) {
        *to = from + (most - from) * i / p->n_steps;
        stopped = improve_to(p, *to * *to);
    }
    /* Now: sweeps that follow do not reach the nodes that other processes have gathered. */
    for (int64_t i = 0; i < p->n_patches; i++)
        p->patch[i].value = pl_joint_value(&p->joint, &p->patch[i].seed);
    return stopped;
}

/* ---- stages --------------------------------------------------------------------------------- */

/** Bring elements below limit, a square, by sweeps of the stars that are marked as changed. Not 0 if
 *  it was cut short. */
static int improve_by_sweeps(stages *p, double limit) {
    pl_run *r = p->run;
    int64_t most = 0;
    int stopped = 0;
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
    return stopped;
}

/** Mark the nodes of the elements that find_bad has found. */
static void mark_bad(const stages *p) {
    const planish_plan *plan = p->run->plan;
    memset(plan->scratch.changed, 0, (size_t)plan->work.n_nodes);
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        for (int j = 0; p->state[i] == PL_WORSE && j <= plan->dim; j++)
            plan->scratch.changed[pl_plan_inner(plan, i, j)] = 1;
}

/** Worst measure of all, a square. */
static double worst_square(const pl_run *r) {
    const pl_star_limits worst = pl_run_worst_limits(r, 1);
    return is_of_angle(r) ? worst.acuteness : worst.rr2;
}

/** Number of patches of the stage whose elements were below a limit, a square, when it began. */
static int64_t count_good(const stages *p, double limit) {
    const double value = pl_joint_value_of(p->run, limit);
    int64_t n = 0;
    for (int64_t i = 0; i < p->n_patches; i++)
        n += p->patch[i].of.value >= value;
    return n;
}

/** Try a stage: bring the elements above a limit, *to, below it; from: the limit of the stage before.
 *  *to becomes a larger one if the stage ended there. *failed: F rose too much in it. The stage stands if
 *  not, and if the worst element is better or fewer are above the limit. Not 0 if it was cut short. */
static int try_stage(stages *p, double from, double *to, int *failed) {
    pl_run *r = p->run;
    const double worst = worst_square(r), limit = *to * *to;
    const int64_t n_bad = find_bad(p, limit);
    pl_trial trial;
    *failed = 0;
    if (n_bad == 0)
        return 0;
    pl_trial_begin(r, 1, p->before, &trial);
    r->phase = PLANISH_PHASE_WORST;
    p->joint.least = pl_joint_value_of(r, worst);
    p->n_patches = 0;
    p->most_of_stage = p->work + (p->most_work - p->work) / 2;
    int stopped = p->has_patches ? improve_patches(p, from, n_bad, to) : 0;
    if (!stopped && p->has_sweeps && find_bad(p, limit) > 0) {
        mark_bad(p);
        stopped = improve_by_sweeps(p, limit);
    }
    pl_run_measure(r);
    const double now = worst_square(r);
    *failed = !(pl_run_objective(r) <= p->most && r->sums.radius_max <= p->most_of_cell);
    const int is_better = !p->is_competing && now < worst;
    const int is_taken = !*failed && (p->is_competing || now <= worst) &&
                         (is_better || find_bad(p, *to * *to) < n_bad - count_good(p, *to * *to));
    pl_trial_end(&trial, is_taken);
    if (is_taken)
        note_pinned(p);
    pl_free(p->patch);
    pl_free(p->chosen);
    p->patch = NULL;
    p->chosen = NULL;
    return stopped;
}

/** Whether the worst element is at its limit. */
static int is_worst_pinned(const stages *p) {
    const pl_joint *joint = &p->joint;
    const double worst = pl_joint_value_of(p->run, worst_square(p->run));
    double least = INFINITY;
    for (int64_t i = 0; i < joint->n_pinned; i++)
        least = fmin(least, joint->pinned[i].value);
    return worst >= least * (1 - PL_JOINT_LOSS);
}

/** Number of nodes of the plan's mesh, in all processes. */
static int64_t count_nodes(const planish_plan *plan) {
    int64_t n = plan->work.n_nodes - pl_parts_ghosts(plan->work.n_nodes);
    pl_parts_add(&n, 1);
    return n;
}

/** Whether stages have used the work that patches may take, or the visits of sweeps alone. */
static int is_spent(const stages *p) {
    if (!p->has_patches)
        return p->run->result->visits >= p->most_visits;
    return (double)(p->most_work - p->work) < WORK_LEFT * (double)p->most_work;
}

/** Lower the limit stage by stage. Not 0 if it was cut short. */
static int run_stages(stages *p) {
    const int64_t tries = TRIES_AT_LEAST + count_nodes(p->run->plan) / NODES_PER_TRY;
    double reached = fmin(sqrt(worst_square(p->run)), STAGE_MOST), refused = 1;
    int calm = 0;
    for (int failures = 0; failures <= HALVINGS && reached > STAGE_LEAST;) {
        const double before = sqrt(worst_square(p->run));
        const double part =
            p->n_steps > 1 ? STAGE_FACTOR * STAGE_FACTOR * STAGE_FACTOR : STAGE_FACTOR;
        double next = failures == 0 ? 1 + (reached - 1) * part : (reached + refused) / 2;
        int failed;
        if (try_stage(p, reached, &next, &failed))
            return 1;
        const double worst = sqrt(worst_square(p->run));
        const int is_pinned = p->is_competing || is_worst_pinned(p);
        if (failed && p->n_steps > 1 && !is_spent(p)) { /* again, in stages of one step */
            p->n_steps = 1;
            continue;
        }
        if (failed)
            refused = next;
        else if (!is_pinned && worst > next && worst < before * (1 - SAME))
            reached = worst; /* of an element that was not above the limit */
        else
            reached = next;
        failures += failures > 0 || failed;
        const int is_in_vain = is_pinned || !(worst < before * (1 - SAME));
        if (is_in_vain && p->tries > tries && !p->is_competing)
            return 0;
        calm = worst < before * (1 - CALM) ? 0 : calm + 1;
        if (is_spent(p) || (p->is_competing && calm == CALM_STAGES))
            return 0;
    }
    return 0;
}

/** Lower the limit by sweeps alone, from the worst there is, as long as that brings something. Not 0
 *  if it was cut short. */
static int run_sweeps(stages *p) {
    double reached = fmin(sqrt(worst_square(p->run)), STAGE_MOST), part = STAGE_FACTOR;
    p->limits = pl_run_worst_limits(p->run, PL_LIMIT_MARGIN);
    p->has_patches = 0;
    p->has_sweeps = 1;
    for (int failures = 0; failures <= HALVINGS && reached > STAGE_LEAST;) {
        double next = 1 + (reached - 1) * part;
        int failed;
        if (try_stage(p, reached, &next, &failed))
            return 1;
        const double worst = sqrt(worst_square(p->run));
        if (!(worst < reached * (1 - SAME))) {
            failures++;
            part = (1 + part) / 2;
        }
        reached = fmin(worst, reached);
        if (is_spent(p))
            return 0;
    }
    return 0;
}

/** Improve the mesh from start by sweeps alone, and keep the result if the worst element is better than
 *  it is now. skin and limits: as they were at start. */
static void compete(stages *p, const double *start, void *skin, pl_star_limits limits) {
    pl_run *r = p->run;
    const int64_t n = r->plan->work.n_nodes * r->plan->dim;
    const double worst = worst_square(r);
    double *now = pl_alloc(n, sizeof *now);
    pl_trial trial;
    if (pl_parts_any(!now)) {
        pl_free(now);
        return;
    }
    pl_trial_begin(r, 1, now, &trial);
    memcpy(r->plan->scratch.coordinates, start, (size_t)n * sizeof *start);
    pl_skin_restore(&r->skin, skin);
    pl_run_measure(r);
    p->has_patches = 0;
    p->has_sweeps = p->n_steps = p->is_competing = 1;
    p->limits = limits;
    run_stages(p);
    pl_trial_end(&trial, worst_square(r) < worst);
    pl_free(now);
}

/** Most work of all patches after so many visits. */
static int64_t work_of(double visits, double rise) {
    const double of_small = fmin(WORK_AT_LEAST + WORK_EACH * visits, WORK_OF_SMALL);
    return (int64_t)(fmax(visits, of_small) * fmax(1, fmin(rise / USUAL_RISE, MOST_TIMES)));
}

/** Improve the worst elements: by patches; and in a small mesh by sweeps then, and by sweeps alone. */
static void improve_worst(stages *p) {
    pl_run *r = p->run;
    const int64_t n = r->plan->work.n_nodes * r->plan->dim;
    const int is_small = count_nodes(r->plan) <= SMALL_MESH;
    double *start = is_small ? pl_alloc(n, sizeof *start) : NULL;
    void *skin = is_small ? pl_skin_save(&r->skin) : NULL;
    const int can_compete = is_small && !pl_parts_any(!start);
    if (can_compete)
        memcpy(start, r->plan->scratch.coordinates, (size_t)n * sizeof *start);
    const pl_star_limits limits = p->limits;
    p->has_patches = 1;
    /* Corners: patches gain less than sweeps in some meshes. */
    p->has_sweeps = p->joint.leaves_nodes || r->plan->work.corner;
    p->n_steps = p->has_sweeps ? 1 : STEPS;
    const double visits = (double)r->result->visits;
    p->most_work = work_of(visits, r->options->worst_rise);
    const int64_t more = (int64_t)fmax(VISITS_EACH * visits, VISITS_AT_LEAST);
    int stopped = run_stages(p);
    p->most_visits = r->result->visits + more;
    if (!stopped && is_small && !run_sweeps(p) && can_compete) {
        p->most_visits = r->result->visits + more;
        compete(p, start, skin, limits);
    }
    pl_free(start);
    pl_free(skin);
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

/** Limits of the run: no element shall become worse than the worst one it began with. */
static pl_star_limits limits_of_run(const pl_run *r) {
    const pl_star_limits now = pl_run_worst_limits(r, 1);
    pl_star_limits limits = r->limits_at_start;
    limits.rr2 = fmax(limits.rr2, now.rr2);
    limits.acuteness = fmax(limits.acuteness, now.acuteness);
    return limits;
}

static int prepare_stages(stages *p, planish_error *error) {
    const planish_plan *plan = p->run->plan;
    const pl_star_limits limits[2] = {pl_run_worst_limits(p->run, 1), limits_of_run(p->run)};
    p->state = pl_alloc(plan->work.n_elements, sizeof *p->state);
    p->before = pl_alloc(plan->work.n_nodes * plan->dim, sizeof *p->before);
    if (!p->state || !p->before)
        return pl_fail_memory(error, "the worst elements");
    const int status = pl_joint_create(p->run, limits, &p->joint, error);
    p->joint.most_of_cell = p->most_of_cell * PL_LIMIT_MARGIN;
    if (status || !pl_part_here())
        return status;
    return pl_gather_create(&p->joint, &p->gather, error);
}

int pl_run_worst(pl_run *r, planish_error *error) {
    const planish_plan *plan = r->plan;
    const double objective = pl_run_objective(r), before = worst_of(r);
    const double of_cell = r->worst_at_start < INFINITY ? r->worst_at_start : 0;
    stages p = {.run = r,
                .most = objective * (1 + r->options->worst_rise),
                .most_of_cell = plan->work.corner ? fmax(r->sums.radius_max, of_cell) : INFINITY,
                .limits = pl_run_worst_limits(r, PL_LIMIT_MARGIN)};
    const int status = prepare_stages(&p, error);
    pl_log(PLANISH_LOG_DETAIL, "improving the worst elements");
    const double limit_of_cells = r->watch.worst_ar2;
    if (!status) {
        pl_watch_limit(&r->watch, p.joint.most_of_cell);
        improve_worst(&p);
        pl_watch_limit(&r->watch, limit_of_cells);
    }
    if (r->result->worst_sweeps > 0) {
        r->result->objective_of_worst = objective;
        r->result->worst_before = before;
        r->result->worst_after = worst_of(r);
    }
    pl_gather_destroy(&p.gather);
    pl_joint_destroy(&p.joint);
    pl_free(p.state);
    pl_free(p.before);
    pl_free(p.joint.pinned);
    return status;
}
