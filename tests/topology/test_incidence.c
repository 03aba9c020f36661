/* Tests of src/topology/incidence.c. */
#include "topology/topology.h"

#include "geometry/corner.h"

#include "support/allocations.h"
#include "support/cell_meshes.h"
#include "support/meshes.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

static void two_tetrahedra(void **state) {
    (void)state;
    const int32_t elements[] = {0, 1, 2, 3, 4, 3, 2, 1};
    const int64_t offset[] = {0, 1, 3, 5, 7, 8, 8};
    const int32_t element[] = {0, 0, 1, 0, 1, 0, 1, 1};
    test_mesh mesh;
    pl_incidence incidence;
    test_mesh_create(&mesh, 3, 6, NULL, 2, elements); /* node 5 is unused */
    assert_int_equal(pl_incidence_create(&mesh.mesh, NULL, 1, &incidence, NULL), PLANISH_OK);
    assert_memory_equal(incidence.offset, offset, sizeof offset);
    assert_memory_equal(incidence.element, element, sizeof element);
    pl_incidence_destroy(&incidence);
    test_mesh_destroy(&mesh);
}

/** Every list is ascending, and holds only elements of its node; together they hold all. */
static void check(const planish_mesh *mesh, const pl_incidence *incidence) {
    int k = mesh->dim + 1;
    assert_int_equal(incidence->offset[0], 0);
    assert_int_equal(incidence->offset[mesh->n_nodes], mesh->n_elements * k);
    for (int64_t node = 0; node < mesh->n_nodes; node++) {
        int64_t begin = incidence->offset[node], end = incidence->offset[node + 1];
        assert_true(begin <= end);
        for (int64_t i = begin; i < end; i++) {
            int32_t element = incidence->element[i];
            int found = 0;
            assert_true(i == begin || element > incidence->element[i - 1]);
            assert_true(element >= 0 && element < mesh->n_elements);
            for (int j = 0; j < k; j++)
                found |= mesh->elements[element * k + j] == node;
            assert_true(found);
        }
    }
}

/** Enough nodes for several buckets, and elements for several chunks. */
static void large_meshes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh mesh;
        pl_incidence first, other;
        test_mesh_box(&mesh, dim, dim == 3 ? 16 : 100);
        test_mesh_renumber(&mesh, 5, NULL);
        assert_int_equal(pl_incidence_create(&mesh.mesh, NULL, 1, &first, NULL), PLANISH_OK);
        check(&mesh.mesh, &first);
        size_t n_offset = (size_t)(mesh.mesh.n_nodes + 1) * sizeof *first.offset;
        size_t n_element = (size_t)mesh.mesh.n_elements * (size_t)(dim + 1) * sizeof(int32_t);
        for (int threads = 2; threads <= 5; threads++) {
            assert_int_equal(pl_incidence_create(&mesh.mesh, NULL, threads, &other, NULL),
                             PLANISH_OK);
            assert_memory_equal(first.offset, other.offset, n_offset);
            assert_memory_equal(first.element, other.element, n_element);
            pl_incidence_destroy(&other);
        }
        pl_incidence_destroy(&first);
        test_mesh_destroy(&mesh);
    }
}

/** Lists that nobody asks for are empty, and the others the same. */
static void some_lists(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh mesh;
        pl_incidence all, some;
        unsigned random = 3;
        test_mesh_box(&mesh, dim, dim == 3 ? 12 : 60);
        test_mesh_renumber(&mesh, 5, NULL);
        const int64_t n = mesh.mesh.n_nodes;
        uint8_t *unasked = malloc((size_t)n);
        for (int64_t i = 0; i < n; i++)
            unasked[i] = test_random(&random) < 0.6 ? 2 : 0;
        assert_int_equal(pl_incidence_create(&mesh.mesh, NULL, 2, &all, NULL), PLANISH_OK);
        assert_int_equal(pl_incidence_create(&mesh.mesh, unasked, 2, &some, NULL), PLANISH_OK);
        for (int64_t i = 0; i < n; i++) {
            const int64_t length = some.offset[i + 1] - some.offset[i];
            assert_int_equal(length, unasked[i] ? 0 : all.offset[i + 1] - all.offset[i]);
            assert_memory_equal(some.element + some.offset[i], all.element + all.offset[i],
                                (size_t)length * sizeof *some.element);
        }
        pl_incidence_destroy(&all);
        pl_incidence_destroy(&some);
        free(unasked);
        test_mesh_destroy(&mesh);
    }
}

/** So many nodes that the buckets grow. */
static void many_nodes(void **state) {
    (void)state;
    test_mesh mesh;
    pl_incidence incidence;
    test_mesh_garbage(&mesh, 2, 1100000, 2000, 3);
    assert_int_equal(pl_incidence_create(&mesh.mesh, NULL, 3, &incidence, NULL), PLANISH_OK);
    check(&mesh.mesh, &incidence);
    pl_incidence_destroy(&incidence);
    test_mesh_destroy(&mesh);
}

static void survives_without_memory(void **state) {
    (void)state;
    test_mesh mesh;
    pl_incidence incidence;
    test_mesh_box(&mesh, 3, 2);
    int status = PLANISH_ERROR_MEMORY;
    for (int permitted = 0; status; permitted++) {
        allocations_permit(permitted);
        status = pl_incidence_create(&mesh.mesh, NULL, 2, &incidence, NULL);
        allocations_permit(-1);
        assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
        assert_true(status == (permitted < 5 ? PLANISH_ERROR_MEMORY : PLANISH_OK));
    }
    pl_incidence_destroy(&incidence);
    test_mesh_destroy(&mesh);
}

/** Of each node its cells, ascending, by their first corners. Large boxes are several chunks, whose ends
 *  are within cells. */
static void lists_of_cells(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int threads = 1; threads <= 3; threads++) {
            cell_box *b = cell_box_create((cell_box_kind)kind, threads == 1 ? 3 : 13);
            const planish_cells *cells = b->mesh.cells;
            pl_dense dense;
            pl_incidence incidence;
            assert_int_equal(pl_dense_create(&b->mesh, threads, &dense, NULL), PLANISH_OK);
            assert_non_null(dense.corner);
            assert_int_equal(
                pl_cell_incidence_create(&dense.mesh, dense.corner, threads, &incidence, NULL),
                PLANISH_OK);
            assert_int_equal(incidence.offset[b->mesh.n_nodes], cells->offset[cells->n]);
            int64_t *next = malloc((size_t)b->mesh.n_nodes * sizeof *next);
            assert_non_null(next);
            memcpy(next, incidence.offset, (size_t)b->mesh.n_nodes * sizeof *next);
            for (int64_t c = 0; c < cells->n; c++)
                for (int64_t i = cells->offset[c]; i < cells->offset[c + 1]; i++)
                    assert_int_equal(incidence.element[next[cells->node[i]]++],
                                     dense.cell_begin[c]);
            for (int64_t i = 0; i < b->mesh.n_nodes; i++)
                assert_int_equal(next[i], incidence.offset[i + 1]);
            free(next);
            pl_incidence_destroy(&incidence);
            pl_dense_destroy(&dense);
            cell_box_destroy(b);
        }
}

/** Items of a list: the corners of a mesh's element, the first one twice, and no node. */
static int nodes_of(const void *context, int64_t item, int32_t node[PL_CELL_NODES]) {
    const planish_mesh *mesh = context;
    const int k = mesh->dim + 1;
    memcpy(node, mesh->elements + item * k, (size_t)k * sizeof *node);
    node[k] = node[0];
    node[k + 1] = -1;
    return k + 2;
}

/** Items are listed as elements are, in any number of threads. */
static void lists_of_items(void **state) {
    (void)state;
    test_mesh mesh;
    pl_incidence elements, items;
    test_mesh_box(&mesh, 3, 12);
    test_mesh_renumber(&mesh, 5, NULL);
    const int64_t n = mesh.mesh.n_nodes, m = mesh.mesh.n_elements;
    assert_int_equal(pl_incidence_create(&mesh.mesh, NULL, 1, &elements, NULL), PLANISH_OK);
    for (int threads = 1; threads <= 5; threads++) {
        assert_true(pl_items_of_nodes(n, m, nodes_of, &mesh.mesh, threads, &items));
        assert_memory_equal(items.offset, elements.offset, (size_t)(n + 1) * sizeof *items.offset);
        assert_memory_equal(items.element, elements.element,
                            (size_t)elements.offset[n] * sizeof *items.element);
        pl_incidence_destroy(&items);
    }
    assert_true(pl_items_of_nodes(n, 0, nodes_of, &mesh.mesh, 2, &items));
    assert_int_equal(items.offset[n], 0);
    pl_incidence_destroy(&items);
    for (int permitted = 0; permitted < 3; permitted++) {
        allocations_permit(permitted);
        const int done = pl_items_of_nodes(n, m, nodes_of, &mesh.mesh, 1, &items);
        allocations_permit(-1);
        assert_int_equal(done, permitted == 2);
        assert_true(done || (!items.offset && !items.element));
    }
    pl_incidence_destroy(&items);
    pl_incidence_destroy(&elements);
    test_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_tetrahedra), cmocka_unit_test(large_meshes),
        cmocka_unit_test(some_lists),     cmocka_unit_test(many_nodes),
        cmocka_unit_test(lists_of_cells), cmocka_unit_test(survives_without_memory),
        cmocka_unit_test(lists_of_items),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
