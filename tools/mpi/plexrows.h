/* plexrows: a copy of PETSc's HDF5 file in which only coordinates differ.
 */
#ifndef PL_TOOLS_MPI_PLEXROWS_H
#define PL_TOOLS_MPI_PLEXROWS_H

#include "mpi/plexfile.h"

/** Why processes cannot read and write the file at path together: NULL, and form is filled in, if
 * they can; "" if it is no such file, or a damaged one, which its reader will say. */
const char *pl_plexrows_refusal(const char *path, pl_plexform *form);

/** Make path a copy of the file that f was read from, with the coordinates of share. *reason: 0 in
 *  all processes, or an errno in those that have failed; then it may be there and be anything.
 *  checksums [2]: as of pl_plexfile_write. Collective. */
PetscErrorCode pl_plexrows_write(const pl_plexfile *f, const pl_share *share, const char *path,
                                 uint64_t *checksums, int *reason);

#endif
