/* worst_place: what there is to know of the worst elements besides their radius ratios. */
#ifndef PL_TOOLS_WORST_PLACE_H
#define PL_TOOLS_WORST_PLACE_H

#include "job/worst.h"

/** Fill in all but element and radius_ratio of worst->bad, from the mesh as it is now. Returns 0,
 *  -1 without memory, or an exit status after a message; what there is by then is the owner's to
 *  release. */
int pl_worst_place(const pl_job *job, pl_worst *worst);

#endif
