/* slides: which nodes of a mesh that no process has all of can slide on its surface. */
#ifndef PL_TOOLS_MPI_SLIDES_H
#define PL_TOOLS_MPI_SLIDES_H

#include "mpi/crew.h"

/** Find what planish_find_slides finds for the whole mesh (whose region is share's), of which all
 * nodes are free so far: constraint and direction of crew's share. tolerance: as in
 * planish_surface. Collective. Returns 0, or a planish_status with *error, the same in all
 * processes. */
int pl_surface_slide(pl_crew *crew, double tolerance, planish_error *error);

#endif
