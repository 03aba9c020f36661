/* given_up: the state of elements while a mesh is untangled, and elements given up in another process. */
#ifndef PL_IMPROVE_UNTANGLE_GIVEN_UP_H
#define PL_IMPROVE_UNTANGLE_GIVEN_UP_H

#include "plan/plan.h"

/** State of an element that is not PLANISH_VOLUME_MET. */
typedef enum pl_tangle_state {
    PL_TANGLED = PLANISH_VOLUME_BELOW,
    PL_GIVEN_UP = 2 /* tangled, and given up */
} pl_tangle_state;

/** Tell the other processes of given-up elements, and hear of theirs. state [n_elements] becomes PL_GIVEN_UP where it
 *  is PL_TANGLED and the star of a ghost has given the element up in its process. of_facet:
 *  pl_proof_role of the stars here. Errors: _MEMORY. */
int pl_send_given_up(const planish_plan *plan, const uint8_t *of_facet, uint8_t *state,
                     planish_error *error);

#endif
