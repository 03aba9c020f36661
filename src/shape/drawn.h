/* drawn: solids of one element's thickness, as plane meshes become that are drawn along an axis. Their layers
 * are in the plane, however thin the solid is. Internal to shape.
 *
 *   pl_drawn_find       whether a mesh is one, with layers
 *   pl_drawn_factors    edges of its elements from plane to plane
 */
#ifndef PL_SHAPE_DRAWN_H
#define PL_SHAPE_DRAWN_H

#include "geometry/cell.h"

#include <planish/planish.h>

/** All corners of elements are in two planes across an axis, and some hexahedra are thin in these planes. */
typedef struct pl_drawn {
    int axis; /* 0 .. 2; -1: the mesh is no such solid: it may be a plate, which is a layer itself */
    double thickness; /* distance of the planes */
} pl_drawn;

/** Find whether a mesh with dense coordinates is such a solid. */
pl_drawn pl_drawn_find(const planish_mesh *mesh);

/** Return the factor of a product whose edges go from plane to plane, as a bit: it has no uprights. 0: there
 *  is none, it is the triangle of a wedge, or the mesh is no such solid. */
unsigned pl_drawn_factors(const pl_drawn *drawn, const planish_mesh *mesh,
                          const pl_cell_shape *shape, const int32_t *node);

#endif
