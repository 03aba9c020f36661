/* cell_types: what the model knows of a planish_cell_type. */
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

#endif
