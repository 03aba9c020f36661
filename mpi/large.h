/* large: meshes in PETSc's files, of which no process ever has all. */
#ifndef PL_MPI_LARGE_H
#define PL_MPI_LARGE_H

#include "crew.h"

/** Smooth arguments->input, one of pl_plexfile_is; arguments: of the first process, NULL in the
 *  others. Collective. Returns the exit status. */
int pl_large_smooth(pl_crew *crew, const pl_arguments *arguments);

#endif
