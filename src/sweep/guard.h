/* guard: the guarded kernel's input from options and plan: objective, minimum volumes, bounds.
 *
 *   pl_guard_create, _destroy, _weigh             arrays and weights of the guarded kernel
 *   pl_minimum_volume, pl_check_delta               options.min_volume as a volume
 *   pl_objective_problem_of, pl_objective_of_all, _of_movable, pl_rms    the objective F
 */
#ifndef PL_SWEEP_GUARD_H
#define PL_SWEEP_GUARD_H

#include "quality/objective.h"
#include "plan/plan.h"

#include <math.h>

/** Root mean square of n numbers from the sum of their squares; 0 without any. */
static inline double pl_rms(double sum, double n) {
    return n > 0 ? sqrt(sum / n) : 0;
}

/** Ready for the sweeps of one call. Its arrays are owned. */
typedef struct pl_guard {
    int wanted; /* 0: the plain problem will do */
    pl_star_guard star;
    double min_volume; /* delta */
    uint8_t
        *mobility; /* [n] of the plan's mesh: the plan's, but for held ones; or NULL: the same */
    int64_t held_outside;
} pl_guard;

/** delta of options: a fraction is of the volume of all of the mesh, whose coordinates all [.][dim]
 *  are. */
double pl_minimum_volume(const planish_plan *plan, const planish_options *options,
                         const double *all);

/** Return the sum over the mesh, or over the plan's part if no more is known, that options ask
 *  for. */
pl_objective_problem pl_objective_problem_of(const planish_plan *plan,
                                             const planish_options *options, const double *all,
                                             double delta);

/** Whether the fraction of the domain's volume, if one was asked for, is a volume. */
int pl_check_delta(const planish_options *options, double delta, planish_error *error);

/** Make the guard for coordinates [n][dim] and delta; the plan's own coordinates are already there.
 *  Errors: _ARGUMENT (an area weight without a
 *  fitting minimum volume for every element, a fraction of nothing),
 *  _MEMORY. */
int pl_guard_create(const planish_plan *plan, const planish_options *options,
                    const double *coordinates, double delta, pl_guard *guard, planish_error *error);

/** Free the arrays of guard. */
void pl_guard_destroy(pl_guard *guard);

/** F = mu1 f1 + mu2 f2 of sums: over all valid elements, or over those with a free node. */
double pl_objective_of_all(const planish_options *options, const pl_objective_sums *sums);

/** F of the elements with a free node. */
double pl_objective_of_movable(const planish_options *options, const pl_objective_sums *sums);

/** Weigh sum AR^2 and sum g^2 of a star so that their sum, times the factor that is returned, is an
 *  upper bound of F up to a constant, and touches it at the present f1 and f2. */
double pl_guard_weigh(pl_guard *guard, const planish_options *options,
                      const pl_objective_sums *sums);

#endif
