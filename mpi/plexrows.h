/* plexrows: a copy of PETSc's HDF5 file in which only coordinates differ.
 */
#ifndef PL_MPI_PLEXROWS_H
#define PL_MPI_PLEXROWS_H

#include "plexfile.h"

/** Make path a copy of the file that f was read from, with the coordinates of share. *done: 0 if
 * that is not possible, as they do not stand there in rows of doubles, are not those that f has, or
 * could not be written: path may be there then, and be anything. Collective. */
PetscErrorCode pl_plexrows_write(const pl_plexfile *f, const pl_share *share, const char *path,
                                 int *done);

#endif
