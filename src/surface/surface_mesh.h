/* surface_mesh: a mesh of triangles and quadrilaterals in space, without solids, as its nodes see it.
 *
 *   stars.c     pl_surface_mesh_create, _destroy     terms and colours of the nodes that move
 *               pl_surface_quadrilateral
 *   measure.c   pl_surface_measure                   sums over all elements
 *
 * visit.h has the local problem of one node, smooth.h the sweeps.
 */
#ifndef PL_SURFACE_SURFACE_MESH_H
#define PL_SURFACE_SURFACE_MESH_H

#include "base/sum.h"
#include "shape/curved.h"
#include "surface/facet_terms.h"

/** Stars in the order of their visits. Nodes have the shape's numbers. Arrays are owned. */
typedef struct pl_surface_mesh {
    const planish_shape *shape;
    int by_radius; /* not 0: triangles alone, by their radius ratios; 0: aspect ratios */
    int64_t n_stars;
    int32_t *node;         /* [n_stars] colour by colour */
    int64_t *term_offset;  /* [n_stars + 1] */
    pl_facet_term *term;   /* of each star */
    int n_colours;         /* no two nodes of one are in an element, or opposite across an edge */
    int64_t *colour_begin; /* [n_colours + 1] first star of each */
} pl_surface_mesh;

/** Corners of the quadrilateral whose first half is facet, one after the other. */
void pl_surface_quadrilateral(const planish_shape *shape, int32_t facet, int32_t corner[4]);

/** Make the stars of the nodes for which moves [shape->n_nodes] is not 0. Errors: _MEMORY. */
int pl_surface_mesh_create(const planish_shape *shape, const uint8_t *moves, int threads,
                           pl_surface_mesh *mesh, planish_error *error);

/** Free the arrays of mesh. */
void pl_surface_mesh_destroy(pl_surface_mesh *mesh);

/** Parts of the elements by what their nodes may do. */
enum {
    PL_SURFACE_FIXED, /* no node is movable */
    PL_SURFACE_MOVES, /* a node moves */
    PL_SURFACE_HELD,  /* nodes are movable, but this run holds them */
    PL_SURFACE_PARTS
};

/** Sums over the elements that have not turned over, by parts. */
typedef struct pl_surface_sums {
    double ratio[PL_SURFACE_PARTS]; /* of RR^2, or AR^2 */
    double n[PL_SURFACE_PARTS];
    double worst;     /* largest RR^2 (AR^2) of elements with a node that moves, */
    double acuteness; /* and 1 / sin^2 of the smallest angle, or 1 / SJ^2 of a corner */
    int64_t
        n_inverted; /* elements that have turned over against the shape, or have a corner that has */
} pl_surface_sums;

/** Measure the mesh with its nodes at x [shape->n_nodes][3]. moves, is_movable [shape->n_nodes]: whether
 *  a node moves in this run, and whether one may that holds no node. ratio [n_facets] (may be NULL): RR^2
 *  (AR^2) of each element, at its first half; infinite if it is inverted. Errors: _MEMORY. */
int pl_surface_measure(const pl_surface_mesh *mesh, const double (*x)[3], const uint8_t *moves,
                       const uint8_t *is_movable, int threads, double *ratio, pl_surface_sums *sums,
                       planish_error *error);

#endif
