/* xdmf_tags: grids that list elements of another grid once more, to give them values (tags of
 * DOLFINx).
 */
#ifndef PL_IO_XDMF_XDMF_TAGS_H
#define PL_IO_XDMF_XDMF_TAGS_H

#include "io/core/parts.h"
#include "io/vtk/vtk_cells.h"

/** Return the parts of a cell of VTK's type, its dimension and number of corners; NULL: it is no flat
 *  or solid element. */
const io_parts *xdmf_parts_of(int type, int *dim, int *corners);

/** Find the cell of the model, of a number below end, that has the corners of each cell of grid:
 *  *map [grid->n], owned by the caller. NULL: not all are there. Error: _MEMORY. */
int xdmf_find_map(const io_model *model, const vtk_grid *grid, int64_t end, int64_t **map,
                  planish_error *error);

#endif
