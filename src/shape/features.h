/* features: features, patches and curves of a shape under work. */
#ifndef PL_SHAPE_FEATURES_H
#define PL_SHAPE_FEATURES_H

#include "shape/making.h"

/** Match the facets at edges: beside, n_ends, diagonals; and the mean lengths of edges. Errors: _MEMORY. */
int pl_features_match(pl_features *w, planish_error *error);

/** Turn facets the same way round, so that normals point out of the elements, or of those of the lower
 *  region. Where that cannot be an edge becomes one of a conflict. coordinates [n_mesh][3]. Errors: _MEMORY. */
int pl_features_orient(pl_features *w, const double *coordinates, planish_error *error);

/** Find features, patches and curves. Errors: _MEMORY. */
int pl_features_find(pl_features *w, planish_error *error);

/** Find the nodes of patches. */
void pl_features_settle(pl_features *w);

/** Count edges that do not have two facets which agree, and odd facets. */
void pl_features_count(const pl_features *w, planish_shape_info *info);

#endif
