/* Tests of src/topology/rings.c. */
#include "topology/topology.h"

#include "support/allocations.h"
#include "support/meshes.h"
#include "support/rings.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

/** The definition, word by word: returns the length of the ring of node. */
static int64_t naive_ring(const planish_mesh *mesh, int32_t node, int32_t *ring) {
    int64_t n = 0;
    int k = mesh->dim + 1;
    for (int64_t e = 0; e < mesh->n_elements; e++) {
        const int32_t *element = mesh->elements + e * k;
        int contains = 0;
        for (int j = 0; j < k; j++)
            contains |= element[j] == node;
        for (int j = 0; contains && j < k; j++) {
            int known = element[j] == node;
            for (int64_t i = 0; i < n; i++)
                known |= ring[i] == element[j];
            if (!known)
                ring[n++] = element[j];
        }
    }
    return n;
}

static void check_against_definition(const planish_mesh *mesh, const test_rings *r) {
    int32_t *ring = malloc((size_t)mesh->n_nodes * sizeof *ring);
    assert_non_null(ring);
    assert_int_equal(r->rings.n_rings, r->n_free);
    for (int64_t i = 0; i < r->n_free; i++) {
        int64_t n = naive_ring(mesh, r->node[i], ring);
        assert_int_equal(r->rings.offset[i + 1] - r->rings.offset[i], n);
        assert_memory_equal(r->rings.neighbour + r->rings.offset[i], ring,
                            (size_t)n * sizeof *ring);
    }
    free(ring);
}

static void check_threads(const planish_mesh *mesh, const test_rings *first, int all) {
    int64_t n = first->n_free;
    for (int threads = 2; threads <= 5; threads++) {
        test_rings other;
        test_rings_create(&other, mesh, all, threads);
        assert_int_equal(other.n_free, n);
        assert_memory_equal(first->rings.offset, other.rings.offset,
                            (size_t)(n + 1) * sizeof(int64_t));
        assert_memory_equal(first->rings.neighbour, other.rings.neighbour,
                            (size_t)first->rings.offset[n] * sizeof(int32_t));
        test_rings_destroy(&other);
    }
}

static void interior_of_boxes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_rings rings;
        test_mesh_box(&box, dim, dim == 3 ? 8 : 30);
        test_mesh_renumber(&box, 2, NULL);
        test_rings_create(&rings, &box.mesh, 0, 1);
        assert_int_equal(rings.n_free, dim == 3 ? 7 * 7 * 7 : 29 * 29);
        check_against_definition(&box.mesh, &rings);
        check_threads(&box.mesh, &rings, 0);
        test_rings_destroy(&rings);
        test_mesh_destroy(&box);
    }
}

/** Links that are no spheres: open ones, and those of random elements. */
static void links_of_any_shape(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (unsigned seed = 0; seed < 4; seed++) {
            test_mesh mesh;
            test_rings rings;
            if (seed == 0)
                test_mesh_box(&mesh, dim, 6);
            else
                test_mesh_garbage(&mesh, dim, 12 << (2 * seed), 900, seed);
            test_rings_create(&rings, &mesh.mesh, 1, 1);
            check_against_definition(&mesh.mesh, &rings);
            check_threads(&mesh.mesh, &rings, 1);
            test_rings_destroy(&rings);
            test_mesh_destroy(&mesh);
        }
}

/** A fan of triangles around node 0: its link is larger than positions can say. */
static void holds_giant_links(void **state) {
    (void)state;
    for (int32_t extra = 0; extra < 2; extra++) {
        int32_t n = PL_MAX_LINK + extra;
        int32_t *elements = malloc((size_t)n * 3 * sizeof *elements);
        assert_non_null(elements);
        for (int32_t i = 0; i < n; i++) {
            elements[3 * i] = 0;
            elements[3 * i + 1] = 1 + i;
            elements[3 * i + 2] = 1 + (i + 1) % n;
        }
        test_mesh mesh;
        test_rings rings;
        test_mesh_create(&mesh, 2, n + 1, NULL, n, elements);
        test_rings_create(&rings, &mesh.mesh, 1, 2);
        assert_int_equal(rings.is_free[0], extra == 0);
        assert_int_equal(rings.n_free, extra ? n : n + 1);
        assert_int_equal(rings.rings.n_rings, rings.n_free);
        int32_t first = rings.node[0];
        assert_int_equal(first, extra);
        assert_int_equal(rings.rings.offset[1], extra ? 3 : n);
        test_rings_destroy(&rings);
        test_mesh_destroy(&mesh);
        free(elements);
    }
}

static void no_free_node(void **state) {
    (void)state;
    test_mesh box;
    test_rings rings;
    test_mesh_box(&box, 3, 1);
    test_rings_create(&rings, &box.mesh, 0, 2);
    assert_int_equal(rings.rings.n_rings, 0);
    assert_int_equal(rings.rings.offset[0], 0);
    test_rings_destroy(&rings);
    test_mesh_destroy(&box);
}

static void survives_without_memory(void **state) {
    (void)state;
    test_mesh mesh;
    test_rings base;
    pl_rings rings;
    test_mesh_garbage(&mesh, 3, 50, 900, 7);
    test_rings_create(&base, &mesh.mesh, 1, 1);
    int status = PLANISH_ERROR_MEMORY, permitted = 0;
    for (; status; permitted++) {
        allocations_permit(permitted);
        status = pl_rings_create(&mesh.mesh, &base.incidence, NULL, base.is_free, base.node,
                                 &base.n_free, 1, &rings, NULL);
        allocations_permit(-1);
        assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
    }
    assert_true(permitted > 3);
    pl_rings_destroy(&rings);
    test_rings_destroy(&base);
    test_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(interior_of_boxes),       cmocka_unit_test(links_of_any_shape),
        cmocka_unit_test(holds_giant_links),       cmocka_unit_test(no_free_node),
        cmocka_unit_test(survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
