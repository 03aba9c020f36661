/* Tests of src/topology/ordering.c. */
#include "topology/frame.h"
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

/** A node and its key, level by level as Hamilton's algorithm 2 has it. */
typedef struct keyed {
    uint64_t key;
    int32_t node;
} keyed;

static unsigned rotate(unsigned bits, int left, int dim) {
    left = (left % dim + dim) % dim;
    return (bits << left | bits >> (dim - left)) & ((1u << dim) - 1);
}

static uint64_t reference_key(int dim, const uint32_t *place) {
    const int levels = dim == 3 ? 21 : 31;
    unsigned entry = 0;
    int direction = 0;
    uint64_t key = 0;
    for (int level = levels - 1; level >= 0; level--) {
        unsigned cell = 0, w = 0;
        for (int d = 0; d < dim; d++)
            cell |= (place[d] >> level & 1) << d;
        const unsigned gray = rotate(cell ^ entry, -(direction + 1), dim);
        while ((w ^ w >> 1) != gray)
            w++;
        const unsigned before = w ? (w - 1) / 2 * 2 : 0;
        entry ^= rotate(before ^ before >> 1, direction + 1, dim);
        int ones = 0; /* trailing ones of w, or of w - 1 if w is even */
        for (unsigned u = w % 2 || !w ? w : w - 1; u & 1; u >>= 1)
            ones++;
        direction = (direction + ones % dim + 1) % dim;
        key = key << dim | w;
    }
    return key;
}

static int compare_keyed(const void *a, const void *b) {
    const keyed *p = a, *q = b;
    return p->key != q->key ? (p->key > q->key) - (p->key < q->key)
                            : (p->node > q->node) - (p->node < q->node);
}

/** Nodes are in the order of their keys; of those with the same key, of their numbers. */
static void check_against_reference(const planish_mesh *mesh) {
    const int dim = mesh->dim;
    const double cells = dim == 3 ? 0x1p21 : 0x1p31;
    keyed *expected = malloc((size_t)mesh->n_nodes * sizeof *expected);
    pl_frame frame;
    assert_non_null(expected);
    assert_int_equal(pl_frame_create(mesh, NULL, 1, &frame, NULL), PLANISH_OK);
    for (int32_t i = 0; i < mesh->n_nodes; i++) {
        uint32_t place[3];
        for (int d = 0; d < dim; d++)
            place[d] = (uint32_t)(cells * pl_frame_difference(
                                              &frame, mesh->coordinates[(int64_t)i * dim + d],
                                              frame.low[d]));
        expected[i] = (keyed){reference_key(dim, place), i};
    }
    qsort(expected, (size_t)mesh->n_nodes, sizeof *expected, compare_keyed);
    for (int threads = 1; threads <= 3; threads++) {
        int32_t *order = order_of(mesh, threads);
        for (int64_t i = 0; i < mesh->n_nodes; i++)
            assert_int_equal(order[i], expected[i].node);
        free(order);
    }
    free(expected);
}

/** Move the nodes together, so many each time, every second one of them to the same place. */
static void make_clusters(const planish_mesh *mesh, double *coordinates, int64_t size) {
    const int dim = mesh->dim;
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const int64_t cluster = i / size;
        const double *first = coordinates + cluster * size * dim;
        const int64_t centre[3] = {cluster % 8, cluster / 8 % 64, cluster / 512};
        for (int d = 0; d < dim; d++) {
            double *x = &coordinates[i * dim + d];
            *x = i % 2 ? first[d] : (double)centre[d] + 1e-5 * *x;
        }
    }
}

/** Nodes spread evenly; graded towards a corner, so that leading digits leave few or many together;
 *  clusters of a few nodes, of more, and of all; few nodes. */
static void sorts_by_keys(void **state) {
    (void)state;
    const struct {
        int64_t n, cluster;
        double power;
    } cases[] = {{20000, 0, 1},  {20000, 0, 4},  {20000, 0, 8},     {20000, 0, 16},
                 {10000, 20, 1}, {20000, 40, 1}, {20000, 20000, 1}, {5, 0, 1}};
    for (int dim = 2; dim <= 3; dim++)
        for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
            test_mesh mesh;
            test_mesh_garbage(&mesh, dim, cases[c].n, 1, 3 + (unsigned)c);
            for (int64_t i = 0; i < cases[c].n * dim; i++)
                mesh.coordinates[i] = pow(fabs(mesh.coordinates[i]), cases[c].power);
            if (cases[c].cluster)
                make_clusters(&mesh.mesh, mesh.coordinates, cases[c].cluster);
            check_against_reference(&mesh.mesh);
            test_mesh_destroy(&mesh);
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
    assert_true(permitted > 3);
    test_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walks_through_lattices),   cmocka_unit_test(sorts_by_keys),
        cmocka_unit_test(does_not_see_the_scale),   cmocka_unit_test(survives_extremes),
        cmocka_unit_test(is_stable_on_any_threads), cmocka_unit_test(survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
