/* corner: the forms of link facets, from the ideal corners of the shapes. */
#include "geometry/corner.h"

#include "geometry/cube_root.h"
#include "planish/planish.h"

#include <math.h>
#include <string.h>

/** A type of each kind, in 2-D and 3-D; 0: there is none. */
static const uint8_t TYPE[2][4] = {
    {PLANISH_CELL_TRIANGLE, PLANISH_CELL_QUADRILATERAL, 0, 0},
    {PLANISH_CELL_TETRAHEDRON, PLANISH_CELL_HEXAHEDRON, PLANISH_CELL_WEDGE, PLANISH_CELL_PYRAMID}};

int pl_kind_of_shape(const pl_cell_shape *shape) {
    int kind = 0;
    while (kind < 3 && pl_cell_type_of(TYPE[shape->dim - 2][kind])->shape != shape)
        kind++;
    return kind;
}

const pl_cell_shape *pl_shape_of_kind(int dim, int kind) {
    const pl_cell_type *type = pl_cell_type_of(TYPE[dim - 2][kind]);
    return type ? type->shape : NULL;
}

/** Weights of the edges between the nodes of a corner, the corner being node 0. */
static void find_weights(const pl_cell_shape *shape, double weight[4][4]) {
    memset(weight, 0, 16 * sizeof weight[0][0]);
    for (int i = 0; i < shape->dim; i++)
        weight[0][i + 1] = weight[i + 1][0] = shape->to_corner[i];
    for (int i = 0, pair = 0; i < shape->dim; i++)
        for (int j = i + 1; j < shape->dim; j++, pair++)
            weight[i + 1][j + 1] = weight[j + 1][i + 1] = shape->between[pair];
}

/** Volume of an element whose corners all have the determinant 1. */
static double volume_of(const pl_cell_shape *shape) {
    static const double VOLUME[2][4] = {{1.0 / 2, 1, 0, 0}, {1.0 / 6, 1, 1.0 / 2, 1.0 / 3}};
    return VOLUME[shape->dim - 2][pl_kind_of_shape(shape)];
}

/** Fill the row that kernels load. e0 = sum over the edges of the facet of (w_i w_j / c + w_ij)
 * |edge|^2, which loses nothing to cancellation. */
static void make_row(pl_corner_form *form, int dim) {
    const double root = sqrt(form->factor);
    double c = 0;
    for (int j = 0; j < dim; j++)
        c += form->weight[j];
    for (int j = 1; j < dim; j++)
        form->row[j - 1] = form->weight[j] / c;
    form->row[2] = root * c;
    form->row[3] = form->share;
    for (int i = 0, pair = dim; i < dim; i++)
        for (int j = i + 1; j < dim; j++, pair++)
            form->row[4 + pair - dim] =
                root * (form->weight[i] * form->weight[j] / c + form->weight[pair]);
}

/** Whether an element has the edge between nodes i and j of a corner, the corner being node 0. The
 *  edge of a pyramid to its apex has no weight, the diagonal of its base has one. */
static int has_edge(const pl_cell_shape *shape, double weight[4][4], int i, int j) {
    const int is_pyramid = shape->n_simplices == 0;
    return weight[i][j] > 0 || (is_pyramid && weight[i][j] == 0);
}

static void make_form(const pl_cell_shape *shape, int place, int turned, pl_corner_form *form) {
    const int dim = shape->dim;
    double weight[4][4];
    int node[3] = {0, 0, 0}, k = 0;
    find_weights(shape, weight);
    for (int j = 0; j <= dim; j++)
        if (j != place)
            node[k++] = j;
    if (turned) {
        const int first = dim - 2, kept = node[first];
        node[first] = node[first + 1];
        node[first + 1] = kept;
    }
    form->corner = -1;
    for (int i = 0, pair = dim; i < dim; i++) {
        form->weight[i] = weight[place][node[i]];
        form->is_edge[i] = (uint8_t)has_edge(shape, weight, place, node[i]);
        form->corner = node[i] == 0 ? i : form->corner;
        for (int j = i + 1; j < dim; j++, pair++) {
            form->weight[pair] = weight[node[i]][node[j]];
            form->is_edge[pair] = (uint8_t)has_edge(shape, weight, node[i], node[j]);
        }
    }
    const double w = shape->determinant;
    form->factor = dim == 3 ? w * pl_cube_root(w) / 9 : w * w / 4;
    form->share = shape->n_simplices == 1 ? 1 : 1.0 / shape->n_measured;
    form->determinant = w;
    form->volume = volume_of(shape);
    make_row(form, dim);
}

void pl_corner_forms_make(int dim, pl_corner_form form[PL_N_FORMS]) {
    memset(form, 0, PL_N_FORMS * sizeof *form);
    for (int kind = 0; kind < 4 && TYPE[dim - 2][kind] != 0; kind++)
        for (int place = 0; place <= dim; place++)
            for (int turned = 0; turned < 2; turned++)
                make_form(pl_cell_type_of(TYPE[dim - 2][kind])->shape, place, turned,
                          &form[pl_form_code(pl_corner_code(kind, 0), place, turned)]);
}

/* ---- mean ratios of sharp corners --------------------------------------------------------------
 *
 * With T = J W^-1, W the ideal corner and det T = 1, edge i of a corner is T w_i, and with S = T^T T
 * mu = trace S / dim and 1 / SJ^2 = f = prod w_i^T S w_i. What is wanted is the least mu with
 * f >= A. Let det S >= 1 be enough; then that is a convex problem, as log f and log det are concave,
 * and its solution has the symmetries of the ideal corner. So S is diag(a, b, b) along the axis of a
 * tetrahedron; diag(p, q, r) for a wedge, p along the middle of its triangle's edges; of a pyramid
 * the plane of its axis and of the middle of its base's edges decouples from the third direction. */

/** Least mu of a corner of a triangle with f >= A, y its root: of 3 p + q = 4 y and p q = 1. */
static double least_of_triangle(double y) {
    return (4 * y - sqrt(4 * y * y - 3)) / 3;
}

/** Least mu of a tetrahedron, c the cube root of A: (2 a + b) / 3 = c and a b^2 = 1, so that
 *  b^3 - 3 c b^2 + 2 = 0 with b <= 1; mu = (c + b) / 2. */
static double least_of_tetrahedron(double c) {
    enum { STEPS = 60 };
    double low = 0, high = 1;
    for (int i = 0; i < STEPS; i++) {
        const double b = (low + high) / 2;
        if (b * b * (b - 3 * c) + 2 > 0)
            low = b;
        else
            high = b;
    }
    return (c + low) / 2;
}

/** Trace of S, three mu, of a pyramid where the base's edges have 2 k = S_uu + S_vv, and a = S_uu, v
 *  the third direction: f = A says S_uz, and det S = 1 leaves a quadratic equation for S_zz. */
static double trace_of_pyramid(double acuteness, double k, double a) {
    const double m = acuteness / (k * k), square = 2 * m * a - 1 / (2 * k - a);
    return 2 * k + 2 * m + a - 2 * sqrt(square > 0 ? square : 0);
}

enum { GOLDEN_STEPS = 45 };
static const double GOLDEN = 0.61803398874989485;

/** Least trace of a pyramid with that k. */
static double least_trace(double acuteness, double k) {
    const double half = k * sqrt(1 - 1 / (2 * acuteness)); /* where det S = 1 can be had */
    double low = k - half, high = k + half;
    for (int i = 0; i < GOLDEN_STEPS; i++) {
        const double one = high - GOLDEN * (high - low), two = low + GOLDEN * (high - low);
        if (trace_of_pyramid(acuteness, k, one) < trace_of_pyramid(acuteness, k, two))
            high = two;
        else
            low = one;
    }
    return trace_of_pyramid(acuteness, k, (low + high) / 2);
}

/** Least mu of a corner of a pyramid, c the cube root of A. */
static double least_of_pyramid(double acuteness, double c) {
    double low = c / 4, high = 4 * c;
    for (int i = 0; i < GOLDEN_STEPS; i++) {
        const double one = high - GOLDEN * (high - low), two = low + GOLDEN * (high - low);
        if (least_trace(acuteness, one) < least_trace(acuteness, two))
            high = two;
        else
            low = one;
    }
    return least_trace(acuteness, (low + high) / 2) / 3;
}

double pl_blunt_mean_square(int dim, unsigned kinds, double acuteness) {
    if (!(acuteness < INFINITY))
        return INFINITY;
    if (!(acuteness > 1))
        return 0;
    const double root = sqrt(acuteness), cube_root = pl_cube_root(acuteness);
    const double margin = 1 - 1e-6 - 0x1p-48 * root; /* of the searches, and of D's rounding */
    double least = dim == 3 ? cube_root : root;      /* of hexahedra, quadrilaterals */
    if (dim == 2 && kinds & 1U << PL_KIND_SIMPLEX)
        least = fmin(least, least_of_triangle(root));
    if (dim == 3 && kinds & 1U << PL_KIND_SIMPLEX)
        least = fmin(least, least_of_tetrahedron(cube_root));
    if (dim == 3 && kinds & 1U << PL_KIND_WEDGE) {
        const double plane = pl_cube_root(least_of_triangle(root));
        least = fmin(least, plane * plane);
    }
    if (dim == 3 && kinds & 1U << PL_KIND_PYRAMID)
        least = fmin(least, least_of_pyramid(acuteness, cube_root));
    return margin > 0 ? margin * (least * least) : 0;
}

/** Cosine of the angle between edges i < j of an ideal corner, all of which are 1 long. */
static double ideal_cosine(const pl_cell_shape *shape, int i, int j) {
    return shape->between[i + j - 1] > 0 ? 0.5 : 0;
}

void pl_ideal_edges(const pl_cell_shape *shape, double edges[3][3]) {
    const double cosine = ideal_cosine(shape, 0, 1), sine = sqrt(1 - cosine * cosine);
    edges[0][0] = 1;
    edges[1][0] = cosine;
    edges[1][1] = sine;
    if (shape->dim == 2)
        return;
    edges[2][0] = ideal_cosine(shape, 0, 2);
    edges[2][1] = (ideal_cosine(shape, 1, 2) - cosine * edges[2][0]) / sine;
    edges[2][2] = sqrt(1 - edges[2][0] * edges[2][0] - edges[2][1] * edges[2][1]);
}
