/* crew: the processes of planish-mpi. The first one runs `planish smooth`; what that asks of the
 * library it does together with the others, each with its part of the mesh.
 */
#ifndef PL_TOOLS_MPI_CREW_H
#define PL_TOOLS_MPI_CREW_H

#include "mpi/share.h"

/** One process of them. */
typedef struct pl_crew {
    pl_engine engine; /* of the first process; first, so that an engine is its crew */
    MPI_Comm comm;    /* for orders and what is collected; the share's is another one */
    MPI_Comm exchange_comm;
    int rank, n_ranks, threads, bind;
    pl_share share;
    planish_plan *plan; /* of the share */
    int is_alone;       /* the first process works by itself, on the whole mesh */
    int is_broken;      /* PETSc has failed with a file, and HDF5 cannot be left in peace */
} pl_crew;

/** Whether a failed process may wait for the others so long before it ends them, seconds. */
#define PL_CREW_PATIENCE 10.0

/** Collective. threads: of this process; bind: whether they may be bound to cores. */
void pl_crew_create(pl_crew *crew, int threads, int bind);
/** With is_broken this ends all processes with status. */
void pl_crew_destroy(pl_crew *crew, int status);

/** The first process: do what arguments say, and let the others go. Returns the exit status. */
int pl_crew_lead(pl_crew *crew, const pl_arguments *arguments);

/** The others: work until there is no more to do. Returns the exit status. */
int pl_crew_follow(pl_crew *crew);

/* ---- what all processes do at the same time ------------------------------------------------- */

/** Whether all have done their work (code and *error: of this one): PLANISH_OK in all, or the same
 *  error in all. One that fails while others wait in the midst of something ends them. */
int pl_crew_agree(const pl_crew *crew, int code, planish_error *error);

/** The options of the first process (the others: NULL) for this one. */
planish_options pl_crew_options(const pl_crew *crew, const planish_options *options);

/** Make the plan of the share. */
int pl_crew_plan(pl_crew *crew, const planish_options *options, planish_error *error);

int pl_crew_measure(const pl_crew *crew, planish_quality *quality, planish_error *error);

/** Smooth the share. traffic: of all processes. */
int pl_crew_smooth(pl_crew *crew, const planish_options *options, planish_result *result,
                   pl_traffic *traffic, planish_error *error);

/** Of the share, and that itself. */
void pl_crew_destroy_plan(pl_crew *crew);

#endif
