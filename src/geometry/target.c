/* target: V from the edges of the corner that is wanted. */
#include "geometry/target.h"

#include <float.h>

static double extent_of(int dim, const double edges[3][3]) {
    double extent = 0;
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            extent = fmax(extent, fabs(edges[j][d]));
    return extent;
}

/** Copy edges, brought to a size of about 1 if they are far from that: returns the exponent of the power
 *  of two by which they were larger. */
static int scale_edges(int dim, const double edges[3][3], double scaled[3][3]) {
    const double extent = extent_of(dim, edges);
    int exponent = 0;
    if (!(extent > 0x1p-60 && extent < 0x1p60)) {
        frexp(extent, &exponent);
        exponent = pl_scale_exponent(exponent);
    }
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            scaled[j][d] = exponent == 0 ? edges[j][d] : ldexp(edges[j][d], -exponent);
    return exponent;
}

/** Fill inverse with R^-1, R the upper triangle of W = Q R, from the edges and determinant D > 0 of a
 *  corner of the plane. */
static void invert_2d(const double e[3][3], double D, double inverse[6]) {
    const double length = sqrt(pl_dot(2, e[0], e[0]));
    inverse[0] = 1 / length;
    inverse[1] = -pl_dot(2, e[0], e[1]) / (length * D);
    inverse[2] = length / D;
}

/** Invert R in space. R_22 and R_23 are made of the normals of the faces at the first edge, which are
 *  accurate where the edges are nearly parallel. */
static void invert_3d(const double e[3][3], double D, double inverse[6]) {
    double low[3], high[3];
    pl_cross(e[0], e[1], low);
    pl_cross(e[0], e[2], high);
    const double r11 = sqrt(pl_dot(3, e[0], e[0])), area = sqrt(pl_dot(3, low, low));
    const double r12 = pl_dot(3, e[0], e[1]) / r11, r13 = pl_dot(3, e[0], e[2]) / r11;
    const double r22 = area / r11, r23 = pl_dot(3, low, high) / (r11 * area), r33 = D / area;
    inverse[0] = 1 / r11;
    inverse[1] = -r12 / (r11 * r22);
    inverse[2] = (r12 * r23 - r13 * r22) / (r11 * r22 * r33);
    inverse[3] = 1 / r22;
    inverse[4] = -r23 / (r22 * r33);
    inverse[5] = 1 / r33;
}

int pl_target_make(int dim, const double edges[3][3], double sign, pl_target *target) {
    double e[3][3] = {{0}};
    const int exponent = scale_edges(dim, edges, e);
    const double D = sign * pl_determinant_of_edges(dim, (const double(*)[3])e);
    *target = (pl_target){.unit = 1 / D, .measure = D};
    if (exponent != 0) {
        target->unit = ldexp(1 / D, -dim * exponent);
        target->measure = ldexp(D, dim * exponent);
    }
    if (!(D > DBL_MIN && target->unit >= DBL_MIN && target->measure >= DBL_MIN &&
          target->unit <= DBL_MAX && target->measure <= DBL_MAX))
        return 0;
    if (dim == 3)
        invert_3d((const double(*)[3])e, D, target->v);
    else
        invert_2d((const double(*)[3])e, D, target->v);
    const double root = dim == 3 ? pl_cube_root(D) : sqrt(D);
    double sum = 0;
    for (int k = 0; k < dim * (dim + 1) / 2; k++) {
        target->v[k] *= root;
        sum += target->v[k];
    }
    return isfinite(sum);
}

const char *pl_target_flaw(int dim, const double edges[3][3], double determinant) {
    const double extent = extent_of(dim, edges);
    return !isfinite(determinant) || extent > pow(DBL_MAX, 1. / dim)
               ? "is too large, or not finite,"
           : extent > 0 && extent < pow(DBL_MIN, 1. / dim) ? "is too small"
           : determinant < 0                               ? "is inverted"
                                                           : "is flat";
}

void pl_target_weights(int dim, const pl_target *target, double weight[6]) {
    double slope[4][4] = {{0}};
    int k = 0;
    pl_target_slopes(dim, target->v, slope);
    for (int i = 0; i <= dim; i++)
        for (int j = i + 1; j <= dim; j++)
            weight[k++] = -pl_dot(dim, slope[i], slope[j]);
}
