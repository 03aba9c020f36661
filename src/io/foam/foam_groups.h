/* foam_groups: facets, entities and groups of patches and zones. */
#ifndef PL_IO_FOAM_FOAM_GROUPS_H
#define PL_IO_FOAM_FOAM_GROUPS_H

#include "io/foam/foam_patches.h"

/** Make facets of the faces of the boundary and of zones; entities and groups of the sets. */
int foam_make_groups(const foam_mesh *mesh, const foam_sets *sets, planish_error *error);

#endif
