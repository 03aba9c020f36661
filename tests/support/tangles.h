/* tangles: valid meshes of several shapes, and ways to tangle them. */
#ifndef TEST_SUPPORT_TANGLES_H
#define TEST_SUPPORT_TANGLES_H

#include "support/meshes.h"

typedef enum test_shape {
    TEST_BOX,    /* of about equal elements */
    TEST_BAR,    /* ten, or four, times as long as it is wide */
    TEST_GRADED, /* from a corner, whose elements are ten thousand times smaller than the last */
    TEST_RING,   /* around a hole (3-D: a cavity) that is turned */
    TEST_BENT,   /* to a quarter of a circle */
    TEST_WAVY,   /* 3-D: twisted */
    TEST_PINCHED,
    TEST_SHAPES
} test_shape;

typedef enum test_tangling {
    TEST_LEFT_BEHIND, /* the inner nodes are where they were before the shape was deformed */
    TEST_MOVED_FEW,   /* one node in a hundred is moved by up to three sizes, */
    TEST_MOVED_HALF,  /* every second one, */
    TEST_MOVED_ALL,   /* each */
    TEST_GROUPS,      /* some groups of nodes are at one place each */
    TEST_ALL_IN_ONE,  /* all inner nodes are at one place */
    TEST_DUPLICATES,  /* some nodes are where a neighbour is */
    TEST_SWAPPED,     /* some nodes have changed places with each other */
    TEST_THROWN,      /* one node is a thousand sizes away */
    TEST_FLAT,        /* some nodes are on the facet of an element of theirs */
    TEST_TANGLINGS
} test_tangling;

/** A mesh that can be tangled; random numbers of nodes and elements. */
typedef struct test_tangle {
    test_mesh mesh;    /* valid at first */
    double *valid;     /* [n_nodes][dim] */
    double *before;    /* [n_nodes][dim] before the shape was deformed */
    double *size;      /* [n_nodes] mean length of the valid mesh's edges */
    uint8_t *is_inner; /* [n_nodes] not on the boundary */
} test_tangle;

/** fineness: 1 for a hundred or two of inner nodes, more for fineness^dim times as many. */
void test_tangle_create(test_tangle *tangle, int dim, test_shape shape, int fineness,
                        unsigned seed);
void test_tangle_destroy(test_tangle *tangle);

/** Whether the shape's boundary is not that of the lattice it is made from: only then does it leave
 *  its inner nodes behind. */
int test_shape_is_deformed(test_shape shape);

/** Bring all nodes back to their valid places, then tangle them. */
void test_tangle_apply(test_tangle *tangle, test_tangling tangling, unsigned seed);

#endif
