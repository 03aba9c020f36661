/* slides: the nodes that can slide on the planes and lines of the surface (pl_find_slides).
 */
#ifndef PL_SHAPE_SLIDES_H
#define PL_SHAPE_SLIDES_H

#include <planish/planish.h>

/** Find the constraint and direction of each node. mesh is dense; tags may be NULL. See
 *  planish_find_slides. Errors: _MESH, _MEMORY. */
int pl_find_slides(const planish_mesh *mesh, const planish_surface *tags, int threads,
                   uint8_t *constraint, double *direction, planish_slide_info *info,
                   planish_error *error);

#endif
