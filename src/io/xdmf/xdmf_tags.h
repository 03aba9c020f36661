/* xdmf_tags: grids that list elements of another grid once more, to give them values (tags of
 * DOLFINx).
 */
#ifndef PL_IO_XDMF_XDMF_TAGS_H
#define PL_IO_XDMF_XDMF_TAGS_H

#include "base/hash.h"

#include "io/core/parts.h"
#include "io/vtk/vtk_cells.h"

/** Cells of the model of one dimension by their corners: a hash table of places in two lists. */
typedef struct xdmf_table {
    io_list list[2];      /* simplices and others */
    int64_t n_entered[2]; /* of them */
    int64_t *slot;        /* [n_slots] owned: 2 * index + list; -1 */
    int64_t n_slots;
    pl_hash hash;
} xdmf_table;

/** Tables of flat and of solid cells, which begin as zeros. */
typedef struct xdmf_tables {
    xdmf_table table[2];
} xdmf_tables;

/** Return the parts of a cell of VTK's type, its dimension and number of corners; NULL: it is no flat
 *  or solid element. */
const io_parts *xdmf_parts_of(int type, int *dim, int *corners);

/** Find the cell of the model, of a number below end, that has the corners of each cell of grid:
 *  *map [grid->n], owned by the caller. NULL: not all are there. The tables grow with the model, in
 *  which numbers ascend; end, too. Error: _MEMORY. */
int xdmf_find_map(xdmf_tables *tables, const io_model *model, const vtk_grid *grid, int64_t end,
                  int64_t **map, planish_error *error);

/** Release the tables. */
void xdmf_tables_release(xdmf_tables *tables);

#endif
