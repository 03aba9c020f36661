/* walk: a subset of a mesh, found from neighbour to neighbour. */
#ifndef PL_TOPOLOGY_WALK_H
#define PL_TOPOLOGY_WALK_H

#include "topology/subset.h"

/** Nodes from which to walk, and an element of each. */
typedef struct pl_seeds {
    int64_t n;
    const int64_t *node, *element; /* [n] */
} pl_seeds;

/** Find a subset from neighbour to neighbour, which mesh has: the nodes of seeds are selected, and
 * those of so many rings of elements around. Of the mesh, which need not be dense, no more is
 * looked at than the subset, and that is checked; and of a node no more elements than it has
 * together with its seed, by facets at it. Errors: _ARGUMENT, _MESH, _MEMORY. */
int pl_subset_by_walk(const planish_mesh *mesh, const pl_seeds *seeds, int rings, pl_subset *subset,
                      planish_error *error);

#endif
