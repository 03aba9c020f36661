/* kernel_visit: look at one star after another and move their nodes to better places.
 *
 * The plain problem: the radius ratio, volumes positive. Included by every kernel_*.c after it has
 * defined PL_PACK; see kernel.c. kernel_guarded.h has everything else.
 */
#ifndef PL_STAR_KERNEL_VISIT_H
#define PL_STAR_KERNEL_VISIT_H

#include "star/kernel_step.h"

/* ---- the plain problem --------------------------------------------------------------------- */

/** The star at its node's place. */
typedef struct state {
    double x[3];  /* scaled */
    double size2; /* see derivatives; at the place before */
    double sum;   /* of RR^2, at the place before */
    double max;   /* of RR^2 */
} state;

/* A Hessian is kept where the step that it led to brought less than this part of the star's
 * function, and serves while that is the same but for the second part. Coarser, it serves in a few
 * visits more, and on large meshes the sweeps converge more slowly. */
#define KEEP_BELOW 0.001
#define KEEP_WHILE 0.01

/** Look at the star where its node is; 0 if no step is to be tried. */
PL_INLINE int look(const local *here, state *now, objective *f, derivatives *derivative,
                   const int with_hessian, const int dim) {
    *f = derivatives_at(&here->s, now->x, derivative, with_hessian, dim);
    ++*here->evaluations;
    now->size2 = derivative->size2;
    now->sum = f->sum;
    now->max = f->max;
    return f->positive && f->sum < INFINITY && f->max > here->problem->rr2_skip;
}

/** Look at the star with its Hessian: seldom called, so kept out of line of the frequent path. */
PL_NOINLINE int look_closely(const local *here, state *now, objective *f, derivatives *derivative,
                             const int dim) {
    return look(here, now, f, derivative, 1, dim);
}

/** Step from where f is along direction, if that leads to a better place; returns by how much the
 *  sum fell, 0 for no step. */
static inline double step_along(const local *here, state *now, const objective *f,
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

/** The exponent of the star's scale at its last visit, if it will do, else NULL: what need not be
 *  chosen need not be waited for. */
static inline const int *known_scale(const pl_star_problem *problem, const pl_star_kept *kept) {
    return kept && kept->sum != 0 && !(problem->rr2_skip > 0) ? &kept->exponent : NULL;
}

/** Newton's direction by the Hessian that was kept; 0 if the star has changed too much since. */
static inline int kept_direction(const local *here, const pl_star_kept *kept, const objective *f,
                                 const derivatives *derivative, double *direction) {
    const double *g = derivative->gradient;
    const int rescaled = exponent_of(here->s.scale) - kept->exponent;
    if (!(fabs(f->sum - (double)kept->sum) <= KEEP_WHILE * f->sum) || rescaled < -1 || rescaled > 1)
        return 0;
    const double scale = power_of_two(2 * rescaled);
    for (int i = 0; i < 3; i++) {
        double sum = 0;
        for (int j = 0; j < 3; j++)
            sum += (double)kept->inverse[i <= j ? packed(i, j, 3) : packed(j, i, 3)] * g[j];
        direction[i] = -sum * scale;
    }
    limit_length(direction, derivative->size2, 3);
    return 1;
}

/** Keep the scale that the star has. */
static inline void keep_scale(const local *here, pl_star_kept *kept) {
    kept->sum = PL_SCALE_ALONE;
    kept->exponent = exponent_of(here->s.scale);
}

/** Keep the Hessian of a star with this sum, if it is positive definite. */
static inline void keep(const local *here, pl_star_kept *kept, const double *hessian, double sum) {
    double inverse[6];
    if (!invert(hessian, inverse))
        return;
    for (int i = 0; i < 6; i++)
        kept->inverse[i] = (float)inverse[i];
    kept->sum = (float)sum;
    kept->exponent = exponent_of(here->s.scale);
}

/** If the star has become of a size that the scale it kept is not for, keep nothing, and have it
 *  visited again, with a scale that is chosen. */
PL_NOINLINE void check_scale(const local *here, int32_t node, pl_star_kept *kept,
                             const objective *f) {
    if (!kept || kept->sum == 0 || (f->positive && f->sum < INFINITY))
        return;
    kept->sum = 0;
    __atomic_store_n(&here->problem->changed[node], PL_CHANGED, __ATOMIC_RELAXED);
}

/** One step, if a better place is found; returns by how much the sum fell, 0 for no step. */
static inline double one_step(const local *here, int32_t node, pl_star_kept *kept,
                              conjugate *memory, state *now, const int dim) {
    const pl_star_problem *problem = here->problem;
    derivatives derivative;
    double direction[3], fall;
    objective f;
    if (kept && kept->sum > 0 && !here->alone) {
        if (!look(here, now, &f, &derivative, 0, dim)) {
            check_scale(here, node, kept, &f);
            return 0;
        }
        if (kept_direction(here, kept, &f, &derivative, direction)) {
            fall = step_along(here, now, &f, &derivative, direction, dim);
            if (fall > 0)
                return fall;
        }
        keep_scale(here, kept);
    }
    if (!look_closely(here, now, &f, &derivative, dim)) {
        check_scale(here, node, kept, &f);
        return 0;
    }
    if (!find_direction(problem->direction, &derivative, memory, direction, dim))
        return 0;
    fall = step_along(here, now, &f, &derivative, direction, dim);
    if (kept && kept->sum == 0)
        keep_scale(here, kept);
    if (kept && fall < KEEP_BELOW * f.sum)
        keep(here, kept, derivative.hessian, f.sum);
    return fall;
}

/** Whether the star has an element that is bad enough: most have none by the time of their visit,
 *  and then derivatives would be for nothing. */
static inline int is_worth_a_step(const local *here, const double *x, const int dim) {
    const double skip = here->problem->rr2_skip;
    if (!(skip > 0))
        return 1;
    ++*here->evaluations;
    return value_at(&here->s, x, 0, dim).max > skip;
}

/** Improve one star, which has these flags. */
static inline void visit_star(const pl_star_problem *problem, int64_t index, int flags,
                              double *scratch, pl_star_tally *tally, const int dim) {
    int32_t node = problem->node[index];
    double *place = problem->coordinates + (int64_t)node * dim;
    pl_star_kept *kept = dim == 3 && problem->kept ? &problem->kept[index] : NULL;
    local here = local_of(problem, index, place, known_scale(problem, kept), scratch,
                          &tally->evaluations, 0, dim);
    conjugate memory = {{0, 0, 0}, 0};
    state now;
    double decrease = 0;
    int steps = 0, wanted;
    here.alone = (flags & PL_TOLD) != 0;
    to_star(&here, place, now.x, dim);
    if (!is_worth_a_step(&here, now.x, dim)) {
        acquit(problem, node);
        return;
    }
    do {
        const double fall = one_step(&here, node, kept, &memory, &now, dim);
        if (!(fall > 0))
            break;
        decrease += fall;
        wanted = steps_of_visit(problem->direction, fall, now.sum, dim);
    } while (++steps < wanted);
    if (!(decrease > 0))
        return;
    settle(&here, node, now.x, now.size2, decrease / now.sum, !(now.max <= problem->rr2_skip),
           place, dim);
    pl_sum_add(&tally->decrease, decrease);
    tally->improved += decrease > IMPROVED * now.sum;
}

/* ---- ranges of stars ----------------------------------------------------------------------- */

/** Visit stars begin .. end - 1. */
static inline void visit_range(const pl_star_problem *problem, int64_t begin, int64_t end,
                               double *scratch, pl_star_tally *tally, const int dim) {
    for (int64_t i = begin; i < begin + AHEAD; i++)
        fetch_ahead(problem, i, end, dim);
    for (int64_t i = begin; i < end; i++) {
        fetch_ahead(problem, i + AHEAD, end, dim);
        const int flags = claim(problem, i);
        if (!flags)
            continue;
        visit_star(problem, i, flags, scratch, tally, dim);
        tally->visits++;
    }
}

/** Evaluate the star of index where its node is. */
static inline int evaluate(const pl_star_problem *problem, int64_t index, double *scratch,
                           int with_derivatives, pl_star_value *value, const int dim) {
    const double *place = problem->coordinates + (int64_t)problem->node[index] * dim;
    int64_t evaluations = 0;
    const local here = local_of(problem, index, place, NULL, scratch, &evaluations, 0, dim);
    double x[3];
    to_star(&here, place, x, dim);
    derivatives derivative = {{0}, {0}, 0};
    objective f;
    if (!with_derivatives)
        f = value_at(&here.s, x, 0, dim);
    else if (with_derivatives == PL_GRADIENT_ALONE)
        f = derivatives_at(&here.s, x, &derivative, 0, dim);
    else
        f = derivatives_at(&here.s, x, &derivative, 1, dim);
    give_value(&here, &f, &derivative, value);
    return f.positive;
}

/* ---- the functions of a variant ------------------------------------------------------------ */

/** Visit stars begin .. end - 1 of triangles. */
static void visit_triangles(const pl_star_problem *problem, int64_t begin, int64_t end,
                            double *scratch, pl_star_tally *tally) {
    visit_range(problem, begin, end, scratch, tally, 2);
}

/** Visit stars begin .. end - 1 of tetrahedra. */
static void visit_tetrahedra(const pl_star_problem *problem, int64_t begin, int64_t end,
                             double *scratch, pl_star_tally *tally) {
    visit_range(problem, begin, end, scratch, tally, 3);
}

/** Evaluate a star of triangles. */
static int evaluate_triangles(const pl_star_problem *problem, int64_t star_index, double *scratch,
                              int with_derivatives, pl_star_value *value) {
    return evaluate(problem, star_index, scratch, with_derivatives, value, 2);
}

/** Evaluate a star of tetrahedra. */
static int evaluate_tetrahedra(const pl_star_problem *problem, int64_t star_index, double *scratch,
                               int with_derivatives, pl_star_value *value) {
    return evaluate(problem, star_index, scratch, with_derivatives, value, 3);
}

#endif
