/* create: make the shape of a mesh, and free it. */
#ifndef PL_SHAPE_CREATE_H
#define PL_SHAPE_CREATE_H

#include "shape/curved.h"

/** Make the shape of mesh, in space, whose coordinates are dense. cells: elements, and tags->region goes
 *  by them; NULL: those of mesh, and given, the caller's mesh, may have their mids. Errors: _MEMORY. */
int pl_shape_create(const planish_mesh *mesh, const planish_mesh *given, const planish_cells *cells,
                    const planish_surface *tags, int threads, planish_shape **shape,
                    planish_shape_info *info, planish_error *error);

/** Free shape; NULL is allowed. */
void pl_shape_destroy(planish_shape *shape);

#endif
