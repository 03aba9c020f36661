/* foam_cells: elements of the cells that faces enclose. */
#ifndef PL_IO_FOAM_FOAM_CELLS_H
#define PL_IO_FOAM_FOAM_CELLS_H

#include "io/foam/foam_walk.h"

/** Make elements of the cells that have the faces of one. Others hold their nodes. */
int foam_make_cells(foam_mesh *mesh, planish_error *error);

/** Find the elements that cells of three dimensions are: their types, which are 0 of other cells, and
 *  nodes, to be released in any case. is_plain: without the walk over faces, for tests. */
int foam_find_elements(const foam_mesh *mesh, int is_plain, foam_elements *elements,
                       planish_error *error);

#endif
