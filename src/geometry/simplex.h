/* simplex: measure, radius ratio and angles of one triangle or tetrahedron.
 *
 * The plain reference: scalar, written for reading, one body for both dimensions. Vertices go in,
 * numbers come out; nothing is allocated and nothing is decided. What decides where nodes go is
 * made of + - * / and sqrt only, so that its bits are the same everywhere.
 *
 * Conventions: dim is 2 or 3 and constant where the call is inlined. vertex [dim + 1] are pointers
 * to coordinates [dim]. Row j of edges [dim][dim] is v_{j+1} - v_0. D = det(edges) is 6 times the
 * signed volume, or twice the signed area. Facet j is the one opposite vertex j, and its normal
 * n_j = dD/dv_j points inwards where D > 0; |n_j| is twice a face's area, or an edge's length.
 *
 *   pl_edges, pl_determinant_of_edges                            measure
 *   pl_shape_of, pl_radius_ratio_square                          radius ratio and angles
 *   pl_edge_squares_of, pl_mean_ratio, pl_scaled_jacobian_of ... other measures
 *   pl_simplex_measure, pl_edge_ratio, pl_angle_cosines          for tests
 *   pl_dot, pl_cross, pl_subtract, pl_unit, pl_distance          vectors
 *   pl_scale_exponent                                            of the scale of a mesh or element
 */
#ifndef PL_GEOMETRY_SIMPLEX_H
#define PL_GEOMETRY_SIMPLEX_H

#include "geometry/cube_root.h"
#include "geometry/inline.h"

#include <math.h>

/* ---- Vectors ------------------------------------------------------------------------------ */

/** Scalar product of vectors a and b [dim]. */
PL_INLINE double pl_dot(int dim, const double a[], const double b[]) {
    double sum = a[0] * b[0] + a[1] * b[1];
    return dim == 3 ? sum + a[2] * b[2] : sum;
}

/** Compute difference = a - b of vectors [dim]. */
PL_INLINE void pl_subtract(int dim, const double a[], const double b[], double difference[]) {
    difference[0] = a[0] - b[0];
    difference[1] = a[1] - b[1];
    if (dim == 3)
        difference[2] = a[2] - b[2];
}

/** Compute a x b of vectors in space. */
PL_INLINE void pl_cross(const double a[], const double b[], double product[]) {
    product[0] = a[1] * b[2] - a[2] * b[1];
    product[1] = a[2] * b[0] - a[0] * b[2];
    product[2] = a[0] * b[1] - a[1] * b[0];
}

/** Return exponent, of a size, as near as a scale may have it: 2^exponent and its inverse are
 *  normal doubles. */
PL_INLINE int pl_scale_exponent(int exponent) {
    enum { LIMIT = 1000 };
    return exponent > LIMIT ? LIMIT : exponent < -LIMIT ? -LIMIT : exponent;
}

/* ---- Measure ------------------------------------------------------------------------------ */

/** Compute edges [dim][dim] from the vertices [dim + 1]: row j is v_{j+1} - v_0. */
PL_INLINE void pl_edges(int dim, const double *const vertex[], double edges[3][3]) {
    for (int j = 0; j < dim; j++)
        pl_subtract(dim, vertex[j + 1], vertex[0], edges[j]);
}

/** Compute n_1 .. n_dim, the rows of the cofactor matrix of edges, into normals [1] .. [dim]. */
PL_INLINE void pl_cofactor_normals(int dim, const double edges[3][3], double normals[4][3]) {
    if (dim == 3) {
        pl_cross(edges[1], edges[2], normals[1]);
        pl_cross(edges[2], edges[0], normals[2]);
        pl_cross(edges[0], edges[1], normals[3]);
    } else {
        normals[1][0] = edges[1][1];
        normals[1][1] = -edges[1][0];
        normals[2][0] = -edges[0][1];
        normals[2][1] = edges[0][0];
    }
}

/** Compute n_0 from the facet's own edges: the sum of the others would cancel where it is small. */
PL_INLINE void pl_base_normal(int dim, const double edges[3][3], double normal[3]) {
    double b[3] = {0}, c[3] = {0};
    pl_subtract(dim, edges[1], edges[0], b);
    if (dim == 3) {
        pl_subtract(dim, edges[2], edges[0], c);
        pl_cross(c, b, normal);
    } else {
        normal[0] = -b[1];
        normal[1] = b[0];
    }
}

/** The unit vector along v, without overflow; 0 if v has no direction. */
static inline int pl_unit(int dim, const double v[], double unit[]) {
    double largest = 0, square = 0;
    for (int d = 0; d < dim; d++)
        largest = fmax(largest, fabs(v[d]));
    if (!(largest > 0 && largest < INFINITY))
        return 0;
    for (int d = 0; d < dim; d++) {
        unit[d] = v[d] / largest;
        square += unit[d] * unit[d];
    }
    for (int d = 0; d < dim; d++)
        unit[d] /= sqrt(square);
    return isfinite(square);
}

/** Distance without overflow, and with the same bits everywhere, which hypot does not promise. */
PL_INLINE double pl_distance(int dim, const double *x, const double *y) {
    double largest = 0, square = 0;
    for (int d = 0; d < dim; d++)
        largest = fmax(largest, fabs(y[d] - x[d]));
    for (int d = 0; largest > 0 && d < dim; d++)
        square += (y[d] - x[d]) / largest * ((y[d] - x[d]) / largest);
    return largest * sqrt(square);
}

/** Return D from edges; the rounding error bounds of quality/certificate.c hold for this order. */
PL_INLINE double pl_determinant_of_edges(int dim, const double edges[3][3]) {
    double normal[3];
    if (dim == 2)
        return edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0];
    pl_cross(edges[1], edges[2], normal);
    return pl_dot(3, edges[0], normal);
}

/* ---- Radius ratio ------------------------------------------------------------------------- */

/** Components of the radius ratio and the angles of an element. */
typedef struct pl_shape {
    double determinant;         /* D */
    double circumradius_square; /* N = (2 R D)^2, R the circumradius; 0 only if edges are */
    double facet_sum;       /* S: sum of the facets' areas, or perimeter; r = D / (2 S), D / S */
    double smallest_cosine; /* of the angles between facets: that of the largest angle */
    double largest_cosine;
    double acute_square;  /* least sine of the acute ones of these angles, squared; 1 without any */
    double obtuse_square; /* and of the obtuse ones */
} pl_shape;

/** Square of the common edge of facets i and j of a tetrahedron, which is between the other two
 *  vertices. */
PL_INLINE double pl_common_edge_square(const double edges[3][3], int i, int j) {
    double edge[3];
    const int k = i == 0 ? (j == 1 ? 2 : 1) : j == 0 ? (i == 1 ? 2 : 1) : 0, l = 6 - i - j - k;
    for (int d = 0; d < 3; d++)
        edge[d] = edges[l - 1][d] - (k > 0 ? edges[k - 1][d] : 0);
    return pl_dot(3, edge, edge);
}

/** Take the angle between facets i and j into the extremes, from their unit normals and the lengths
 *  of all normals: sin = |D| l / (|n_i| |n_j|), l the length of their common edge (1 in the plane).
 */
PL_INLINE void pl_take_angle(int dim, const double edges[3][3], const double unit[4][3],
                             const double inverse[4], int i, int j, pl_shape *shape) {
    const double cosine = -pl_dot(dim, unit[i], unit[j]);
    const double common = dim == 3 ? pl_common_edge_square(edges, i, j) : 1;
    const double by_length = shape->determinant * inverse[i] * inverse[j];
    const double square = by_length * by_length * common;
    const double acute = cosine > 0 ? square : 1, obtuse = cosine < 0 ? square : 1;
    shape->smallest_cosine = cosine < shape->smallest_cosine ? cosine : shape->smallest_cosine;
    shape->largest_cosine = cosine > shape->largest_cosine ? cosine : shape->largest_cosine;
    shape->acute_square = acute < shape->acute_square ? acute : shape->acute_square;
    shape->obtuse_square = obtuse < shape->obtuse_square ? obtuse : shape->obtuse_square;
}

/** Extremes of the angles between facets (dihedral in space, at the vertices in the plane) from the
 *  normals and their lengths. */
PL_INLINE void pl_extreme_angles(int dim, const double edges[3][3], const double normals[4][3],
                                 const double lengths[4], pl_shape *shape) {
    double unit[4][3] = {{0}}, inverse[4];
    for (int j = 0; j <= dim; j++) {
        inverse[j] = 1 / lengths[j];
        for (int d = 0; d < dim; d++)
            unit[j][d] = normals[j][d] * inverse[j];
    }
    shape->smallest_cosine = 1;
    shape->largest_cosine = -1;
    shape->acute_square = shape->obtuse_square = 1;
    /* One by one, so that compilers make vectors of a loop around. */
    pl_take_angle(dim, edges, unit, inverse, 0, 1, shape);
    pl_take_angle(dim, edges, unit, inverse, 1, 2, shape);
    pl_take_angle(dim, edges, unit, inverse, 2, 0, shape);
    if (dim == 2)
        return;
    pl_take_angle(dim, edges, unit, inverse, 0, 3, shape);
    pl_take_angle(dim, edges, unit, inverse, 1, 3, shape);
    pl_take_angle(dim, edges, unit, inverse, 2, 3, shape);
}

/** Return (2 R D)^2: the circumcentre is v_0 + sum |e_j|^2 n_{j+1} / (2 D). In the plane it is the
 * square of the product of the edges. */
PL_INLINE double pl_circumradius_square(int dim, const double edges[3][3],
                                        const double normals[4][3], const double squares[4]) {
    if (dim == 2)
        return squares[0] * squares[1] * squares[2];
    double length0 = pl_dot(3, edges[0], edges[0]);
    double length1 = pl_dot(3, edges[1], edges[1]);
    double length2 = pl_dot(3, edges[2], edges[2]);
    double alpha[3];
    for (int d = 0; d < 3; d++)
        alpha[d] = length0 * normals[1][d] + length1 * normals[2][d] + length2 * normals[3][d];
    return pl_dot(3, alpha, alpha);
}

/** Return the shape of an element. determinant: its D, which may be better known than by edges. */
PL_INLINE pl_shape pl_shape_of(int dim, const double edges[3][3], double determinant) {
    double normals[4][3] = {{0}}, squares[4], lengths[4];
    pl_cofactor_normals(dim, edges, normals);
    pl_base_normal(dim, edges, normals[0]);
    double sum = 0;
    for (int j = 0; j <= dim; j++) {
        squares[j] = pl_dot(dim, normals[j], normals[j]);
        lengths[j] = sqrt(squares[j]);
        sum += lengths[j];
    }
    pl_shape shape;
    shape.determinant = determinant;
    shape.circumradius_square = pl_circumradius_square(dim, edges, normals, squares);
    shape.facet_sum = dim == 3 ? sum / 2 : sum;
    pl_extreme_angles(dim, edges, normals, lengths, &shape);
    return shape;
}

/** Return the shape of an element from its edges [dim][dim]. */
PL_INLINE pl_shape pl_shape_of_edges(int dim, const double edges[3][3]) {
    return pl_shape_of(dim, edges, pl_determinant_of_edges(dim, edges));
}

/** RR^2 = N S^2 / (9 D^4) or N S^2 / (16 D^4); in range for sizes from 1e-20 to 1e20. */
PL_INLINE double pl_radius_ratio_square_of_shape(int dim, const pl_shape *shape) {
    double d2 = shape->determinant * shape->determinant;
    double s2 = shape->facet_sum * shape->facet_sum;
    return shape->circumradius_square * s2 / ((dim == 3 ? 9 : 16) * (d2 * d2));
}

/** RR in an order of operations that overflows only where RR does. */
PL_INLINE double pl_radius_ratio_of_shape(int dim, const pl_shape *shape) {
    double d = fabs(shape->determinant);
    return sqrt(shape->circumradius_square) / d * (shape->facet_sum / ((dim == 3 ? 3 : 4) * d));
}

/** RR^2 of an element; D < 0 makes no difference, infinite or NaN where D is 0. */
PL_INLINE double pl_radius_ratio_square(int dim, const double *const vertex[]) {
    double edges[3][3];
    pl_edges(dim, vertex, edges);
    pl_shape shape = pl_shape_of_edges(dim, edges);
    return pl_radius_ratio_square_of_shape(dim, &shape);
}

/* ---- Other measures (docs/measures.md) ---------------------------------------------------- */

/** Squared edge lengths of an element. */
typedef struct pl_edge_squares {
    double shortest, longest, sum;
    double corner; /* the largest product of those that meet in a vertex */
} pl_edge_squares;

/** Take in the edge from vertex i to vertex j; corner [dim + 1]: the products at the vertices. */
PL_INLINE void pl_take_edge(int dim, const double x[4][3], int i, int j, pl_edge_squares *of,
                            double corner[4]) {
    double edge[3];
    pl_subtract(dim, x[j], x[i], edge);
    double square = pl_dot(dim, edge, edge);
    of->shortest = square < of->shortest ? square : of->shortest;
    of->longest = square > of->longest ? square : of->longest;
    of->sum += square;
    corner[i] *= square;
    corner[j] *= square;
}

/** Return the squared edge lengths of vertices x [dim + 1][dim]. Each edge is computed from its
 *  own two vertices: as a difference of other edges a short one would cancel. */
PL_INLINE pl_edge_squares pl_edge_squares_of(int dim, const double x[4][3]) {
    pl_edge_squares of = {INFINITY, 0, 0, 0};
    double corner[4] = {1, 1, 1, 1};
    for (int j = 0; j < 3; j++) {
        pl_take_edge(dim, x, j, (j + 1) % 3, &of, corner);
        if (dim == 3)
            pl_take_edge(dim, x, j, 3, &of, corner);
    }
    for (int i = 0; i <= dim; i++)
        of.corner = corner[i] > of.corner ? corner[i] : of.corner;
    return of;
}

/** Return the squared edge lengths of an element, from pointers to its vertices [dim + 1]. */
static inline pl_edge_squares pl_edge_squares_at(int dim, const double *const vertex[]) {
    double x[4][3] = {{0}};
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            x[j][d] = vertex[j][d];
    return pl_edge_squares_of(dim, x);
}

/* Extremes of the squared edges are means of the power 2^this: the smoothed ratio is at most the
 * ratio, and at least 6^(-1/32) = 0.946 of it (triangles: 3^(-1/32) = 0.966). */
enum { PL_EDGE_SHARPNESS = 5 };

/** Longest edge by shortest with the extremes smoothed: means of the power 2^PL_EDGE_SHARPNESS of
 * the squares, and of their inverses. */
static inline double pl_smoothed_edge_ratio(int dim, const double *const vertex[]) {
    pl_edge_squares squares = pl_edge_squares_at(dim, vertex);
    double large = 0, small = 0, n = dim == 3 ? 6 : 3;
    for (int i = 0; i < dim; i++)
        for (int j = i + 1; j <= dim; j++) {
            double edge[3];
            pl_subtract(dim, vertex[j], vertex[i], edge);
            double square = pl_dot(dim, edge, edge);
            double up = square / squares.longest, down = squares.shortest / square;
            for (int k = 0; k < PL_EDGE_SHARPNESS; k++) {
                up *= up;
                down *= down;
            }
            large += up;
            small += down;
        }
    double means = large / n * (small / n);
    for (int k = 0; k < PL_EDGE_SHARPNESS; k++)
        means = sqrt(means);
    return sqrt(squares.longest / squares.shortest * means);
}

/* What makes the measures 1 for the regular element, of dimension 2 and 3. */
static const double PL_CIRCUMRADIUS_SCALE[] = {0, 0, 1.7320508075688772935 / 2,
                                               0.81649658092772603273}; /* sqrt(3)/2, sqrt(2/3) */
static const double PL_INRADIUS_SCALE[] = {0, 0, 1 / 3.4641016151377545871,
                                           1 / 2.4494897427831780982}; /* 1/sqrt(12), 1/sqrt(6) */
static const double PL_JACOBIAN_SCALE[] = {0, 0, 1.1547005383792515290,
                                           1.4142135623730950488}; /* 2/sqrt(3), sqrt(2) */

/** Circumradius by longest edge, R / h from N = (2 R D)^2; |D| and h > 0. */
PL_INLINE double pl_circumradius_to_edge(int dim, const pl_shape *shape, double longest) {
    double d = fabs(shape->determinant);
    return PL_CIRCUMRADIUS_SCALE[dim] * (sqrt(shape->circumradius_square) / d / longest);
}

/** Longest edge by inradius: h / r, r = D / (2 S) or D / S. */
PL_INLINE double pl_edge_to_inradius(int dim, const pl_shape *shape, double longest) {
    return PL_INRADIUS_SCALE[dim] * (longest * (shape->facet_sum / fabs(shape->determinant)));
}

/** Mean ratio from |D| and the sum of the edges' squares: 12 (3 V)^(2/3) or 4 sqrt(3) A by it. */
PL_INLINE double pl_mean_ratio_of(int dim, double determinant, double sum) {
    if (dim == 2)
        return 3.4641016151377545871 * determinant / sum;
    double root = pl_cube_root(determinant / 2);
    return 12 * (root * root) / sum;
}

/** Mean ratio: 1 for the regular element, 0 for a flat one, negative where D is; NaN if all the
 *  vertices are one. In range for sizes from 1e-100 to 1e100. */
static inline double pl_mean_ratio(int dim, const double *const vertex[]) {
    double edges[3][3];
    pl_edges(dim, vertex, edges);
    double determinant = pl_determinant_of_edges(dim, edges);
    double sum = pl_edge_squares_at(dim, vertex).sum;
    return copysign(pl_mean_ratio_of(dim, fabs(determinant), sum), determinant);
}

/** Scaled Jacobian from D: least of the D / (product of the edges) of the vertices. In range for
 *  sizes from 1e-50 to 1e50. */
PL_INLINE double pl_scaled_jacobian_of(int dim, double determinant, double corner) {
    return PL_JACOBIAN_SCALE[dim] * (determinant / sqrt(corner));
}

/* ---- For tests ----------------------------------------------------------------------------- */

/** Signed measure: area, positive counter-clockwise, or volume, positive where v1 v2 v3 turn
 *  right-handed seen from v0. */
PL_INLINE double pl_simplex_measure(int dim, const double *const vertex[]) {
    double edges[3][3];
    pl_edges(dim, vertex, edges);
    return pl_determinant_of_edges(dim, edges) / (dim == 3 ? 6 : 2);
}

/** Longest edge by shortest; infinite if two vertices are one. */
static inline double pl_edge_ratio(int dim, const double *const vertex[]) {
    pl_edge_squares squares = pl_edge_squares_at(dim, vertex);
    return sqrt(squares.longest / squares.shortest);
}

/** Smallest and largest cosine of the dihedral angles of a tetrahedron, or of the angles of a
 *  triangle: those of the largest and the smallest angle. */
static inline void pl_angle_cosines(int dim, const double *const vertex[], double *smallest,
                                    double *largest) {
    double edges[3][3];
    pl_edges(dim, vertex, edges);
    pl_shape shape = pl_shape_of_edges(dim, edges);
    *smallest = shape.smallest_cosine;
    *largest = shape.largest_cosine;
}

#endif
