#include "support/bodies.h"

#include "support/effort.h"

#include "geometry/simplex.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CUBES = 1000 };

static int32_t node_at(const body *b, int i, int j, int k) {
    i = b->joins && i == b->n[0] ? 0 : i;
    return (int32_t)((i * (b->n[1] + 1) + j) * (b->n[2] + 1) + k);
}

/** Add an element of n nodes. */
static void add(body *b, planish_cell_type type, int n, const int32_t *node, int32_t region) {
    const int64_t e = b->mesh.n_elements++;
    memcpy(b->node + b->offset[e], node, (size_t)n * sizeof *node);
    b->offset[e + 1] = b->offset[e] + n;
    b->type[e] = (uint8_t)type;
    b->region[e] = region;
}

/** Add the tetrahedra of a cube: along its diagonal, one for each order of the directions. */
static void add_tetrahedra(body *b, int i, int j, int k, int32_t region) {
    static const int ORDER[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int t = 0; t < 6; t++) {
        int at[3] = {i, j, k};
        int32_t node[4] = {node_at(b, i, j, k)};
        for (int step = 0; step < 3; step++) {
            at[ORDER[t][step]]++;
            node[step + 1] = node_at(b, at[0], at[1], at[2]);
        }
        if (t >= 3) {
            const int32_t last = node[3];
            node[3] = node[2];
            node[2] = last;
        }
        add(b, PLANISH_CELL_TETRAHEDRON, 4, node, region);
    }
}

/** Add a hexahedron, or two wedges whose triangles lie along one of two diagonals. */
static void add_cells(body *b, int i, int j, int k, int is_cut, int other, int32_t region) {
    const int at[4][2] = {{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}};
    int32_t node[8];
    for (int m = 0; m < 8; m++)
        node[m] = node_at(b, at[m % 4][0], at[m % 4][1], k + m / 4);
    if (!is_cut)
        add(b, PLANISH_CELL_HEXAHEDRON, 8, node, region);
    for (int half = 0; is_cut && half < 2; half++) {
        const int first = other + 2 * half;
        int32_t wedge[6];
        for (int m = 0; m < 6; m++)
            wedge[m] = node[(first + m % 3) % 4 + 4 * (m / 3)];
        add(b, PLANISH_CELL_WEDGE, 6, wedge, region);
    }
}

/** Add the elements of a column of cubes: their kind is the column's. */
static void add_column(body *b, int i, int j, uint64_t *state) {
    const int is_cut = b->of == OF_WEDGES || (b->of == OF_BOTH && random_below(state, 2));
    const int other = (int)random_below(state, 2);
    for (int k = 0; k < b->n[2]; k++) {
        const int32_t region = b->kind == BODY_REGIONS && k >= b->n[2] / 2;
        if (b->kind == BODY_SHEETS && k == 1)
            continue;
        if (b->of == OF_TETRAHEDRA)
            add_tetrahedra(b, i, j, k, region);
        else
            add_cells(b, i, j, k, is_cut, other, region);
    }
}

/** Map the square -1 .. 1 to the disc. */
static void to_disc(double *u, double *v) {
    const double a = *u, b = *v;
    *u = a * sqrt(1 - b * b / 2);
    *v = b * sqrt(1 - a * a / 2);
}

static void to_ball(double *x) {
    const double u = x[0] * x[0], v = x[1] * x[1], w = x[2] * x[2];
    x[0] *= sqrt(1 - v / 2 - w / 2 + v * w / 3);
    x[1] *= sqrt(1 - w / 2 - u / 2 + w * u / 3);
    x[2] *= sqrt(1 - u / 2 - v / 2 + u * v / 3);
}

/** The form of a body, drawn once. */
typedef struct form {
    double wave[6], slope, bend;
} form;

/** Take a place in the grid to its place in space. */
static void to_space(const body *b, const form *f, const double g[3], double x[3]) {
    const double pi = acos(-1.), *w = f->wave;
    const double u = 2 * g[1] / b->n[1] - 1, v = 2 * g[2] / b->n[2] - 1;
    const double wave = w[0] * sin(w[1] * g[0] + 3 * w[2]) + w[3] * sin(w[4] * g[1] + 3 * w[5]);
    memcpy(x, g, 3 * sizeof *x);
    if (b->kind == BODY_BALL) {
        for (int d = 0; d < 3; d++)
            x[d] = 2 * g[d] / b->n[d] - 1;
        to_ball(x);
        for (int d = 0; d < 3; d++)
            x[d] *= b->n[d] / 2.;
    } else if (b->kind == BODY_ROD || b->kind == BODY_RING) {
        double disc[2] = {u, v};
        to_disc(&disc[0], &disc[1]);
        const double a = b->joins ? 2 * pi * g[0] / b->n[0] : f->bend * g[0];
        const double r = (b->joins ? b->n[0] / (2 * pi) + 1 : 1 / f->bend) + disc[0];
        x[0] = r * cos(a);
        x[1] = r * sin(a);
        x[2] = disc[1];
    } else if (b->kind == BODY_WEDGE) {
        x[2] = g[2] + f->slope * fabs(g[0] - b->n[0] / 2);
    } else if (b->kind == BODY_PLATE) {
        x[2] = 0.1 * g[2] + wave;
    } else if (b->kind == BODY_SHEETS) {
        x[2] = wave + (g[2] < 1 ? g[2] : g[2] < 2 ? 1 + 0.1 * (g[2] - 1) : g[2] - 0.9);
    } else {
        x[2] = g[2] + wave * (b->kind == BODY_REGIONS ? 1 : g[2] / b->n[2]);
    }
    if (b->kind == BODY_NEEDLES)
        x[0] *= 0.03;
}

/** Place the nodes: inside and along the surface by up to amount of an edge beside the grid's place. */
static void place_nodes(body *b, double amount, uint64_t *state) {
    form f = {.slope = random_between(state, 0.03, 1.2), .bend = random_between(state, 0.05, 0.3)};
    double angle[3];
    for (int i = 0; i < 6; i++)
        f.wave[i] = random_between(state, 0, i % 3 ? 0.9 : 0.4);
    for (int d = 0; d < 3; d++)
        angle[d] = random_between(state, 0, 6.3);
    const double scale = pow(10, (double)random_below(state, 5) - 2);
    for (int i = 0; i < b->n[0] + !b->joins; i++)
        for (int j = 0; j <= b->n[1]; j++)
            for (int k = 0; k <= b->n[2]; k++) {
                double g[3] = {i, j, k}, *x = b->x + 3 * (int64_t)node_at(b, i, j, k);
                for (int d = 0; d < 3; d++) {
                    const double by = amount * random_between(state, -1, 1);
                    const int at = (int)g[d];
                    const int is_crease = b->kind == BODY_WEDGE && d == 0 && at == b->n[0] / 2;
                    const int is_side =
                        d == 2 && (b->kind == BODY_SHEETS || b->kind == BODY_PLATE ||
                                   (b->kind == BODY_REGIONS && at == b->n[2] / 2));
                    if (((at > 0 && at < b->n[d]) || (d == 0 && b->joins)) && !is_crease &&
                        !is_side)
                        g[d] += by;
                }
                to_space(b, &f, g, x);
                for (int d = 0; d < 3; d++) {
                    double *p = &x[d], *q = &x[(d + 1) % 3];
                    const double u = *p * cos(angle[d]) - *q * sin(angle[d]);
                    *q = *p * sin(angle[d]) + *q * cos(angle[d]);
                    *p = u;
                }
                for (int d = 0; d < 3; d++)
                    x[d] *= scale;
            }
}

body body_create(uint64_t *state) {
    body b = {.kind = (int)random_below(state, BODY_KINDS)};
    b.of = random_below(state, 2) ? OF_TETRAHEDRA : OF_HEXAHEDRA + (int)random_below(state, 3);
    for (int d = 0; d < 3; d++)
        b.n[d] = 2 + (int)random_below(state, 3);
    if (b.kind == BODY_RING || b.kind == BODY_ROD)
        b.n[0] += 4;
    if (b.kind == BODY_BALL)
        b.n[0] = b.n[1] = b.n[2] = 4 + (int)random_below(state, 2);
    if (b.kind == BODY_PLATE)
        b.n[2] = 1;
    if (b.kind == BODY_SHEETS)
        b.n[2] = 3;
    b.joins = b.kind == BODY_RING;
    b.mesh.dim = 3;
    b.mesh.n_nodes = (b.n[0] + !b.joins) * (b.n[1] + 1) * (b.n[2] + 1);
    b.x = malloc((size_t)b.mesh.n_nodes * 3 * sizeof *b.x);
    b.node = malloc(MOST_CUBES * 24 * sizeof *b.node);
    b.region = malloc(MOST_CUBES * 6 * sizeof *b.region);
    b.offset = calloc(MOST_CUBES * 6 + 1, sizeof *b.offset);
    b.type = malloc(MOST_CUBES * 6);
    for (int i = 0; i < b.n[0]; i++)
        for (int j = 0; j < b.n[1]; j++)
            add_column(&b, i, j, state);
    place_nodes(&b, random_between(state, 0, b.of == OF_TETRAHEDRA ? 0.35 : 0.25), state);
    b.mesh.coordinates = b.x;
    if (b.of == OF_TETRAHEDRA)
        b.mesh.elements = b.node;
    b.cells =
        (planish_cells){.n = b.mesh.n_elements, .type = b.type, .offset = b.offset, .node = b.node};
    return b;
}

void body_destroy(body *b) {
    free(b->x);
    free(b->node);
    free(b->region);
    free(b->offset);
    free(b->type);
}

/** The determinant of the ways from node a to b, c and d. */
static double corner(const double *x, const int32_t *node, int a, int b, int c, int d) {
    const int to[3] = {b, c, d};
    double v[3][3], normal[3];
    for (int j = 0; j < 3; j++)
        pl_subtract(3, x + 3 * (int64_t)node[to[j]], x + 3 * (int64_t)node[a], v[j]);
    pl_cross(v[0], v[1], normal);
    return pl_dot(3, normal, v[2]);
}

double body_least_corner(const body *b, const double *x, int64_t e) {
    const int32_t *node = b->node + b->offset[e];
    const int n = (int)(b->offset[e + 1] - b->offset[e]), m = n / 2; /* corners of each end */
    double least = INFINITY;
    if (n == 4)
        return corner(x, node, 0, 1, 2, 3);
    for (int k = 0; k < m; k++) {
        const int next = (k + 1) % m, before = (k + m - 1) % m;
        least = fmin(least, corner(x, node, k, next, before, k + m));
        least = fmin(least, corner(x, node, k + m, before + m, next + m, k));
    }
    return least;
}
