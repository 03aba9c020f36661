/* orientation: which order of its nodes each element has. Internal to topology. */
#ifndef PL_TOPOLOGY_ORIENTATION_H
#define PL_TOPOLOGY_ORIENTATION_H

#include "topology/topology.h"

/** Fill in sign, n_components and n_reversed of boundary, whose on_boundary exists and gets the
 *  nodes of facets at which no orientation is possible.
 *  consistent: neighbours traverse every facet that joins them in opposite directions. */
int pl_orientation_create(const planish_mesh *mesh, const pl_incidence *incidence, int consistent,
                          int threads, pl_boundary *boundary, planish_error *error);

#endif
