/* drawn_triangles: the triangles of a mesh that can be seen: of solid elements those that bound them, of
 * flat ones all. */
#ifndef PL_REPORT_DRAWN_TRIANGLES_H
#define PL_REPORT_DRAWN_TRIANGLES_H

#include "report/drawn_surface.h"

/** Fill triangle, element, sides and n_triangles of surface, between nodes of mesh (as for
 *  pl_drawn_surface_find). The caller frees surface also after an error. Errors: _MEMORY, and those of
 *  a mesh that is wrong. */
int pl_drawn_triangles_find(const planish_mesh *mesh, pl_drawn_surface *surface,
                            planish_error *error);

#endif
