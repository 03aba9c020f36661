/* rings: what the tests of rings, colouring and stars start from. */
#ifndef TEST_SUPPORT_RINGS_H
#define TEST_SUPPORT_RINGS_H

#include "topology/topology.h"

typedef struct test_rings {
    pl_incidence incidence;
    pl_rings rings;
    uint8_t *is_free; /* [n] */
    int32_t *node;    /* [n] the first n_free are the free nodes */
    int64_t n_free;
} test_rings;

/** Rings of the nodes that are not on the boundary, or of all that have an element (all), in the
 *  order of the nodes. Fails the test on any error. */
void test_rings_create(test_rings *rings, const planish_mesh *mesh, int all, int threads);
void test_rings_destroy(test_rings *rings);

#endif
