/* crossings: facets that have come to go through others. */
#ifndef PL_SURFACE_CROSSINGS_H
#define PL_SURFACE_CROSSINGS_H

#include "surface/smooth.h"

/** Set held [n_nodes of the shape] to 1 for the nodes of facets that go through others now, and did not at
 *  the start. *n_held: how many these are that were not held. Errors: _MEMORY. */
int pl_surface_hold_crossings(const pl_surface_run *run, uint8_t *held, int64_t *n_held,
                              planish_error *error);

#endif
