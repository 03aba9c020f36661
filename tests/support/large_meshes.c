/* large_meshes: numbers, places and constraints of lattices. */
#include "support/large_meshes.h"

#include "support/effort.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Corners of a cube in VTK's order, and the six tetrahedra around its diagonal. */
static const uint8_t corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                     {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
static const uint8_t cut[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                  {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
/* Ends of the mids of a quadratic tetrahedron. */
static const uint8_t edge[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};

/** How a kind fills a cube of the lattice. */
typedef struct filling {
    int parts, corners, nodes, type;
    int step;    /* steps of the lattice along a cube */
    double push; /* in edges */
} filling;

static const filling fillings[N_LARGE_KINDS] = {
    [LARGE_TETRAHEDRA] = {6, 4, 4, PLANISH_CELL_TETRAHEDRON, 1, 0.14},
    [LARGE_HEXAHEDRA] = {1, 8, 8, PLANISH_CELL_HEXAHEDRON, 1, 0.2},
    [LARGE_QUADRATIC] = {6, 4, 10, PLANISH_CELL_TETRAHEDRON10, 2, 0.14},
    [LARGE_BALL] = {1, 8, 8, PLANISH_CELL_HEXAHEDRON, 1, 0.1},
};

static void *taken(int64_t n, size_t size) {
    void *block = calloc((size_t)n, size);
    assert_non_null(block);
    return block;
}

static int64_t number_of(int side, const int at[3]) {
    return at[0] + side * (at[1] + (int64_t)side * at[2]);
}

/** Node k of the part of the cube at first. */
static int32_t node_of(const large_mesh *m, const filling *f, const int first[3], int part, int k) {
    int at[3], twice[3] = {0};
    const int is_mid = k >= f->corners;
    for (int end = 0; end < 2; end++) {
        const int own = is_mid ? edge[k - f->corners][end] : k;
        const int c = f->parts == 1 ? own : cut[part][own];
        for (int d = 0; d < 3; d++)
            twice[d] += f->step * corner[c][d];
    }
    for (int d = 0; d < 3; d++)
        at[d] = first[d] + twice[d] / 2;
    return (int32_t)number_of(m->side, at);
}

static void fill(large_mesh *m, const filling *f, int cubes) {
    int32_t *to = m->node;
    for (int64_t i = 0; i < (int64_t)cubes * cubes * cubes; i++) {
        const int first[3] = {(int)(i % cubes) * f->step, (int)(i / cubes % cubes) * f->step,
                              (int)(i / cubes / cubes) * f->step};
        for (int part = 0; part < f->parts; part++)
            for (int k = 0; k < f->nodes; k++)
                *to++ = node_of(m, f, first, part, k);
    }
}

/** Take a point of the cube -1 .. 1 to the ball. */
static void to_ball(double x[3]) {
    const double length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    const double largest = fmax(fabs(x[0]), fmax(fabs(x[1]), fabs(x[2])));
    for (int d = 0; d < 3; d++)
        x[d] *= length > 0 ? largest / length : 1;
}

/** Place the nodes, and push those inside; mids come between their ends afterwards. */
static void place(large_mesh *m, const filling *f, int is_ball, int cubes) {
    const double edge_length = 2.0 / cubes;
    uint64_t random = effort_seed(77);
    for (int64_t i = 0; i < m->mesh.n_nodes; i++) {
        const int at[3] = {(int)(i % m->side), (int)(i / m->side % m->side),
                           (int)(i / m->side / m->side)};
        int is_inside = 1;
        double *x = m->x + 3 * i;
        for (int d = 0; d < 3; d++) {
            x[d] = at[d] * edge_length / f->step - 1;
            is_inside &= at[d] > 0 && at[d] < m->side - 1;
        }
        if (is_ball)
            to_ball(x);
        for (int d = 0; is_inside && d < 3; d++)
            x[d] += f->push * edge_length * random_between(&random, -1, 1);
    }
    for (int64_t i = 0; f->nodes > f->corners && i < m->mesh.n_elements * f->nodes; i++) {
        const int32_t *own = m->node + i / f->nodes * f->nodes;
        const int k = (int)(i % f->nodes) - f->corners;
        for (int d = 0; k >= 0 && d < 3; d++)
            m->x[3 * (int64_t)own[k + f->corners] + d] =
                (m->x[3 * (int64_t)own[edge[k][0]] + d] + m->x[3 * (int64_t)own[edge[k][1]] + d]) /
                2;
    }
}

/** Let the surface slide on its shape. */
static void let_slide(large_mesh *m) {
    m->constraint = taken(m->mesh.n_nodes, 1);
    m->direction = taken(m->mesh.n_nodes * 3, sizeof *m->direction);
    assert_int_equal(planish_shape_create(&m->mesh, NULL, 0, &m->shape, NULL, NULL), 0);
    const planish_surface surface = {.shape = m->shape};
    assert_int_equal(
        planish_find_slides(&m->mesh, &surface, 0, m->constraint, m->direction, NULL, NULL), 0);
    m->mesh.constraint = m->constraint;
    m->mesh.direction = m->direction;
}

/** Tell the mesh where its elements are. */
static void link_elements(large_mesh *m, large_kind kind, const filling *f) {
    const int64_t n = m->mesh.n_elements;
    if (kind == LARGE_TETRAHEDRA) {
        m->mesh.elements = m->node;
        return;
    }
    m->type = taken(n, 1);
    m->offset = taken(n + 1, sizeof *m->offset);
    memset(m->type, f->type, (size_t)n);
    for (int64_t i = 0; i <= n; i++)
        m->offset[i] = i * f->nodes;
    m->cells = (planish_cells){.n = n, .type = m->type, .offset = m->offset, .node = m->node};
    m->mesh.cells = &m->cells;
}

large_mesh *large_mesh_create(large_kind kind, int64_t n) {
    const filling *f = &fillings[kind];
    const int cubes = (int)fmax(2, round(cbrt((double)n / f->parts)));
    large_mesh *m = taken(1, sizeof *m);
    m->side = cubes * f->step + 1;
    m->mesh.dim = 3;
    m->mesh.n_nodes = (int64_t)m->side * m->side * m->side;
    m->mesh.n_elements = (int64_t)cubes * cubes * cubes * f->parts;
    m->mesh.coordinates = m->x = taken(m->mesh.n_nodes * 3, sizeof *m->x);
    m->node = taken(m->mesh.n_elements * f->nodes, sizeof *m->node);
    fill(m, f, cubes);
    place(m, f, kind == LARGE_BALL, cubes);
    link_elements(m, kind, f);
    if (kind == LARGE_BALL)
        let_slide(m);
    return m;
}

void large_mesh_destroy(large_mesh *m) {
    planish_shape_destroy(m->shape);
    free(m->x);
    free(m->node);
    free(m->offset);
    free(m->type);
    free(m->constraint);
    free(m->direction);
    free(m);
}
