/* lead: the work of planish-mpi. The first process runs `planish smooth` with an engine that gives
 * the others orders; all carry each order out together, each with its share of the mesh.
 */
#ifndef PL_TOOLS_MPI_LEAD_H
#define PL_TOOLS_MPI_LEAD_H

#include "mpi/crew.h"

#include "options/options.h"

/** In the first process: do what arguments say, and let the others go. Returns the exit status. */
int pl_crew_lead(pl_crew *crew, const pl_arguments *arguments);

/** In the others: work until there is no more to do. Returns the exit status. */
int pl_crew_follow(pl_crew *crew);

#endif
