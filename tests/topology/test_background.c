/* Tests of src/topology/background.c: points are found in boxes of all kinds, whatever the way to them. */
#include "topology/background.h"

#include "support/allocations.h"
#include "support/cell_meshes.h"
#include "support/effort.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 4 };

static pl_background background_of(const cell_box *box, int threads) {
    pl_background b;
    planish_error error;
    if (pl_background_create(&box->mesh, box->x, threads, &b, &error))
        fail_msg("%s", error.text);
    return b;
}

/** Squared distance of point from where weights of a simplex are; the weights are checked. */
static double distance(const pl_background *b, int32_t simplex, const double *weight,
                       const double *point) {
    double sum = 0, square = 0;
    for (int i = 0; i <= b->dim; i++) {
        assert_true(weight[i] >= 0);
        sum += weight[i];
    }
    assert_true(fabs(sum - 1) < 1e-14);
    for (int d = 0; d < b->dim; d++) {
        double x = -point[d];
        for (int i = 0; i <= b->dim; i++)
            x += weight[i] *
                 b->x[(int64_t)b->node[(int64_t)simplex * (b->dim + 1) + i] * b->dim + d] /
                 b->scale;
        square += x * x;
    }
    return sqrt(square);
}

/** Points inside are found from any simplex. */
static void points_inside_are_found(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, SIDE);
        cell_box_shake(box, 0.15, 7);
        pl_background b = background_of(box, 1);
        uint64_t seed = effort_seed((uint64_t)kind);
        for (int k = 0; k < 500; k++) {
            double point[3], weight[4];
            for (int d = 0; d < 3; d++)
                point[d] = random_between(&seed, 0, SIDE);
            int32_t at = (int32_t)random_below(&seed, b.n_simplices);
            pl_background_find(&b, point, &at, weight);
            assert_true(distance(&b, at, weight, point) < 1e-12);
        }
        pl_background_destroy(&b);
        cell_box_destroy(box);
    }
}

/** The simplices fill the box, each facet has a simplex at both sides or lies on the box, and each node is
 *  found at itself. */
static void simplices_fill_the_box(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int order = 1; order <= 2; order++) {
            cell_box *box = cell_box_create((cell_box_kind)kind, SIDE);
            if (order == 2) {
                cell_box *raised = cell_box_raise(box, 0);
                cell_box_destroy(box);
                box = raised;
            }
            pl_background b = background_of(box, 3);
            const int k = b.dim + 1;
            for (int64_t s = 0; s < b.n_simplices; s++)
                for (int j = 0; j < k; j++) {
                    int on_side = 0;
                    for (int d = 0; d < b.dim; d++) {
                        int low = 1, high = 1;
                        for (int i = 0; i < k; i++) {
                            const double x = box->x[(int64_t)b.node[s * k + i] * b.dim + d];
                            low &= i == j || x == 0;
                            high &= i == j || x == SIDE;
                        }
                        on_side |= low | high;
                    }
                    assert_int_equal(b.across[s * k + j] < 0, on_side);
                }
            for (int64_t i = 0; i < b.n_nodes; i++) {
                double weight[4];
                int32_t at = b.first[i];
                if (at < 0) {
                    assert_int_equal(order, 2); /* mids are of no simplex */
                    continue;
                }
                pl_background_find(&b, box->x + i * b.dim, &at, weight);
                assert_true(distance(&b, at, weight, box->x + i * b.dim) < 1e-13);
                assert_int_equal(at, b.first[i]);
            }
            pl_background_destroy(&b);
            cell_box_destroy(box);
        }
}

/** Outside the walk ends near the point: no farther than one cell from the nearest place. */
static void points_outside_are_come_near(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, SIDE);
        pl_background b = background_of(box, 1);
        uint64_t seed = effort_seed((uint64_t)kind + 100);
        for (int k = 0; k < 200; k++) {
            double point[3], weight[4], nearest = 0;
            for (int d = 0; d < 3; d++)
                point[d] = random_between(&seed, -1, SIDE + 1);
            for (int d = 0; d < b.dim; d++) {
                const double off = point[d] - fmin(fmax(point[d], 0), SIDE);
                nearest += off * off;
            }
            int32_t at = b.first[0];
            pl_background_find(&b, point, &at, weight);
            assert_true(distance(&b, at, weight, point) <= sqrt(nearest) + 1.5);
        }
        pl_background_destroy(&b);
        cell_box_destroy(box);
    }
}

/** Walks end in tangled and in flat meshes, and at every scale. */
static void walks_end(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int way = 0; way < 4; way++) {
            cell_box *box = cell_box_create((cell_box_kind)kind, SIDE);
            cell_box_shake(box, 1.5, 7);
            for (int64_t i = 0; i < box->mesh.n_nodes * box->mesh.dim; i++)
                box->x[i] *= way == 1 ? 0 : way == 2 ? 1e-300 : way == 3 ? 1e300 : 1;
            pl_background b = background_of(box, 1);
            for (int64_t i = 0; i < b.n_nodes; i++) {
                double weight[4], sum = 0;
                int32_t at = b.first[0];
                pl_background_find(&b, box->x + i * b.dim, &at, weight);
                for (int j = 0; j <= b.dim; j++)
                    sum += weight[j];
                assert_true(at >= 0 && at < b.n_simplices && fabs(sum - 1) < 1e-12);
            }
            pl_background_destroy(&b);
            cell_box_destroy(box);
        }
}

/** Simplices of a mesh without cells are themselves. */
static void simplices_are_themselves(void **state) {
    (void)state;
    cell_box *box = cell_box_create(BOX_QUADRILATERALS, 1);
    static const int32_t element[] = {0, 1, 3, 0, 3, 2};
    planish_mesh mesh = box->mesh;
    mesh.cells = NULL;
    mesh.elements = element;
    mesh.n_elements = 2;
    pl_background b;
    planish_error error;
    assert_int_equal(pl_background_create(&mesh, box->x, 1, &b, &error), 0);
    assert_int_equal(b.n_simplices, 2);
    assert_memory_equal(b.node, element, sizeof element);
    pl_background_destroy(&b);
    cell_box_destroy(box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_inside_are_found),      cmocka_unit_test(simplices_fill_the_box),
        cmocka_unit_test(points_outside_are_come_near), cmocka_unit_test(walks_end),
        cmocka_unit_test(simplices_are_themselves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
