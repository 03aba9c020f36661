/* hollows: which pieces of the outside of a shape lie in others. */
#ifndef PL_FIT_HOLLOWS_H
#define PL_FIT_HOLLOWS_H

#include "fit/fit.h"

/** Turn the closed pieces that are hollows in others, and find the nests of all. facets: the tree of all facets.
 *  Errors: _MEMORY. */
int pl_fit_turn_hollows(const planish_shape *shape, const pl_tree *facets, int threads,
                        pl_fit_pieces *pieces, planish_error *error);

#endif
