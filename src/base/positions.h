/* positions: where the nodes of a call are, as its progress function may ask. */
#ifndef PL_BASE_POSITIONS_H
#define PL_BASE_POSITIONS_H

#include "base/context.h"

/** Positions of the nodes of a call, as long as its progress function runs. */
struct planish_positions {
    void (*fill)(const void *from, double *coordinates); /* as planish_progress_get_coordinates */
    const void *from;
    pl_context *context; /* of the call */
    const double *given; /* coordinates of the call */
};

#endif
