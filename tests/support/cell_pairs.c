/* cell_pairs: see cell_pairs.h. */
#include "support/cell_pairs.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MOST_MIDS = 6, MOST_NODES = 8 };

static const uint8_t EDGES[MOST_MIDS][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

void *cell_pair_zeroed(int64_t n, size_t size) {
    void *array = calloc((size_t)n + 1, size);
    assert_non_null(array);
    return array;
}

double *cell_pair_place(const cell_pair *p, int64_t node, int d) {
    const int64_t step = p->mesh.node_stride ? p->mesh.node_stride : p->mesh.dim;
    const int64_t apart = p->mesh.component_stride ? p->mesh.component_stride : 1;
    return p->x + node * step + d * apart;
}

void cell_pair_append(cell_pair *p, int type, const int32_t *node, int n) {
    const int64_t i = p->cells.n++;
    p->type[i] = (uint8_t)type;
    memcpy(p->node + p->offset[i], node, (size_t)n * sizeof *node);
    p->offset[i + 1] = p->offset[i] + n;
}

/** The mid of an edge: a new node, unless mid_of [n][n] has it. */
static int32_t mid_of_edge(cell_pair *p, int32_t *mid_of, int32_t a, int32_t b) {
    const int64_t n = p->plain.n_nodes;
    int32_t *mid = &mid_of[a < b ? a * n + b : b * n + a];
    if (!*mid) {
        *mid = (int32_t)p->mesh.n_nodes++;
        p->end[*mid][0] = a;
        p->end[*mid][1] = b;
    }
    return *mid;
}

static void append_simplex(cell_pair *p, int64_t element, int is_quadratic, int32_t *mid_of) {
    const int k = p->plain.dim + 1, n_mids = is_quadratic ? 3 * (k - 2) : 0;
    int32_t node[10];
    memcpy(node, p->plain.elements + element * k, (size_t)k * sizeof *node);
    for (int e = 0; e < n_mids; e++)
        node[k + e] = mid_of_edge(p, mid_of, node[EDGES[e][0]], node[EDGES[e][1]]);
    p->cell_of[element] = p->cells.n;
    cell_pair_append(p, is_quadratic ? (k == 4 ? 24 : 22) : (k == 4 ? 10 : 5), node, k + n_mids);
}

/** Append elements that are not smoothed: apart, with a node twice or of another dimension, and at the
 *  corners of an element. */
static void append_others(cell_pair *p, int64_t element) {
    const int k = p->plain.dim + 1, n = k == 4 ? 8 : 4;
    int32_t apart[MOST_NODES], collapsed[MOST_NODES];
    const int32_t *corner = p->plain.elements + element * k;
    for (int j = 0; j < n; j++)
        apart[j] = (int32_t)p->mesh.n_nodes++;
    memcpy(collapsed, apart, sizeof collapsed);
    collapsed[n - 1] = collapsed[n - 2];
    cell_pair_append(p, k == 4 ? 12 : 9, collapsed, n);
    cell_pair_append(p, k == 4 ? 5 : 10, k == 4 ? apart + 5 : apart, k == 4 ? 3 : 4);
    if (element % 3 == 0)
        cell_pair_append(p, 3, corner, 2);
    if (element % 5 == 0)
        cell_pair_append(p, 1, corner + 2, 1);
    for (int j = 0; j < 3; j++)
        if ((element % 3 == 0 && j < 2) || (element % 5 == 0 && j == 2))
            p->constraint[corner[j]] = PLANISH_CONSTRAINT_FIXED;
}

/** Place the nodes: those apart are at corners of the box. */
static void place_nodes(cell_pair *p, int how) {
    const int dim = p->plain.dim;
    const double *x = p->plain.coordinates;
    p->x = cell_pair_zeroed((p->mesh.n_nodes + 1) * dim, sizeof *p->x);
    if (how & PAIR_BY_COMPONENT) {
        p->mesh.node_stride = 1;
        p->mesh.component_stride = p->mesh.n_nodes;
    }
    for (int64_t i = 0; i < p->mesh.n_nodes; i++)
        for (int d = 0; d < dim; d++)
            *cell_pair_place(p, i, d) =
                i < p->plain.n_nodes ? x[i * dim + d]
                : p->end[i][0] < 0   ? x[d]
                                     : (x[p->end[i][0] * dim + d] + x[p->end[i][1] * dim + d]) / 2;
    p->mesh.coordinates = p->x;
}

cell_pair cell_pair_of(const test_mesh *simplices, int how) {
    const planish_mesh *plain = &simplices->mesh;
    const int64_t n = plain->n_nodes, m = plain->n_elements;
    cell_pair p = {.plain = *plain, .mesh = *plain};
    int32_t *mid_of = cell_pair_zeroed(n * n, sizeof *mid_of);
    const int64_t most = n + m * (MOST_MIDS + MOST_NODES);
    p.type = cell_pair_zeroed(5 * m, 1);
    p.offset = cell_pair_zeroed(5 * m, sizeof *p.offset);
    p.node = cell_pair_zeroed(30 * m, sizeof *p.node);
    p.cell_of = cell_pair_zeroed(m, sizeof *p.cell_of);
    p.constraint = cell_pair_zeroed(n, 1);
    p.end = cell_pair_zeroed(most, sizeof *p.end);
    memset(p.end, -1, (size_t)most * sizeof *p.end);
    for (int64_t i = 0; i < m; i++) {
        if ((how & PAIR_OTHERS) && i % (m / 7) == 1)
            append_others(&p, i);
        append_simplex(&p, i, (how & PAIR_ORDER_2) && !(how & PAIR_HALF && i % 2), mid_of);
    }
    free(mid_of);
    place_nodes(&p, how);
    p.cells.type = p.type;
    p.cells.offset = p.offset;
    p.cells.node = p.node;
    p.mesh.elements = NULL;
    p.mesh.n_elements = p.cells.n;
    p.plain.constraint = p.constraint;
    return p;
}

void cell_pair_fasten(cell_pair *p) {
    p->mesh.cells = &p->cells;
}

void cell_pair_release(cell_pair *p) {
    free(p->type);
    free(p->offset);
    free(p->node);
    free(p->x);
    free(p->cell_of);
    free(p->constraint);
    free(p->end);
}

void *cell_pair_by_cells(const cell_pair *p, const void *plain, size_t size) {
    char *of_cell = cell_pair_zeroed(p->cells.n, size);
    memset(of_cell, 0x7f, (size_t)p->cells.n * size); /* NaN as double */
    memset(of_cell, 0xff, size);
    for (int64_t i = 0; i < p->plain.n_elements; i++)
        memcpy(of_cell + (size_t)p->cell_of[i] * size, (const char *)plain + (size_t)i * size,
               size);
    return of_cell;
}

planish_options cell_pair_options(void) {
    planish_options options;
    planish_options_init(&options);
    options.threads = 2;
    options.max_sweeps = 6;
    return options;
}

test_mesh cell_pair_box(int dim, int cells, double shake) {
    test_mesh box;
    test_mesh_box(&box, dim, cells);
    test_mesh_perturb(&box, shake, 5);
    test_mesh_renumber(&box, 7, NULL);
    return box;
}

void cell_pair_slide(cell_pair *p, const planish_surface *surface,
                     const planish_surface *of_cells) {
    const int64_t n = p->plain.n_nodes, n_all = p->mesh.n_nodes, dim = p->plain.dim;
    uint8_t *constraint = cell_pair_zeroed(n, 1), *by_cells = cell_pair_zeroed(n_all, 1);
    double *direction = cell_pair_zeroed(n * dim, sizeof *direction);
    double *direction_by_cells = cell_pair_zeroed(n_all * dim, sizeof *direction);
    planish_slide_info info[2];
    assert_int_equal(
        planish_find_slides(&p->plain, surface, 1, constraint, direction, &info[0], NULL), 0);
    assert_int_equal(
        planish_find_slides(&p->mesh, of_cells, 2, by_cells, direction_by_cells, &info[1], NULL),
        0);
    assert_memory_equal(constraint, by_cells, (size_t)n);
    for (int64_t i = n; i < n_all; i++)
        assert_true(by_cells[i] == PLANISH_CONSTRAINT_FREE ||
                    (p->end[i][0] < 0 && by_cells[i] == PLANISH_CONSTRAINT_FIXED));
    assert_memory_equal(&info[0], &info[1], sizeof info[0]);
    memcpy(p->constraint, constraint, (size_t)n);
    free(constraint);
    p->plain.direction = direction;
    p->mesh.constraint = by_cells;
    p->mesh.direction = direction_by_cells;
}

void cell_pair_stop_sliding(cell_pair *p) {
    free((void *)p->plain.direction);
    free((void *)p->mesh.constraint);
    free((void *)p->mesh.direction);
}

void cell_pair_make_periodic(cell_pair *p, double size, int64_t most) {
    const int64_t n = p->mesh.n_nodes;
    int32_t *list = cell_pair_zeroed(2 * n, sizeof *list);
    int64_t n_plain = 0, n_all = 0;
    for (int64_t i = 0; i < n; i++)
        for (int64_t k = 0; k < n && *cell_pair_place(p, i, 0) == 0; k++) {
            double off = fabs(*cell_pair_place(p, k, 0) - size);
            for (int d = 1; d < p->mesh.dim; d++)
                off += fabs(*cell_pair_place(p, k, d) - *cell_pair_place(p, i, d));
            if (off > 0 || (i < p->plain.n_nodes) != (k < p->plain.n_nodes) ||
                (i < p->plain.n_nodes && n_plain == most))
                continue;
            list[2 * n_all] = (int32_t)i;
            list[2 * n_all++ + 1] = (int32_t)k;
            n_plain += i < p->plain.n_nodes;
        }
    p->plain.periodic = p->mesh.periodic = list; /* corners come first */
    p->plain.n_periodic = n_plain;
    p->mesh.n_periodic = n_all;
}
