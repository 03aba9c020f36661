/* visit: look at one star after another and move their nodes to better places.
 *
 * Included by every kernel_*.c after it has defined PL_PACK; see kernel.c.
 */
#ifndef PL_STAR_VISIT_H
#define PL_STAR_VISIT_H

#include "star/step.h"

/* A move shorter than this fraction of the star's size changes nothing for the stars around. */
#define STILL 1e-4
/* No direction is longer than this many sizes (root mean square distance of the link) of a star. */
#define STEP_LIMIT 2.0

/** Steps of one visit: one Newton step (more sweeps beat more steps), but as many conjugate
 *  directions as there are coordinates, or they would never be conjugate. */
static inline int steps_of_visit(planish_direction direction, const int dim) {
    return direction == PLANISH_NEWTON ? 1 : dim;
}

static inline int find_direction(const pl_star_problem *problem, const derivatives *derivative,
                                 conjugate *memory, double *direction, const int dim) {
    int found = problem->direction == PLANISH_NEWTON
                    ? newton_direction(derivative->gradient, derivative->hessian, direction, dim)
                    : fletcher_reeves_direction(derivative->gradient, derivative->hessian,
                                                derivative->size2, memory, direction, dim);
    if (!found)
        return 0;
    double length2 = dot(direction, direction, dim);
    double limit2 = STEP_LIMIT * STEP_LIMIT * derivative->size2;
    if (length2 > limit2) {
        double factor = sqrt(limit2 / length2);
        for (int d = 0; d < dim; d++)
            direction[d] *= factor;
    }
    return 1;
}

/** Tell the nodes of the star, and its own, that their stars have changed. Several threads may tell
 *  one node at the same time, the same. */
static inline void tell_neighbours(const pl_star_problem *problem, int32_t node, const star *s) {
    __atomic_store_n(&problem->changed[node], 1, __ATOMIC_RELAXED);
    for (int64_t i = 0; i < s->n_ring; i++)
        __atomic_store_n(&problem->changed[s->ring[i]], 1, __ATOMIC_RELAXED);
}

/** One step from x (scaled, changed if a better place is found); returns by how much the sum of
 * RR^2 fell, 0 for no step. */
static inline double one_step(const pl_star_problem *problem, const star *s, conjugate *memory,
                              double *x, double *size2, const int dim) {
    derivatives derivative;
    double direction[3];
    trial best;
    objective now = derivatives_at(s, x, &derivative, dim);
    *size2 = derivative.size2;
    if (!now.positive || !(now.sum < INFINITY) || !(now.max > problem->rr2_skip))
        return 0;
    if (!find_direction(problem, &derivative, memory, direction, dim))
        return 0;
    double slope = dot(derivative.gradient, direction, dim);
    if (!(slope < 0) || !search(problem, s, x, &now, direction, slope, &best, dim))
        return 0;
    for (int d = 0; d < dim; d++)
        x[d] = best.position[d];
    return now.sum - best.value.sum;
}

/** Improve one star; returns by how much the sum of RR^2 fell. */
static inline double visit_star(const pl_star_problem *problem, int64_t index, double *scratch,
                                const int dim) {
    int32_t node = problem->node[index];
    double *place = problem->coordinates + (int64_t)node * dim;
    star s = gather(problem, index, place, scratch, dim);
    conjugate memory = {{0, 0, 0}, 0};
    double x[3], decrease = 0, moved2 = 0, size2 = 0;
    for (int d = 0; d < dim; d++)
        x[d] = place[d] * s.scale;
    for (int step = 0; step < steps_of_visit(problem->direction, dim); step++) {
        double fall = one_step(problem, &s, &memory, x, &size2, dim);
        if (!(fall > 0))
            break;
        decrease += fall;
    }
    if (!(decrease > 0))
        return 0;
    for (int d = 0; d < dim; d++) {
        double move = x[d] - place[d] * s.scale;
        moved2 += move * move;
        place[d] = x[d] * s.unscale;
    }
    if (moved2 > STILL * STILL * size2)
        tell_neighbours(problem, node, &s);
    return decrease;
}

static inline pl_star_tally visit_range(const pl_star_problem *problem, int64_t begin, int64_t end,
                                        double *scratch, const int dim) {
    pl_star_tally tally = {0, 0};
    for (int64_t i = begin; i < end; i++) {
        uint8_t *changed = &problem->changed[problem->node[i]];
        if (!__atomic_load_n(changed, __ATOMIC_RELAXED))
            continue;
        __atomic_store_n(changed, 0, __ATOMIC_RELAXED);
        tally.decrease += visit_star(problem, i, scratch, dim);
        tally.visits++;
    }
    return tally;
}

static inline int evaluate(const pl_star_problem *problem, int64_t index, double *scratch,
                           int with_derivatives, pl_star_value *value, const int dim) {
    const double *place = problem->coordinates + (int64_t)problem->node[index] * dim;
    star s = gather(problem, index, place, scratch, dim);
    double x[3];
    for (int d = 0; d < dim; d++)
        x[d] = place[d] * s.scale;
    derivatives derivative = {{0}, {0}, 0};
    objective f = with_derivatives ? derivatives_at(&s, x, &derivative, dim) : value_at(&s, x, dim);
    value->sum = f.sum;
    value->max = f.max;
    for (int d = 0; d < 3; d++)
        value->gradient[d] = derivative.gradient[d] * s.scale;
    for (int d = 0; d < 6; d++)
        value->hessian[d] = derivative.hessian[d] * s.scale * s.scale;
    return f.positive;
}

/* ---- the functions of a variant ------------------------------------------------------------ */

static pl_star_tally visit_triangles(const pl_star_problem *problem, int64_t begin, int64_t end,
                                     double *scratch) {
    return visit_range(problem, begin, end, scratch, 2);
}

static pl_star_tally visit_tetrahedra(const pl_star_problem *problem, int64_t begin, int64_t end,
                                      double *scratch) {
    return visit_range(problem, begin, end, scratch, 3);
}

static int evaluate_triangles(const pl_star_problem *problem, int64_t star_index, double *scratch,
                              int with_derivatives, pl_star_value *value) {
    return evaluate(problem, star_index, scratch, with_derivatives, value, 2);
}

static int evaluate_tetrahedra(const pl_star_problem *problem, int64_t star_index, double *scratch,
                               int with_derivatives, pl_star_value *value) {
    return evaluate(problem, star_index, scratch, with_derivatives, value, 3);
}

#endif
