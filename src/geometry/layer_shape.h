/* layer_shape: the shape that an element of a layer is to have, and those that others are.
 *
 * A layer element has uprights, edges across the layer, which have a height each, and edges along the
 * layer, which are to be regular: at a right angle and equally long in quadrilaterals and hexahedra,
 * those of an equilateral triangle in wedges and tetrahedra. Its corners are targets (target.h).
 *
 *   pl_layer_shape      of an element
 *   pl_layer_shapes     of all elements of a mesh
 *   pl_factor_of, pl_upright_at    the uprights of products
 *   pl_layer_target     the target of a corner
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

/** Shapes of the elements of a mesh. Owned. */
typedef struct pl_layer_shapes {
    int32_t *place; /* [cells] of an element in shape, -1: it is to be ideal */
    pl_layer_shape *shape;
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

#endif
