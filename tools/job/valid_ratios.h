/* valid_ratios: ratios of a mesh by corners, without the elements that are inverted inside. */
#ifndef PL_TOOLS_VALID_RATIOS_H
#define PL_TOOLS_VALID_RATIOS_H

#include "job/cells.h"

/** Measure the mesh as it is now, and find out which elements are valid. Of elements of other types than
 *  simplices the ratios of movable and of fixed elements are over those that validity->quality is over.
 *  validity is to be freed also after an error. Returns 0, or an exit status after a message. */
int pl_measure_valid(const pl_job *job, planish_quality *quality, pl_cells_validity *validity);

#endif
