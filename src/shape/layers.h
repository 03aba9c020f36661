/* layers: the thin elements that lie in layers (pl_find_layers).
 */
#ifndef PL_SHAPE_LAYERS_H
#define PL_SHAPE_LAYERS_H

#include <planish/planish.h>

/** Find the elements of layers: is_layer [n_elements] becomes 1 for them, 0 for the others, and
 *  *n_layer their number. mesh is dense. See planish_find_layers. Errors: _MESH, _MEMORY. */
int pl_find_layers(const planish_mesh *mesh, int threads, uint8_t *is_layer, int64_t *n_layer,
                   planish_error *error);

#endif
