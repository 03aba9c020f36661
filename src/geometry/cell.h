/* cell: the types of elements, and common properties of all elements of a type.
 *
 * A type is a shape (triangle, quadrilateral, tetrahedron, hexahedron, wedge, pyramid) with nodes of
 * order 1 or 2. Nodes stand in VTK's order: the corners, then the mids of edges, of faces, of the
 * cell. Every shape but the pyramid is a product of simplices: a hexahedron of three lines, a wedge
 * of a triangle and a line. So one set of formulas serves all of them (jacobian.h).
 *
 *   pl_cell_shape     corners, edges, faces, ideal corners of a shape
 *   pl_cell_type      a type
 *   pl_cell_type_of   the type of a public number
 *   pl_cell_parents   the corners that a node follows
 */
#ifndef PL_GEOMETRY_CELL_H
#define PL_GEOMETRY_CELL_H

#include <stdint.h>

enum {
    PL_CELL_CORNERS = 8,
    PL_CELL_NODES = 27,
    PL_CELL_EDGES = 12,
    PL_CELL_FACES = 6,
    PL_CELL_SIMPLICES = 3 /* whose product a shape is */
};

/** Shape of an element, by its corners. */
typedef struct pl_cell_shape {
    const char *name;
    uint8_t dim; /* 2 or 3 */
    uint8_t n_corners;
    uint8_t n_edges;
    uint8_t n_facets; /* faces in 3-D, edges in 2-D */
    uint8_t n_simplices;
    uint8_t n_vertices[PL_CELL_SIMPLICES];              /* of each simplex */
    uint8_t vertex[PL_CELL_CORNERS][PL_CELL_SIMPLICES]; /* of each simplex that makes a corner */
    uint8_t edge[PL_CELL_EDGES][2];
    int8_t facet[PL_CELL_FACES][4]; /* corners, outwards by the right hand; -1: none */
    uint8_t n_measured; /* corners at which dim edges meet: all but the apex of a pyramid */
    uint8_t neighbour[PL_CELL_CORNERS][3]; /* where the edges of these lead, right-handed */
    /* The ideal corner: |T|^2 = sum over i of to_corner[i] |e_i|^2 + sum over pairs of between
       |e_j - e_i|^2 (pairs 01, 02, 12), e_i the edge to neighbour i; and its determinant. */
    double to_corner[3], between[3], determinant; /* its edges have length 1 */
} pl_cell_shape;

/** Type of elements. */
typedef struct pl_cell_type {
    const pl_cell_shape *shape;
    uint8_t type; /* planish_cell_type */
    uint8_t order;
    uint8_t n_nodes;
    /* The corners that a node is between, as far from one as from the other: both the same for a
       corner, the ends of an edge for its mid, opposite corners of a face or cell for theirs. */
    const uint8_t (*between)[2];
    const char *name; /* as people say, plural: "quadratic tetrahedra" */
} pl_cell_type;

/** Return the type for a planish_cell_type; NULL for an unknown number, or a type without a measure
 *  (a point, a line). */
const pl_cell_type *pl_cell_type_of(int type);

/** Return the corners in the middle of which a node is if the element is straight, bit c for corner
 *  c: a corner itself, the ends of an edge, the corners of a face or of the cell. If these move by
 *  d, the node follows by d / (number of them) each. */
uint8_t pl_cell_parents(const pl_cell_type *type, int node);

#endif
