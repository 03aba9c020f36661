/* facet_functions: plain formulas of facets of first and second order. */
#ifndef TEST_FACET_FUNCTIONS_H
#define TEST_FACET_FUNCTIONS_H

/** Compute the values of the functions of a facet of n nodes (3, 4, 6, 8, 9: corners, mids from each to the
 *  next, centre): of triangles at the weights u, v of the first two corners, of quadrilaterals at u, v from 0
 *  to 1, the first edge along u. One of four nodes is two triangles, on both sides of its first corner's
 *  diagonal. */
void facet_functions(int n, double u, double v, double by[9]);

/** Set uv to where node i of a facet of n nodes is, in the same coordinates. */
void facet_place(int n, int i, double uv[2]);

#endif
