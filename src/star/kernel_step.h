/* kernel_step: how far to go along a direction. The largest feasible step is exact, because the
 * measures of a star's elements are affine in the position of its node (docs/algorithm.md).
 *
 *   find_direction, limit_length, steps_of_visit    a direction without constraints
 *   limiting_rate, place_along, try_step            steps along a direction
 *   acceptable, search                              the step that is taken
 */
#ifndef PL_STAR_KERNEL_STEP_H
#define PL_STAR_KERNEL_STEP_H

#include "star/kernel_acute.h"
#include "star/kernel_direction.h"
#include "star/kernel_local.h"

/* Fraction of the largest feasible step that is tried at most: the objective is a barrier there. */
#define STEP_FRACTION_FIRST 0.9
#define STEP_FRACTION_LAST  0.95
/* A Newton step is gone this far: neighbours that move one after the other spread a change of the
 * whole mesh sooner if each overshoots (successive over-relaxation). Farther where its slope is
 * less than so much of the sum: what is still wrong there is smooth over many stars. (Not while
 * multipliers stand for minimum volumes, or the sweeps end a little farther from the optimum.) */
#define STEP_OVER_RELAXATION      1.4
#define STEP_OVER_RELAXATION_NEAR 1.7
#define STEP_NEAR                 1e-3
/* Sufficient decrease: this fraction of what the slope promises (Armijo). */
#define STEP_ARMIJO 1e-4
/* A decrease below this fraction of the sum is noise of rounding, and no decrease. */
#define STEP_NOISE 0x1p-48
/* Stars whose mean RR^2 is above this stand near the barrier, where a Newton step is too short. */
#define STEP_EXPAND_ABOVE 4.0
enum { STEP_BACKTRACKS = 10, STEP_EXPANSIONS = 60 };
/* How far below its floor an element may come by rounding, as g. */
#define GRAZE 1e-6
/* And by how much one that is below already, where the node moves along its link facet. */
#define LOWERED 1e-12

/* ---- the direction without constraints ------------------------------------------------------ */

/* A visit whose Newton step brought more than this part of the star's function takes another one:
 * the star is at hand, and its node far from where it belongs. */
#define STEP_AGAIN 0.1

/** Steps of one visit, after one that brought fall of sum: one Newton step (more sweeps beat more
 *  steps) or two, but as many conjugate directions as there are coordinates, or they would never be
 *  conjugate. */
static inline int steps_of_visit(planish_search direction, double fall, double sum, const int dim) {
    if (direction != PLANISH_SEARCH_NEWTON)
        return dim;
    return fall > STEP_AGAIN * sum ? 2 : 1;
}

/* No direction is longer than this many sizes (root mean square distance of the link) of a star. */
#define STEP_LIMIT 2.0

/** Shorten direction to STEP_LIMIT sizes of the star. */
static inline void limit_length(double *direction, double size2, const int dim) {
    double length2 = dot(direction, direction, dim);
    double limit2 = STEP_LIMIT * STEP_LIMIT * size2;
    if (length2 > limit2) {
        double factor = sqrt(limit2 / length2);
        for (int d = 0; d < dim; d++)
            direction[d] *= factor;
    }
}

/** Find a direction of descent; returns 0 if there is none. */
static inline int find_direction(planish_search kind, const derivatives *derivative,
                                 conjugate *memory, double *direction, const int dim) {
    int found = kind == PLANISH_SEARCH_NEWTON
                    ? newton_direction(derivative->gradient, derivative->hessian, direction, dim)
                    : fletcher_reeves_direction(derivative->gradient, derivative->hessian,
                                                derivative->size2, memory, direction, dim);
    if (found)
        limit_length(direction, derivative->size2, dim);
    return found;
}

/* ---- how far --------------------------------------------------------------------------------- */

/** Return the largest rate, 1 / step, at which facets or the node's bounds block the direction; 0
 *  if nothing is in the way. Of facets: the largest of -(n . S) / D; RATE holds 1 / D, or
 *  for the guarded kernel what guarded_at says. */
static inline double limiting_rate(const local *here, const double *x, const double *direction,
                                   const int guarded, const int dim) {
    const star *s = &here->s;
    lanes most[PL_PACKS];
    for (int k = 0; k < PL_PACKS; k++)
        most[k] = lanes_of(0);
    lanes sx = lanes_of(-direction[0]), sy = lanes_of(-direction[1]);
    lanes sz = lanes_of(dim == 3 ? -direction[2] : 0);
    lanes parallel = lanes_of(guarded ? PARALLEL * sqrt(dot(direction, direction, dim)) : 0);
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            int64_t j = i + k * PL_PACK;
            lanes slope;
            if (dim == 3)
                slope = load(s, NX, j) * sx + load(s, NY, j) * sy + load(s, NZ, j) * sz;
            else
                slope = (load(s, P0Y, j) - load(s, P1Y, j)) * sx +
                        (load(s, P1X, j) - load(s, P0X, j)) * sy;
            if (guarded) /* what is parallel does not block */
                slope = lanes_select(lanes_greater(slope, parallel * load(s, LENGTH, j)), slope,
                                     lanes_of(0));
            most[k] = lanes_max(slope * load(s, RATE, j), most[k]);
        }
    double rate = lanes_largest(most);
    if (!guarded)
        return rate;
    double of_bounds = FLOOR_FRACTION * bounds_rate(&here->b, x, direction, dim);
    return of_bounds > rate ? of_bounds : rate;
}

/** Trial position and the objective there. */
typedef struct trial {
    double position[3];
    objective value;
} trial;

/** Find the position step along direction from x0, as it will be stored: rounded if need be, and to
 *  what is left of a double where coordinates are subnormal. */
static inline void place_along(const local *here, const double *x0, const double *direction,
                               double step, double *position, const int guarded, const int dim) {
    const pl_storage *storage = &here->problem->storage;
    for (int d = 0; d < dim; d++)
        position[d] = x0[d] + step * direction[d];
    if (guarded) {
        clamp(&here->b, position, dim);
        slide_place(here->problem, &here->slide, &here->s, position, dim);
    }
    for (int d = 0; d < dim; d++) {
        double stored = position[d] * here->s.unscale;
        if (storage->precision != PLANISH_PRECISION_DOUBLE)
            stored = pl_store(storage, stored);
        position[d] = stored * here->s.scale;
    }
}

/** Evaluate the star at the position step along direction from x0, as it will be stored. */
PL_INLINE trial try_step(const local *here, const double *x0, const double *direction, double step,
                         const int guarded, const int dim) {
    trial t = {.position = {0}};
    place_along(here, x0, direction, step, t.position, guarded, dim);
    t.value = guarded ? guarded_at(&here->s, &here->q, t.position, NULL, 0, dim)
                      : value_at(&here->s, t.position, 0, dim);
    ++*here->evaluations;
    return t;
}

/** Whether the guarded kernel's objective is the ratio that limits are of. */
static inline int is_of_ratio(const local *here) {
    return here->q.objective == PLANISH_OBJECTIVE_RADIUS_RATIO ||
           (has_forms(&here->s) && here->q.objective == PLANISH_OBJECTIVE_MEAN_RATIO);
}

/** Whether the kernel of mean ratios visits simplices, whose limit is of radius ratios. */
static inline int lowers_other_ratio(const local *here) {
    return PL_KERNEL == PL_MEAN && !here->s.form;
}

/** Whether no element of a trial has a worse ratio or a smaller angle than the limits, no corner a
 *  smaller scaled Jacobian. The guarded
 *  kernel's objective may be another one. */
static inline int within_limits(const local *here, const trial *t, const int guarded,
                                const int dim) {
    const pl_star_limits *limits = &here->problem->limits;
    double max = t->value.max, error = t->value.error;
    if (guarded && !is_of_ratio(here)) {
        if (!(limits->rr2 < INFINITY))
            return 1;
        objective rr = value_at(&here->s, t->position, 1, dim);
        max = rr.max;
        error = rr.error;
    }
    if (lowers_other_ratio(here)) {
        const double limit = limits->rr2 / (1 + error);
        return !may_exceed_ratio(max, limit, dim) ||
               !exceeds_ratio(&here->s, t->position, limit, dim);
    }
    max *= 1 + error;
    if (!(max <= limits->rr2) || max <= limits->rr2_blunt)
        return max <= limits->rr2;
    const double acuteness = limits->acuteness / (1 + error);
    if (has_forms(&here->s))
        return !(acuteness < INFINITY) ||
               !has_small_jacobian(&here->s, t->position, acuteness, guarded, dim);
    return !has_acute_angle(&here->s, t->position, acuteness, guarded, dim);
}

/** Whether no element at position is below its floor and lower than now, of which GVALUE is. The
 *  lowest of a star, which may be far below, says nothing of the others. */
static inline int lowers_none(const local *here, const double *position, const int dim) {
    const lanes x[3] = {lanes_of(position[0]), lanes_of(position[1]),
                        lanes_of(dim == 3 ? position[2] : 0)};
    const lanes met = lanes_of(PLANISH_VOLUME_TOLERANCE), graze = lanes_of(GRAZE);
    const star *s = &here->s;
    lanes most[PL_PACKS];
    for (int k = 0; k < PL_PACKS; k++)
        most[k] = lanes_of(NEVER_ACTIVE);
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            const int64_t j = i + k * PL_PACK;
            const lanes now = load(s, GVALUE, j);
            const lanes may = lanes_select(lanes_greater(now, met), now + lanes_of(LOWERED),
                                           lanes_max(now, graze));
            aspect a;
            measure_at(s, j, x, &a, dim);
            most[k] = lanes_max(volume_constraint(s, j, a.D) - may, most[k]);
        }
    return lanes_largest(most) <= 0;
}

/** Whether a trial may be taken: valid beyond doubt, no element worse than the limit, and the sum
 *  below bound and below that of now by more than the rounding errors of both; guarded: no element
 *  below its floor, and the node within its bounds. Not so for values that are not numbers. */
static inline int acceptable(const local *here, const trial *t, const objective *now, double bound,
                             const int guarded, const int dim) {
    const objective *value = &t->value;
    const double below =
        now->sum - (STEP_NOISE + now->error) * now->sum - value->error * value->sum;
    if (!(value->certain && value->sum < bound && value->sum < below))
        return 0;
    if (guarded && !(value->largest_g <= (now->largest_g > GRAZE ? now->largest_g : GRAZE) &&
                     within_bounds(&here->b, t->position, dim)))
        return 0;
    if (guarded && now->largest_g > PLANISH_VOLUME_TOLERANCE &&
        !lowers_none(here, t->position, dim))
        return 0;
    return within_limits(here, t, guarded, dim);
}

/** Double the step while that pays, from a first trial that was acceptable. */
static inline void expand(const local *here, const double *x0, const objective *now,
                          const double *direction, double step, double largest, trial *best,
                          const int guarded, const int dim) {
    for (int i = 0; i < STEP_EXPANSIONS && step < largest; i++) {
        step = 2 * step < largest ? 2 * step : largest;
        trial t = try_step(here, x0, direction, step, guarded, dim);
        if (!acceptable(here, &t, now, best->value.sum, guarded, dim))
            return;
        *best = t;
    }
}

/** Search along direction from x0, where the objective is now, with slope grad F . direction < 0.
 *  Returns whether an acceptable position was found. */
static inline int search(const local *here, const double *x0, const objective *now,
                         const double *direction, double slope, trial *best, const int guarded,
                         const int dim) {
    const int is_relaxed =
        here->kind == PLANISH_SEARCH_NEWTON && !here->constrained && !here->alone;
    const int is_near = -slope < STEP_NEAR * now->sum && !(guarded && here->q.penalty > 0);
    double rate = limiting_rate(here, x0, direction, guarded, dim);
    double wanted = !is_relaxed ? 1 : is_near ? STEP_OVER_RELAXATION_NEAR : STEP_OVER_RELAXATION;
    double step = rate * wanted > STEP_FRACTION_FIRST ? STEP_FRACTION_FIRST / rate : wanted;
    double last = guarded ? STEP_FRACTION_FIRST : STEP_FRACTION_LAST;
    double largest = rate > 0 ? last / rate : INFINITY;
    double noise = (STEP_NOISE + now->error) * now->sum;
    for (int i = 0; i < STEP_BACKTRACKS; i++) {
        *best = try_step(here, x0, direction, step, guarded, dim);
        if (acceptable(here, best, now, now->sum + STEP_ARMIJO * slope * step, guarded, dim)) {
            if (i == 0 && now->sum > STEP_EXPAND_ABOVE * here->s.weight)
                expand(here, x0, now, direction, step, largest, best, guarded, dim);
            return 1;
        }
        int is_lost = 1; /* in rounding: the trial stands where the node stood */
        for (int d = 0; d < dim; d++)
            is_lost &= best->position[d] == x0[d];
        if (-slope * step < noise || is_lost)
            return 0;
        /* the minimum of the parabola through the sum and slope at 0 and the sum at step */
        double rise = best->value.sum - now->sum - slope * step;
        double next = rise > 0 && best->value.positive ? -0.5 * slope * step * step / rise : 0;
        if (!(next < 0.5 * step))
            next = 0.5 * step;
        step = next > 0.1 * step ? next : 0.1 * step;
    }
    return 0;
}

#endif
