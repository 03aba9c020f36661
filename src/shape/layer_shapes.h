/* layer_shapes: the shapes that elements of layers are to have: heights from the input, smoothed along
 * the layer, and regular along it (docs/algorithm.md, "Elements thin in layers").
 *
 *   pl_layer_shapes_find, _free
 */
#ifndef PL_SHAPE_LAYER_SHAPES_H
#define PL_SHAPE_LAYER_SHAPES_H

#include "geometry/layer_shape.h"

#include <planish/planish.h>

/** Find the shapes of the marked elements of mesh, which has checked cells and dense coordinates, and of
 *  flat ones that go on from them. Others are to be ideal. Errors: _MEMORY, _MESH. shapes is to be freed
 *  in either case. */
int pl_layer_shapes_find(const planish_mesh *mesh, const uint8_t *is_layer, int threads,
                         pl_layer_shapes *shapes, planish_error *error);

/** Free the shapes. */
void pl_layer_shapes_free(pl_layer_shapes *shapes);

#endif
