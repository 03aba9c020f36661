/* guard: the guarded kernel's input from options and plan: objective, minimum volumes, bounds.
 *
 *   pl_guard_create, _destroy, _weigh             arrays and weights of the guarded kernel
 *   pl_minimum_volume                             options.min_volume as a volume
 */
#ifndef PL_SWEEP_GUARD_H
#define PL_SWEEP_GUARD_H

#include "quality/objective.h"
#include "plan/plan.h"

/** Ready for the sweeps of one call. Its arrays are owned. */
typedef struct pl_guard {
    int wanted;    /* 0: the plain problem will do */
    int in_visits; /* 1: and visits need the guard, too; 0: they are plain ones of wanted's ratio */
    pl_star_guard star;
    double min_volume; /* delta */
    uint8_t
        *mobility;    /* [n] of the plan's mesh: the plan's, but for held ones; or NULL: the same */
    uint8_t *is_held; /* [m] of that mesh, 1: the element has movable nodes, and all are held; with
                         corners so is their cell; NULL: nothing is held, in no process */
    int64_t held_outside;
} pl_guard;

/** Find the minimum volume delta of options. A fraction refers to the volume of the whole mesh,
 *  with coordinates all [.][dim]. Errors: _ARGUMENT, if the result is not a volume. */
int pl_minimum_volume(const planish_plan *plan, const planish_options *options, const double *all,
                      double *delta, planish_error *error);

/** Make the guard for coordinates [n][dim] and delta; the plan's own coordinates are already there.
 *  Errors: _ARGUMENT (bounds that are no numbers, an area weight without a fitting minimum volume
 * for every element), _MEMORY. */
int pl_guard_create(const planish_plan *plan, const planish_options *options,
                    const double *coordinates, double delta, pl_guard *guard, planish_error *error);

/** Free the arrays of guard. */
void pl_guard_destroy(pl_guard *guard);

/** Choose weights of sum AR^2 and sum g^2 of a star. Their weighted sum, times the returned factor
 *  and plus a constant, is an upper bound of F that touches F at the present f1 and f2. */
double pl_guard_weigh(pl_guard *guard, const planish_options *options,
                      const pl_objective_sums *sums);

#endif
