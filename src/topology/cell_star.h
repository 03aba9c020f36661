/* cell_star: the part of a cell in the stars of its nodes, where elements are corners of cells. Internal
 * to topology.
 *
 *   pl_cell_kinds_make       the tables of all kinds
 *   pl_cell_kind_of          the kind of the cell that begins with an element
 *   pl_cell_nodes            its nodes
 *   pl_cell_place            the place of a node among them
 *   pl_cell_facets           number of link facets that it has at a node
 *   pl_cell_facet_elements   and their elements
 *   pl_facet_corner          order of the nodes of a link facet
 *
 * A cell is known by its first corner: corners of a cell are elements one after the other. A node of a
 * cell is in several of its corners, each of which is a facet of the node's link. Which these are, and
 * how the node's neighbours stand in them, depends on the cell's kind and on the place of the node in it
 * alone.
 */
#ifndef PL_TOPOLOGY_CELL_STAR_H
#define PL_TOPOLOGY_CELL_STAR_H

#include "geometry/corner.h"
#include "geometry/fetch.h"

#include <stdint.h>

enum { PL_CELL_STAR_FACETS = 4, PL_CELL_KINDS = 4 };

/** Part of a node's star that one cell adds. */
typedef struct pl_cell_star {
    uint8_t n_others, n_facets;
    uint8_t
        other[PL_CELL_CORNERS]; /* its other nodes, in the order in which its corners at the node
                                       name them */
    uint8_t facet[PL_CELL_STAR_FACETS]
                 [3];                    /* of each of these corners the nodes of its link facet, in
                                              the facet's order (pl_rings.link) */
    uint8_t form[PL_CELL_STAR_FACETS];   /* its code, */
    uint8_t corner[PL_CELL_STAR_FACETS]; /* and which corner of the cell it is */
} pl_cell_star;

/** Cells of one kind. */
typedef struct pl_cell_kind {
    uint8_t n_nodes;
    uint8_t
        at[PL_CELL_CORNERS]; /* of each node: its place in elements after those before the cell */
    uint8_t twice;           /* twice the nodes of a closed link that a cell stands for, after
                                    Euler; in 3-D there are 2 nodes more */
    pl_cell_star star[2][PL_CELL_CORNERS]; /* [sign is negative][place of the node] */
} pl_cell_kind;

/** Which node of its facet in a link the j-th of the other nodes of an element is. turned: the order
 *  of the facet needs two of them exchanged. No branch: nothing could predict it. */
PL_AT_ONCE int pl_facet_corner(int dim, int j, int turned) {
    const int exchange = -turned & (2 * dim - 3); /* 3-D: 1 and 2, 2-D: 0 and 1 */
    return j < dim - 2 ? j : j ^ exchange;
}

/** Make the tables of elements of dimension dim. */
void pl_cell_kinds_make(int dim, pl_cell_kind kind[PL_CELL_KINDS]);

/** Kind of the cell that begins with an element. */
static inline const pl_cell_kind *pl_cell_kind_of(const pl_cell_kind *kinds, const uint8_t *corner,
                                                  int64_t first) {
    return kinds + pl_corner_kind(corner[first]);
}

/** Copy the nodes of a cell, of which own [..] are the elements from the first corner on. */
PL_AT_ONCE void pl_cell_nodes(const pl_cell_kind *kind, const int32_t *own,
                              int32_t node[PL_CELL_CORNERS]) {
    for (int v = 0; v < kind->n_nodes; v++)
        node[v] = own[kind->at[v]];
}

/** Place of wanted among the nodes of a cell. No branch: nothing could predict it. */
PL_AT_ONCE int pl_cell_place(const pl_cell_kind *kind, const int32_t *node, int32_t wanted) {
    int place = 0;
    for (int v = 1; v < kind->n_nodes; v++)
        place += v & -(node[v] == wanted);
    return place;
}

/** Number of link facets that the cell from the element first on has at a node. */
int pl_cell_facets(const pl_cell_kind *kinds, const uint8_t *corner, const int32_t *elements,
                   int dim, int64_t first, int32_t node);

/** Fill element with the elements of these link facets, in the order of pl_rings.link; returns how
 *  many. */
int pl_cell_facet_elements(const pl_cell_kind *kinds, const uint8_t *corner,
                           const int32_t *elements, int dim, int64_t first, int32_t node,
                           int32_t *element);

#endif
