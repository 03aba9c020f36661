/* angle: the extreme angles of an element, dihedral in space; and the smallest one compared without
 * its arc cosine.
 *
 * The cosine of an angle near 0 or 180 degrees tells little of it: 1e-16 in it is 1e-8 radians. So
 * there the sine decides.
 *
 * Of an acute angle theta the acuteness is 1 / sin^2 theta: the smaller the angle, the larger it
 * is. Facets i and j enclose theta with sin theta = l D / (|n_i| |n_j|), n their normals and l the
 * length of their common edge (1 in the plane). The smallest angle of an element is acute.
 *
 *   pl_smallest_angle, pl_largest_angle      angles of a shape
 *   pl_acuteness, pl_blunt_ratio_square      comparison by acuteness
 */
#ifndef PL_GEOMETRY_ANGLE_H
#define PL_GEOMETRY_ANGLE_H

#include "geometry/arc_cosine.h"
#include "geometry/simplex.h"

/** Cosine of 30 degrees: from there on the sine tells more of an angle. */
#define PL_STEEP_COSINE 0.86602540378443864676

/** The angle in radians of a cosine that is an extreme of the shape's. */
PL_INLINE double pl_angle_of(const pl_shape *shape, double cosine) {
    static const double PI = 3.1415926535897932385;
    double c = fabs(cosine), square = cosine < 0 ? shape->obtuse_square : shape->acute_square;
    c = c < 1 ? c : 1;
    square = square < 0.25 ? square : 0.25;                   /* rounding may have put it above */
    const int by_sine = c > PL_STEEP_COSINE, steep = c > 0.5; /* acos(c) = 2 asin(..) */
    const double root = sqrt(by_sine ? square : (1 - c) / 2);
    const double arc = pl_arc_sine_of_half(steep ? root : c);
    const double angle = by_sine ? arc : steep ? 2 * arc : PI / 2 - arc;
    return cosine < 0 ? PI - angle : angle;
}

/** The smallest angle in radians. The error is a few 2^-53 of it and that of D. */
PL_INLINE double pl_smallest_angle(const pl_shape *shape) {
    return pl_angle_of(shape, shape->largest_cosine);
}

/** The largest angle in radians; its difference from 180 degrees is as precise. */
PL_INLINE double pl_largest_angle(const pl_shape *shape) {
    return pl_angle_of(shape, shape->smallest_cosine);
}

/** Acuteness of the smallest angle of an element of a size of about 1. determinant: its D, which
 *  may be better known than by edges. */
static inline double pl_acuteness(int dim, const double edges[3][3], double determinant) {
    double normals[4][3] = {{0}}, position[4][3] = {{0}}, largest = 0;
    pl_cofactor_normals(dim, edges, normals);
    pl_base_normal(dim, edges, normals[0]);
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            position[j + 1][d] = edges[j][d];
    for (int i = 0; i < dim; i++)
        for (int j = i + 1; j <= dim; j++) {
            if (pl_dot(dim, normals[i], normals[j]) >= 0)
                continue;
            double common = 1;
            if (dim == 3) {
                double edge[3];
                const int k = i == 0 ? (j == 1 ? 2 : 1) : 0, l = 6 - i - j - k;
                pl_subtract(3, position[l], position[k], edge);
                common = pl_dot(3, edge, edge);
            }
            largest = fmax(largest, pl_dot(dim, normals[i], normals[i]) *
                                        pl_dot(dim, normals[j], normals[j]) /
                                        (determinant * determinant * common));
        }
    return largest;
}

/** The square of a radius ratio up to which no element has an angle of a larger acuteness.
 *
 * The incentre of a tetrahedron is r / sin(theta / 2) from the edge at which the angle is theta,
 * and the circumcentre at most sqrt((R + r) (R - 3r)) from the incentre (Grace 1918, Danielsson
 * 1949); points of the edge are at most R from the circumcentre. Hence, with k = 1 / sin(theta / 2)
 * and q = R / r, k <= q + sqrt((q + 1) (q - 3)), which is q >= (k^2 + 3) / (2 (k - 1)) for k >= 3.
 * Of the triangles with an angle theta the best one is isosceles: R / r = k^2 / (2 (k - 1)). */
static inline double pl_blunt_ratio_square(int dim, double acuteness) {
    const double cosine = sqrt(fmax(0, 1 - 1 / acuteness));
    const double k = sqrt(2 * acuteness * (1 + cosine)), plane = k * k / (4 * (k - 1));
    const double margin = 1 - 1e-9 - 0x1p-46 * k; /* rounding of D, relative, is about k 2^-53 */
    if (!(acuteness < INFINITY))
        return INFINITY;
    if (!(acuteness > 1 && margin > 0))
        return 0;
    const double ratio = dim == 2 ? plane : k > 3 ? (k * k + 3) / (6 * (k - 1)) : 1;
    return margin * ratio * ratio;
}

#endif
