/* planes: the planes of a surface, and the edges between them. Internal to shape. */
#ifndef PL_SHAPE_PLANES_H
#define PL_SHAPE_PLANES_H

#include "shape/surface.h"

/** An edge of the shape: between facets of different planes or labels, or tagged; in 2-D each facet
 *  is one. */
typedef struct pl_ridge {
    int32_t node[2]; /* own numbers of the surface, ascending */
    pl_label label;  /* in 2-D of the facet; in 3-D its tag alone */
} pl_ridge;

typedef struct pl_ridges {
    int64_t n, capacity;
    pl_ridge *ridge; /* [n] ascending by nodes */
} pl_ridges;

/** Planes: classes of facets that are joined by edges across which they are coplanar. */
typedef struct pl_planes {
    int64_t n;
    int32_t *of_facet; /* [n_facets] its plane; -1: the class is not planar as a whole */
    double *normal;    /* [n][3] of unit length */
} pl_planes;

/** Find the planes of a surface in 3-D, and the edges between them. tolerance: how far nodes may be
 *  off, in the surface's units. is_fixed [nodes of the mesh] becomes PL_FIXED_ALWAYS for nodes of
 *  tagged edges that are not on the surface, and PL_FIXED_UNLESS_CURVED for nodes of quadrilaterals
 *  that are not planar. ridges is to be released in any case. Errors: _MEMORY. */
int pl_planes_create(const pl_surface *surface, const planish_surface *tags, double tolerance,
                     pl_planes *planes, pl_ridges *ridges, uint8_t *is_fixed, planish_error *error);

/** Free the arrays of planes. */
void pl_planes_destroy(pl_planes *planes);

#endif
