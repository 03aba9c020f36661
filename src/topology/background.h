/* background: a mesh in which points are found.
 *
 * Elements are cut into simplices: each is joined from its corner of the smallest number to the facets
 * that do not have it, and so are these. Neighbours cut their common facet in the same way.
 *
 *   pl_background_create, _destroy
 *   pl_background_find              the simplex that has a point
 */
#ifndef PL_TOPOLOGY_BACKGROUND_H
#define PL_TOPOLOGY_BACKGROUND_H

#include "topology/topology.h"

/** Simplices of a mesh. Everything is owned. */
typedef struct pl_background {
    int dim;
    int64_t n_nodes, n_simplices;
    double scale;  /* a power of two, of x: they are about 1 */
    double *x;     /* [n_nodes][dim] */
    int32_t *node; /* [n_simplices][dim + 1] */
    int32_t
        *across; /* [n_simplices][dim + 1] what lies across the facet opposite each node; -1: none,
                        or more than one */
    int32_t *first; /* [n_nodes] a simplex of each node; -1: there is none */
} pl_background;

/** Make the background of a mesh, whose nodes are at x [n_nodes][dim]: of its elements, or those of its
 *  cells that are of its dimension, which are checked. *background is to be destroyed in any case.
 *  Errors: _MEMORY, _MESH (too many simplices). */
int pl_background_create(const planish_mesh *mesh, const double *x, int threads,
                         pl_background *background, planish_error *error);

/** Free the arrays of background. */
void pl_background_destroy(pl_background *background);

/** Walk from *simplex to the simplex with the point at [dim], or near it if no simplex has the
 *  point: *simplex, and weight [dim + 1], the point as a mean of its nodes: none is negative. */
void pl_background_find(const pl_background *background, const double *at, int32_t *simplex,
                        double weight[4]);

#endif
