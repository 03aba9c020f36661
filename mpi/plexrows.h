/* plexrows: a copy of PETSc's HDF5 file in which only coordinates differ.
 */
#ifndef PL_MPI_PLEXROWS_H
#define PL_MPI_PLEXROWS_H

#include "plexfile.h"

typedef enum pl_plexrows {
    PL_PLEXROWS_WRITTEN,
    PL_PLEXROWS_OTHER, /* coordinates do not stand there in rows of doubles, or are not those that
                          the mesh was read with */
    PL_PLEXROWS_FAILED /* the file cannot be copied or written */
} pl_plexrows;

/** Make path a copy of the file that f was read from, with the coordinates of share; if that is not
 *  possible it may be there and be anything. Collective, with the same result in all. */
PetscErrorCode pl_plexrows_write(const pl_plexfile *f, const pl_share *share, const char *path,
                                 pl_plexrows *result);

#endif
