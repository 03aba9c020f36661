/* shapes: elements from regular to nearly degenerate, by the names that the literature has for
 * what is wrong with them; of any size, turned, and far from the origin.
 */
#ifndef TEST_SUPPORT_SHAPES_H
#define TEST_SUPPORT_SHAPES_H

#include <stdint.h>

typedef enum shape_kind {
    SHAPE_REGULAR,  /* nearly so */
    SHAPE_SLIVER,   /* a square, folded a little; a triangle with a short edge */
    SHAPE_CAP,      /* a vertex near the inside of the facet opposite */
    SHAPE_SPADE,    /* a vertex near an edge opposite */
    SHAPE_WEDGE,    /* two vertices near one another */
    SHAPE_NEEDLE,   /* all vertices but one near one another */
    SHAPE_SPINDLE,  /* two edges, opposite, short: two pairs far from one another */
    SHAPE_SPLINTER, /* vertices along a line, each at a distance of its own */
    SHAPE_FLAT,     /* anywhere in a plane, nearly */
    SHAPE_KINDS
} shape_kind;

extern const char *const shape_name[SHAPE_KINDS];

/** Where and how large. */
typedef struct shape_place {
    int turned; /* by any rotation, so that coordinates are not those of the shape's axes */
    int size;   /* exponent */
    double far; /* distance from the origin, in sizes; coordinates have that much fewer bits */
} shape_place;

/** Any of these: half of the elements are of about 1 at the origin. */
shape_place shape_place_draw(uint64_t *random, int most_size);

/** Draw the vertices x [dim + 1][dim] of one, in any order, of thickness thin relative to its size.
 */
void shape_draw(shape_kind kind, int dim, double thin, const shape_place *place, uint64_t *random,
                double x[4][3]);

#endif
