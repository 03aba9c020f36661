/* settle: what smoothing in a tilted plane becomes as it is written, in space. */
#ifndef PL_TOOLS_SETTLE_H
#define PL_TOOLS_SETTLE_H

#include "report/result.h"

/** Let nodes go back to where they were where the rounding of what is written would make the mesh
 *  worse than it was: result->returned_nodes. Nothing happens to meshes in other planes. Returns 0,
 *  or an exit status after a message. */
int pl_settle(pl_job *job, pl_result *result);

#endif
