/* shape: the planes and straight lines that the surface of a mesh is made of, and which of its
 * nodes may slide on them. One header for the folder's own parts; slides.c is what the library
 * offers.
 */
#ifndef PL_SHAPE_H
#define PL_SHAPE_H

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
 *  off, in the surface's units. is_fixed [nodes of the mesh] becomes 1 for nodes of tagged edges
 * that are none of the surface. Errors: _MEMORY. ridges is to be released in any case. */
int pl_planes_create(const pl_surface *surface, const planish_surface *tags, double tolerance,
                     pl_planes *planes, pl_ridges *ridges, uint8_t *is_fixed, planish_error *error);

/** Free the arrays of planes. */
void pl_planes_destroy(pl_planes *planes);

/** is_fixed [nodes of the mesh] becomes 1 for nodes of the surface at the place of another one.
 *  Errors: _MEMORY. */
int pl_hold_twins(const pl_surface *surface, uint8_t *is_fixed, planish_error *error);

/** The edges of the shape in 2-D. Errors: _MEMORY. */
int pl_ridges_of_plane_mesh(const pl_surface *surface, pl_ridges *ridges, planish_error *error);

/** Straight lines: chains of two or more ridges. */
typedef struct pl_lines {
    int64_t n;
    int32_t *of_node;   /* [n_nodes] the line that the node is inside of, or -1 */
    int32_t (*next)[2]; /* [n_nodes] its neighbours on that line */
    double *direction;  /* [n][3] of unit length */
} pl_lines;

/** Find the lines that ridges make. A node is inside of one if two ridges of the same label meet
 *  there, straight on. Errors: _MEMORY. */
int pl_lines_create(const pl_surface *surface, const pl_ridges *ridges, double tolerance,
                    pl_lines *lines, planish_error *error);

/** Free the arrays of lines. */
void pl_lines_destroy(pl_lines *lines);

#endif
