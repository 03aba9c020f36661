/* creases: features of a shape under work by their bend alone. */
#ifndef PL_SHAPE_CREASES_H
#define PL_SHAPE_CREASES_H

#include "shape/making.h"

/** Before edges are decided about: find the nodes of very many facets. Errors: _MEMORY. */
int pl_creases_begin(pl_features *w, planish_error *error);

/** Whether the bend of edge k of f, of two facets whose normals make an angle of that cosine, alone makes
 *  it a feature. */
int pl_is_crease(const pl_features *w, int32_t f, int k, double cosine);

/** Chains of one or two creases of at most 60 degrees of which an end is in the smooth surface are noise:
 *  make smooth edges of them. Errors: _MEMORY. */
int pl_creases_prune(pl_features *w, planish_error *error);

#endif
