/* kernel_guarded: visits of stars with other objectives, minimum volumes and bounds.
 *
 *   visit_star          move the node of a star to a better place: kept_visit or full_visit
 *   optimality_range    first-order optimality of stars
 *   evaluate_at         the function of a star
 *
 * kernel_entry.h includes this file for the guarded kernel. kernel_visit.h has the plain problem
 * alone, faster.
 */
#ifndef PL_STAR_KERNEL_GUARDED_H
#define PL_STAR_KERNEL_GUARDED_H

#include "star/kernel_feasible.h"
#include "star/kernel_kept.h"

/* An optimum's constraints are in force within this of g = 0: as far as the violated ones. */
#define FORCE_BAND VIOLATED_ABOVE
/* Steps of a visit that brings elements up, and of one along constraints: each may meet another. */
enum { RESTORING_STEPS = 4, CONSTRAINED_STEPS = 4 };
/* A visit along constraints that brought more than this, relative, is worth another one. */
#define CONSTRAINED_FALL 1e-8

/** Find the function and derivatives at x, in the node's directions, with the columns that
 *  directions and steps need. derive: 1 or PL_GRADIENT_ALONE. */
PL_INLINE objective find_derivatives(local *here, const double *x, derivatives *derivative,
                                     const int derive, const int dim) {
    ++*here->evaluations;
    const objective now = guarded_at(&here->s, &here->q, x, derivative, derive, dim);
    if (here->slide.kind == PLANISH_CONSTRAINT_FREE)
        return now;
    double place[3];
    for (int d = 0; d < dim; d++)
        place[d] = x[d] * here->s.unscale;
    if (here->slide.of->kind == PLANISH_CONSTRAINT_ON_SURFACE &&
        !slide_ask(here->problem, &here->slide, place, NULL, dim)) {
        for (int d = 0; d < dim; d++)
            derivative->gradient[d] = 0; /* no direction is downhill */
        return now;
    }
    slide_along(&here->slide, derivative->gradient, dim);
    if (derive != PL_GRADIENT_ALONE)
        slide_hessian(&here->slide, derivative->hessian, dim);
    return now;
}

/** Whether the star is to be improved: valid, and bad enough. */
static inline int worth_a_step(const local *here, const double *x, const objective *now,
                               const int dim) {
    const double skip = here->problem->rr2_skip;
    if (!now->positive || !(now->sum < INFINITY))
        return 0;
    if (is_of_worst(here->q.objective))
        return now->max > 1;
    if (is_of_ratio(here) || !(skip > 0))
        return now->max > skip;
    return value_at(&here->s, x, 1, dim).max > skip;
}

/** Move the node to the trial position. */
static inline void move_to_trial(const trial *t, double *x, objective *now, const int dim) {
    for (int d = 0; d < dim; d++)
        x[d] = t->position[d];
    *now = t->value;
}

/** Take one step of cases 1 and 2 in a direction of this kind. */
static inline int step_by(local *here, planish_search kind, conjugate *memory, double *x,
                          objective *now, const derivatives *derivative, const int dim) {
    double direction[3];
    trial best;
    here->kind = kind;
    if (!guarded_direction(here, x, now, derivative, memory, direction, dim))
        return 0;
    double slope = dot(derivative->gradient, direction, dim);
    if (!(slope < 0) || !search(here, x, now, direction, slope, &best, 1, dim))
        return 0;
    move_to_trial(&best, x, now, dim);
    return 1;
}

/** Step until nothing improves or the steps are used up; returns how many steps were taken. */
static inline int guarded_steps(local *here, double *x, objective *now, derivatives *derivative,
                                const int dim) {
    const planish_search kind = here->problem->search;
    conjugate memory = {{0, 0, 0}, 0};
    int moves = 0, wanted;
    do {
        const double before = now->sum;
        if (!worth_a_step(here, x, now, dim))
            break;
        /* The limit on the radius ratio is no part of other objectives, and Newton's direction may
         * run into it: then that of steepest descent is tried. */
        conjugate none = {{0, 0, 0}, 0};
        if (!step_by(here, kind, &memory, x, now, derivative, dim) &&
            !(kind == PLANISH_SEARCH_NEWTON && !is_of_ratio(here) &&
              step_by(here, PLANISH_SEARCH_FLETCHER_REEVES, &none, x, now, derivative, dim)))
            break;
        /* With a weight of the volumes, the function is F's only next to where it was weighed. */
        const double fall = here->q.volume_weight > 0 ? 0 : before - now->sum;
        wanted = here->constrained ? CONSTRAINED_STEPS : steps_of_visit(kind, fall, before, dim);
        if (++moves < wanted)
            *now = find_derivatives(here, x, derivative, 1, dim);
    } while (moves < wanted);
    return moves;
}

/** The largest ratio that limits are of, with the node at x, where the objective is now. */
static inline double ratio_of(const local *here, const double *x, const objective *now,
                              const int dim) {
    return is_of_ratio(here) || !has_forms(&here->s) ? now->max : value_at(&here->s, x, 1, dim).max;
}

/** Visit of a star under way. */
typedef struct visit_state {
    double x[3]; /* the node, scaled */
    objective now;
    derivatives derivative; /* at x, or where the last step began */
    double size2, before;   /* of the star, and its function, before the steps */
    int restored, moves;    /* moves that brought violated elements up, and all */
} visit_state;

/** Return the Hessian that the star keeps between visits; NULL if this problem keeps none. */
static inline pl_star_kept *kept_of(const local *here, int64_t index, const int dim) {
    const pl_star_problem *problem = here->problem;
    const int keeps = dim == 3 && problem->kept && problem->search == PLANISH_SEARCH_NEWTON &&
                      has_gradient_alone(&here->q);
    return keeps ? &problem->kept[index] : NULL;
}

/** Step by the Hessian that was kept, where no constraint is near; returns whether it did. */
static inline int step_by_kept(local *here, const pl_star_kept *kept, visit_state *v) {
    double direction[3];
    trial best;
    if (is_near_constraint(here, v->x, &v->now, &v->derivative, 3) ||
        !kept_direction(here, kept, &v->now, &v->derivative, direction, 3))
        return 0;
    if (here->slide.kind != PLANISH_CONSTRAINT_FREE)
        slide_along(&here->slide, direction, 3);
    const double slope = dot(v->derivative.gradient, direction, 3);
    if (!(slope < 0) || !search(here, v->x, &v->now, direction, slope, &best, 1, 3))
        return 0;
    move_to_trial(&best, v->x, &v->now, 3);
    return 1;
}

/** Visit the star by the Hessian that was kept. Returns whether that is enough; if not, the star
 *  keeps none any more. */
static inline int kept_visit(local *here, pl_star_kept *kept, visit_state *v) {
    v->now = find_derivatives(here, v->x, &v->derivative, PL_GRADIENT_ALONE, 3);
    v->size2 = v->derivative.size2;
    v->before = v->now.sum;
    if (v->now.positive && !(v->now.largest_g > ACTIVE_ABOVE) &&
        !worth_a_step(here, v->x, &v->now, 3))
        return 1;
    v->moves = v->now.positive && step_by_kept(here, kept, v);
    if (!v->moves)
        kept->sum = 0;
    return v->moves;
}

/** Bring violated elements up, if that is wanted. */
static inline void restoring_steps(local *here, visit_state *v, const int dim) {
    while (!here->problem->guard->keep_below && v->restored < RESTORING_STEPS &&
           v->now.largest_g > violated_above(here)) {
        trial best;
        if (!restore(here, v->x, &v->now, &v->derivative, &best, dim))
            return;
        move_to_trial(&best, v->x, &v->now, dim);
        v->now = find_derivatives(here, v->x, &v->derivative, 1, dim);
        v->restored++;
    }
}

/** Visit the star by the derivatives with the Hessian, which is kept if it led to the optimum and no
 *  constraint is near. Returns 0 if the star cannot be visited. */
static inline int full_visit(local *here, pl_star_kept *kept, visit_state *v, const int dim) {
    v->now = find_derivatives(here, v->x, &v->derivative, 1, dim);
    if (here->slide.kind != PLANISH_CONSTRAINT_FREE && !v->now.positive)
        return 0; /* no facet of the surface can fold over only while the elements are positive */
    v->size2 = v->derivative.size2;
    restoring_steps(here, v, dim);
    v->moves = v->restored;
    v->before = v->now.sum;
    if (here->problem->guard->keep_below || !(v->now.largest_g > violated_above(here)))
        v->moves += guarded_steps(here, v->x, &v->now, &v->derivative, dim);
    if (kept && v->moves <= 1 && !v->restored && !here->constrained &&
        v->before - v->now.sum < KEEP_BELOW * v->before)
        keep_hessian(here, kept, v->derivative.hessian, v->before);
    return 1;
}

/** Visit one star with a guard. */
static inline void visit_star(const pl_star_problem *problem, int64_t index, int flags,
                              double *scratch, pl_star_tally *tally, const int dim) {
    int32_t node = problem->node[index];
    double *place = problem->coordinates + (int64_t)node * dim;
    local here;
    local_init(&here, problem, index, place, NULL, scratch, &tally->evaluations, 1, dim);
    pl_star_kept *kept = kept_of(&here, index, dim);
    visit_state v = {.moves = 0};
    here.alone = (flags & PL_TOLD) != 0;
    to_star(&here, place, v.x, dim);
    if (!(kept && kept->sum > 0 && !here.alone && kept_visit(&here, kept, &v)) &&
        !full_visit(&here, kept, &v, dim))
        return;
    const double fell = v.before - v.now.sum;
    if (v.moves) {
        const int for_more =
            v.restored || here.constrained || here.q.volume_weight > 0 || here.q.penalty > 0;
        move_node(&here, node, v.x, v.size2, for_more ? FALL_TOLD : fell / v.before, 1, place, dim);
    }
    if (here.constrained && fell > CONSTRAINED_FALL * v.before)
        __atomic_fetch_or(&problem->changed[node], PL_CHANGED, __ATOMIC_RELAXED);
    const double ratio = ratio_of(&here, v.x, &v.now, dim);
    note_ratio(tally, ratio);
    note_gain(tally, index, ratio, v.moves > v.restored ? fell : 0, fell > IMPROVED * v.before,
              v.restored > 0);
}

/** Add the star's projected gradient and multipliers. */
static inline void add_optimality(const pl_star_problem *problem, int64_t index, double *scratch,
                                  pl_star_optimality *sum, const int dim) {
    const double *place = problem->coordinates + (int64_t)problem->node[index] * dim;
    int64_t evaluations = 0;
    double x[3], direction[3];
    local here;
    local_init(&here, problem, index, place, NULL, scratch, &evaluations, 1, dim);
    const star *s = &here.s;
    derivatives derivative;
    cone_point point;
    to_star(&here, place, x, dim);
    objective now = find_derivatives(&here, x, &derivative, 1, dim);
    if (!now.positive || now.largest_g > violated_above(&here) || !(now.sum < INFINITY))
        return;
    const double size = sqrt(derivative.size2);
    const factors identity = {.pivot = {1, 1, 1}, .inverse = {1, 1, 1}};
    active a = active_within(&here, x, FORCE_BAND, size, dim);
    if (!project_direction(&derivative, &identity, &a, direction, &point, dim))
        return;
    double rest = sqrt(dot(direction, direction, dim)) * size;
    double residual = now.sum > 0 ? rest / now.sum : 0; /* f is 0 at its very best */
    sum->residual = residual > sum->residual ? residual : sum->residual;
    pl_sum_add(&sum->residual2, residual * residual);
    sum->n_stars++;
    for (int i = 0; i < point.n_active; i++) {
        int64_t facet = (int64_t)a.rows[point.active[i]][ROW_LENGTH - 1];
        sum->n_active++;
        if (facet == OF_BOUND)
            continue;
        double steepness = *entry(s, LENGTH, facet) * *entry(s, INVERSE_FLOOR, facet);
        double multiplier = point.multiplier[i] / steepness;
        sum->multiplier = multiplier > sum->multiplier ? multiplier : sum->multiplier;
    }
}

/** Add the optimality of stars begin .. end - 1. */
static inline void optimality_range(const pl_star_problem *problem, int64_t begin, int64_t end,
                                    double *scratch, pl_star_optimality *sum, const int dim) {
    for (int64_t i = begin; i < end; i++)
        if (!pl_star_is_held(problem->guard, problem->node[i], dim))
            add_optimality(problem, i, scratch, sum, dim);
}

/** Evaluate the star with its node at x; with_derivatives as for pl_star_evaluate_fn. */
static inline objective evaluate_at(local *here, const double *x, int with_derivatives,
                                    derivatives *derivative, const int dim) {
    return with_derivatives ? find_derivatives(here, x, derivative, with_derivatives, dim)
                            : guarded_at(&here->s, &here->q, x, NULL, 0, dim);
}

#endif
