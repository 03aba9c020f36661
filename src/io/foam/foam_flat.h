/* foam_flat: a layer of cells between empty patches is a mesh of two dimensions. */
#ifndef PL_IO_FOAM_FOAM_FLAT_H
#define PL_IO_FOAM_FOAM_FLAT_H

#include "io/foam/foam_patches.h"

/** Make a mesh of two dimensions of one that is a layer of cells between empty patches: the points of
 *  both sides become nodes of one, and mesh->dim is 2. Else it stays as it is. */
int foam_flatten(foam_mesh *mesh, const foam_patches *patches, planish_error *error);

#endif
