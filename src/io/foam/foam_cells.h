/* foam_cells: elements of the cells that faces enclose. */
#ifndef PL_IO_FOAM_FOAM_CELLS_H
#define PL_IO_FOAM_FOAM_CELLS_H

#include "io/foam/foam_faces.h"

/** Make elements of the cells that have the faces of one. Others hold their nodes. */
int foam_make_cells(foam_mesh *mesh, planish_error *error);

#endif
