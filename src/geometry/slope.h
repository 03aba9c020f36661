/* slope: measures of one element, and their derivatives by the coordinates of its vertices.
 *
 * Plain formulas, one element at a time. Every measure is larger the better the element is: angles in
 * radians, dihedral in 3-D; 1 / RR; of corners (geometry/corner.h) 1 / mu and the scaled Jacobian.
 * Vertices [dim + 1][dim] are in an order with a positive determinant D; the vertices of a corner are
 * those of a link facet, then the node x of the star, as forms have them.
 *
 *   pl_angle_between                    an angle from its sine and cosine
 *   pl_angle_slopes                     all angles
 *   pl_ratio_slope                      1 / RR
 *   pl_mean_slope, pl_jacobian_slopes   of a corner
 */
#ifndef PL_GEOMETRY_SLOPE_H
#define PL_GEOMETRY_SLOPE_H

#include "geometry/angle.h"
#include "geometry/corner.h"

enum { PL_MOST_SLOPES = 6 };

/** A measure of an element, and its derivatives by the coordinates of its vertices [dim + 1][dim]. */
typedef struct pl_slope {
    double value;
    double by[4][3];
} pl_slope;

/** Return the angle in radians of a sine (at least 0) and a cosine, both times one positive number. */
PL_INLINE double pl_angle_between(double sine, double cosine) {
    static const double PI = 3.1415926535897932385;
    const double length = sqrt(sine * sine + cosine * cosine), c = fabs(cosine) / length;
    const double s = sine / length;
    const int by_sine = s<0.5, steep = c> 0.5;
    const double half = by_sine ? s : steep ? sqrt((1 - c) / 2) : c;
    const double arc = pl_arc_sine_of_half(half < 0.5 ? half : 0.5);
    const double angle = by_sine ? arc : steep ? 2 * arc : PI / 2 - arc;
    return cosine < 0 ? PI - angle : angle;
}

/** Normals of a tetrahedron's facets, the derivatives of D by its vertices. */
typedef struct pl_normals {
    double of[4][3], square[4]; /* of the facet opposite to a vertex, and its square length */
    double D;
} pl_normals;

/** Compute the normals of the tetrahedron x. */
PL_INLINE void pl_normals_of(const double x[4][3], pl_normals *normals) {
    double edge[3][3];
    for (int j = 0; j < 3; j++)
        pl_subtract(3, x[j + 1], x[0], edge[j]);
    pl_cofactor_normals(3, (const double(*)[3])edge, normals->of);
    pl_base_normal(3, (const double(*)[3])edge, normals->of[0]);
    for (int v = 0; v < 4; v++)
        normals->square[v] = pl_dot(3, normals->of[v], normals->of[v]);
    normals->D = pl_dot(3, edge[0], normals->of[1]);
}

/** Compute the dihedral angle at the edge from vertex a to b, between the faces with c and d; D is
 *  positive in the order a, b, c, d. derive: and its derivatives. */
PL_INLINE void pl_dihedral_slope(const double x[4][3], const pl_normals *normals, int a, int b,
                                 int c, int d, int derive, pl_slope *slope) {
    double e[3], u[3], v[3];
    pl_subtract(3, x[b], x[a], e);
    const double ee = pl_dot(3, e, e), length = sqrt(ee);
    slope->value =
        pl_angle_between(length * normals->D, -pl_dot(3, normals->of[c], normals->of[d]));
    if (!derive)
        return;
    pl_subtract(3, x[c], x[a], u);
    pl_subtract(3, x[d], x[a], v);
    const double by_c = -length / normals->square[d], by_d = -length / normals->square[c];
    const double along_c = pl_dot(3, u, e) / ee, along_d = pl_dot(3, v, e) / ee;
    for (int k = 0; k < 3; k++) {
        slope->by[c][k] = by_c * normals->of[d][k];
        slope->by[d][k] = by_d * normals->of[c][k];
        slope->by[b][k] = -(along_c * slope->by[c][k] + along_d * slope->by[d][k]);
        slope->by[a][k] = -(slope->by[b][k] + slope->by[c][k] + slope->by[d][k]);
    }
}

/** Compute the 6 or 3 angles of an element into slope; return how many. derive: and their
 *  derivatives. */
PL_INLINE int pl_angle_slopes(int dim, const double x[4][3], int derive, pl_slope slope[]) {
    if (dim == 3) {
        pl_normals normals;
        pl_normals_of(x, &normals);
        pl_dihedral_slope(x, &normals, 0, 1, 2, 3, derive, &slope[0]);
        pl_dihedral_slope(x, &normals, 0, 2, 3, 1, derive, &slope[1]);
        pl_dihedral_slope(x, &normals, 0, 3, 1, 2, derive, &slope[2]);
        pl_dihedral_slope(x, &normals, 1, 2, 0, 3, derive, &slope[3]);
        pl_dihedral_slope(x, &normals, 1, 3, 2, 0, derive, &slope[4]);
        pl_dihedral_slope(x, &normals, 2, 3, 0, 1, derive, &slope[5]);
        return 6;
    }
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        double u[3], v[3];
        pl_subtract(2, x[b], x[a], u);
        pl_subtract(2, x[c], x[a], v);
        slope[a].value = pl_angle_between(u[0] * v[1] - u[1] * v[0], pl_dot(2, u, v));
        const double uu = pl_dot(2, u, u), vv = pl_dot(2, v, v);
        for (int k = 0; derive && k < 2; k++) {
            slope[a].by[b][k] = (k ? -u[0] : u[1]) / uu;
            slope[a].by[c][k] = (k ? v[0] : -v[1]) / vv;
            slope[a].by[a][k] = -(slope[a].by[b][k] + slope[a].by[c][k]);
        }
    }
    return 3;
}

/** Set the derivatives of slope by the edges from vertex 0, gradient [dim][dim]. */
PL_INLINE void pl_slope_of_edges(int dim, const double gradient[3][3], pl_slope *slope) {
    for (int k = 0; k < dim; k++) {
        slope->by[0][k] = 0;
        for (int j = 0; j < dim; j++) {
            slope->by[j + 1][k] = gradient[j][k];
            slope->by[0][k] -= gradient[j][k];
        }
    }
}

/** Compute 1 / RR of a tetrahedron: 6 D^2 / (|w| S), w = a^2 (b x c) + b^2 (c x a) + c^2 (a x b), S the sum of
 *  the lengths of the faces' normals. */
PL_INLINE void pl_ratio_slope_3d(const double x[4][3], int derive, pl_slope *slope) {
    double edge[3][3], normal[4][3], w[3], g[3][3], length[4], square[3], S = 0;
    for (int j = 0; j < 3; j++)
        pl_subtract(3, x[j + 1], x[0], edge[j]);
    pl_cofactor_normals(3, (const double(*)[3])edge, normal);
    pl_base_normal(3, (const double(*)[3])edge, normal[0]);
    const double D = pl_dot(3, edge[0], normal[1]);
    for (int i = 0; i < 4; i++) {
        length[i] = sqrt(pl_dot(3, normal[i], normal[i]));
        S += length[i];
    }
    for (int j = 0; j < 3; j++)
        square[j] = pl_dot(3, edge[j], edge[j]);
    for (int k = 0; k < 3; k++)
        w[k] = square[0] * normal[1][k] + square[1] * normal[2][k] + square[2] * normal[3][k];
    const double ww = pl_dot(3, w, w);
    slope->value = D > 0 ? 6 * D * D / (sqrt(ww) * S) : 0;
    if (!derive)
        return;
    /* By an edge a, b and c being the next ones: of D b x c, of |w|^2 / 2 the terms below, and of the
     * normals a x b, c x a and the base (b - a) x (c - a). */
    for (int j = 0; j < 3; j++) {
        const int jb = (j + 1) % 3, jc = (j + 2) % 3;
        double wc[3], bw[3], far[3], of_base[3], of_ab[3], of_ca[3];
        pl_cross(w, edge[jc], wc);
        pl_cross(edge[jb], w, bw);
        pl_cross(edge[jb], normal[jc + 1], of_ab);
        pl_cross(normal[jb + 1], edge[jc], of_ca);
        pl_subtract(3, edge[jc], edge[jb], far);
        pl_cross(far, normal[0], of_base);
        const double along = 2 * pl_dot(3, w, normal[j + 1]);
        for (int k = 0; k < 3; k++) {
            const double of_w = along * edge[j][k] + square[jb] * wc[k] + square[jc] * bw[k];
            const double of_s =
                of_ab[k] / length[jc + 1] + of_ca[k] / length[jb + 1] + of_base[k] / length[0];
            g[j][k] = slope->value * (2 * normal[j + 1][k] / D - of_w / ww - of_s / S);
        }
    }
    pl_slope_of_edges(3, (const double(*)[3])g, slope);
}

/** Compute 1 / RR of a triangle: 4 D^2 / (a b c (a + b + c)). */
PL_INLINE void pl_ratio_slope_2d(const double x[4][3], int derive, pl_slope *slope) {
    double e[3][2], length[3];
    for (int j = 0; j < 3; j++) {
        pl_subtract(2, x[(j + 1) % 3], x[j], e[j]);
        length[j] = sqrt(pl_dot(2, e[j], e[j]));
    }
    const double D = e[0][0] * e[1][1] - e[0][1] * e[1][0], L = length[0] + length[1] + length[2];
    slope->value = D > 0 ? 4 * D * D / (length[0] * length[1] * length[2] * L) : 0;
    for (int j = 0; derive && j < 3; j++) {
        const int last = (j + 2) % 3, next = (j + 1) % 3; /* edge next is opposite to vertex j */
        for (int k = 0; k < 2; k++) {
            const double of_d = k ? e[next][0] : -e[next][1];
            const double of_lengths = e[last][k] / length[last] * (1 / length[last] + 1 / L) -
                                      e[j][k] / length[j] * (1 / length[j] + 1 / L);
            slope->by[j][k] = slope->value * (2 * of_d / D - of_lengths);
        }
    }
}

/** Compute 1 / RR of an element, 0 where D is not positive. derive: and its derivatives. */
PL_INLINE void pl_ratio_slope(int dim, const double x[4][3], int derive, pl_slope *slope) {
    if (dim == 3)
        pl_ratio_slope_3d(x, derive, slope);
    else
        pl_ratio_slope_2d(x, derive, slope);
}

/* ---- corners ------------------------------------------------------------------------------- */

/** Compute D and its derivatives by the vertices, the normals of the facets. */
PL_INLINE double pl_determinant_slopes(int dim, const double x[4][3], double normal[4][3]) {
    double edge[3][3];
    for (int j = 0; j < dim; j++)
        pl_subtract(dim, x[j + 1], x[0], edge[j]);
    pl_cofactor_normals(dim, (const double(*)[3])edge, normal);
    pl_base_normal(dim, (const double(*)[3])edge, normal[0]);
    return pl_determinant_of_edges(dim, (const double(*)[3])edge);
}

/** Compute 1 / mu = D^(k / 2) / (sqrt(factor) E) of a corner, k / 2 = 2 / 3 or 1; 0 where D is not
 *  positive. derive: and its derivatives. */
PL_INLINE void pl_mean_slope(int dim, const double x[4][3], const pl_corner_form *form, int derive,
                             pl_slope *slope) {
    double normal[4][3], by_e[4][3] = {{0}}, E = 0;
    const double D = pl_determinant_slopes(dim, x, normal), power = dim == 3 ? 2.0 / 3 : 1;
    for (int i = 0, pair = dim; i < dim; i++)
        for (int j = i + 1; j <= dim; j++) {
            const double weight = form->weight[j == dim ? i : pair++];
            for (int k = 0; k < dim; k++) {
                const double along = x[j][k] - x[i][k];
                E += weight * along * along;
                by_e[j][k] += 2 * weight * along;
                by_e[i][k] -= 2 * weight * along;
            }
        }
    const double top = !(D > 0) ? 0 : dim == 3 ? pl_cube_root(D * D) : D;
    slope->value = top / (sqrt(form->factor) * E);
    for (int v = 0; derive && v <= dim; v++)
        for (int k = 0; k < dim; k++)
            slope->by[v][k] = slope->value * (power * normal[v][k] / D - by_e[v][k] / E);
}

/** Compute the scaled Jacobian of the corner at vertex v: D by the lengths of its edges and the ideal
 *  determinant. derive: and its derivatives. */
PL_INLINE void pl_jacobian_slope(int dim, const double x[4][3], int v, double ideal, int derive,
                                 pl_slope *slope) {
    double normal[4][3], along[4][3], square[4], product = ideal;
    const double D = pl_determinant_slopes(dim, x, normal);
    for (int j = 0; j <= dim; j++) {
        if (j == v)
            continue;
        pl_subtract(dim, x[j], x[v], along[j]);
        square[j] = pl_dot(dim, along[j], along[j]);
        product *= sqrt(square[j]);
    }
    slope->value = D > 0 ? D / product : 0;
    for (int k = 0; derive && k < dim; k++) {
        slope->by[v][k] = slope->value * normal[v][k] / D;
        for (int j = 0; j <= dim; j++) {
            if (j == v)
                continue;
            const double of_length = slope->value * along[j][k] / square[j];
            slope->by[j][k] = slope->value * normal[j][k] / D - of_length;
            slope->by[v][k] += of_length;
        }
    }
}

/** Compute the scaled Jacobians of a corner, one, or of a simplex, those of all its vertices; return
 *  how many. is_simplex: the form is that of a simplex. */
PL_INLINE int pl_jacobian_slopes(int dim, const double x[4][3], const pl_corner_form *form,
                                 int is_simplex, int derive, pl_slope slope[]) {
    int n = 0;
    for (int v = 0; v <= dim; v++)
        if (is_simplex || v == (form->corner < 0 ? dim : form->corner))
            pl_jacobian_slope(dim, x, v, form->determinant, derive, &slope[n++]);
    return n;
}

#endif
