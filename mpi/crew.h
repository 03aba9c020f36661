/* crew: the processes of planish-mpi. The first one runs `planish smooth`; what that asks of the
 * library it does together with the others, each with its part of the mesh.
 */
#ifndef PL_MPI_CREW_H
#define PL_MPI_CREW_H

#include "share.h"

/** One process of them. */
typedef struct pl_crew {
    pl_engine engine; /* of the first process; first, so that an engine is its crew */
    MPI_Comm comm;    /* for orders and what is collected; the share's is another one */
    MPI_Comm exchange_comm;
    int rank, n_ranks, threads, bind;
    pl_share share;
    planish_plan *plan; /* of the share */
    int is_alone;       /* the first process works by itself, on the whole mesh */
} pl_crew;

/** Whether a failed process may wait for the others so long before it ends them, seconds. */
#define PL_CREW_PATIENCE 10.0

/** Collective. threads: of this process; bind: whether they may be bound to cores. */
void pl_crew_create(pl_crew *crew, int threads, int bind);
void pl_crew_destroy(pl_crew *crew);

/** The first process: do what arguments say, and let the others go. Returns the exit status. */
int pl_crew_lead(pl_crew *crew, const pl_arguments *arguments);

/** The others: work until there is no more to do. Returns the exit status. */
int pl_crew_follow(pl_crew *crew);

#endif
