/* crew: the processes of planish-mpi, and how they act together.
 *
 *     pl_crew_create, _destroy    the processes, and what each has of the mesh
 *     pl_crew_tell, _listen       orders of the first process
 *     pl_crew_agree               whether a step was done in all of them
 *     pl_crew_options             the first one's options
 *
 * lead.h has the work that they do, large.h meshes that no process has all of.
 */
#ifndef PL_TOOLS_MPI_CREW_H
#define PL_TOOLS_MPI_CREW_H

#include "mpi/plexfile.h"
#include "mpi/share.h"

#include "job/engine.h"

#include <limits.h>

/** One process of them. */
typedef struct pl_crew {
    pl_engine engine; /* of the first process; first, so that an engine is its crew */
    MPI_Comm comm;    /* for orders and what is collected; the share's is another one */
    MPI_Comm exchange_comm;
    int rank, n_ranks, threads, bind;
    pl_share share;
    planish_plan *plan;   /* of the share */
    int is_large;         /* no process has all of the mesh, which is in */
    pl_plexfile file;     /* this file, */
    char input[PATH_MAX]; /* of this name */
    int is_broken;        /* PETSc has failed with a file, and HDF5 cannot be left in peace */
} pl_crew;

/** Create the crew. Collective. threads: of this process; bind: whether they may be bound to cores.
 */
void pl_crew_create(pl_crew *crew, int threads, int bind);

/** Release all that it has; with is_broken this ends all processes with status. */
void pl_crew_destroy(pl_crew *crew, int status);

/** Destroy the plan of the share, and the share itself but for large meshes, which are written from
 *  it. */
void pl_crew_destroy_plan(pl_crew *crew);

/** Send an order of the first process to the others, and wait for one in the others. */
void pl_crew_tell(const pl_crew *crew, int order);
int pl_crew_listen(const pl_crew *crew);

/** Whether all have done their work (code and *error: of this one): PLANISH_OK in all, or the same
 *  error in all. One that fails while others wait in the midst of something ends them. Collective.
 */
int pl_crew_agree(const pl_crew *crew, int code, planish_error *error);

/** Options for this process: those that the first one gives. Collective. */
planish_options pl_crew_options(const pl_crew *crew, const planish_options *options);

/** Copy a path of the first process into path [PATH_MAX] of all. Collective. */
void pl_crew_path(const pl_crew *crew, const char *from, char *path);

#endif
