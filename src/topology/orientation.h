/* orientation: the positive order of the nodes of each element. Internal to topology.
 *
 *   pl_orientation_guess      by the signs of the measures
 *   pl_orientation_create     by the facets
 */
#ifndef PL_TOPOLOGY_ORIENTATION_H
#define PL_TOPOLOGY_ORIENTATION_H

#include "topology/topology.h"

/** Fill in sign, n_reversed and is_guess of boundary if the measures of all elements agree. */
int pl_orientation_guess(const planish_mesh *mesh, int threads, pl_boundary *boundary,
                         planish_error *error);

/** Fill in sign, n_components and n_reversed of boundary by its components; on_boundary is complete
 *  but for the nodes of facets at which no orientation is possible, which it gets. */
int pl_orientation_create(const planish_mesh *mesh, const pl_incidence *incidence, int threads,
                          pl_boundary *boundary, planish_error *error);

#endif
