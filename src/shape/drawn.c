/* drawn: solids of one element's thickness. */
#include "shape/drawn.h"

#include "geometry/layer_shape.h"
#include "geometry/simplex.h"
#include "shape/shape.h"
#include "topology/cells.h"

#include <math.h>

/** Return the distance of the two planes across an axis that the corners of all elements are in; 0: there are no
 *  two. Each element has corners in both, so the first one tells where they are. */
static double thickness_along(const planish_mesh *mesh, int axis) {
    static const double TOLERANCE = 1e-6; /* of the distance */
    double low = INFINITY, high = -INFINITY;
    for (int64_t i = 0; i < mesh->cells->n; i++) {
        const pl_cell_type *type = pl_counted_type(mesh->cells, 3, i);
        const int32_t *node = mesh->cells->node + mesh->cells->offset[i];
        const int n = type ? type->shape->n_corners : 0, is_first = !(low <= high);
        for (int k = 0; k < n && is_first; k++) {
            low = fmin(low, mesh->coordinates[(int64_t)node[k] * 3 + axis]);
            high = fmax(high, mesh->coordinates[(int64_t)node[k] * 3 + axis]);
        }
        for (int k = 0; k < n; k++) {
            const double x = mesh->coordinates[(int64_t)node[k] * 3 + axis];
            if (!(fmin(fabs(x - low), fabs(x - high)) <= TOLERANCE * (high - low)))
                return 0;
        }
    }
    return high > low ? high - low : 0;
}

/** Whether an element is a hexahedron that is thin in the planes. */
static int is_thin_in_plane(const pl_drawn *drawn, const planish_mesh *mesh, int64_t element) {
    const pl_cell_type *type = pl_counted_type(mesh->cells, 3, element);
    const int32_t *node = mesh->cells->node + mesh->cells->offset[element];
    double sum[3] = {0}, least = INFINITY, most = 0; /* of lengths */
    if (!type || type->shape->n_simplices != 3)
        return 0;
    const unsigned left_out = pl_drawn_factors(drawn, mesh, type->shape, node);
    for (int e = 0; e < type->shape->n_edges; e++) {
        const int a = type->shape->edge[e][0], b = type->shape->edge[e][1];
        sum[pl_factor_of(type->shape, a, b)] += pl_distance(
            3, mesh->coordinates + (int64_t)node[a] * 3, mesh->coordinates + (int64_t)node[b] * 3);
    }
    for (int f = 0; f < 3; f++)
        if (!(left_out >> f & 1)) {
            least = fmin(least, sum[f]);
            most = fmax(most, sum[f]);
        }
    return left_out && most >= PL_THIN * least;
}

pl_drawn pl_drawn_find(const planish_mesh *mesh) {
    pl_drawn drawn = {.axis = -1};
    int n_thin = 0;
    for (int d = 0; d < 3 && mesh->dim == 3 && drawn.axis < 0; d++) {
        drawn.thickness = thickness_along(mesh, d);
        drawn.axis = drawn.thickness > 0 ? d : -1;
    }
    for (int64_t i = 0; drawn.axis >= 0 && n_thin < PL_LEAST_OF_LAYER && i < mesh->cells->n; i++)
        n_thin += is_thin_in_plane(&drawn, mesh, i);
    drawn.axis = n_thin == PL_LEAST_OF_LAYER ? drawn.axis : -1;
    return drawn;
}

unsigned pl_drawn_factors(const pl_drawn *drawn, const planish_mesh *mesh,
                          const pl_cell_shape *shape, const int32_t *node) {
    unsigned found = 0;
    int is_line =
        1; /* not a triangle across the planes: a wedge that was drawn has its triangles in these */
    for (int e = 0; drawn->axis >= 0 && shape->n_simplices > 1 && e < shape->n_edges; e++) {
        const int a = shape->edge[e][0], b = shape->edge[e][1];
        const int factor = pl_factor_of(shape, a, b);
        const double way = mesh->coordinates[(int64_t)node[b] * 3 + drawn->axis] -
                           mesh->coordinates[(int64_t)node[a] * 3 + drawn->axis];
        if (fabs(way) > drawn->thickness / 2) {
            found |= 1U << factor;
            is_line &= shape->n_vertices[factor] == 2;
        }
    }
    return is_line && !(found & (found - 1)) ? found : 0;
}
