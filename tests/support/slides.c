#include "support/slides.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

slides_found slides_find_on(const planish_mesh *mesh, const planish_surface *surface, int threads) {
    slides_found f;
    planish_error error = {.text = ""};
    f.constraint = malloc((size_t)mesh->n_nodes);
    f.direction = malloc((size_t)(mesh->n_nodes * mesh->dim) * sizeof(double));
    assert_int_equal(
        planish_find_slides(mesh, surface, threads, f.constraint, f.direction, &f.info, &error), 0);
    return f;
}

slides_found slides_find(const planish_mesh *mesh, const planish_surface *surface) {
    return slides_find_on(mesh, surface, 1);
}

void slides_release(slides_found *f) {
    free(f->constraint);
    free(f->direction);
}

int slides_is_side(double x) {
    return x == 0 || x == SLIDES_CELLS;
}

int64_t slides_node_at(const planish_mesh *mesh, double x, double y, double z) {
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        if (mesh->coordinates[3 * i] == x && mesh->coordinates[3 * i + 1] == y &&
            mesh->coordinates[3 * i + 2] == z)
            return i;
    fail_msg("no node at %g %g %g", x, y, z);
    return -1;
}

void slides_expect_axis(const double *direction, int dim, int axis) {
    for (int d = 0; d < dim; d++)
        assert_true(d == axis ? fabs(direction[d]) == 1 : direction[d] == 0);
}

void slides_expect_node(const slides_found *f, int64_t i, int dim, const int *crosses) {
    int n = 0, axis = 0, rest = 0;
    for (int d = 0; d < dim; d++) {
        n += crosses[d];
        axis = crosses[d] ? d : axis;
        rest = crosses[d] ? rest : d;
    }
    if (n == 0) {
        assert_int_equal(f->constraint[i], PLANISH_CONSTRAINT_FREE);
    } else if (n == dim) {
        assert_int_equal(f->constraint[i], PLANISH_CONSTRAINT_FIXED);
    } else if (n == dim - 1) {
        assert_int_equal(f->constraint[i], PLANISH_CONSTRAINT_ON_LINE);
        slides_expect_axis(f->direction + i * dim, dim, rest);
    } else {
        assert_int_equal(f->constraint[i], PLANISH_CONSTRAINT_ON_PLANE);
        slides_expect_axis(f->direction + i * dim, dim, axis);
    }
}

void slides_expect_sides(const planish_mesh *mesh, const slides_found *f,
                         int (*is_held)(const double *x)) {
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const double *x = mesh->coordinates + 3 * i;
        const int all = is_held && is_held(x);
        const int crosses[3] = {all || slides_is_side(x[0]), all || slides_is_side(x[1]),
                                all || slides_is_side(x[2])};
        slides_expect_node(f, i, 3, crosses);
    }
}
