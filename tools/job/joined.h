/* joined: triangles that have points of their own, as many programs write them, joined where these are equal.
 *
 *     pl_join_triangles           join them
 *     pl_joined_free
 */
#ifndef PL_TOOLS_JOINED_H
#define PL_TOOLS_JOINED_H

#include <planish/planish.h>

/** Triangles that are joined. */
typedef struct pl_joined {
    planish_cells cells; /* the first ones of the arrays that were given, but for node */
    int32_t *node;       /* [3 * cells.n] owned */
    int32_t *region;     /* [cells.n] owned; NULL: they have none */
    int32_t *edges;      /* [n_edges][2] of the surface; owned */
    int64_t n_points;    /* that are others now */
    int64_t n_triangles; /* left out: they are there twice, or have no area */
} pl_joined;

/** Join triangles at borders: equal points there become one, and of triangles between the same points that turn alike
 *  the first one is left. Closed surfaces that touch stay two. Other cells stay as they are. mesh has cells; surface: its regions and
 *  edges. joined is to be freed in any case. Returns 0: there is no memory. */
int pl_join_triangles(const planish_mesh *mesh, const planish_surface *surface, pl_joined *joined);

void pl_joined_free(pl_joined *joined);

#endif
