/* partition: which process gets which elements. */
#ifndef PL_TOOLS_MPI_PARTITION_H
#define PL_TOOLS_MPI_PARTITION_H

#include <petscdmplex.h>

#include <stdint.h>

/** Cut a mesh, of which each process has n elements (none, some or all) with these corners [n][dim
 * + 1], numbers of nodes in the whole mesh, into as many pieces of the same size as comm has
 *  processes, with little between them. dm's partitioner then hands out these pieces: dm's elements
 *  are the first points of each process, in the same order. Scotch cuts, if PETSc has it, or what
 *  PETSC_OPTIONS say (-petscpartitioner_type). Collective. */
PetscErrorCode pl_partition(MPI_Comm comm, int dim, int64_t n, const int32_t *corner, DM dm);

#endif
