/* rings: what the tests of rings, colouring and stars start from. */
#ifndef TEST_SUPPORT_RINGS_H
#define TEST_SUPPORT_RINGS_H

#include "topology/topology.h"

typedef struct test_rings {
    pl_incidence incidence;
    pl_rings rings;
    uint8_t *is_free; /* [n] */
    int32_t *node;    /* [n] the first rings.n_rings are theirs, -1: of none */
    int8_t *sign;     /* [n_elements] as in pl_boundary, NULL: all +1 */
} test_rings;

/** Rings of the nodes that are not on the boundary, or of all that have an element (all: then those
 *  that are not inside are none), in the order of the nodes. Fails the test on any error. */
void test_rings_create(test_rings *rings, const planish_mesh *mesh, int all, int threads);

/** The same for all nodes that have an element, open or closed, from the definition: neighbours
 *  only, no links. */
void test_rings_define(test_rings *rings, const planish_mesh *mesh);
void test_rings_destroy(test_rings *rings);

/** The ring of node by its definition, into ring; returns its length. */
int64_t test_ring_of_node(const planish_mesh *mesh, int32_t node, int32_t *ring);

#endif
