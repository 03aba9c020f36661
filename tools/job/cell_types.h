/* cell_types: what is known of elements by their types alone.
 *
 *     pl_cell_type_name, _count             name of a type; elements of it as text
 *     pl_cells_count                        the number of elements by type, as text
 *     pl_cells_have_types                   whether some are no simplices
 *     pl_cells_are_flat                     whether all have two dimensions
 *     pl_cell_corners, pl_cell_is_simplex   what a type has
 */
#ifndef PL_TOOLS_CELL_TYPES_H
#define PL_TOOLS_CELL_TYPES_H

#include <planish/planish.h>

#include <stddef.h>

/** Number of corners of an element of a type of two or three dimensions. */
int pl_cell_corners(planish_cell_type type);

/** Whether a type is a triangle or tetrahedron, of any order. */
int pl_cell_is_simplex(planish_cell_type type);

/** Whether cells have elements of dimension dim that are smoothed and no simplices: ratios are
 *  aspect ratios then. */
int pl_cells_have_types(const planish_cells *cells, int dim);

/** Whether all cells are elements of two dimensions. */
int pl_cells_are_flat(const planish_cells *cells);

/** Name of a type of two or three dimensions in tables and reports: "hexahedron", "hexahedron20". */
const char *pl_cell_type_name(planish_cell_type type);

/** Put n elements of a type into text: "1 hexahedron", "12 quadratic hexahedra". */
void pl_cell_type_count(planish_cell_type type, int64_t n, char *text, size_t size);

/** Put the numbers of the elements by type into text: "703 tetrahedra, 560 hexahedra". */
void pl_cells_count(const planish_cells *cells, char *text, size_t size);

#endif
