/* twins: nodes of the surface that lie at the same place.
 *
 * Parts of a mesh that were written side by side (the pieces of a parallel program, bodies that are
 * tied) have the nodes between them twice, and so does a crack. Each would slide for its own star,
 * and what was one would gape. So they stay.
 */
#include "shape/shape.h"

#include "base/memory.h"
#include "base/status.h"
#include "topology/points.h"

int pl_hold_twins(const pl_surface *surface, uint8_t *is_fixed, planish_error *error) {
    const pl_points points = {surface->x, surface->n_nodes, surface->dim, surface->dim, 1, NULL};
    uint8_t *is_doubled = pl_alloc(surface->n_nodes, sizeof *is_doubled);
    int status = is_doubled ? PLANISH_OK : pl_fail_memory(error, "the surface");
    if (!status)
        status = pl_points_find_doubled(&points, is_doubled, error);
    for (int64_t i = 0; !status && i < surface->n_nodes; i++)
        if (is_doubled[i])
            is_fixed[surface->node[i]] = 1;
    pl_free(is_doubled);
    return status;
}
