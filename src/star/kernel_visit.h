/* kernel_visit: move the node of a star to a better place.
 *
 *   visit_star, one_step                       a visit, and its steps
 *   step_along, step_down                      a step along a direction
 *   find_derivatives, find_hessian             the star's function
 *   keep_scale, check_scale                    a star's scale kept from visit to visit
 *   evaluate_at                                for pl_star_evaluate_fn
 *
 * The plain problem: one ratio, volumes positive. kernel_entry.h includes this file for the kernels
 * of radius ratios and of mean ratios. kernel_guarded.h has everything else.
 */
#ifndef PL_STAR_KERNEL_VISIT_H
#define PL_STAR_KERNEL_VISIT_H

#include "star/kernel_kept.h"
#include "star/kernel_step.h"

/** Star with its node at a place. */
typedef struct visit_state {
    double x[3];  /* scaled */
    double size2; /* see derivatives; at the place before */
    double sum;   /* of RR^2, at the place before */
    double max;   /* of RR^2 */
} visit_state;

/** Find the derivatives where the node is; return 0 if no step is to be tried. */
PL_INLINE int find_derivatives(const local *here, visit_state *now, objective *f,
                               derivatives *derivative, const int with_hessian, const int dim) {
    *f = derivatives_at(&here->s, now->x, derivative, with_hessian, dim);
    ++*here->evaluations;
    now->size2 = derivative->size2;
    now->sum = f->sum;
    now->max = f->max;
    return f->positive && f->sum < INFINITY && f->max > here->problem->rr2_skip;
}

/** Find the derivatives with the Hessian: seldom called, so kept out of line of the frequent path.
 */
PL_NOINLINE int find_hessian(const local *here, visit_state *now, objective *f,
                             derivatives *derivative, const int dim) {
    return find_derivatives(here, now, f, derivative, 1, dim);
}

/** Step from where f is along direction, if that leads to a better place; returns by how much the
 *  sum fell, 0 for no step. */
static inline double step_along(const local *here, visit_state *now, const objective *f,
                                const derivatives *derivative, const double *direction,
                                const int dim) {
    trial best;
    const double slope = dot(derivative->gradient, direction, dim);
    if (!(slope < 0) || !search(here, now->x, f, direction, slope, &best, 0, dim))
        return 0;
    for (int d = 0; d < dim; d++)
        now->x[d] = best.position[d];
    now->max = best.value.max;
    return f->sum - best.value.sum;
}

/** Step along steepest descent, as step_along does, where a limit on another ratio can have stopped
 *  Newton's step: nothing of it is in his direction. */
static inline double step_down(local *here, visit_state *now, const objective *f,
                               const derivatives *derivative, const int dim) {
    conjugate none = {{0, 0, 0}, 0};
    double direction[3], fall = 0;
    if (!lowers_other_ratio(here) || here->kind != PLANISH_SEARCH_NEWTON ||
        !may_exceed_ratio(f->max, here->problem->limits.rr2, dim))
        return 0;
    here->kind = PLANISH_SEARCH_FLETCHER_REEVES;
    if (find_direction(here->kind, derivative, &none, direction, dim))
        fall = step_along(here, now, f, derivative, direction, dim);
    here->kind = PLANISH_SEARCH_NEWTON;
    return fall;
}

/** Keep the scale that the star has. */
static inline void keep_scale(const local *here, pl_star_kept *kept) {
    kept->sum = PL_SCALE_ALONE;
    kept->exponent = exponent_of(here->s.scale);
}

/** Forget the kept scale if it no longer fits the star's size. The star is then visited again with
 *  a newly chosen scale. */
PL_NOINLINE void check_scale(const local *here, int32_t node, pl_star_kept *kept,
                             const objective *f) {
    if (!kept || kept->sum == 0 || (f->positive && f->sum < INFINITY))
        return;
    kept->sum = 0;
    __atomic_store_n(&here->problem->changed[node], PL_CHANGED, __ATOMIC_RELAXED);
}

/** Take one step, if a better place is found; return by how much the sum fell, 0 for no step. Out of line
 *  visits take 6 % longer. */
PL_INLINE double one_step(local *here, int32_t node, pl_star_kept *kept, conjugate *memory,
                          visit_state *now, const int dim) {
    const pl_star_problem *problem = here->problem;
    derivatives derivative;
    double direction[3], fall;
    objective f;
    if (kept && kept->sum > 0 && !here->alone) {
        if (!find_derivatives(here, now, &f, &derivative, 0, dim)) {
            check_scale(here, node, kept, &f);
            return 0;
        }
        if (kept_direction(here, kept, &f, &derivative, direction, dim)) {
            fall = step_along(here, now, &f, &derivative, direction, dim);
            if (fall > 0)
                return fall;
        }
        keep_scale(here, kept);
    }
    if (!find_hessian(here, now, &f, &derivative, dim)) {
        check_scale(here, node, kept, &f);
        return 0;
    }
    if (!find_direction(problem->search, &derivative, memory, direction, dim))
        return 0;
    fall = step_along(here, now, &f, &derivative, direction, dim);
    if (!(fall > 0))
        fall = step_down(here, now, &f, &derivative, dim);
    if (kept && kept->sum == 0)
        keep_scale(here, kept);
    if (kept && fall < KEEP_BELOW * f.sum)
        keep_hessian(here, kept, derivative.hessian, f.sum);
    return fall;
}

/** Improve one star, which has these flags. */
static inline void visit_star(const pl_star_problem *problem, int64_t index, int flags,
                              double *scratch, pl_star_tally *tally, const int dim) {
    int32_t node = problem->node[index];
    double *place = problem->coordinates + (int64_t)node * dim;
    pl_star_kept *kept = dim == 3 && problem->kept ? &problem->kept[index] : NULL;
    /* a scale that is known need not be chosen and waited for */
    const int *exponent =
        kept && kept->sum != 0 && !(problem->rr2_skip > 0) ? &kept->exponent : NULL;
    local here;
    local_init(&here, problem, index, place, exponent, scratch, &tally->evaluations, 0, dim);
    conjugate memory = {{0, 0, 0}, 0};
    visit_state now;
    double decrease = 0;
    int steps = 0, wanted;
    here.alone = (flags & PL_TOLD) != 0;
    to_star(&here, place, now.x, dim);
    /* Most stars have no bad element by now, and need no derivatives. */
    if (problem->rr2_skip > 0) {
        ++*here.evaluations;
        now.max = value_at(&here.s, now.x, 0, dim).max;
        if (!(now.max > problem->rr2_skip)) {
            note_ratio(tally, now.max);
            acquit(problem, node);
            return;
        }
    }
    do {
        const double fall = one_step(&here, node, kept, &memory, &now, dim);
        if (!(fall > 0))
            break;
        decrease += fall;
        wanted = steps_of_visit(problem->search, fall, now.sum, dim);
    } while (++steps < wanted);
    note_ratio(tally, now.max);
    if (!(decrease > 0))
        return;
    move_node(&here, node, now.x, now.size2, decrease / now.sum, !(now.max <= problem->rr2_skip),
              place, dim);
    note_gain(tally, index, now.max, decrease, decrease > IMPROVED * now.sum, 0);
}

/** Evaluate the star with its node at x; with_derivatives as for pl_star_evaluate_fn. */
static inline objective evaluate_at(const local *here, const double *x, int with_derivatives,
                                    derivatives *derivative, const int dim) {
    if (!with_derivatives)
        return value_at(&here->s, x, 0, dim);
    if (with_derivatives == PL_GRADIENT_ALONE)
        return derivatives_at(&here->s, x, derivative, 0, dim);
    return derivatives_at(&here->s, x, derivative, 1, dim);
}

#endif
