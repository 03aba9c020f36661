/* random_surfaces: the part of a random call on elements that has to do with regions and the curved surface, and what
 * must hold of the surface afterwards.
 *
 *   cells_bulge           a box with curved sides
 *   cells_draw_surface    regions, shape, and nodes that slide
 *   cells_check_surface   the surface is where it was, within the tolerance
 */
#ifndef TEST_SUPPORT_RANDOM_SURFACES_H
#define TEST_SUPPORT_RANDOM_SURFACES_H

#include "support/random_cells.h"

/** Bend all sides of a box in space of so many cubes along each side, but for those across the first direction:
 *  nodes of these stay in pairs. x [n_nodes][3] of any nodes of it. */
void cells_bulge(double *x, int64_t n_nodes, int cubes, uint64_t *state);

/** Make regions and the shape of a call as its levels ask for, and let nodes slide. regular: coordinates of the box
 *  before nodes were pushed. */
void cells_draw_surface(cells_call *c, const double *regular);

/** Find the nodes that slide on planes and lines, and on the shape of the call if there is one. */
void cells_find_slides(cells_call *c);

/** Return what is wrong with the surface at x [n_nodes][3], after a call that began with it as it was made;
 *  NULL: nothing. */
const char *cells_check_surface(const cells_call *c, const double *x);

#endif
