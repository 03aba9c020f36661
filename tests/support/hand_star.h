/* hand_star: one star made by hand, as the kernels see it: an icosahedron (3-D) or a polygon (2-D)
 * of uneven radius around one node. */
#ifndef TEST_SUPPORT_HAND_STAR_H
#define TEST_SUPPORT_HAND_STAR_H

#include "star/star.h"

enum { HAND_STAR_MAX_NODES = 24, HAND_STAR_MAX_FACETS = 24 };

typedef struct hand_star {
    int dim;
    double coordinates[HAND_STAR_MAX_NODES * 3]; /* node 0 is the centre */
    int32_t node, ring[HAND_STAR_MAX_NODES];
    int64_t ring_offset[2], link_offset[2];
    uint16_t link[HAND_STAR_MAX_FACETS * 3];
    uint8_t positions[HAND_STAR_MAX_FACETS * 9]; /* link, as the problem has it */
    uint8_t changed[HAND_STAR_MAX_NODES];
    double *scratch; /* owned */
    pl_star_problem problem;
} hand_star;

/** unevenness 0: regular; up to about 0.6: bad but valid. seed chooses radii and the centre's
 *  place. Release with hand_star_destroy. */
void hand_star_create(hand_star *star, int dim, double unevenness, unsigned seed);
void hand_star_destroy(hand_star *star);

/** After a change of link: write positions. */
void hand_star_pack_link(hand_star *star);

/** Sum of RR^2 over the star with its centre at x, in long double, from the textbook formulas
 *  (circumradius and inradius), which share nothing with the kernels. */
long double hand_star_sum(const hand_star *star, const long double *x);

/** Measure (positive inside the star) of the element of a facet with its centre at x, its least
 * measure by the problem's guard (0: none), and its aspect ratio (of the edges: the smoothed one;
 * of pl_star_worst: the root of what it adds to the sum), by textbook formulas. */
long double hand_star_measure(const hand_star *star, int64_t facet, const long double *x);
long double hand_star_floor(const hand_star *star, int64_t facet);
long double hand_star_aspect(const hand_star *star, int64_t facet, const long double *x,
                             int measure);

/** The smallest of all its angles, radians. */
long double hand_star_angle(const hand_star *star, const long double *x);

/** The star's function as the problem's guard says: of AR^2 and g^2, with their weights. */
long double hand_star_function(const hand_star *star, const long double *x);

#endif
