/* foam_walk: tetrahedra and hexahedra, by one walk over the faces. */
#ifndef PL_IO_FOAM_FOAM_WALK_H
#define PL_IO_FOAM_FOAM_WALK_H

#include "io/foam/foam_faces.h"

/** Elements that cells are. Owned arrays. */
typedef struct foam_elements {
    uint8_t *type; /* [n_cells] planish_cell_type; 0: none that is known */
    int width;     /* 4, or 8 where a face has more than three nodes */
    int32_t *node; /* [n_cells][width] in VTK's order, of cells with a type */
} foam_elements;

/** Find the cells that are tetrahedra or hexahedra: their types, which are all 0 before, and nodes. */
int foam_walk_faces(const foam_mesh *mesh, foam_elements *elements, planish_error *error);

#endif
