/* layer_shape: the shape that an element of a layer is to have, and those that others are.
 *
 * A layer element has uprights, edges across the layer, which have a height each, and edges along the
 * layer, which are to be regular: at a right angle and equally long in quadrilaterals and hexahedra,
 * those of an equilateral triangle in wedges and tetrahedra. Its corners are targets (target.h).
 *
 *   pl_layer_shape      of an element
 *   pl_layer_shapes     of all elements of a mesh
 *   pl_factor_of, pl_upright_at    the uprights of products
 *   pl_layer_target, pl_layer_shapes_target    the target of a corner
 */
#ifndef PL_GEOMETRY_LAYER_SHAPE_H
#define PL_GEOMETRY_LAYER_SHAPE_H

#include "geometry/cell.h"
#include "geometry/target.h"

enum { PL_UPRIGHTS = 4 }; /* of an element, at most */

/** Shape that an element of a layer is to have. */
typedef struct pl_layer_shape {
    uint8_t factor;             /* of a product: the line of it that the uprights are, */
    double height[PL_UPRIGHTS]; /* their lengths, by pl_upright_at, */
    double size;                /* and the length of the edges along the layer */
    double edges[3][3];         /* of a simplex: from its first corner */
} pl_layer_shape;

/** Shape that a product has: from its first corner to the others. */
typedef struct pl_own_shape {
    double edges[PL_CELL_CORNERS - 1][3];
} pl_own_shape;

/** Shapes of the elements of a mesh. Owned. */
typedef struct pl_layer_shapes {
    int32_t
        *place; /* [cells] of an element in shape; -1: it is to be ideal; -2 - i: it is own[i] */
    pl_layer_shape *shape;
    pl_own_shape *own;
} pl_layer_shapes;

/** Return the simplex of the product that differs between corners a and b of an edge. */
static inline int pl_factor_of(const pl_cell_shape *shape, int a, int b) {
    int f = 0;
    while (shape->vertex[a][f] == shape->vertex[b][f])
        f++;
    return f;
}

/** Return the number of the upright at corner c of a product: the uprights in the order of their first
 *  corners. */
int pl_upright_at(const pl_cell_shape *shape, int factor, int c);

/** Make the target of corner c of an element of a shape; wanted is NULL for the ideal one. Return as
 *  pl_target_make. */
int pl_layer_target(const pl_cell_shape *shape, const pl_layer_shape *wanted, int c,
                    pl_target *target);

/** Make the target of corner c of an element, which is cell of the mesh of shapes. Return as
 *  pl_target_make. */
int pl_layer_shapes_target(const pl_layer_shapes *shapes, const pl_cell_shape *shape, int64_t cell,
                           int c, pl_target *target);

/** Find the edges of corner c of an element with the shape own. Return their determinant. */
double pl_own_shape_edges(const pl_cell_shape *shape, const pl_own_shape *own, int c,
                          double edges[3][3]);

#endif
