/* guarded_star: a hand-made star with bounds, floors and an objective, for the guarded kernel. */
#ifndef TEST_GUARDED_STAR_H
#define TEST_GUARDED_STAR_H

#include "support/hand_star.h"

/* Limit of pl_star_worst that most stars are above. */
#define WORST_LIMIT 1.5

typedef struct guarded_star {
    hand_star s;
    pl_star_guard guard;
    double floors[HAND_STAR_MAX_FACETS];
    double lower[HAND_STAR_MAX_NODES * 3], upper[HAND_STAR_MAX_NODES * 3];
    double start[HAND_STAR_MAX_NODES * 3], radius[HAND_STAR_MAX_NODES];
} guarded_star;

/** A start of test_random that differs much from those of the seeds next to it. */
unsigned test_mixed_seed(unsigned seed);

/** Make a star of dim with a guard without bounds and floors; unevenness and seed as in
 * hand_star_create. */
void guarded_create(guarded_star *g, int dim, double unevenness, unsigned seed);

/** Free what g owns. */
void guarded_destroy(guarded_star *g);

/** Copy the coordinates of the node to x [dim]. */
void guarded_position(const guarded_star *g, long double *x);

/** Measure of the element at facet. */
long double guarded_measure(const guarded_star *g, int64_t facet);

/** Number of facets of the star. */
int64_t guarded_facets(const guarded_star *g);

/** Largest g = 1 - V / floor. */
long double guarded_worst(const guarded_star *g);

/** Mean of the measures of the elements. */
long double guarded_mean_measure(const guarded_star *g);

/** Visit the star once with the kernel of isa. */
pl_star_tally guarded_visit(guarded_star *g, planish_isa isa);

/** Visit the star n times. */
void guarded_visits(guarded_star *g, int n);

/** Evaluate the function of the star; derive: with derivatives. Return as the kernel does. */
int guarded_evaluate(guarded_star *g, planish_isa isa, int derive, pl_star_value *value);

/** Optimality of the node where it is. */
pl_star_optimality guarded_optimality(guarded_star *g, planish_isa isa);

/** Set floors of every kind: for all, for some, larger or smaller than the volumes. */
void guarded_random_floors(guarded_star *g, unsigned *state);

#endif
