/* large: meshes in PETSc's files, which go through DMPlex from end to end. */
#ifndef PL_MPI_LARGE_H
#define PL_MPI_LARGE_H

#include "crew.h"

/** Smooth arguments->input, one of pl_plexfile_is; arguments: of the first process, NULL in the
 *  others. Collective. Returns the exit status. */
int pl_large_smooth(pl_crew *crew, const pl_arguments *arguments);

#endif
