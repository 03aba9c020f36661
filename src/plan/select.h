/* select: the nodes that options.only_worse_than and options.around select.
 *
 *   pl_select            nodes of bad elements, and rings of elements around them
 *   pl_select_around     nodes around options->around
 */
#ifndef PL_PLAN_SELECT_H
#define PL_PLAN_SELECT_H

#include "topology/subset.h"

/** Choose the nodes that options->only_worse_than is about: is_selected [n] is filled with 0, or
 *  not 0 for the nodes of elements whose RR is above it, that are below their minimum volume, or
 * not positive, and of rings of elements around these. sign: as in pl_boundary. *all_positive: no
 *  element was found that is not. subset, which is {0}, is filled if it was found on the way.
 * Errors: _MESH (of its neighbours), _MEMORY. */
int pl_select(const planish_mesh *mesh, const int8_t *sign, const planish_options *options,
              int threads, uint8_t *is_selected, int *all_positive, pl_subset *subset,
              planish_error *error);

/** Choose the nodes that options->around is about; is_selected [n] is 0 before. */
void pl_select_around(const planish_mesh *mesh, const planish_options *options, int threads,
                      uint8_t *is_selected);

#endif
