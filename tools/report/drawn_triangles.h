/* drawn_triangles: the triangles of a mesh that can be seen: of solid elements those that bound them, of
 * flat ones all. */
#ifndef PL_REPORT_DRAWN_TRIANGLES_H
#define PL_REPORT_DRAWN_TRIANGLES_H

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

/** Fill triangle, element, sides and n_triangles of surface, between nodes of mesh (as for
 *  pl_drawn_surface_find). The caller frees surface also after an error. Errors: _MEMORY, and those of
 *  a mesh that is wrong. */
int pl_drawn_triangles_find(const planish_mesh *mesh, pl_drawn_surface *surface,
                            planish_error *error);

#endif
