/* topology: what connects to what. One header for most of the folder; one source file per part.
 * Headers of their own have facets, subset (and walk), points, cells and frame; cell_star,
 * element_walk, local_map and small_ring are internal to the folder.
 *
 * Shapes use n = n_nodes, m = n_elements, k = dim + 1 (nodes of an element). A facet is a triangle
 * of a tetrahedron or an edge of a triangle. Everything is a function of the mesh alone, whatever
 * the number of threads.
 */
#ifndef PL_TOPOLOGY_H
#define PL_TOPOLOGY_H

#include "geometry/cell.h"
#include "geometry/link.h"

#include <planish/planish.h>

/* ---- validate.c: is this a mesh? ---------------------------------------------------------- */

/** A mesh of simplices of 32 bits and coordinates [n_nodes][dim]: the caller's arrays where they are
 *  such, else copies. */
typedef struct pl_dense {
    planish_mesh mesh;   /* cells is NULL */
    int32_t *elements;   /* copy or NULL */
    double *coordinates; /* copy or NULL */
    int32_t *cell_of;    /* [mesh.n_elements] of a mesh with cells: the cell of each element, whose
                            corners it has; NULL: the same numbers */
    uint8_t *corner;     /* [mesh.n_elements] where elements are corners (geometry/corner.h), those
                            of a cell one after the other; NULL: they are simplices */
    int64_t n_cells;     /* then: cells, */
    int32_t *cell_begin; /* [n_cells + 1] and the first corner of each */
    uint8_t *role;       /* [n_nodes] of a mesh with cells: PL_OF_CORNER, ...; NULL: all nodes of
                            elements are corners */
    uint8_t *constraint; /* [n_nodes] with role: the mesh's, FIXED for corners that cells hold */
    double *min_volume;  /* copies by element, */
    int32_t *periodic;   /* and without pairs of mids, or NULL */
} pl_dense;

/** Check dim, counts and strides of mesh, and which arrays there are. */
int pl_check_counts(const planish_mesh *mesh, planish_error *error);

/** Check the fields of mesh that concern nodes alone, as pl_check_counts does. */
int pl_check_nodes(const planish_mesh *mesh, planish_error *error);

/** Check mesh->part, if there is one: its functions, the numbers and roles of nodes, and that
 * elements have no ghosts alone. Errors: _ARGUMENT, _MESH. */
int pl_check_part(const planish_mesh *mesh, planish_error *error);

/** Check counts as pl_check_counts does, and indices, repeated nodes of an element and finite
 *  coordinates; then make *dense. The lowest offending element or node is reported, for any
 *  number of threads. Errors: _ARGUMENT, _MESH, _MEMORY. */
int pl_dense_create(const planish_mesh *mesh, int threads, pl_dense *dense, planish_error *error);

/** Check a mesh that has cells, and make *dense: the same mesh with dense coordinates. It is to be
 *  destroyed in any case. Errors: _ARGUMENT, _MESH, _MEMORY. */
int pl_dense_create_cells(const planish_mesh *mesh, int threads, pl_dense *dense,
                          planish_error *error);

/** Free the copies of dense. */
void pl_dense_destroy(pl_dense *dense);

/** Return mesh; if mesh->is_layer marks no element, a copy without targets. The
 *  counts of mesh are checked. */
const planish_mesh *pl_drop_targets(const planish_mesh *mesh, planish_mesh *copy);

/** Whether elements are to have sizes. */
static inline int pl_has_sizes(const planish_mesh *mesh) {
    return mesh->size || mesh->metric;
}

/** Whether elements are to have other shapes than the ideal ones, of a mesh from pl_drop_targets. */
static inline int pl_has_targets(const planish_mesh *mesh) {
    return mesh->reference || mesh->is_layer || pl_has_sizes(mesh);
}

/** Check the nodes of one element, of a mesh without cells. */
int pl_check_element(const planish_mesh *mesh, int64_t element, planish_error *error);

/** Node of a corner of an element of either width. */
static inline int64_t pl_corner(const planish_mesh *mesh, int64_t element, int corner) {
    const int64_t i = element * (mesh->dim + 1) + corner;
    return mesh->elements ? mesh->elements[i] : mesh->elements64[i];
}

/* ---- corners.c: a mesh of any elements as one of simplices --------------------------------- */

/** Bits of the role of a node in cells. */
enum {
    PL_OF_CORNER = 1, /* corner of a smoothed element */
    PL_OF_MID = 2,    /* mid of an edge of one, */
    PL_OF_EDGES = 4,  /* of several edges */
    PL_OF_OTHER = 8,  /* node of an element that is not smoothed */
    PL_STAYS = 16,    /* corner that cells hold */
    PL_BOUND = 32     /* not free by planish_mesh.constraint: a mid does not move by itself */
};

/** Whether a node of that role is a mid and nothing else: it follows the ends of its edge. */
static inline int pl_follows(uint8_t role) {
    return (role & PL_OF_MID) && !(role & (PL_OF_CORNER | PL_OF_OTHER));
}

/** Whether a cell, whose nodes are valid, is smoothed in a mesh of dimension dim: it is of that
 *  dimension, no pyramid of order 2, and has no corner twice. */
int pl_is_smoothed(const planish_cells *cells, int64_t cell, int dim);

/** Check mesh->cells, and make dense, which is mesh, one of the smoothed elements, by their corners if
 *  not all are simplices.
 *  Errors: _ARGUMENT, _MESH, _MEMORY. */
int pl_corners_take(const planish_mesh *mesh, int threads, pl_dense *dense, planish_error *error);

/** Find the curved edges of a cell of mesh, whose coordinates are finite: bit e is set if node e
 *  behind the corners is farther off the middle than planish_options.rounding: the mid of an edge
 *  off the middle of its ends, the node of a face or cell off the middle of its corners. 0 for a
 *  cell that is not smoothed. */
int pl_curved_edges(const planish_mesh *mesh, int64_t cell, double rounding);

/** Whether node i of a cell of mesh, in the middle of a quadrilateral face, is farther off the
 *  planes of its corners than planish_options.rounding. In these planes it may be anywhere: the
 *  face is as it would be without it, also after corners have moved in them. */
int pl_is_off_face(const planish_mesh *mesh, int64_t cell, int i, double rounding);

/* ---- incidence.c: the elements of every node ---------------------------------------------- */

/** Elements of each node that is asked for, compressed, ascending. */
typedef struct pl_incidence {
    int64_t *offset;  /* [n + 1] */
    int32_t *element; /* [offset[n]] */
} pl_incidence;

/** List the elements of every node. unasked [n]: not 0 for nodes whose list shall be empty; NULL:
 *  for none. Errors: _MEMORY. */
int pl_incidence_create(const planish_mesh *mesh, const uint8_t *unasked, int threads,
                        pl_incidence *incidence, planish_error *error);

/** List the first corner of each cell of every node, in a mesh whose elements are corners: corner [m]
 *  (geometry/corner.h). Errors: _MEMORY. */
int pl_cell_incidence_create(const planish_mesh *mesh, const uint8_t *corner, int threads,
                             pl_incidence *incidence, planish_error *error);

/** Write the nodes of an item, any thing that has some, to node; returns how many. */
typedef int pl_nodes_of_fn(const void *context, int64_t item, int32_t node[PL_CELL_NODES]);

/** List the items of each of n_nodes nodes. A node that is there twice has the item once, negative ones
 *  are passed over. Returns 0 without memory; incidence is empty then. */
int pl_items_of_nodes(int64_t n_nodes, int64_t n_items, pl_nodes_of_fn *nodes_of,
                      const void *context, int threads, pl_incidence *incidence);

/** Free the arrays of incidence. */
void pl_incidence_destroy(pl_incidence *incidence);

/* ---- boundary.c: facets, boundary nodes, orientation -------------------------------------- */

/** Result of the search of facets. */
typedef struct pl_boundary {
    uint8_t *on_boundary; /* [n] 1: on a facet of one element or of more than two, of a duplicate
                             element, or on a facet that contradicts its component's order */
    int8_t *sign;         /* [m] +1, -1: sign * measure is positive in a valid mesh; NULL: all +1 */
    int is_guess;         /* sign is that of the measures, which all agree: facets were not asked */
    int64_t n_boundary_facets;    /* of one element */
    int64_t n_nonmanifold_facets; /* of more than two */
    int64_t n_duplicate_elements; /* with the nodes of an earlier one, in any order */
    int64_t n_components;         /* of elements joined by facets, 0: was not needed */
    int64_t n_reversed;           /* elements of sign -1 */
    int64_t n_wrapped;            /* elements that wrap around: on_boundary has their nodes; */
    uint8_t *flags;               /* [m] PL_WRAPPED is set at these; NULL: there are none */
} pl_boundary;

/** Compare the signs of the measures: if all are positive (all_positive: that is known), or all
 * negative, sign is that for a guess. mesh is valid. */
int pl_boundary_create(const planish_mesh *mesh, int all_positive, int threads,
                       pl_boundary *boundary, planish_error *error);

enum { PL_WRAPPED = 1 };

/** Count the facets, and orient the elements. Orientation is combinatorial (docs/algorithm.md):
 * inside a component of elements joined by facets of two elements (no duplicates), neighbours
 * traverse their facet in opposite directions; the component's sign is that of its summed measure,
 * elements that wrap around left out (wrapped.c). Where there are such, or no boundary, it is that
 * of 80 % of the elements if they all contradict the sum. Neither is so in a mesh in parts. A
 * component that cannot be oriented, such as a Moebius strip, keeps the file's order up to that
 * sign; where two of its neighbours traverse their facet in the same direction, the facet's nodes
 * are held. A guess that no facet contradicts says the same, and remains. is_inside [n]: 1 for
 * nodes that are known to be inside, as pl_rings_create says, by that guess; NULL: none are. */
int pl_boundary_find(const planish_mesh *mesh, const pl_incidence *incidence,
                     const uint8_t *is_inside, int threads, pl_boundary *boundary,
                     planish_error *error);

/** Free the arrays of boundary. */
void pl_boundary_destroy(pl_boundary *boundary);

/* ---- orientation.c: the positive order of the nodes of each element, for boundary.c -------- */

/** Fill in sign, n_reversed and is_guess of boundary if the measures of all elements agree. */
int pl_orientation_guess(const planish_mesh *mesh, int threads, pl_boundary *boundary,
                         planish_error *error);

/** Fill in sign, n_components and n_reversed of boundary by its components; on_boundary is complete
 *  but for the nodes of facets at which no orientation is possible, which it gets. */
int pl_orientation_create(const planish_mesh *mesh, const pl_incidence *incidence, int threads,
                          pl_boundary *boundary, planish_error *error);

/* ---- components.c: components of elements that facets join, for orientation.c ----------------
 *
 * link [m] says of each element the root of its component among the elements here, an element, << 1
 * | its parity: 1 if its order is opposite to that of the root. In a mesh in parts a component may
 * have several roots, in one process or in several. pl_components_settle and _sum are collective
 * there. */

/** Number of the nodes of an element, by which they are known in all processes: two elements have
 *  the same if they are duplicates, or by one chance in 2^62. */
int64_t pl_element_id(const planish_mesh *mesh, int64_t element);

/** Facts that processes exchange about components. In arrays [m] only the entries of roots
 *  count. */
typedef struct pl_settlement {
    int64_t *label;    /* the same of all roots of a component, and of no other one; owned */
    uint8_t *reversed; /* 1: parities here are opposite to those that all processes agree on: of the
                          element of the smallest id it is 0; owned */
    int8_t *conflict;  /* given: 1 where parities contradict one another; then in all processes */
} pl_settlement;

/** Settle the components of a mesh in parts. s->conflict is given. Errors: _MEMORY. */
int pl_components_settle(const planish_mesh *mesh, const pl_incidence *incidence,
                         const uint32_t *link, pl_settlement *s, planish_error *error);

/** Free the arrays of s. */
void pl_settlement_destroy(pl_settlement *s);

/** Sum the measures of each component, exactly, rounded once: measure [m] of elements becomes, at
 *  roots, that of the component. s: in a mesh in parts; else NULL. *n: how many components there
 *  are. Errors: _MEMORY. */
int pl_components_sum(const planish_mesh *mesh, const uint32_t *link, const pl_settlement *s,
                      double *measure, int64_t *n, planish_error *error);

/* ---- wrapped.c: elements that reach around a periodic domain, for orientation.c ------------ */

/** Flags at the root of a component, beside PL_WRAPPED of an element. */
enum { PL_HAS_WRAPPED = 2, PL_HAS_BOUNDARY = 4 };

/** Find the elements that wrap around. link [m]: as above, of a whole mesh; conflict [m]:
 *  not 0 at roots of components that cannot be oriented, which are left out. flags [m] is given
 *  PL_WRAPPED at such elements and PL_HAS_WRAPPED at the roots of their components; the rest of it
 *  is left as it is. *n: how many there are. Errors: _MEMORY. */
int pl_wrapped_find(const planish_mesh *mesh, const uint32_t *link, const int8_t *conflict,
                    uint8_t *flags, int64_t *n, planish_error *error);

/* ---- ordering.c: nodes along a space-filling curve ---------------------------------------- */

/** Order the nodes along a Hilbert curve through their bounding box (ties: by number): order [n].
 *  Errors: _MEMORY. */
int pl_curve_order(const planish_mesh *mesh, int threads, int32_t *order, planish_error *error);

/* ---- rings.c: the neighbours and the link of every free node ------------------------------- */

/** Neighbours (nodes of a common element) of the nodes node [n_rings], and their links; ring r is
 *  that of node[r], and nothing but room if node[r] < 0. */
typedef struct pl_rings {
    int64_t n_rings, n_free;
    int64_t *offset;      /* [n_rings + 1] into neighbour */
    int32_t *neighbour;   /* each once, in order of first appearance in the ascending elements */
    int64_t *link_offset; /* [n_rings + 1] in link facets: one per element of the node */
    pl_link link; /* of all nodes, without the ends of edges; facets in the order of their elements,
                     oriented so that the measure of (facet, node) is positive in a valid mesh: with
                     x the node, 3-D (x - p0) . ((p1 - p0) x (p2 - p0)) > 0, 2-D
                     (p0 - x) x (p1 - x) > 0; their edges: p0 p1, p1 p2, p2 p0 */
    uint8_t *form; /* [link facets] their codes, where elements are corners; or NULL */
} pl_rings;

/** Make the rings of the free nodes. is_free [n]: not 0 for the nodes that may move, node
 * [n_rings]: these in the wanted order. Free are those of them that are inside, and have no more
 * than PL_MAX_LINK elements (open: half as many); of the others is_free becomes 0, and node -1.
 * Inside: the link is closed, every facet at the node belongs to two elements, no duplicates, which
 * traverse it in opposite directions. open: links may be, as on the boundary: facets of one element
 * will do. The edges of such links are not in rings->link. sign: as in pl_boundary. corner [m]: the
 * elements are corners (geometry/corner.h), each with the opposite one of its hexahedron as a
 * neighbour, and incidence is that of cells: links are open, and the caller knows which nodes are
 * inside; NULL: they are not. */
int pl_rings_create(const planish_mesh *mesh, const pl_incidence *incidence, const int8_t *sign,
                    const uint8_t *corner, uint8_t *is_free, int32_t *node, int64_t n_rings,
                    int open, int threads, pl_rings *rings, planish_error *error);

/** Free the arrays of rings. */
void pl_rings_destroy(pl_rings *rings);

/* ---- periodic.c: nodes that move together -------------------------------------------------- */

/** Node that is where another one, its leader, is, but for a constant. */
typedef struct pl_follower {
    int32_t node, of; /* of: the leader */
    int32_t from, to; /* nodes: the constant is the way from the one to the other at the start */
} pl_follower;

/** The mesh with a layer of copies, see periodic.c. Everything is owned. */
typedef struct pl_periodic {
    int64_t n_nodes, n_elements; /* with images and copies, which come after the mesh's own */
    int32_t *elements;           /* [n_elements][dim + 1] */
    int32_t *source;             /* [n_elements] element that each is a copy of, or itself */
    int8_t *sign;                /* [n_elements] or NULL, */
    double *min_volume;          /* [n_elements] or NULL */
    uint8_t *corner;             /* [n_elements] or NULL */
    int32_t *moves_with;         /* [n_nodes] the leader of its group, or itself */
    int64_t n_followers;
    pl_follower *follower; /* nodes that follow their leaders, then images */
} pl_periodic;

/** Check the pairs of mesh. Errors: _ARGUMENT, _MESH. */
int pl_check_periodic(const planish_mesh *mesh, planish_error *error);

/** Find the nodes that move together, and copy the elements around them. slides [n]: 1 for the
 *  nodes that may slide; of groups of which some may not, or not alike, or
 *  that are no translations of one another, it becomes 0. corner, incidence: as for pl_rings_create;
 *  cells are copied whole. Errors: _MEMORY. */
int pl_periodic_create(const planish_mesh *mesh, const pl_incidence *incidence, const int8_t *sign,
                       const uint8_t *corner, uint8_t *slides, pl_periodic *periodic,
                       planish_error *error);

/** Free the arrays of periodic. */
void pl_periodic_destroy(pl_periodic *periodic);

/* ---- colouring.c: independent nodes ------------------------------------------------------- */

/** Colour the nodes of rings so that no two neighbours share a colour. colour [n_rings]: 0 ..
 *  n_colours-1, -1 where there is no node. Greedy in the order (more free neighbours first, then a
 *  hash of the node's number, then its number), computed in parallel after Jones and Plassmann
 *  (1993): the result is that of the serial greedy algorithm, whatever the order of the rings, and
 *  whichever processes have parts of the mesh; colour has room for all ghosts, too
 *  (pl_parts_ghosts). number [n_nodes] is that number, ascending; NULL: node is. moves_with
 *  [n_nodes]: the node that each moves with counts for it; NULL: itself. */
int pl_colouring_create(const pl_rings *rings, const int32_t *node, const int32_t *number,
                        int64_t n_nodes, const int32_t *moves_with, int threads, int32_t *colour,
                        int *n_colours, planish_error *error);

/* ---- stars.c: the star of every free node ------------------------------------------------- */

/** The rings and links of nodes, compressed, in visiting order (the caller's choice). */
typedef struct pl_stars {
    int64_t n_stars;
    int64_t *ring_offset; /* [n_stars + 1] into ring */
    int32_t *ring;        /* the star's other nodes as in pl_rings, but numbered by number_of */
    int64_t *link_offset; /* [n_stars + 1] in link facets */
    pl_link link;         /* as in pl_rings, with the ends of edges: those of a link that is closed,
                             p and q as its last facet with that edge traverses it */
    double *min_volume;   /* [link_offset[n_stars]] mesh->min_volume of the facets' elements, or
                             NULL */
    uint8_t *form;        /* [link_offset[n_stars]] the facets' codes (geometry/corner.h), where
                                   elements are corners; or NULL */
    int32_t *element;     /* [link_offset[n_stars]] the facets' elements, of corners of a mesh with
                             a reference; or NULL */
    int64_t max_ring, max_link; /* of one star */
} pl_stars;

/** Copy the rings and links of the free nodes in the order of their visits. Star star_of[r], of 0
 *  .. rings->n_free-1, is that of ring r, which has a node; -1 where there is none: star_of
 *  [n_rings], node [n_rings] as returned by pl_rings_create. number_of [n] maps the mesh's node
 *  numbers to those written to stars->ring. incidence is used if the mesh has minimum volumes or a
 *  reference; corner
 *  as for pl_rings_create. Of the rings nothing is left afterwards. */
int pl_stars_create(const planish_mesh *mesh, const pl_incidence *incidence, const uint8_t *corner,
                    pl_rings *rings, const int32_t *node, const int32_t *star_of,
                    const int32_t *number_of, int threads, pl_stars *stars, planish_error *error);

/** Free the arrays of stars. */
void pl_stars_destroy(pl_stars *stars);

#endif
