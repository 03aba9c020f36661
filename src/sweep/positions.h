/* positions: where the nodes of a run are, in the caller's numbering. */
#ifndef PL_SWEEP_POSITIONS_H
#define PL_SWEEP_POSITIONS_H

#include "sweep/skin.h"
#include "sweep/watch.h"

/** Positions of the nodes of a run, as they are or were. */
typedef struct pl_positions {
    const planish_plan *plan;
    const double *given; /* [n][dim] where the plan's nodes were when the run began */
    const double *now;   /* [n][dim] by inner numbers */
    const pl_mids *mids; /* NULL: no node follows corners */
    const pl_skin *skin;
    const void *saved; /* places of the skin at that time (pl_skin_save); NULL: as they are */
} pl_positions;

/** Write where the plan's nodes, and those that follow, are to coordinates, laid out as the caller's: bit by
 *  bit as a result is written. positions: a pl_positions. */
void pl_positions_fill(const void *positions, double *coordinates);

#endif
