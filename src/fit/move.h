/* move: rounds of steps towards the places. */
#ifndef PL_FIT_MOVE_H
#define PL_FIT_MOVE_H

#include "fit/fit.h"

/** Move each node towards its place, unless it is there, as far as its elements stay valid and
 *  above floor, a fraction of their size. coordinates: as points say. Returns the largest part of
 *  its way that a node has gone. */
double pl_fit_round(planish_fit *fit, const pl_points *points, double *coordinates, double floor);

/** Find which of the nodes that were there are still on the other shape: where nodes are now. */
void pl_fit_stay(planish_fit *fit, const pl_points *points);

/** Find which nodes are at their places. Returns how many are not; *farthest (may be NULL): of them from
 *  there, in the mesh's units. */
int64_t pl_fit_arrive(planish_fit *fit, const pl_points *points, double *farthest);

#endif
