/* kernel_untangle: the regularised energy of a patch.
 *
 *   untangle_range    visit stars to lower the energy
 *   energy_range      sum the energy over stars
 *
 * kernel_entry.h includes this file for the guarded kernel.
 */
#ifndef PL_STAR_KERNEL_UNTANGLE_H
#define PL_STAR_KERNEL_UNTANGLE_H

#include "star/kernel_foldover.h"
#include "star/kernel_step.h"

/* Steps of a visit: the energy is far from a parabola while elements are inverted. */
enum { UNTANGLING_STEPS = 2 };
/* A step is halved, or doubled while that pays, so often. */
enum { UNTANGLING_BACKTRACKS = 10, UNTANGLING_EXPANSIONS = 6 };

/* ---- visits -------------------------------------------------------------------------------- */

/** Trial position and its energy. */
typedef struct attempt {
    double position[3];
    regularised energy;
} attempt;

/** Evaluate the energy at the position step along direction from x. */
static inline attempt attempt_at(const local *here, double epsilon, const double *x,
                                 const double *direction, double step, const int dim) {
    attempt t = {.position = {0}};
    place_along(here, x, direction, step, t.position, 1, dim);
    t.energy = energy_at(&here->s, epsilon, t.position, NULL, 0, dim);
    ++*here->evaluations;
    return t;
}

/** Search along direction for a lower energy; return 0 if there is no such place. */
static inline int untangling_search(const local *here, double epsilon, const double *x,
                                    double energy, const double *direction, double slope,
                                    attempt *best, const int dim) {
    double step = 1;
    for (int i = 0; i < UNTANGLING_BACKTRACKS; i++, step *= 0.5) {
        *best = attempt_at(here, epsilon, x, direction, step, dim);
        if (best->energy.sum < energy + STEP_ARMIJO * slope * step)
            break;
        if (i == UNTANGLING_BACKTRACKS - 1)
            return 0;
    }
    for (int i = 0; step >= 1 && i < UNTANGLING_EXPANSIONS; i++) {
        step *= 2;
        attempt t = attempt_at(here, epsilon, x, direction, step, dim);
        if (!(t.energy.sum < best->energy.sum))
            break;
        *best = t;
    }
    return within_bounds(&here->b, best->position, dim);
}

/** Visit one star to lower its energy. */
static inline void untangle_star(const pl_star_problem *problem, int64_t index, double *scratch,
                                 pl_star_tally *tally, const int dim) {
    const int32_t node = problem->node[index];
    const double epsilon = problem->untangling->epsilon;
    double *place = problem->coordinates + (int64_t)node * dim, x[3], fall = 0, size2 = 0;
    local here;
    untangling_init(&here, problem, index, place, scratch, &tally->evaluations, dim);
    to_star(&here, place, x, dim);
    for (int step = 0; step < UNTANGLING_STEPS; step++) {
        derivatives derivative;
        double direction[3];
        attempt best;
        const regularised now = energy_at(&here.s, epsilon, x, &derivative, 1, dim);
        tally->evaluations++;
        if (step == 0)
            size2 = derivative.size2;
        if (!(now.sum < INFINITY) ||
            !newton_direction(derivative.gradient, derivative.hessian, direction, dim))
            break;
        limit_length(direction, derivative.size2, dim);
        const double slope = dot(derivative.gradient, direction, dim);
        if (!(slope < 0) ||
            !untangling_search(&here, epsilon, x, now.sum, direction, slope, &best, dim))
            break;
        memcpy(x, best.position, sizeof x);
        fall += now.sum - best.energy.sum;
    }
    if (fall > 0)
        move_node(&here, node, x, size2, FALL_TOLD, 1, place, dim);
    pl_sum_add(&tally->decrease, fall);
}

/** Whether the node of the star is in the patch. */
static inline int may_move(const pl_star_problem *problem, int64_t index) {
    return problem->untangling->in_patch[problem->node[index]];
}

/** Visit stars begin .. end - 1 of the patch. */
static inline void untangle_range(const pl_star_problem *problem, int64_t begin, int64_t end,
                                  double *scratch, pl_star_tally *tally, const int dim) {
    for (int64_t i = begin; i < end; i++) {
        if (!may_move(problem, i))
            continue;
        untangle_star(problem, i, scratch, tally, dim);
        tally->visits++;
    }
}

/* ---- the energy of a range ------------------------------------------------------------------ */

/** Sum the energy of stars begin .. end - 1; slope may be NULL. */
static inline pl_star_energy energy_range(const pl_star_problem *problem, int64_t begin,
                                          int64_t end, double *scratch, pl_star_slope *slope,
                                          const int dim) {
    pl_star_energy total = {.least = INFINITY};
    int64_t evaluations = 0;
    for (int64_t i = begin; i < end; i++) {
        if (!may_move(problem, i))
            continue;
        const double *place = problem->coordinates + (int64_t)problem->node[i] * dim;
        local here;
        untangling_init(&here, problem, i, place, scratch, &evaluations, dim);
        derivatives derivative = {{0}, {0}, 0};
        double x[3];
        to_star(&here, place, x, dim);
        const regularised now =
            slope ? energy_at(&here.s, problem->untangling->epsilon, x, &derivative, 1, dim)
                  : energy_at(&here.s, problem->untangling->epsilon, x, NULL, 0, dim);
        if (slope)
            to_mesh(&here, &derivative, slope[i - begin].gradient, slope[i - begin].hessian);
        pl_sum_add(&total.sum, now.shared);
        total.least = now.least < total.least ? now.least : total.least;
        total.tangled += (int64_t)ceil(now.tangled); /* shares of rows may be parts */
    }
    return total;
}

#endif
