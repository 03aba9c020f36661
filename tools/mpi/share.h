/* share: the part that a process has of a mesh.
 *
 * PETSc's DMPlex cuts the mesh into pieces (PT-Scotch) with one layer of overlap, and hands them
 * out.
 *
 *     pl_share_create     from a mesh that the first process has
 *     pl_share_take       from a piece that each process has
 *     pl_collect          values of all shares to the first process
 *     pl_share_explain    errors with numbers of the whole mesh
 */
#ifndef PL_TOOLS_MPI_SHARE_H
#define PL_TOOLS_MPI_SHARE_H

#include "mpi/exchange.h"
#include "mpi/piece.h"

/** Values of all processes in the first one, and their numbers in the whole mesh. */
typedef struct pl_collection {
    pl_gathering gathering;
    int32_t *number; /* [gathering.n_all]; owned */
} pl_collection;

/** The part of this process. Everything is owned. */
typedef struct pl_share {
    planish_mesh mesh; /* its arrays are those that follow */
    planish_part part;
    double *coordinates, *direction, *min_volume;
    int32_t *elements, *region; /* region: of a piece that has them, or NULL */
    uint8_t *constraint, *role, *is_counted;
    int64_t *node_number, *element_number; /* in the whole mesh */
    pl_exchange exchange;
    pl_collection own_nodes, counted_elements;
} pl_share;

/** Share whole, which the first process has (the others: NULL). Collective. Returns 0, or a
 * negative planish_status with *error filled in, not in all processes the same; to be destroyed in
 * any case.
 */
int pl_share_create(pl_share *share, MPI_Comm comm, const planish_mesh *whole,
                    planish_error *error);
/** Create the share from a piece that each process has by itself; nothing can be collected then. */
int pl_share_take(pl_share *share, MPI_Comm comm, pl_piece *piece, planish_error *error);
void pl_share_destroy(pl_share *share);

/** Let the error of a call on the part, if code says that there is one, tell the numbers of the
 * whole mesh, too. Returns code. */
int pl_share_explain(const pl_share *share, int code, planish_error *error);

/** A planish_status, with *error filled in, for what PETSc says. */
int pl_fail_petsc(planish_error *error, PetscErrorCode code);

/** Collect values [n][size] of all processes: the first one puts them to whole [.][size], in the
 * order of the whole mesh. room: for
 * gathering.n_all of them. */
void pl_collect(const pl_collection *collection, const void *values, int size, void *room,
                void *whole);

#endif
