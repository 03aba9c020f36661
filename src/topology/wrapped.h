/* wrapped: elements that reach around a periodic domain, from one side to the other
 * (pl_wrapped_find). Internal to topology.
 */
#ifndef PL_TOPOLOGY_WRAPPED_H
#define PL_TOPOLOGY_WRAPPED_H

#include "topology/topology.h"

/** Flags of an element, and at a root of its component. */
enum { PL_HAS_WRAPPED = 2, PL_HAS_BOUNDARY = 4 }; /* beside PL_WRAPPED */

/** Find the elements that wrap around. link [m]: as in components.h, of a whole mesh; conflict [m]:
 *  not 0 at roots of components that cannot be oriented, which are left out. flags [m] is given
 *  PL_WRAPPED at such elements and PL_HAS_WRAPPED at the roots of their components; the rest of it
 *  is left as it is. *n: how many there are. Errors: _MEMORY. */
int pl_wrapped_find(const planish_mesh *mesh, const uint32_t *link, const int8_t *conflict,
                    uint8_t *flags, int64_t *n, planish_error *error);

#endif
