/* small_star: stars of few elements, one of them of a shape that is asked for: a node inside a
 * triangle, a tetrahedron or an octahedron. */
#ifndef TEST_SUPPORT_SMALL_STAR_H
#define TEST_SUPPORT_SMALL_STAR_H

#include "support/hand_star.h"
#include "support/shapes.h"

/** Make star, which hand_star_create has made, another one of its dimension: the element of facet 0
 *  is of this shape, its first vertex the node; the other nodes are such that the node is inside,
 *  but for rounding. Returns the exponent of its size. */
int small_star_draw(hand_star *star, shape_kind kind, double thin, uint64_t *random);

#endif
