/* bend: tangents and normals of a shape under work. */
#ifndef PL_SHAPE_BEND_H
#define PL_SHAPE_BEND_H

#include "shape/making.h"

/** Compute the tangents of curves, and the normals at corners. */
void pl_shape_bend(pl_features *w);

/** Give the shape the normals at corners: those that are the same for all facets of a node once. Errors:
 *  _MEMORY. */
int pl_shape_pack_normals(pl_features *w, planish_error *error);

#endif
