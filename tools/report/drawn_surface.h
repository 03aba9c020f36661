/* drawn_surface: the triangles that a picture draws: of solid elements those that bound them, of flat
 * ones all; coarser where they are many. A quadrilateral is two triangles. */
#ifndef PL_REPORT_DRAWN_SURFACE_H
#define PL_REPORT_DRAWN_SURFACE_H

#include "report/drawn_triangles.h"

/** Find the surface of mesh (elements of 32 bits, or cells, of which the corners are drawn;
 *  coordinates without strides), of at most most triangles. 0 or a negative planish_status. */
int pl_drawn_surface_find(const planish_mesh *mesh, int64_t most, pl_drawn_surface *surface,
                          planish_error *error);

void pl_drawn_surface_free(pl_drawn_surface *surface);

#endif
