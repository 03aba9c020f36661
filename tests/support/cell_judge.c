/* cell_judge: det J in fractions, by its values at points of a cube; ratios by textbook formulas. */
#include "support/cell_judge.h"

#ifdef PLANISH_HAVE_GMP

#include "geometry/cell.h"
#include "support/shape_functions.h"

#include <gmp.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 6, DEPTH = 12 };

/* det J has at most degree 2 in each direction for elements of order 1, and 5 for order 2. */
static const double of_three[] = {0, 0.5, 1}, of_six[] = {0, 0.125, 0.375, 0.625, 0.875, 1};

/** det J of an element on a cube: values at points, then coefficients. */
typedef struct polynomial {
    int dim, n[3], n_all; /* coefficients along each direction, 1 beyond dim; and of all */
    mpq_t of[POINTS * POINTS * POINTS];
} polynomial;

static void polynomial_size(polynomial *p, const pl_cell_type *type) {
    p->dim = type->type == PLANISH_CELL_PYRAMID ? 2 : type->shape->dim;
    p->n_all = 1;
    for (int d = 0; d < 3; d++) {
        p->n[d] = d >= p->dim ? 1 : type->order == 1 ? 3 : POINTS;
        p->n_all *= p->n[d];
    }
}

static void polynomial_clear(polynomial *p) {
    for (int i = 0; i < p->n_all; i++)
        mpq_clear(p->of[i]);
}

/* ---- det J at a point ------------------------------------------------------------------------- */

/** The point of the reference element that belongs to one of the cube. */
static void point_of(const pl_cell_shape *shape, const double u[3], double t[3]) {
    const int corners = shape->n_corners, dim = shape->dim;
    memcpy(t, u, 3 * sizeof *t);
    if ((dim == 2 && corners == 3) || (dim == 3 && (corners == 4 || corners == 6)))
        t[1] = u[1] * (1 - u[0]);
    if (dim == 3 && corners == 4)
        t[2] = u[2] * (1 - u[0]) * (1 - u[1]);
}

/** sum += factor (a - b). */
static void add_difference(mpq_t sum, double factor, double a, double b) {
    mpq_t difference, term;
    mpq_inits(difference, term, NULL);
    mpq_set_d(difference, a);
    mpq_set_d(term, b);
    mpq_sub(difference, difference, term);
    mpq_set_d(term, factor);
    mpq_mul(difference, difference, term);
    mpq_add(sum, sum, difference);
    mpq_clears(difference, term, NULL);
}

/** result += sign a b c. */
static void add_product(mpq_t result, int sign, const mpq_t a, const mpq_t b, const mpq_t c) {
    mpq_t product;
    mpq_init(product);
    mpq_mul(product, a, b);
    mpq_mul(product, product, c);
    if (sign > 0)
        mpq_add(result, result, product);
    else
        mpq_sub(result, result, product);
    mpq_clear(product);
}

static void determinant(mpq_t result, mpq_t j[3][3]) {
    for (int k = 0; k < 3; k++) {
        add_product(result, 1, j[0][k], j[1][(k + 1) % 3], j[2][(k + 2) % 3]);
        add_product(result, -1, j[0][k], j[1][(k + 2) % 3], j[2][(k + 1) % 3]);
    }
}

/** det J at point t of the reference element. */
static void determinant_at(const planish_mesh *mesh, int64_t i, const double *x, const double t[3],
                           mpq_t result) {
    const pl_cell_type *type = pl_cell_type_of(mesh->cells->type[i]);
    const int32_t *node = mesh->cells->node + mesh->cells->offset[i];
    const int dim = type->shape->dim;
    double slope[SHAPE_NODES][3];
    mpq_t j[3][3];
    shape_slopes(type->type, t, slope);
    for (int m = 0; m < 3; m++)
        for (int d = 0; d < 3; d++) {
            mpq_init(j[m][d]);
            mpq_set_si(j[m][d], m == d && d >= dim, 1);
            for (int k = 1; m < dim && d < dim && k < type->n_nodes; k++)
                if (slope[k][m] != 0) /* all slopes together are 0 */
                    add_difference(j[m][d], slope[k][m], x[(int64_t)node[k] * dim + d],
                                   x[(int64_t)node[0] * dim + d]);
        }
    mpq_set_si(result, 0, 1);
    determinant(result, j);
    for (int m = 0; m < 9; m++)
        mpq_clear(j[m / 3][m % 3]);
}

/** Point number k of the cube, in the reference element. */
static void place_of(const polynomial *p, const pl_cell_shape *shape, int k, double t[3]) {
    double u[3] = {0};
    for (int d = 0; d < p->dim; d++) {
        u[d] = (p->n[d] == 3 ? of_three : of_six)[k % p->n[d]];
        k /= p->n[d];
    }
    point_of(shape, u, t);
}

static void evaluate(polynomial *p, const planish_mesh *mesh, int64_t i, const double *x,
                     int sign) {
    for (int k = 0; k < p->n_all; k++) {
        double t[3];
        place_of(p, pl_cell_type_of(mesh->cells->type[i])->shape, k, t);
        determinant_at(mesh, i, x, t, p->of[k]);
        if (sign < 0)
            mpq_neg(p->of[k], p->of[k]);
    }
}

/* ---- coefficients ------------------------------------------------------------------------------ */

/** What a line of numbers becomes, n of them, one every step. */
typedef void line_fn(mpq_t *first, int n, int step);

/** Do so with all lines along direction d. */
static void along(polynomial *p, int d, line_fn *act) {
    int step = 1;
    for (int k = 0; k < d; k++)
        step *= p->n[k];
    for (int k = 0; k < p->n_all; k++)
        if (k / step % p->n[d] == 0)
            act(p->of + k, p->n[d], step);
}

/** Bernstein's polynomial number b of degree n - 1 at t, exactly. */
static void bernstein(mpq_t result, int n, int b, double t) {
    static const int binomial[2][POINTS] = {{1, 2, 1}, {1, 5, 10, 10, 5, 1}};
    mpq_t at, rest;
    mpq_inits(at, rest, NULL);
    mpq_set_d(at, t);
    mpq_set_d(rest, 1 - t);
    mpq_set_si(result, binomial[n == POINTS][b], 1);
    for (int i = 0; i < n - 1; i++)
        mpq_mul(result, result, i < b ? at : rest);
    mpq_clears(at, rest, NULL);
}

/** row [n + 1] -= factor other; the factor is that which makes row[k] 0. */
static void eliminate(mpq_t *row, mpq_t *other, int n, int k) {
    mpq_t factor, term;
    mpq_inits(factor, term, NULL);
    mpq_div(factor, row[k], other[k]);
    for (int j = 0; j <= n; j++) {
        mpq_mul(term, factor, other[j]);
        mpq_sub(row[j], row[j], term);
    }
    mpq_clears(factor, term, NULL);
}

/** Values at points become coefficients, by Gauss's elimination: points and polynomials are in an order in
 *  which no pivot is 0. */
static void interpolate(mpq_t *first, int n, int step) {
    mpq_t row[POINTS][POINTS + 1];
    for (int r = 0; r < n; r++)
        for (int b = 0; b <= n; b++) {
            mpq_init(row[r][b]);
            if (b < n)
                bernstein(row[r][b], n, b, (n == 3 ? of_three : of_six)[r]);
            else
                mpq_set(row[r][b], first[(ptrdiff_t)r * step]);
        }
    for (int k = 0; k < n; k++)
        for (int r = 0; r < n; r++)
            if (r != k)
                eliminate(row[r], row[k], n, k);
    for (int r = 0; r < n; r++) {
        mpq_div(first[(ptrdiff_t)r * step], row[r][n], row[r][r]);
        for (int b = 0; b <= n; b++)
            mpq_clear(row[r][b]);
    }
}

/** Coefficients of the lower half, by de Casteljau's means. */
static void halve_low(mpq_t *first, int n, int step) {
    for (int round = 1; round < n; round++)
        for (int b = n - 1; b >= round; b--) {
            mpq_ptr here = first[(ptrdiff_t)b * step];
            mpq_add(here, here, first[(ptrdiff_t)(b - 1) * step]);
            mpq_div_2exp(here, here, 1);
        }
}

/** And of the upper half. */
static void halve_high(mpq_t *first, int n, int step) {
    halve_low(first + (ptrdiff_t)(n - 1) * step, n, -step);
}

/* ---- validity ---------------------------------------------------------------------------------- */

static int is_corner(const polynomial *p, int k) {
    for (int d = 0; d < p->dim; d++) {
        const int at = k % p->n[d];
        if (at != 0 && at != p->n[d] - 1)
            return 0;
        k /= p->n[d];
    }
    return 1;
}

/** 1, 0 or, if the coefficients do not say, -1. */
static int look(const polynomial *p) {
    int answer = 1;
    for (int k = 0; k < p->n_all; k++)
        if (mpq_sgn(p->of[k]) <= 0) {
            if (is_corner(p, k))
                return 0;
            answer = -1;
        }
    return answer;
}

static int decide(const polynomial *p, int depth);

static int decide_half(const polynomial *whole, int depth, line_fn *halve) {
    polynomial half = *whole;
    for (int k = 0; k < half.n_all; k++) {
        mpq_init(half.of[k]);
        mpq_set(half.of[k], whole->of[k]);
    }
    along(&half, depth % half.dim, halve);
    const int answer = decide(&half, depth + 1);
    polynomial_clear(&half);
    return answer;
}

static int decide(const polynomial *p, int depth) {
    const int answer = look(p);
    if (answer >= 0 || depth >= DEPTH * p->dim)
        return answer;
    const int low = decide_half(p, depth, halve_low);
    if (low == 0)
        return 0;
    const int high = decide_half(p, depth, halve_high);
    return high == 0 ? 0 : low < 0 ? low : high;
}

static int exact_answer(polynomial *p, const planish_mesh *mesh, int64_t i, const double *x,
                        int sign) {
    for (int k = 0; k < p->n_all; k++)
        mpq_init(p->of[k]);
    evaluate(p, mesh, i, x, sign);
    for (int d = 0; d < p->dim; d++)
        along(p, d, interpolate);
    const int answer = decide(p, 0);
    polynomial_clear(p);
    return answer;
}

static long double volume(int dim, long double e[3][3]) {
    if (dim == 2)
        return e[0][0] * e[1][1] - e[0][1] * e[1][0];
    long double sum = 0;
    for (int k = 0; k < 3; k++)
        sum += e[0][k] *
               (e[1][(k + 1) % 3] * e[2][(k + 2) % 3] - e[1][(k + 2) % 3] * e[2][(k + 1) % 3]);
    return sum;
}

/** Largest difference of a coordinate of the element from its first node's. */
static long double extent_of(const planish_mesh *mesh, int64_t i, const double *x) {
    const int32_t *node = mesh->cells->node + mesh->cells->offset[i];
    const int n = pl_cell_type_of(mesh->cells->type[i])->n_nodes;
    long double extent = 0;
    for (int k = 0; k < n * mesh->dim; k++) {
        const int d = k % mesh->dim;
        const long double x0 = x[(int64_t)node[0] * mesh->dim + d];
        extent = fmaxl(extent, fabsl(x[(int64_t)node[k / mesh->dim] * mesh->dim + d] - x0));
    }
    return extent;
}

/* ---- most elements are clear --------------------------------------------------------------------- */

/** Parts of |x|^dim, x the element's extent, that long double may be wrong by, and far more. */
#define DOUBT 1e-9L

/** The matrix by which n values become coefficients, rounded. */
static void matrix_of(int n, long double matrix[POINTS][POINTS]) {
    for (int column = 0; column < n; column++) {
        mpq_t unit[POINTS];
        for (int r = 0; r < n; r++) {
            mpq_init(unit[r]);
            mpq_set_si(unit[r], r == column, 1);
        }
        interpolate(unit, n, 1);
        for (int r = 0; r < n; r++) {
            matrix[r][column] = mpq_get_d(unit[r]);
            mpq_clear(unit[r]);
        }
    }
}

/** det J about t, in long double. */
static long double about(const planish_mesh *mesh, int64_t i, const double *x, const double t[3]) {
    const pl_cell_type *type = pl_cell_type_of(mesh->cells->type[i]);
    const int32_t *node = mesh->cells->node + mesh->cells->offset[i];
    const int dim = type->shape->dim;
    double slope[SHAPE_NODES][3];
    long double j[3][3] = {{0}};
    shape_slopes(type->type, t, slope);
    for (int k = 1; k < type->n_nodes; k++)
        for (int m = 0; m < dim; m++)
            for (int d = 0; d < dim; d++)
                j[m][d] += slope[k][m] * ((long double)x[(int64_t)node[k] * dim + d] -
                                          (long double)x[(int64_t)node[0] * dim + d]);
    return volume(dim, j);
}

/** 1 or 0 where rounding cannot matter, else -1. p: of the element, without numbers. */
static int clear_answer(const polynomial *p, const planish_mesh *mesh, int64_t i, const double *x,
                        int sign) {
    const pl_cell_shape *shape = pl_cell_type_of(mesh->cells->type[i])->shape;
    long double value[POINTS * POINTS * POINTS], matrix[POINTS][POINTS];
    matrix_of(p->n[0], matrix);
    for (int k = 0; k < p->n_all; k++) {
        double t[3];
        place_of(p, shape, k, t);
        value[k] = sign * about(mesh, i, x, t);
    }
    for (int d = 0, step = 1; d < p->dim; step *= p->n[d++])
        for (int k = 0; k < p->n_all; k++) {
            long double line[POINTS] = {0};
            for (int r = 0; k / step % p->n[d] == 0 && r < p->n[d] * p->n[d]; r++)
                line[r / p->n[d]] +=
                    matrix[r / p->n[d]][r % p->n[d]] * value[k + r % p->n[d] * step];
            for (int r = 0; k / step % p->n[d] == 0 && r < p->n[d]; r++)
                value[k + r * step] = line[r];
        }
    const long double doubt = DOUBT * powl(extent_of(mesh, i, x), shape->dim);
    int answer = 1;
    for (int k = 0; k < p->n_all; k++) {
        if (value[k] < -doubt && is_corner(p, k))
            return 0;
        if (!(value[k] > doubt))
            answer = -1;
    }
    return answer;
}

int cell_judge_validity(const planish_mesh *mesh, int64_t i, const double *x, int sign) {
    polynomial p;
    polynomial_size(&p, pl_cell_type_of(mesh->cells->type[i]));
    const int answer = clear_answer(&p, mesh, i, x, sign);
    return answer >= 0 ? answer : exact_answer(&p, mesh, i, x, sign);
}

/* ---- ratios ------------------------------------------------------------------------------------ */

/** Where the edges of corners lead, right-handed. */
static const uint8_t of_triangle[][3] = {{1, 2}, {2, 0}, {0, 1}};
static const uint8_t of_quadrilateral[][3] = {{1, 3}, {2, 0}, {3, 1}, {0, 2}};
static const uint8_t of_tetrahedron[][3] = {{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {0, 2, 1}};
static const uint8_t of_pyramid[][3] = {{1, 3, 4}, {2, 0, 4}, {3, 1, 4}, {0, 2, 4}};
static const uint8_t of_wedge[][3] = {{1, 2, 3}, {2, 0, 4}, {0, 1, 5},
                                      {5, 4, 0}, {3, 5, 1}, {4, 3, 2}};
static const uint8_t of_hexahedron[][3] = {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                                           {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}};

/** The corners that count of a shape; share: volume of the body at a corner by that of its
 *  parallelepiped; ideal: edges of the ideal corner. */
typedef struct corners {
    int n;
    const uint8_t (*to)[3];
    long double share, ideal[3][3];
} corners;

static corners corners_of(const pl_cell_shape *shape) {
    const long double r = sqrtl(3) / 2, s = sqrtl(0.5L);
    const corners triangle = {3, of_triangle, 0.5L, {{1, 0}, {0.5L, r}}};
    const corners quadrilateral = {4, of_quadrilateral, 1, {{1, 0}, {0, 1}}};
    const corners tetrahedron = {
        4, of_tetrahedron, 1 / 6.0L, {{1, 0, 0}, {0.5L, r, 0}, {0.5L, r / 3, sqrtl(2 / 3.0L)}}};
    const corners pyramid = {4, of_pyramid, 1 / 3.0L, {{1, 0, 0}, {0, 1, 0}, {0.5L, 0.5L, s}}};
    const corners wedge = {6, of_wedge, 0.5L, {{1, 0, 0}, {0.5L, r, 0}, {0, 0, 1}}};
    const corners hexahedron = {8, of_hexahedron, 1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    if (shape->dim == 2)
        return shape->n_corners == 3 ? triangle : quadrilateral;
    return shape->n_corners == 4   ? tetrahedron
           : shape->n_corners == 5 ? pyramid
           : shape->n_corners == 6 ? wedge
                                   : hexahedron;
}

/** The edges of a corner at x; node: of the element. */
static void edges_at(int dim, const int32_t *node, int corner, const uint8_t *to, const double *x,
                     long double e[3][3]) {
    for (int k = 0; k < dim; k++)
        for (int d = 0; d < dim; d++)
            e[k][d] = (long double)x[(int64_t)node[to[k]] * dim + d] -
                      (long double)x[(int64_t)node[corner] * dim + d];
}

/** |A W^-1|^2 for edges a and w: edge k is A's, or W's, column. By Cramer's rule row d of A W^-1 is that
 *  combination of W's rows which gives row d of A. */
static long double norm_square(int dim, long double a[3][3], long double w[3][3]) {
    const long double whole = volume(dim, w);
    long double sum = 0;
    for (int d = 0; d < dim; d++)
        for (int r = 0; r < dim; r++) {
            long double with[3][3];
            memcpy(with, w, sizeof with);
            for (int k = 0; k < dim; k++)
                with[k][r] = a[k][d];
            const long double t = volume(dim, with) / whole;
            sum += t * t;
        }
    return sum;
}

static void add_corner(cell_worth *worth, int dim, const corners *c, long double a[3][3],
                       long double w[3][3], long double weight, int sign) {
    const long double v = sign * volume(dim, a), whole = fabsl(volume(dim, w));
    long double lengths = 1, ideal[3][3];
    memcpy(ideal, c->ideal, sizeof ideal);
    for (int k = 0; k < dim; k++) {
        const long double length = hypotl(hypotl(a[k][0], a[k][1]), dim == 3 ? a[k][2] : 0);
        worth->edge = fmaxl(worth->edge, length);
        lengths *= length;
    }
    worth->is_positive &= v > 0;
    worth->volume = fminl(worth->volume, c->share * v);
    worth->jacobian = fminl(worth->jacobian, v / lengths / volume(dim, ideal));
    const long double norm = norm_square(dim, a, w);
    const long double mu =
        dim == 3 ? norm / (3 * powl(v / whole, 2 / 3.0L)) : norm / (2 * v / whole);
    worth->square += ((1 - weight) * mu * mu + weight * (v / whole + whole / v) / 2) / c->n;
}

cell_worth cell_judge_worth(const planish_mesh *mesh, int64_t i, const double *x,
                            const double *reference, double weight, int sign) {
    const pl_cell_shape *shape = pl_cell_type_of(mesh->cells->type[i])->shape;
    const int32_t *node = mesh->cells->node + mesh->cells->offset[i];
    const corners c = corners_of(shape);
    cell_worth worth = {.is_positive = 1, .jacobian = INFINITY, .volume = INFINITY};
    for (int k = 0; k < c.n; k++) {
        long double a[3][3], w[3][3];
        memcpy(w, c.ideal, sizeof w);
        edges_at(shape->dim, node, k, c.to[k], x, a);
        if (reference)
            edges_at(shape->dim, node, k, c.to[k], reference, w);
        add_corner(&worth, shape->dim, &c, a, w, weight, sign);
    }
    return worth;
}

#endif
