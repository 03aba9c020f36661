/* Tests of src/topology/ordering.c. */
#include "topology/topology.h"

#include "support/allocations.h"
#include "support/meshes.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

static int32_t *order_of(const planish_mesh *mesh, int threads) {
    int32_t *order = malloc((size_t)mesh->n_nodes * sizeof *order);
    assert_non_null(order);
    assert_int_equal(pl_curve_order(mesh, threads, order, NULL), PLANISH_OK);
    return order;
}

static void check_permutation(const int32_t *order, int64_t n) {
    uint8_t *seen = calloc((size_t)n, 1);
    assert_non_null(seen);
    for (int64_t i = 0; i < n; i++) {
        assert_true(order[i] >= 0 && order[i] < n);
        assert_false(seen[order[i]]++);
    }
    free(seen);
}

/** What makes the curve Hilbert's: on a lattice of 2^k points a side it goes to a neighbour at
 *  every step, and visits the octants (quadrants) of every level one after the other. */
static void walks_through_lattices(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 15);
        test_mesh_renumber(&box, 4, NULL);
        int64_t n = box.mesh.n_nodes;
        int32_t *order = order_of(&box.mesh, 1);
        check_permutation(order, n);
        for (int64_t i = 1; i < n; i++) {
            double steps = 0;
            const double *x = box.coordinates + order[i] * dim;
            const double *y = box.coordinates + order[i - 1] * dim;
            for (int d = 0; d < dim; d++)
                steps += fabs(x[d] - y[d]);
            assert_true(steps == 1);
        }
        for (int64_t half = 8, run = n >> dim; half >= 1; half /= 2, run >>= dim)
            for (int64_t i = 0; i < n; i++)
                for (int d = 0; d < dim; d++) {
                    double first = box.coordinates[order[i / run * run] * dim + d];
                    double here = box.coordinates[order[i] * dim + d];
                    assert_true(floor(first / (double)half) == floor(here / (double)half));
                }
        free(order);
        test_mesh_destroy(&box);
    }
}

/** Positions inside the box are all that matters: not its scale, however extreme. */
static void does_not_see_the_scale(void **state) {
    (void)state;
    const double scales[] = {0x1p-1000, 0x1p-300, 0x1p300, 0x1p1021};
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 8);
        test_mesh_perturb(&box, 0.3, 6);
        test_mesh_transform(&box, 1, -4); /* so that differences overflow before coordinates do */
        int32_t *order = order_of(&box.mesh, 1);
        for (int i = 0; i < 4; i++) {
            test_mesh_transform(&box, scales[i], 0);
            int32_t *scaled = order_of(&box.mesh, 1);
            assert_memory_equal(order, scaled, (size_t)box.mesh.n_nodes * sizeof *order);
            free(scaled);
            test_mesh_transform(&box, 1 / scales[i], 0);
        }
        free(order);
        test_mesh_destroy(&box);
    }
}

/** Coordinates at both ends of the range, denormal numbers, and all nodes in one place. */
static void survives_extremes(void **state) {
    (void)state;
    const int32_t triangle[] = {0, 1, 2};
    const double meshes[][8] = {
        {-1.7e308, -1.7e308, 1.7e308, -1.7e308, 1.7e308, 1.7e308, 0, 0},
        {5e-324, 0, 0, 5e-324, 0, 0, 1e-323, 0},
        {1, 1, 1, 1, 1, 1, 1, 1},
        {1e300, -1e300, 1e-300, 1e-300, 0, 1e300, -1e-300, 0},
    };
    for (int i = 0; i < 4; i++) {
        test_mesh mesh;
        test_mesh_create(&mesh, 2, 4, meshes[i], 1, triangle);
        int32_t *order = order_of(&mesh.mesh, 1);
        check_permutation(order, 4);
        free(order);
        test_mesh_destroy(&mesh);
    }
}

/** Ties are in the order of the numbers; threads make no difference. */
static void is_stable_on_any_threads(void **state) {
    (void)state;
    test_mesh mesh;
    test_mesh_garbage(&mesh, 3, 40000, 1, 8);
    for (int64_t i = 0; i < 3 * mesh.mesh.n_nodes; i++)
        mesh.coordinates[i] = floor(8 * mesh.coordinates[i]);
    int32_t *order = order_of(&mesh.mesh, 1);
    check_permutation(order, mesh.mesh.n_nodes);
    for (int64_t i = 1; i < mesh.mesh.n_nodes; i++) {
        const double *x = mesh.coordinates + order[i] * 3, *y = mesh.coordinates + order[i - 1] * 3;
        if (memcmp(x, y, 3 * sizeof *x) == 0)
            assert_true(order[i] > order[i - 1]);
    }
    for (int threads = 2; threads <= 5; threads++) {
        int32_t *other = order_of(&mesh.mesh, threads);
        assert_memory_equal(order, other, (size_t)mesh.mesh.n_nodes * sizeof *order);
        free(other);
    }
    free(order);
    test_mesh_destroy(&mesh);
}

static void survives_without_memory(void **state) {
    (void)state;
    int32_t order[27];
    test_mesh mesh;
    test_mesh_box(&mesh, 3, 2);
    int status = PLANISH_ERROR_MEMORY, permitted = 0;
    for (; status; permitted++) {
        allocations_permit(permitted);
        status = pl_curve_order(&mesh.mesh, 2, order, NULL);
        allocations_permit(-1);
        assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
    }
    assert_true(permitted > 4);
    test_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walks_through_lattices),  cmocka_unit_test(does_not_see_the_scale),
        cmocka_unit_test(survives_extremes),       cmocka_unit_test(is_stable_on_any_threads),
        cmocka_unit_test(survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
