/* drawn_surface: the triangles that a picture draws: of solid elements those that bound them, of flat
 * ones all; coarser where they are many. A quadrilateral is two triangles. */
#ifndef PL_REPORT_DRAWN_SURFACE_H
#define PL_REPORT_DRAWN_SURFACE_H

#include <planish/planish.h>

/** Triangles between points; a point stands for one or more nodes of the mesh. */
typedef struct pl_drawn_surface {
    int64_t n_all;       /* triangles that the surface has */
    int64_t n_triangles; /* that are drawn */
    int32_t *triangle;   /* [n_triangles][3] points, owned; of solid elements counterclockwise as
                            seen from outside */
    uint8_t
        *sides; /* [n_triangles] bit j: the line from corner j to the next one is an edge; owned,
                       or NULL: all are */
    int32_t *element; /* [n_triangles] element of the mesh that each is a part of, owned */
    int64_t n_points;
    int32_t *point; /* [n_nodes of the mesh] their point, or -1; owned */
} pl_drawn_surface;

/** Find the surface of mesh (elements of 32 bits, or cells, of which the corners are drawn;
 *  coordinates without strides), of at most most triangles. 0 or a negative planish_status. */
int pl_drawn_surface_find(const planish_mesh *mesh, int64_t most, pl_drawn_surface *surface,
                          planish_error *error);

void pl_drawn_surface_free(pl_drawn_surface *surface);

#endif
