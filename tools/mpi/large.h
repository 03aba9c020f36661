/* large: meshes in PETSc's files that no process has all of: the steps of lead.h that differ. All
 * but pl_large_can are collective, and return PLANISH_OK or the same planish_status with *error in
 * all processes.
 *
 *     pl_large_can                         whether this mesh goes this way
 *     pl_large_read, _share, _write        its steps
 */
#ifndef PL_TOOLS_MPI_LARGE_H
#define PL_TOOLS_MPI_LARGE_H

#include "mpi/crew.h"

#include "options/options.h"

/** Whether the mesh is too large for one process, and processes can do what arguments say each with
 *  its part of the file. */
int pl_large_can(const pl_arguments *arguments);

/** Read the mesh at path (of the first process) into crew->file. */
int pl_large_read(pl_crew *crew, const char *path, planish_error *error);

/** Cut it, take this process's share, and let its nodes slide if arguments (of the first process)
 *  say so. */
int pl_large_share(pl_crew *crew, const pl_arguments *arguments, planish_error *error);

/** Write the file with the coordinates of the shares to path. checksums [2]: as of pl_engine, in
 *  the first process; NULL: not wanted. */
int pl_large_write(pl_crew *crew, const char *path, uint64_t *checksums, planish_error *error);

#endif
