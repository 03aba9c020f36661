/* degenerate: elements that are flat, or nearly so, in every way that doubles have.
 *
 * For what must be exact: half of them are told from flat ones by their last bits, or by what over-
 * and underflow leave of them.
 */
#ifndef TEST_SUPPORT_DEGENERATE_H
#define TEST_SUPPORT_DEGENERATE_H

#include <stdint.h>

typedef enum degenerate_kind {
    DEGENERATE_FLAT,      /* exactly flat, each axis by a power of two of its own */
    DEGENERATE_ONE_UNIT,  /* the same with one coordinate changed by one unit in its last place */
    DEGENERATE_ROUNDED,   /* the last vertex on the plane of the others but for rounding */
    DEGENERATE_FAR,       /* a few units in the last place large, far from the origin */
    DEGENERATE_TOGETHER,  /* vertices at one place, or next to one another */
    DEGENERATE_THIN,      /* squeezed along one or two directions, and sheared */
    DEGENERATE_RANGE,     /* exponents from the smallest to the largest */
    DEGENERATE_SUBNORMAL, /* of few units of 2^-1074 */
    DEGENERATE_UNDERFLOW, /* the measure is about 2^-1074 of the element's size */
    DEGENERATE_OVERFLOW,  /* differences of coordinates are larger than doubles can be */
    DEGENERATE_KINDS
} degenerate_kind;

extern const char *const degenerate_name[DEGENERATE_KINDS];

/** Draw the vertices x [dim + 1][dim] of one; all coordinates are finite. */
void degenerate_draw(degenerate_kind kind, int dim, uint64_t *random, double x[4][3]);

#endif
