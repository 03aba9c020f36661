/* drawn: solids of one element's thickness. */
#include "shape/drawn.h"

#include "geometry/layer_shape.h"

#include <math.h>

/** Return the distance of the two planes across an axis that all nodes are in; 0: there are no two. */
static double thickness_along(const planish_mesh *mesh, int axis) {
    static const double TOLERANCE = 1e-6; /* of the distance */
    const double *x = mesh->coordinates + axis;
    double second = x[0];
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        second = second == x[0] ? x[i * 3] : second;
        const double off = fmin(fabs(x[i * 3] - x[0]), fabs(x[i * 3] - second));
        if (!(off <= TOLERANCE * fabs(second - x[0])))
            return 0;
    }
    return fabs(second - x[0]);
}

pl_drawn pl_drawn_find(const planish_mesh *mesh) {
    pl_drawn drawn = {.axis = -1};
    for (int d = 0; d < 3 && mesh->dim == 3 && mesh->n_nodes > 0 && drawn.axis < 0; d++) {
        drawn.thickness = thickness_along(mesh, d);
        drawn.axis = drawn.thickness > 0 ? d : -1;
    }
    return drawn;
}

unsigned pl_drawn_factors(const pl_drawn *drawn, const planish_mesh *mesh,
                          const pl_cell_shape *shape, const int32_t *node) {
    unsigned found = 0;
    for (int e = 0; drawn->axis >= 0 && shape->n_simplices == 3 && e < shape->n_edges; e++) {
        const int a = shape->edge[e][0], b = shape->edge[e][1];
        const double way = mesh->coordinates[(int64_t)node[b] * 3 + drawn->axis] -
                           mesh->coordinates[(int64_t)node[a] * 3 + drawn->axis];
        if (fabs(way) > drawn->thickness / 2)
            found |= 1U << pl_factor_of(shape, a, b);
    }
    return found & (found - 1) ? 0 : found;
}
