#include "support/loose_cells.h"

#include "geometry/cell.h"
#include "support/effort.h"
#include "support/faults.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

const int loose_types[LOOSE_TYPES] = {5,  22, 9,  23, 28, 10, 24, 12,
                                      25, 29, 13, 26, 32, 14, 27, 128};

loose_cells loose_cells_create(int dim) {
    loose_cells m = {.dim = dim};
    m.type = malloc(LOOSE_MOST);
    m.offset = calloc(LOOSE_MOST + 1, sizeof *m.offset);
    m.node = malloc(LOOSE_MOST * PL_CELL_NODES * sizeof *m.node);
    m.x = calloc((size_t)(LOOSE_MOST * PL_CELL_NODES * dim), sizeof *m.x);
    m.cells = (planish_cells){.type = m.type, .offset = m.offset, .node = m.node};
    return m;
}

void loose_cells_destroy(loose_cells *m) {
    free(m->type);
    free(m->offset);
    free(m->node);
    free(m->x);
}

const loose_point *loose_choose(int type, const loose_point *const of[6]) {
    const pl_cell_shape *shape = pl_cell_type_of(type)->shape;
    return of[shape->n_corners == 3  ? 0
              : shape->dim == 2      ? 1
              : shape->n_corners < 8 ? shape->n_corners - 2
                                     : 5];
}

const loose_point *loose_ideal_corners(int type) {
    static const double TRIANGLE[][3] = {{0}, {1}, {0.5, 0.8660254037844386}};
    static const double QUADRILATERAL[][3] = {{0}, {1}, {1, 1}, {0, 1}};
    static const double TETRAHEDRON[][3] = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
    static const double HEXAHEDRON[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                           {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    static const double WEDGE[][3] = {{0, 0, 0}, {1, 0, 0}, {0.5, 0.8660254037844386, 0},
                                      {0, 0, 1}, {1, 0, 1}, {0.5, 0.8660254037844386, 1}};
    static const double PYRAMID[][3] = {{0}, {1}, {1, 1}, {0, 1}, {0.5, 0.5, 0.7071067811865476}};
    static const loose_point *const of[] = {TRIANGLE, QUADRILATERAL, TETRAHEDRON,
                                            PYRAMID,  WEDGE,         HEXAHEDRON};
    return loose_choose(type, of);
}

int32_t loose_cells_add(loose_cells *m, int type, double push, double bend, double side,
                        uint64_t *random) {
    const pl_cell_type *of = pl_cell_type_of(type);
    const int32_t first = (int32_t)m->n_nodes;
    double *x = m->x + m->n_nodes * m->dim;
    for (int i = 0; i < of->n_nodes; i++)
        for (int d = 0; d < m->dim; d++) {
            const double a = x[of->between[i][0] * m->dim + d],
                         b = x[of->between[i][1] * m->dim + d];
            const double off = 2 * random_unit(random) - 1;
            x[i * m->dim + d] =
                i < of->shape->n_corners
                    ? (d == 0 ? side : 1) * loose_ideal_corners(type)[i][d] + push * off
                    : (a + b) / 2 + bend * off;
        }
    for (int i = 0; i < of->n_nodes; i++)
        m->node[m->offset[m->cells.n] + i] = first + i;
    m->type[m->cells.n++] = (uint8_t)type;
    m->offset[m->cells.n] = m->offset[m->cells.n - 1] + of->n_nodes;
    m->n_nodes += of->n_nodes;
    return first;
}

void loose_cells_add_line(loose_cells *m) {
    m->node[m->offset[m->cells.n]] = 0;
    m->node[m->offset[m->cells.n] + 1] = 1;
    m->type[m->cells.n++] = PLANISH_CELL_LINE;
    m->offset[m->cells.n] = m->offset[m->cells.n - 1] + 2;
}

/** A mesh of elements of all types of dimension dim, valid and invalid, and lines. */
loose_cells loose_cells_mixed(int dim, int64_t n, uint64_t seed) {
    loose_cells m = loose_cells_create(dim);
    uint64_t random = effort_seed(seed);
    while (m.cells.n < n) {
        const int type = loose_types[random_below(&random, LOOSE_TYPES)];
        if (pl_cell_type_of(type)->shape->dim == dim) {
            const double bend = 0.1 * random_unit(&random), push = 0.7 * random_unit(&random);
            loose_cells_add(&m, type, push, bend, 1, &random);
        } else if (m.n_nodes > 1) {
            loose_cells_add_line(&m);
        }
    }
    return m;
}

planish_mesh loose_cells_mesh(const loose_cells *m) {
    return (planish_mesh){.dim = m->dim,
                          .n_nodes = m->n_nodes,
                          .n_elements = m->cells.n,
                          .coordinates = m->x,
                          .cells = &m->cells};
}

cell_values cell_values_make(int64_t n) {
    const size_t m = (size_t)n;
    cell_values v = {.n = n, .bytes = malloc(2 * m), .doubles = malloc(4 * m * sizeof(double))};
    faults_mark(v.bytes, 2 * m);
    faults_mark(v.doubles, 4 * m * sizeof(double));
    v.of = (planish_cell_values){.state = v.bytes,
                                 .is_curved = v.bytes + m,
                                 .aspect_ratio = v.doubles,
                                 .scaled_jacobian = v.doubles + m,
                                 .jacobian_ratio = v.doubles + 2 * m,
                                 .edge_ratio = v.doubles + 3 * m};
    return v;
}

void cell_values_destroy(cell_values *v) {
    free(v->bytes);
    free(v->doubles);
}

void cell_values_expect_same(const cell_values *a, const cell_values *b) {
    assert_memory_equal(a->bytes, b->bytes, 2 * (size_t)a->n);
    assert_memory_equal(a->doubles, b->doubles, 4 * (size_t)a->n * sizeof(double));
}
