/* barrel: a solid with a curved surface, of tetrahedra. */
#include "support/barrel.h"

#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

/** Make the square [-1, 1]^2 a disc, the wider the nearer it is to the middle. */
static void make_round(double *x) {
    const double a = 2 * x[0] / BARREL_CELLS - 1, b = 2 * x[1] / BARREL_CELLS - 1,
                 c = 2 * x[2] / BARREL_CELLS - 1;
    const double radius = 1.2 - 0.2 * c * c;
    x[0] = radius * a * sqrt(1 - b * b / 2);
    x[1] = radius * b * sqrt(1 - a * a / 2);
    x[2] = c + 1;
}

void barrel_create(barrel *m, int threads) {
    *m = (barrel){.shape = NULL};
    test_mesh_box(&m->base, 3, BARREL_CELLS);
    test_mesh_perturb(&m->base, 0.1, 3);
    for (int64_t i = 0; i < m->base.mesh.n_nodes; i++)
        make_round(m->base.coordinates + 3 * i);
    m->mesh = m->base.mesh;
    assert_int_equal(planish_shape_create(&m->mesh, NULL, 1, &m->shape, &m->info, NULL), 0);
    m->constraint = calloc((size_t)m->mesh.n_nodes, 1);
    m->direction = calloc((size_t)m->mesh.n_nodes * 3, sizeof *m->direction);
    const planish_surface surface = {.shape = m->shape};
    assert_int_equal(
        planish_find_slides(&m->mesh, &surface, 1, m->constraint, m->direction, &m->slides, NULL),
        0);
    m->mesh.constraint = m->constraint;
    m->mesh.direction = m->direction;
    m->options = test_options(threads);
    m->options.shape = m->shape;
}

void barrel_destroy(barrel *m) {
    planish_shape_destroy(m->shape);
    free(m->constraint);
    free(m->direction);
    test_mesh_destroy(&m->base);
}
