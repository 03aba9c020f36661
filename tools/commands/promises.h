/* promises: promises of planish_smooth, kept where the file rounds the result, and checked before
 * the mesh is written. Both functions return 0, or an exit status after a message. */
#ifndef PL_TOOLS_PROMISES_H
#define PL_TOOLS_PROMISES_H

#include "report/result.h"

/** In a tilted plane, let nodes return to their old places where the file's rounding would make the
 *  mesh worse than it was: result->returned_nodes. Nothing happens to meshes in other planes. */
int pl_promises_keep(pl_job *job, pl_result *result);

/** The library promises not to make anything worse; a mesh that says otherwise is not written.
 *  Laplacian methods promise nothing; F and the ratios are over the valid elements, and to untangle
 *  others, or bring them above their minimum volume, may cost both. */
int pl_promises_check(const pl_job *job, const pl_result *result);

#endif
