/* large: meshes in PETSc's files, which go through DMPlex from end to end. */
#ifndef PL_TOOLS_MPI_LARGE_H
#define PL_TOOLS_MPI_LARGE_H

#include "mpi/crew.h"

/** Whether the mesh is too large for one process, and processes can do what arguments say each with
 *  its part of the file. */
int pl_large_can(const pl_arguments *arguments);

/** Smooth arguments->input, if pl_large_can; arguments: of the first process, NULL in the
 *  others. Collective. Returns the exit status. */
int pl_large_smooth(pl_crew *crew, const pl_arguments *arguments);

#endif
