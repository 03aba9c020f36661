/* cells: checks and orientation of elements of any types.
 *
 *   pl_check_cell_fields, pl_check_cells     whether planish_cells are what their comments say
 *   pl_counted_type                          the type of an element that counts
 *   pl_orient_cells                          the sign of a valid element's det J (cell_orientation.c)
 *   pl_cell_census_find, _destroy            and how many elements share each facet
 *   pl_cell_facets_find                      which elements share each facet
 *   pl_cell_facet                            the corners of a facet
 */
#ifndef PL_TOPOLOGY_CELLS_H
#define PL_TOPOLOGY_CELLS_H

#include <planish/planish.h>

#include "geometry/cell.h"

/** Check the number of cells, and that all arrays are there. Errors: _ARGUMENT. */
int pl_check_cell_fields(const planish_cells *cells, planish_error *error);

/** Check cells, whose nodes are 0 .. n_nodes - 1: types, numbers of nodes, nodes, missing mids.
 *  Simplices with a node twice are refused. In other elements a node may be there twice, as in
 *  hexahedra that have been collapsed to wedges. Errors: _ARGUMENT, _MESH. */
int pl_check_cells(const planish_cells *cells, int64_t n_nodes, int threads, planish_error *error);

/** Return the type of an element of dimension dim; NULL: the element has another dimension. */
const pl_cell_type *pl_counted_type(const planish_cells *cells, int dim, int64_t element);

/** Find the sign of det J that each element has where the mesh is valid: that of most elements that
 *  facets join, or of its type if nothing joins it; a simplex that nothing joins is right. sign [n] is
 *  +1 or -1, whatever of elements of another dimension than dim. coordinates [n_nodes][dim]. Errors: _MEMORY. */
int pl_orient_cells(const planish_cells *cells, int dim, int64_t n_nodes, const double *coordinates,
                    int threads, int8_t *sign, planish_error *error);

enum { PL_CELL_FACET_PLACES = 8 }; /* of each element in arrays by facets */

/** How elements share facets. Owned. */
typedef struct pl_cell_census {
    int8_t *sign;       /* [n] as of pl_orient_cells */
    uint8_t *n_sharing; /* [n * PL_CELL_FACET_PLACES] elements that have facet k of element i, 3 for
                             more than two: at i * PL_CELL_FACET_PLACES + k; 0: there is no such
                             facet */
    uint8_t
        *on_boundary; /* [n_nodes] 1: corner of a facet of one element, of more than two, or that
                             contradicts the orientation; or of a duplicate */
    uint8_t *is_duplicate; /* [n] 1: with the corners of an earlier element of its type, or with a
                              facet twice */
    int64_t n_boundary_facets, n_nonmanifold_facets; /* of one element, of more than two */
    int64_t n_duplicate_elements;
} pl_cell_census;

/** Find the signs as pl_orient_cells does, and how facets are shared. Errors: _MEMORY. */
int pl_cell_census_find(const planish_cells *cells, int dim, int64_t n_nodes,
                        const double *coordinates, int threads, pl_cell_census *census,
                        planish_error *error);

/** Free the arrays of census. */
void pl_cell_census_destroy(pl_cell_census *census);

/** Find which elements of dimension dim share facets: n_sharing as of a census, and with
 *  [n * PL_CELL_FACET_PLACES] an earlier element, the first of those that have the facet; -1: the
 *  element is that itself, is listed twice, or has no such facet. is_inside [n_nodes]: facets with
 *  such a corner are left out, as if they were not there; NULL: none. Errors: _MEMORY. */
int pl_cell_facets_find(const planish_cells *cells, int dim, int64_t n_nodes,
                        const uint8_t *is_inside, int threads, int32_t *with, uint8_t *n_sharing,
                        planish_error *error);

/** List the corners of facet k of an element, in order around it, each once: node [4]. Returns how
 *  many; fewer than the dimension: there is no facet left. */
int pl_cell_facet(const planish_cells *cells, int64_t element, int k, int32_t *node);

#endif
