/* cell_star: corners by the definition of the mean ratio, T = J W^-1. */
#include "support/cell_star.h"

#include "base/memory.h"
#include "support/effort.h"

#include <math.h>
#include <string.h>

static const planish_cell_type TYPES[2][4] = {
    {PLANISH_CELL_TRIANGLE, PLANISH_CELL_QUADRILATERAL, PLANISH_CELL_TRIANGLE,
     PLANISH_CELL_QUADRILATERAL},
    {PLANISH_CELL_TETRAHEDRON, PLANISH_CELL_HEXAHEDRON, PLANISH_CELL_WEDGE, PLANISH_CELL_PYRAMID}};

void cell_star_ideal(const pl_cell_shape *shape, double x[8][3]) {
    static const double TRIANGLE[3][2] = {{0, 0}, {1, 0}, {0.5, 0.86602540378443865}};
    static const double SQUARE[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const int n = shape->n_corners, of_triangle = n == 3 || n == 6 || (n == 4 && shape->dim == 3);
    memset(x, 0, 8 * sizeof *x);
    for (int i = 0; i < n; i++) {
        const double *base = of_triangle ? TRIANGLE[i % 3] : SQUARE[i % 4];
        x[i][0] = base[0];
        x[i][1] = base[1];
        x[i][2] = i >= n / 2 && n >= 6 ? 1 : 0;
    }
    if (n == 5 || (n == 4 && shape->dim == 3)) {
        x[n - 1][0] = 0.5;
        x[n - 1][1] = n == 5 ? 0.5 : 0.28867513459481288;
        x[n - 1][2] = n == 5 ? 0.70710678118654752 : 0.81649658092772603;
    }
}

static long double determinant(const long double e[3][3], int dim) {
    if (dim == 2)
        return e[0][0] * e[1][1] - e[0][1] * e[1][0];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
           e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

/** Edges e [i] to the neighbours of a corner of the cell with these corners. */
static void edges_of(const pl_cell_shape *shape, int corner, long double x[8][3],
                     long double e[3][3]) {
    memset(e, 0, 9 * sizeof e[0][0]);
    for (int i = 0; i < shape->dim; i++)
        for (int d = 0; d < shape->dim; d++)
            e[i][d] = x[shape->neighbour[corner][i]][d] - x[corner][d];
}

/** Squared Frobenius norm of T, J = T W, where rows of e are columns of J, of w of W: solve. */
static long double square_of_map(long double e[3][3], long double w[3][3], int dim) {
    /* T w_i = e_i: by Cramer, T = sum_i e_i (w_j x w_k)^T / det W */
    long double sum = 0, det = determinant(w, dim);
    for (int r = 0; r < dim; r++)
        for (int c = 0; c < dim; c++) {
            long double t = 0;
            for (int i = 0; i < dim; i++) {
                long double m[3][3];
                memcpy(m, w, sizeof m);
                for (int d = 0; d < 3; d++)
                    m[i][d] = d == c;
                t += e[i][r] * determinant((const long double(*)[3])m, dim) / det;
            }
            sum += t * t;
        }
    return sum;
}

static int is_edge(const pl_cell_shape *shape, int a, int b) {
    int found = 0;
    for (int i = 0; i < shape->n_edges; i++)
        found |= (shape->edge[i][0] == a && shape->edge[i][1] == b) ||
                 (shape->edge[i][0] == b && shape->edge[i][1] == a);
    return found;
}

static long double length2(const long double *p, const long double *q, int dim) {
    long double sum = 0;
    for (int d = 0; d < dim; d++)
        sum += (p[d] - q[d]) * (p[d] - q[d]);
    return sum;
}

/** Smoothed squared ratio of the element's edges among the corner's simplex. */
static long double ratio_of_edges(const pl_cell_shape *shape, int corner, long double x[8][3]) {
    int node[4] = {corner}, n = 0;
    long double large = 0, small = 0;
    for (int i = 0; i < shape->dim; i++)
        node[i + 1] = shape->neighbour[corner][i];
    for (int i = 0; i <= shape->dim; i++)
        for (int j = i + 1; j <= shape->dim; j++) {
            if (!is_edge(shape, node[i], node[j]))
                continue;
            const long double power = powl(length2(x[node[i]], x[node[j]], shape->dim), 32);
            large += power;
            small += 1 / power;
            n++;
        }
    return powl(large / n * (small / n), 1.0L / 32);
}

static cell_corner measure(const pl_cell_shape *shape, int corner, long double x[8][3]) {
    const int dim = shape->dim;
    double at[8][3];
    long double ideal[8][3], e[3][3], w[3][3];
    cell_star_ideal(shape, at);
    for (int i = 0; i < 8; i++)
        for (int d = 0; d < 3; d++)
            ideal[i][d] = at[i][d];
    edges_of(shape, corner, x, e);
    edges_of(shape, corner, ideal, w);
    cell_corner c = {.D = determinant((const long double(*)[3])e, dim),
                     .ideal_determinant = determinant((const long double(*)[3])w, dim),
                     .squares = square_of_map(e, w, dim),
                     .edges = ratio_of_edges(shape, corner, x)};
    const long double det = c.D / c.ideal_determinant;
    const long double mu = c.squares / dim / (dim == 3 ? powl(det, 2.0L / 3) : det);
    c.mu2 = mu * mu;
    c.n_jacobians = shape->n_simplices == 1 ? shape->n_corners : 1;
    for (int k = 0; k < c.n_jacobians; k++) {
        const int at_corner = shape->n_simplices == 1 ? k : corner;
        c.jacobians[k] = 1 / (det * det);
        for (int i = 0; i < dim; i++)
            c.jacobians[k] *= length2(x[at_corner], x[shape->neighbour[at_corner][i]], dim);
        c.jacobian = fmaxl(c.jacobian, c.jacobians[k]);
    }
    return c;
}

static void nodes_of(const cell_star *s, int cell, const long double *x, long double at[8][3]) {
    memset(at, 0, 24 * sizeof at[0][0]);
    for (int i = 0; i < s->shape[cell]->n_corners; i++)
        for (int d = 0; d < s->dim; d++) {
            const int node = s->node[cell][i];
            at[i][d] = node == 0 ? x[d] : s->coordinates[node * s->dim + d];
        }
}

cell_corner cell_star_corner(const cell_star *s, int facet, const long double *x) {
    long double at[8][3];
    nodes_of(s, s->cell[facet], x, at);
    return measure(s->shape[s->cell[facet]], s->corner[facet], at);
}

int cell_star_corners(const cell_star *s, int facet) {
    const pl_cell_shape *shape = s->shape[s->cell[facet]];
    return shape->n_simplices == 1 ? 1 : shape->n_measured;
}

pl_star_row cell_star_row(const cell_star *s, int facet) {
    const int dim = s->dim;
    const double share = 1.0 / cell_star_corners(s, facet);
    long double x[3] = {0, 0, 0};
    for (int d = 0; d < dim; d++)
        x[d] = s->coordinates[d];
    const cell_corner here = cell_star_corner(s, facet, x);
    const long double power = dim == 3 ? 4.0L / 3 : 2;
    pl_star_row row = {.weight = share,
                       .share = 1,
                       .size = 1,
                       .factor = (double)(powl(here.ideal_determinant, power) / (dim * dim)),
                       .e = (double)here.squares,
                       .D0 = (double)here.D};
    for (int d = 0; d < dim; d++) {
        long double up[3], down[3];
        memcpy(up, x, sizeof up);
        memcpy(down, x, sizeof down);
        up[d] += 1;
        down[d] -= 1;
        const cell_corner above = cell_star_corner(s, facet, up);
        const cell_corner below = cell_star_corner(s, facet, down);
        row.c = (double)((above.squares + below.squares) / 2 - here.squares);
        row.slope_e[d] = (double)((above.squares - below.squares) / 4);
        row.slope_d[d] = (double)((above.D - below.D) / 2);
    }
    return row;
}

/** A pl_star_more_fn: user is the star. */
static int64_t rows_of(const void *user, int64_t star, pl_star_row *row) {
    const cell_star *s = user;
    (void)star;
    memcpy(row, s->row, (size_t)s->n_rows * sizeof *row);
    return s->n_rows;
}

void cell_star_use_rows(cell_star *s, int n) {
    s->n_rows = n;
    s->has_more = n > 0;
    s->problem.more = rows_of;
    s->problem.more_user = s;
    s->problem.has_more = &s->has_more;
    s->problem.max_more = CELL_STAR_MAX_ROWS;
}

/* ---- making ---------------------------------------------------------------------------------- */

/** Append the link facet opposite the star's node of the corner of a cell, if it is there. */
static void add_facet(cell_star *s, int cell, int corner) {
    const pl_cell_shape *shape = s->shape[cell];
    const int dim = s->dim, is_simplex = shape->n_simplices == 1;
    int node[4] = {is_simplex ? 0 : corner}, place = -1, k = 0, rest[3] = {0, 0, 0};
    for (int i = 0; i < dim; i++)
        node[i + 1] = is_simplex ? i + 1 : shape->neighbour[corner][i];
    for (int j = 0; j <= dim; j++)
        if (s->node[cell][node[j]] == 0)
            place = j;
        else if (k < dim)
            rest[k++] = s->node[cell][node[j]];
    if (place < 0)
        return;
    const int turned = dim == 3 ? place % 2 == 0 : place % 2 == 1, first = dim - 2,
              f = s->n_facets++;
    if (turned) {
        const int kept = rest[first];
        rest[first] = rest[first + 1];
        rest[first + 1] = kept;
    }
    memcpy(s->facet[f], rest, sizeof rest);
    s->cell[f] = cell;
    s->corner[f] = corner;
    s->code[f] = pl_form_code(pl_corner_code(pl_kind_of_shape(shape), corner), place, turned);
}

/** Give the cell nodes, of a random map of its ideal, with one of them at the star's. */
static void add_cell(cell_star *s, const pl_cell_shape *shape, double noise, uint64_t *random) {
    const int dim = s->dim, cell = s->n_cells++, own = (int)random_below(random, shape->n_corners);
    double ideal[8][3], map[3][3], x[8][3];
    int valid = 0, node = (int)s->ring_offset[1] + 1;
    cell_star_ideal(shape, ideal);
    s->shape[cell] = shape;
    while (!valid) {
        for (int r = 0; r < dim; r++)
            for (int c = 0; c < dim; c++)
                map[r][c] = random_between(random, -1, 1) + (r == c);
        for (int i = 0; i < shape->n_corners; i++)
            for (int d = 0; d < 3; d++)
                ideal[i][d] += d < dim ? noise * random_between(random, -0.5, 0.5) : 0;
        long double at[8][3] = {{0}};
        for (int i = 0; i < shape->n_corners; i++)
            for (int r = 0; r < dim; r++) {
                x[i][r] = 0;
                for (int c = 0; c < dim; c++)
                    x[i][r] += map[r][c] * (ideal[i][c] - ideal[own][c]);
                at[i][r] = x[i][r];
            }
        valid = 1;
        for (int corner = 0; corner < shape->n_measured; corner++)
            valid &= measure(shape, corner, at).jacobian < 400 && measure(shape, corner, at).D > 0;
        if (!valid)
            cell_star_ideal(shape, ideal);
    }
    for (int i = 0; i < shape->n_corners; i++) {
        s->node[cell][i] = i == own ? 0 : node++;
        for (int d = 0; d < dim; d++)
            s->coordinates[s->node[cell][i] * dim + d] = x[i][d];
    }
    for (int64_t i = s->ring_offset[1]; i < node - 1; i++)
        s->ring[i] = (int32_t)(i + 1);
    s->ring_offset[1] = node - 1;
    for (int corner = 0; corner < (shape->n_simplices == 1 ? 1 : shape->n_measured); corner++)
        add_facet(s, cell, corner);
}

void cell_star_create(cell_star *s, int dim, const pl_cell_shape *shape, int n, double noise,
                      uint64_t *random) {
    memset(s, 0, sizeof *s);
    s->dim = dim;
    pl_corner_forms_make(dim, s->form);
    for (int i = 0; i < n; i++) {
        const planish_cell_type type = TYPES[dim - 2][random_below(random, 4)];
        add_cell(s, shape ? shape : pl_cell_type_of((int)type)->shape, noise, random);
    }
    s->link_offset[1] = s->n_facets;
    const pl_link link = {s->positions, NULL};
    for (int f = 0; f < s->n_facets; f++)
        for (int j = 0; j < dim; j++)
            pl_link_set(&link, f * dim + j, s->facet[f][j] - 1);
    memset(s->changed, 1, sizeof s->changed);
    s->scratch = pl_alloc(
        pl_star_scratch_size(dim, CELL_STAR_MAX_NODES, CELL_STAR_MAX_FACETS, CELL_STAR_MAX_ROWS),
        1);
    s->guard = (pl_star_guard){.ratio_weight = 1, .worst_limit = 1};
    s->problem = (pl_star_problem){.coordinates = s->coordinates,
                                   .node = &s->centre,
                                   .ring_offset = s->ring_offset,
                                   .ring = s->ring,
                                   .link_offset = s->link_offset,
                                   .link = {s->positions, NULL},
                                   .link_form = s->code,
                                   .form = s->form,
                                   .changed = s->changed,
                                   .limits = pl_star_no_limits()};
}

void cell_star_destroy(cell_star *s) {
    pl_free(s->scratch);
}
