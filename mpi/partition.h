/* partition: which process gets which elements. */
#ifndef PL_MPI_PARTITION_H
#define PL_MPI_PARTITION_H

#include <planish/planish.h>

#include <petscpartitioner.h>

/** Cut whole (NULL in all processes but the first) by its elements into as many pieces of the same
 *  size as comm has processes, with little between them. to is a partitioner that hands DMPlex
 * these pieces. Collective. */
PetscErrorCode pl_partition(MPI_Comm comm, const planish_mesh *whole, PetscPartitioner to);

/** Scotch, if PETSc has it; or what PETSC_OPTIONS say (-petscpartitioner_type). */
PetscErrorCode pl_choose_partitioner(PetscPartitioner partitioner);

#endif
