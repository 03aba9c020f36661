/* layer_heights: the heights of layers beside those that they are to have.
 *
 *   pl_layer_heights_find
 */
#ifndef PL_SHAPE_LAYER_HEIGHTS_H
#define PL_SHAPE_LAYER_HEIGHTS_H

#include <planish/planish.h>

/** Compare the heights of the layers of marked elements at now [n_nodes][dim] with those that they are to
 *  have by mesh, which has checked cells and dense coordinates. off: as of planish_measure_layers. Errors:
 *  _MEMORY, _MESH. */
int pl_layer_heights_find(const planish_mesh *mesh, const uint8_t *is_layer, const double *now,
                          int threads, planish_layer_heights *found, double *off,
                          planish_error *error);

#endif
