/* cells: checks of elements of any types.
 *
 *   pl_check_cells    whether planish_cells are what their comments say
 */
#ifndef PL_TOPOLOGY_CELLS_H
#define PL_TOPOLOGY_CELLS_H

#include <planish/planish.h>

/** Check cells, whose nodes are 0 .. n_nodes - 1: types, numbers of nodes, nodes, missing mids.
 *  Simplices with a node twice are refused. In other elements a node may be there twice, as in
 *  hexahedra that have been collapsed to wedges. Errors: _ARGUMENT, _MESH. */
int pl_check_cells(const planish_cells *cells, int64_t n_nodes, int threads, planish_error *error);

#endif
