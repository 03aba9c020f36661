/* stages: invalid curved elements become valid. */
#ifndef PL_IMPROVE_MEND_STAGES_H
#define PL_IMPROVE_MEND_STAGES_H

#include "improve/mend/elements.h"

/** Mend the invalid elements that are not given up, with few nodes first; moves_corners: corners may
 *  move, too. No element becomes invalid. Elements that cannot be mended are given up. Errors: _MEMORY,
 *  with the mesh as it is by then. */
int pl_mend_invalid(pl_mend *c, int moves_corners, planish_error *error);

/** Improve the elements whose least coefficient is below options.curve_quality of their mean, by their
 *  mids alone. Errors: as above. */
int pl_mend_poor(pl_mend *c, planish_error *error);

#endif
