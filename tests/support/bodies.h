/* bodies: random small solids with curved surfaces, of tetrahedra, hexahedra or wedges, or hexahedra
 * and wedges. */
#ifndef TEST_SUPPORT_BODIES_H
#define TEST_SUPPORT_BODIES_H

#include <planish/planish.h>

/** Kinds of bodies. */
enum {
    BODY_BUMPS,   /* a box with a wavy top */
    BODY_BALL,    /* no features */
    BODY_ROD,     /* bent, round, with two circles */
    BODY_WEDGE,   /* a box with a crease of 3 to 100 degrees along its top and bottom */
    BODY_PLATE,   /* thin and wavy */
    BODY_NEEDLES, /* bumps, stretched */
    BODY_SHEETS,  /* two wavy plates, 0.1 edges apart */
    BODY_RING,    /* round in both directions */
    BODY_REGIONS, /* bumps, with a wavy interface of two regions */
    BODY_KINDS
};

/** What the cubes of a grid become. */
enum { OF_TETRAHEDRA, OF_HEXAHEDRA, OF_WEDGES, OF_BOTH };

/** A grid of cubes. */
typedef struct body {
    int kind, of, n[3], joins; /* joins: the first direction at its ends */
    planish_mesh mesh;
    planish_cells cells; /* NULL in mesh: all are tetrahedra; a body is not copied then */
    double *x;
    int32_t *node, *region; /* of elements */
    int64_t *offset;
    uint8_t *type;
} body;

/** Draw a body, to be freed by body_destroy. */
body body_create(uint64_t *state);

void body_destroy(body *b);

/** The least of the determinants at the corners of an element with nodes at x: six times its volume if it is a
 *  tetrahedron. */
double body_least_corner(const body *b, const double *x, int64_t element);

#endif
