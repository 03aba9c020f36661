/* cell_types: properties of a planish_cell_type in the model.
 *
 *   io_cell_type_nodes, _corners, _dim   number of nodes and corners, dimension
 *   io_cell_type_is_smoothed             whether its nodes may move
 *   io_cell_type_straight                the type of the corners alone
 *   io_simplex_type, io_simplex_dim, io_has_mids   simplices of order 1 and 2
 *   io_n_mids, io_edge_of          edges of simplices, in VTK's order
 */
#ifndef PL_IO_CORE_CELL_TYPES_H
#define PL_IO_CORE_CELL_TYPES_H

#include <planish/planish.h>

#include <stdint.h>

/** Number of nodes of a planish_cell_type of two or three dimensions; else 0. */
static inline int io_cell_type_nodes(int type) {
    static const uint8_t nodes[] = {
        [PLANISH_CELL_TRIANGLE] = 3,       [PLANISH_CELL_TRIANGLE6] = 6,
        [PLANISH_CELL_QUADRILATERAL] = 4,  [PLANISH_CELL_QUADRILATERAL8] = 8,
        [PLANISH_CELL_QUADRILATERAL9] = 9, [PLANISH_CELL_TETRAHEDRON] = 4,
        [PLANISH_CELL_TETRAHEDRON10] = 10, [PLANISH_CELL_HEXAHEDRON] = 8,
        [PLANISH_CELL_HEXAHEDRON20] = 20,  [PLANISH_CELL_HEXAHEDRON27] = 27,
        [PLANISH_CELL_WEDGE] = 6,          [PLANISH_CELL_WEDGE15] = 15,
        [PLANISH_CELL_WEDGE18] = 18,       [PLANISH_CELL_PYRAMID] = 5,
        [PLANISH_CELL_PYRAMID13] = 13,     [PLANISH_CELL_PYRAMID14] = 14};
    return type >= 0 && type < (int)sizeof nodes ? nodes[type] : 0;
}

enum { IO_CELL_NODES = 27 }; /* of a planish_cell_type, at most */

/** Number of corners, the first nodes, of such a type. */
static inline int io_cell_type_corners(int type) {
    switch (type) {
    case PLANISH_CELL_TRIANGLE:
    case PLANISH_CELL_TRIANGLE6:
        return 3;
    case PLANISH_CELL_PYRAMID:
    case PLANISH_CELL_PYRAMID13:
    case PLANISH_CELL_PYRAMID14:
        return 5;
    case PLANISH_CELL_WEDGE:
    case PLANISH_CELL_WEDGE15:
    case PLANISH_CELL_WEDGE18:
        return 6;
    case PLANISH_CELL_HEXAHEDRON:
    case PLANISH_CELL_HEXAHEDRON20:
    case PLANISH_CELL_HEXAHEDRON27:
        return 8;
    default:
        return 4;
    }
}

/** Dimension, 2 or 3, of such a type. */
static inline int io_cell_type_dim(int type) {
    switch (type) {
    case PLANISH_CELL_TRIANGLE:
    case PLANISH_CELL_TRIANGLE6:
    case PLANISH_CELL_QUADRILATERAL:
    case PLANISH_CELL_QUADRILATERAL8:
    case PLANISH_CELL_QUADRILATERAL9:
        return 2;
    default:
        return 3;
    }
}

/** Whether the nodes of such a type may move: of pyramids of second order, whose bases differ between
 *  programs, they are held. */
static inline int io_cell_type_is_smoothed(int type) {
    return type != PLANISH_CELL_PYRAMID13 && type != PLANISH_CELL_PYRAMID14;
}

/** Type of the same shape with no nodes but its corners, of a type of two or three dimensions. */
static inline int io_cell_type_straight(int type) {
    static const uint8_t straight[] = {[3] = PLANISH_CELL_TRIANGLE,
                                       [4] = PLANISH_CELL_TETRAHEDRON,
                                       [5] = PLANISH_CELL_PYRAMID,
                                       [6] = PLANISH_CELL_WEDGE,
                                       [8] = PLANISH_CELL_HEXAHEDRON};
    return io_cell_type_dim(type) == 2 && io_cell_type_corners(type) == 4
               ? PLANISH_CELL_QUADRILATERAL
               : straight[io_cell_type_corners(type)];
}

/** Type of a simplex of dimension 1 to 3, of order 2 or 1. */
static inline int io_simplex_type(int dim, int has_mids) {
    static const uint8_t types[][2] = {
        [1] = {PLANISH_CELL_LINE, PLANISH_CELL_LINE3},
        [2] = {PLANISH_CELL_TRIANGLE, PLANISH_CELL_TRIANGLE6},
        [3] = {PLANISH_CELL_TETRAHEDRON, PLANISH_CELL_TETRAHEDRON10}};
    return types[dim][has_mids != 0];
}

/** Dimension, 1 to 3, of simplices of order 1 or 2; of other types 0. */
static inline int io_simplex_dim(int type) {
    switch (type) {
    case PLANISH_CELL_LINE:
    case PLANISH_CELL_LINE3:
        return 1;
    case PLANISH_CELL_TRIANGLE:
    case PLANISH_CELL_TRIANGLE6:
        return 2;
    case PLANISH_CELL_TETRAHEDRON:
    case PLANISH_CELL_TETRAHEDRON10:
        return 3;
    default:
        return 0;
    }
}

/** Whether a type is a simplex of second order. */
static inline int io_has_mids(int type) {
    return type == PLANISH_CELL_LINE3 || type == PLANISH_CELL_TRIANGLE6 ||
           type == PLANISH_CELL_TETRAHEDRON10;
}

/** Number of edges of a simplex. */
static inline int io_n_mids(int dim) {
    return dim * (dim + 1) / 2;
}

/** Number of the edge between corners a and b of a simplex: 01 12 20 03 13 23. */
static inline int io_edge_of(int a, int b) {
    static const int8_t edges[4][4] = {{-1, 0, 2, 3}, {0, -1, 1, 4}, {2, 1, -1, 5}, {3, 4, 5, -1}};
    return edges[a][b];
}

#endif
