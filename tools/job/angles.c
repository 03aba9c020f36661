/* angles: the extreme angles of simplices. */
#include "job/angles.h"

#include "geometry/angle.h"

#include <math.h>

static const double DEGREES = 57.295779513082320877; /* of a radian */

pl_angles pl_angles_find(int dim, const double *const vertex[]) {
    double edges[3][3] = {{0}}, largest = 0;
    pl_edges(dim, vertex, edges);
    for (int i = 0; i < dim; i++)
        for (int d = 0; d < dim; d++)
            largest = fmax(largest, fabs(edges[i][d]));
    for (int i = 0; i < dim; i++) /* edges of about 1, so that nothing overflows */
        for (int d = 0; d < dim; d++)
            edges[i][d] /= largest;
    const pl_shape shape = pl_shape_of_edges(dim, edges);
    const int is_known = shape.determinant != 0 && shape.smallest_cosine <= shape.largest_cosine;
    return (pl_angles){is_known ? pl_smallest_angle(&shape) * DEGREES : NAN,
                       is_known ? pl_largest_angle(&shape) * DEGREES : NAN};
}

/** The triangle is laid out in its plane. */
pl_angles pl_angles_find_in_space(const double *const vertex[]) {
    double u[3], v[3], uu = 0, uv = 0, largest = 0;
    for (int d = 0; d < 3; d++) {
        u[d] = vertex[1][d] - vertex[0][d];
        v[d] = vertex[2][d] - vertex[0][d];
        largest = fmax(largest, fmax(fabs(u[d]), fabs(v[d])));
    }
    for (int d = 0; d < 3; d++) {
        u[d] /= largest;
        v[d] /= largest;
        uu += u[d] * u[d];
        uv += u[d] * v[d];
    }
    const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                         u[0] * v[1] - u[1] * v[0]};
    const double length = sqrt(uu), height = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / length;
    const double flat[3][2] = {{0, 0}, {length, 0}, {uv / length, height}};
    const double *const at[] = {flat[0], flat[1], flat[2]};
    return pl_angles_find(2, at);
}
