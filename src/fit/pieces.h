/* pieces: what the outside of a shape consists of. */
#ifndef PL_FIT_PIECES_H
#define PL_FIT_PIECES_H

#include "fit/fit.h"

/** Find the pieces of a shape's outside: facets that are joined at edges of two of them, which turn alike. Closed ones
 *  are to turn so that a body is inside. pieces is to be freed in any case. Errors: _MEMORY. */
int pl_fit_find_pieces(const planish_shape *shape, pl_fit_pieces *pieces, planish_error *error);

void pl_fit_free_pieces(pl_fit_pieces *pieces);

#endif
