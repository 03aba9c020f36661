/* exodus_facets: facets of a mesh that is written, as sides of its elements.
 *
 *   exodus_facets, exodus_facets_find, _release    the facets
 */
#ifndef PL_IO_EXODUS_EXODUS_FACETS_H
#define PL_IO_EXODUS_EXODUS_FACETS_H

#include "io/view/view_blocks.h"

/** Side of an element. */
typedef struct exodus_side {
    int32_t element; /* its place in the file, from 1; 0: the facet is no side of any */
    int32_t side;    /* Exodus' number of the side */
} exodus_side;

/** Facets of a mesh: the cells of one dimension less than its elements. */
typedef struct exodus_facets {
    int dim;
    exodus_side *side; /* [n] in the order of the blocks; owned */
    int64_t n;
} exodus_facets;

/** Find the sides that the facets are, of the first element that has them. Elements are written in
 *  the order of their blocks, as cells of the types in a table. is_space: flat elements have the
 *  sides of shells. To be released in any case. Error: _MEMORY. */
int exodus_facets_find(const io_view *view, const io_view_blocks *blocks, const io_view_type *types,
                       int is_space, exodus_facets *facets, planish_error *error);
void exodus_facets_release(exodus_facets *facets);

#endif
