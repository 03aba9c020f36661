/* joined: facets that have points of their own, as many programs write them, joined where these are equal.
 *
 *     pl_joined_take              copy them, but for collapsed ones
 *     pl_joined_join              join them
 *     pl_joined_free
 */
#ifndef PL_TOOLS_JOINED_H
#define PL_TOOLS_JOINED_H

#include <planish/planish.h>

/** Triangles and quadrilaterals that are joined, or to be. */
typedef struct pl_joined {
    planish_cells cells;          /* of the arrays below; none: there are other cells */
    uint8_t *type;                /* [cells.n] owned */
    int64_t *offset;              /* [cells.n + 1] owned */
    int32_t *node;                /* [offset[cells.n]] owned */
    int32_t *region;              /* [cells.n] owned; NULL: they have none */
    int32_t *edges;               /* [n_edges][2] of the surface; owned */
    int64_t n_points;             /* that are others now */
    int64_t n_left_out;           /* facets that are there twice, or have no area; */
    int64_t n_quadrilaterals_out; /* of these */
} pl_joined;

/** Take the triangles and quadrilaterals of a mesh, which has cells, but for those with less than three nodes; none, if
 *  there are other cells. A quadrilateral with three nodes becomes a triangle. surface: their regions and edges. joined is
 *  to be freed in any case. Returns 0: there is no memory. */
int pl_joined_take(const planish_mesh *mesh, const planish_surface *surface, pl_joined *joined);

/** Join facets at borders: equal points there become one, and of facets between the same points that turn alike the first
 *  one is left. Closed surfaces that touch stay two. mesh: its nodes count; n_edges: of the surface that was taken. Returns
 *  0: there is no memory. */
int pl_joined_join(const planish_mesh *mesh, int64_t n_edges, pl_joined *joined);

void pl_joined_free(pl_joined *joined);

#endif
