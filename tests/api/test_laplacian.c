/* The Laplacian methods, beside which planish is measured. */
#include "support/both.h"
#include "support/effort.h"
#include "support/meshes.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- the rivals ---------------------------------------------------------------------------- */

/** The mean that the method moves the node to, from the facets of its elements; node 0 is the
 *  centre, first in every element. */
static void expected_mean(const planish_mesh *mesh, planish_method method, double *to) {
    const int dim = mesh->dim;
    const double *x = mesh->coordinates;
    double weights = 0;
    for (int d = 0; d < dim; d++)
        to[d] = 0;
    for (int64_t i = 1; i < mesh->n_nodes && method != PLANISH_METHOD_AREA_LAPLACIAN; i++) {
        double length = test_distance(x, x + i * dim, dim);
        double weight = method == PLANISH_METHOD_LENGTH_LAPLACIAN ? length : 1;
        weights += weight;
        for (int d = 0; d < dim; d++)
            to[d] += weight * x[i * dim + d];
    }
    for (int64_t i = 0; i < mesh->n_elements && method == PLANISH_METHOD_AREA_LAPLACIAN; i++) {
        double weight = test_measure_of(mesh, x, i);
        weights += weight;
        for (int d = 0; d < dim; d++)
            for (int j = 0; j <= dim; j++)
                to[d] += weight * x[mesh->elements[i * (dim + 1) + j] * dim + d] / (dim + 1);
    }
    for (int d = 0; d < dim; d++)
        to[d] /= weights;
}

/** A node in an uneven square, or octahedron. */
static void one_star(test_mesh *mesh, int dim) {
    static const double square[] = {0.3, -0.2, 2, 0, 0, 1, -1, 0, 0, -3};
    static const int32_t triangles[] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1};
    static const double octahedron[] = {0.2, 0.1, -0.1, 2, 0, 0, 0, 1, 0, -1, 0,
                                        0,   0,   -3,   0, 0, 0, 1, 0, 0, -2};
    static const int32_t tetrahedra[] = {0, 1, 2, 5, 0, 2, 3, 5, 0, 3, 4, 5, 0, 4, 1, 5,
                                         0, 2, 1, 6, 0, 3, 2, 6, 0, 4, 3, 6, 0, 1, 4, 6};
    if (dim == 3)
        test_mesh_create(mesh, 3, 7, octahedron, 8, tetrahedra);
    else
        test_mesh_create(mesh, 2, 5, square, 4, triangles);
}

static void averages_are_those_that_they_are_called(void **state) {
    int dim = *(int *)*state;
    for (int method = 1; method < 4; method++) {
        test_mesh mesh;
        test_run s;
        double to[3];
        one_star(&mesh, dim);
        planish_options options = test_options(1);
        options.method = (planish_method)method;
        options.max_sweeps = 1;
        expected_mean(&mesh.mesh, options.method, to);
        s = test_smooth(&mesh.mesh, &options);
        assert_int_equal(s.result.n_moved_nodes, 1);
        for (int d = 0; d < dim; d++)
            assert_true(fabs(s.coordinates[d] - to[d]) < 1e-14);
        free(s.coordinates);
        test_mesh_destroy(&mesh);
    }
}

/** The plain mean by numbers that need no code. */
static void the_plain_mean_is_known(void **state) {
    (void)state;
    test_mesh mesh;
    test_run s;
    one_star(&mesh, 2);
    planish_options options = test_options(1);
    options.method = PLANISH_METHOD_LAPLACIAN;
    s = test_smooth(&mesh.mesh, &options);
    assert_true(fabs(s.coordinates[0] - 0.25) < 1e-15 && fabs(s.coordinates[1] + 0.5) < 1e-15);
    assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

static void averages_converge_on_convex_boxes(void **state) {
    int dim = *(int *)*state;
    for (int method = 1; method < 4; method++) {
        test_mesh mesh;
        test_run s;
        test_bad_box(&mesh, dim, 5, 1);
        planish_options options = test_options(1);
        options.method = (planish_method)method;
        s = test_smooth(&mesh.mesh, &options);
        assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
        assert_int_equal(s.after.n_inverted, 0);
        assert_true(s.after.rms_radius_ratio < s.before.rms_radius_ratio);
        free(s.coordinates);
        test_mesh_destroy(&mesh);
    }
}

/** The mean of an L's corners is outside of it. */
static void averages_invert_at_reentrant_corners(void **state) {
    (void)state;
    static const double corners[] = {0.5, 0.5, 0, 0, 10, 0, 10, 1, 1, 1, 1, 10, 0, 10};
    static const int32_t triangles[] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 0, 5, 6, 0, 6, 1};
    test_mesh mesh;
    test_run s;
    test_mesh_create(&mesh, 2, 7, corners, 6, triangles);
    planish_options options = test_options(1);
    options.method = PLANISH_METHOD_LAPLACIAN;
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.before.n_inverted, 0);
    assert_int_equal(s.after.n_inverted, 2);
    assert_true(fabs(s.coordinates[0] - 22.0 / 6) < 1e-14);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(averages_are_those_that_they_are_called),
        cmocka_unit_test(the_plain_mean_is_known),
        BOTH(averages_converge_on_convex_boxes),
        cmocka_unit_test(averages_invert_at_reentrant_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
