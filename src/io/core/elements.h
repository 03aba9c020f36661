/* elements: the table of element types that each format fills in, and the properties of a row.
 *
 *   io_shape, io_element_type    a row: shape, order, number of nodes
 *   io_element_dim               dimension of a type
 *   io_element_use               whether elements of a type are simplices of the model, others, or
 *                                refused
 *   io_element_mids              mids of simplices of second order
 *   io_element_cells             the cells of the model that elements of a type become
 *   io_cell_type                 the planish_cell_type of a shape
 *   io_cell_type_without_faces   what is left of a type where nodes of faces are missing
 *   io_element_reason            why elements that are not kept hold their nodes
 *   io_element_count             count elements that are not kept
 *
 * Readers of formats with a list of types use the table: Abaqus, CGNS, Gmsh, MED, Medit, VTK. Each
 * keeps its own rows and asks here what planish does with a type. The other readers (DMPlex,
 * Netgen, OFF, Nastran, TetGen) decide by the number of nodes.
 *
 * Elements that are no simplices of order 1 or 2 become other elements of the model where a
 * planish_cell_type stands for them (io_element_other); else they hold their nodes.
 */
#ifndef PL_IO_CORE_ELEMENTS_H
#define PL_IO_CORE_ELEMENTS_H

#include "io/core/cell_types.h"
#include "io/core/text.h"

typedef enum io_shape {
    IO_NO_SHAPE, /* the table has no such type */
    IO_POINT,
    IO_LINE,
    IO_TRIANGLE,
    IO_QUADRILATERAL,
    IO_POLYGON,
    IO_TETRAHEDRON,
    IO_PYRAMID,
    IO_PRISM,
    IO_HEXAHEDRON,
    IO_POLYHEDRON,
    IO_ANY_SHAPE /* of no known shape; it counts as one of three dimensions */
} io_shape;

/** Element type of a format. Tables by number have the row of type N at index N. */
typedef struct io_element_type {
    const char *name; /* in the file, where types have names, or for messages; or NULL */
    uint8_t shape;    /* io_shape */
    uint8_t order;    /* 1: straight, its nodes are its corners; 0: fewer nodes than corners */
    uint16_t nodes;   /* 0: each element says how many */
} io_element_type;

typedef enum io_element_treatment {
    IO_HOLD,  /* one of the others of the model, or it holds its nodes */
    IO_KEEP,  /* a cell of the model */
    IO_REFUSE /* fail: a triangle or tetrahedron of third order or higher */
} io_element_treatment;

/** Dimension of the elements of a type, 0 to 3. */
static inline int io_element_dim(const io_element_type *type) {
    const int shape = type->shape;
    return shape >= IO_TETRAHEDRON ? 3 : shape >= IO_TRIANGLE ? 2 : shape == IO_LINE ? 1 : 0;
}

/** Number of mids of a type that is a line, triangle or tetrahedron of second order with a node on
 *  each edge and no other; else 0. */
static inline int io_element_mids(const io_element_type *type) {
    if (type->order != 2) /* called for each element of large files */
        return 0;
    const int dim = io_element_dim(type), n = io_n_mids(dim);
    const int is_simplex =
        type->shape == IO_LINE || type->shape == IO_TRIANGLE || type->shape == IO_TETRAHEDRON;
    return is_simplex && type->nodes == dim + 1 + n ? n : 0;
}

/** Treatment of the elements of a type: lines, triangles and tetrahedra of first order, and of
 *  second order with mids (io_cells_set_mids), are kept. Triangles and tetrahedra of third order or
 *  higher are refused. All others are others, or hold their nodes. */
static inline io_element_treatment io_element_use(const io_element_type *type) {
    const int is_flat = type->shape == IO_TRIANGLE, is_solid = type->shape == IO_TETRAHEDRON;
    if (type->shape != IO_LINE && !is_flat && !is_solid)
        return IO_HOLD;
    if (type->order == 1 || io_element_mids(type) > 0)
        return IO_KEEP;
    return type->order > 2 && type->shape != IO_LINE ? IO_REFUSE : IO_HOLD;
}

/** Cells of the model that elements of a type become, borrowed; NULL: they are not kept. */
static inline io_cells *io_element_cells(io_model *model, const io_element_type *type) {
    return io_element_use(type) == IO_KEEP ? io_model_cells(model, io_element_dim(type)) : NULL;
}

/** Return the planish_cell_type of that shape (io_shape) with that many nodes; 0: there is none. */
static inline int io_cell_type(int shape, int n_nodes) {
    static const uint8_t types[][3] = {{IO_TRIANGLE, 3, PLANISH_CELL_TRIANGLE},
                                       {IO_TRIANGLE, 6, PLANISH_CELL_TRIANGLE6},
                                       {IO_QUADRILATERAL, 4, PLANISH_CELL_QUADRILATERAL},
                                       {IO_QUADRILATERAL, 8, PLANISH_CELL_QUADRILATERAL8},
                                       {IO_QUADRILATERAL, 9, PLANISH_CELL_QUADRILATERAL9},
                                       {IO_TETRAHEDRON, 4, PLANISH_CELL_TETRAHEDRON},
                                       {IO_TETRAHEDRON, 10, PLANISH_CELL_TETRAHEDRON10},
                                       {IO_HEXAHEDRON, 8, PLANISH_CELL_HEXAHEDRON},
                                       {IO_HEXAHEDRON, 20, PLANISH_CELL_HEXAHEDRON20},
                                       {IO_HEXAHEDRON, 27, PLANISH_CELL_HEXAHEDRON27},
                                       {IO_PRISM, 6, PLANISH_CELL_WEDGE},
                                       {IO_PRISM, 15, PLANISH_CELL_WEDGE15},
                                       {IO_PRISM, 18, PLANISH_CELL_WEDGE18},
                                       {IO_PYRAMID, 5, PLANISH_CELL_PYRAMID},
                                       {IO_PYRAMID, 13, PLANISH_CELL_PYRAMID13},
                                       {IO_PYRAMID, 14, PLANISH_CELL_PYRAMID14}};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (types[i][0] == shape && types[i][1] == n_nodes)
            return types[i][2];
    return 0;
}

/** Return the planish_cell_type of elements that become others of the model; 0: they are kept, or hold
 *  their nodes. */
static inline int io_element_other(const io_element_type *type) {
    return io_element_use(type) == IO_HOLD ? io_cell_type(type->shape, type->nodes) : 0;
}

/** Return the planish_cell_type of the same shape and order without nodes of faces and of the
 *  inside, which are the last ones; other types as they are. */
static inline int io_cell_type_without_faces(int type) {
    switch (type) {
    case PLANISH_CELL_QUADRILATERAL9:
        return PLANISH_CELL_QUADRILATERAL8;
    case PLANISH_CELL_HEXAHEDRON27:
        return PLANISH_CELL_HEXAHEDRON20;
    case PLANISH_CELL_WEDGE18:
        return PLANISH_CELL_WEDGE15;
    case PLANISH_CELL_PYRAMID14:
        return PLANISH_CELL_PYRAMID13;
    default:
        return type;
    }
}

/** Reason (an IO_HELD_ bit) why an element that is not in the model holds its nodes. */
static inline uint8_t io_element_reason(const io_element_type *type) {
    return type->shape == IO_POINT ? IO_HELD_BY_POINT : IO_HELD_BY_OTHER;
}

/** Count n elements that are not kept: among the lower ones (points, lines) or the others. */
static inline void io_element_count(io_model *model, const io_element_type *type, int64_t n) {
    *(type->shape == IO_POINT || type->shape == IO_LINE ? &model->n_lower : &model->n_other) += n;
}

#endif
