/* boundary_reference: the boundary of a mesh by its definition, every facet against every other
 * one.
 */
#ifndef TEST_BOUNDARY_REFERENCE_H
#define TEST_BOUNDARY_REFERENCE_H

#include "topology/topology.h"

typedef struct test_facet {
    int32_t node[3]; /* ascending; node[2] = -1 in 2-D */
    int64_t element;
    int direction; /* 0 or 1: how the element traverses it */
} test_facet;

typedef struct boundary_reference {
    pl_boundary boundary;
    int64_t n_facets;
    test_facet *facet; /* [n_facets] (dim + 1) per element */
} boundary_reference;

/** Find facets, signs and duplicates of mesh by comparing every facet with every other one. */
void boundary_reference_create(const planish_mesh *mesh, boundary_reference *r);

/** Free what r owns. */
void boundary_reference_destroy(boundary_reference *r);

#endif
