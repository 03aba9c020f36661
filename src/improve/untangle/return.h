/* return: nodes back to where the call began. */
#ifndef PL_IMPROVE_UNTANGLE_RETURN_H
#define PL_IMPROVE_UNTANGLE_RETURN_H

#include "improve/untangle/tangle.h"

/** Put nodes back to where they were when the call began, where untangling has failed, without
 *  raising the number of tangled or inverted elements. Does nothing without memory, or for a
 *  mesh in parts. */
void pl_tangle_return(pl_tangle *t);

#endif
