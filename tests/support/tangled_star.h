/* tangled_star: a hand-made star with all that untangling asks. */
#ifndef TEST_TANGLED_STAR_H
#define TEST_TANGLED_STAR_H

#include "support/hand_star.h"

/** A hand-made star with all that untangling asks. */
typedef struct tangled_star {
    hand_star s;
    pl_star_guard guard;
    pl_star_untangling asked;
    uint8_t in_patch[HAND_STAR_MAX_NODES], skip[HAND_STAR_MAX_FACETS];
    double size[HAND_STAR_MAX_NODES], floors[HAND_STAR_MAX_FACETS];
    double lower[HAND_STAR_MAX_NODES * 3], upper[HAND_STAR_MAX_NODES * 3];
    double start[HAND_STAR_MAX_NODES * 3], radius[HAND_STAR_MAX_NODES];
} tangled_star;

/** Where the node of a star is. */
enum { INSIDE, OUTSIDE, FAR_AWAY, ON_A_FACET, ON_A_NODE, PLACES };

/** Coordinates of few bits: sums of their products are exact, so that even the measures of nearly
 *  flat elements are. */
double test_few_bits(double x);

/** Make a star with wanted sizes of all kinds; seed says where its node is. */
void tangled_create(tangled_star *t, int dim, unsigned seed);

/** Add floors of few bits for some elements and for all others, neighbours that share the elements,
 *  and elements that do not count. */
void tangled_ask_for_more(tangled_star *t, unsigned seed);

/** Free what t owns. */
void tangled_destroy(tangled_star *t);

/** Number of facets of the star. */
int64_t tangled_facets(const tangled_star *t);

/** Energy of the star by the kernel of isa, and its slope (may be NULL). */
pl_star_energy tangled_energy(tangled_star *t, planish_isa isa, pl_star_slope *slope);

/** Visit the star once. */
pl_star_tally tangled_visit(tangled_star *t, planish_isa isa);

/** The sum of tangled_energy. */
double tangled_energy_sum(tangled_star *t, planish_isa isa);

/** Visit the star once; return the decrease that the kernel reports. */
double tangled_decrease(tangled_star *t);

/** Copy the coordinates of the node to x [dim]. */
void tangled_position(const tangled_star *t, long double *x);

#endif
