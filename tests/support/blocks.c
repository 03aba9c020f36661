#include "support/blocks.h"

#include "support/effort.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- forms ----------------------------------------------------------------------------------- */

/** Take a point of the cube -1 .. 1 to a form, times a size. */
static void to_form(block_form f, double size, double x[3]) {
    const double u = x[0] * x[0], v = x[1] * x[1], w = x[2] * x[2];
    if (f == BLOCK_BALL) {
        x[0] *= sqrt(1 - v / 2 - w / 2 + v * w / 3);
        x[1] *= sqrt(1 - w / 2 - u / 2 + w * u / 3);
        x[2] *= sqrt(1 - u / 2 - v / 2 + u * v / 3);
    } else if (f == BLOCK_CYLINDER) {
        x[0] *= sqrt(1 - v / 2);
        x[1] *= sqrt(1 - u / 2);
    }
    for (int d = 0; d < 3; d++)
        x[d] *= size;
}

/* ---- other surfaces -------------------------------------------------------------------------- */

/** Return the number of the node at at[3], which is made if there is none. */
static int32_t node_at(block_target *s, int32_t *number, int n, const int at[3]) {
    int32_t *of = &number[(at[0] * (n + 1) + at[1]) * (n + 1) + at[2]];
    if (*of >= 0)
        return *of;
    for (int d = 0; d < 3; d++)
        s->x[3 * s->mesh.n_nodes + d] = 2. * at[d] / n - 1;
    return *of = (int32_t)s->mesh.n_nodes++;
}

/** Add the squares of a side, each as two triangles. */
static void add_face(block_target *s, int32_t *number, int n, int axis, int side, int is_turned) {
    for (int i = 0; i < n * n; i++) {
        int32_t v[4];
        for (int k = 0; k < 4; k++) {
            int at[3];
            at[axis] = side * n;
            at[(axis + 1) % 3] = i / n + (k == 1 || k == 2);
            at[(axis + 2) % 3] = i % n + (k >= 2);
            v[k] = node_at(s, number, n, at);
        }
        const int turn = (side == 0) != is_turned;
        for (int k = 0; k < 2; k++) {
            int32_t *to = s->node + 3 * s->cells.n++;
            to[0] = v[0];
            to[1 + turn] = v[1 + k];
            to[2 - turn] = v[2 + k];
        }
    }
}

/** Take the nodes of a surface to a form, and make its shape. */
static void finish(block_form f, double size, block_target *s) {
    for (int64_t i = 0; i < s->mesh.n_nodes; i++)
        to_form(f, size, s->x + 3 * i);
    s->cells.type = s->type;
    s->cells.offset = s->offset;
    s->cells.node = s->node;
    s->mesh.dim = 3;
    s->mesh.coordinates = s->x;
    s->mesh.cells = &s->cells;
    s->mesh.n_elements = s->cells.n;
    assert_int_equal(planish_shape_create(&s->mesh, NULL, 1, &s->shape, NULL, NULL), 0);
}

void block_target_create(block_form f, int n, double size, int is_turned, block_target *s) {
    const size_t most = (size_t)(12 * n * n), grid = (size_t)((n + 1) * (n + 1) * (n + 1));
    int32_t *number = malloc(grid * sizeof *number);
    memset(number, -1, grid * sizeof *number);
    *s = (block_target){.x = malloc(most * 3 * sizeof *s->x),
                        .node = malloc(most * 3 * sizeof *s->node),
                        .offset = malloc((most + 1) * sizeof *s->offset),
                        .type = malloc(most)};
    for (int side = 0; side < 6; side++)
        add_face(s, number, n, side / 2, side % 2, is_turned);
    free(number);
    memset(s->type, PLANISH_CELL_TRIANGLE, most);
    for (int64_t i = 0; i <= s->cells.n; i++)
        s->offset[i] = 3 * i;
    finish(f, size, s);
}

void block_target_place(block_target *s, const double stretch[3], const double shift[3]) {
    for (int64_t i = 0; i < 3 * s->mesh.n_nodes; i++)
        s->x[i] = s->x[i] * stretch[i % 3] + shift[i % 3];
    planish_shape_destroy(s->shape);
    assert_int_equal(planish_shape_create(&s->mesh, NULL, 1, &s->shape, NULL, NULL), 0);
}

void block_target_destroy(block_target *s) {
    planish_shape_destroy(s->shape);
    free(s->x);
    free(s->node);
    free(s->offset);
    free(s->type);
}

void block_target_create_curved(block_form f, double size, block_target *s) {
    int32_t number[27];
    memset(number, -1, sizeof number);
    block_target_create(BLOCK_CUBE, 1, 1, 0, s);
    block_target straight = *s;
    *s = (block_target){.x = malloc(26 * 3 * sizeof *s->x),
                        .node = malloc(12 * 6 * sizeof *s->node),
                        .offset = malloc(13 * sizeof *s->offset),
                        .type = malloc(12)};
    for (int i = 0; i < 12 * 6; i++) {
        const int32_t *corner = straight.node + i / 6 * 3;
        int at[3];
        for (int d = 0; d < 3; d++) {
            const double a = straight.x[3 * corner[i % 3] + d];
            const double b = straight.x[3 * corner[(i + 1) % 3] + d];
            at[d] = (int)(i % 6 < 3 ? a + 1 : (a + b) / 2 + 1);
        }
        s->node[i] = node_at(s, number, 2, at);
    }
    block_target_destroy(&straight);
    memset(s->type, PLANISH_CELL_TRIANGLE6, 12);
    for (int i = 0; i <= 12; i++)
        s->offset[i] = 6 * (int64_t)i;
    s->cells.n = 12;
    finish(f, size, s);
}

/* ---- blocks ---------------------------------------------------------------------------------- */

/** Split a hexahedron into six tetrahedra. */
static void split(const int32_t *hex, int32_t *to) {
    static const int8_t ROUND[7] = {1, 2, 3, 7, 4, 5, 1};
    for (int i = 0; i < 6; i++) {
        const int32_t tetrahedron[4] = {hex[0], hex[ROUND[i]], hex[ROUND[i + 1]], hex[6]};
        memcpy(to + 4 * i, tetrahedron, sizeof tetrahedron);
    }
}

static int is_at_surface(const double *x, int n) {
    int any = 0;
    for (int d = 0; d < 3; d++)
        any |= x[d] == 0 || x[d] == n;
    return any;
}

void block_create(int is_tets, cell_box_kind kind, block_form f, int n, double size, double shake,
                  uint64_t *state, block *b) {
    *b = (block){.box = cell_box_create(is_tets ? BOX_HEXAHEDRA : kind, n)};
    b->mesh = b->box->mesh;
    for (int64_t i = 0; i < b->mesh.n_nodes; i++) {
        double *x = b->box->x + 3 * i;
        const int is_shaken = is_at_surface(x, n);
        for (int d = 0; d < 3; d++)
            x[d] = 2 * x[d] / n - 1;
        to_form(f, size, x);
        for (int d = 0; d < 3; d++)
            x[d] += is_shaken * shake * size * 2 / n * random_between(state, -1, 1);
    }
    if (is_tets) {
        const planish_cells *cells = b->mesh.cells;
        b->tetrahedron = malloc((size_t)cells->n * 24 * sizeof *b->tetrahedron);
        for (int64_t i = 0; i < cells->n; i++)
            split(cells->node + cells->offset[i], b->tetrahedron + 24 * i);
        b->mesh.cells = NULL;
        b->mesh.elements = b->tetrahedron;
        b->mesh.n_elements = 6 * cells->n;
    }
    b->given = test_copy_of(&b->mesh);
    assert_int_equal(planish_shape_create(&b->mesh, NULL, 1, &b->shape, NULL, NULL), 0);
}

void block_stretch(block *b, const double stretch[3]) {
    for (int64_t i = 0; i < 3 * b->mesh.n_nodes; i++)
        b->box->x[i] = b->given[i] *= stretch[i % 3];
    planish_shape_destroy(b->shape);
    assert_int_equal(planish_shape_create(&b->mesh, NULL, 1, &b->shape, NULL, NULL), 0);
}

void block_destroy(block *b) {
    planish_shape_destroy(b->shape);
    cell_box_destroy(b->box);
    free(b->tetrahedron);
    free(b->given);
}
