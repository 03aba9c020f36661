/* Tests of src/topology/colouring.c. */
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

/* ---- the serial greedy algorithm ---------------------------------------------------------- */

typedef struct candidate {
    int64_t degree;
    uint32_t hash;
    int64_t ring;
} candidate;

static uint32_t hash_of(uint32_t h) {
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

static int compare(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    if (x->degree != y->degree)
        return x->degree > y->degree ? -1 : 1;
    return x->hash > y->hash ? -1 : 1;
}

static int64_t ring_of(const test_rings *r, int32_t node) {
    for (int64_t i = 0; i < r->rings.n_rings; i++)
        if (r->node[i] == node)
            return i;
    return -1;
}

static void greedy(const test_rings *r, int32_t *colour) {
    candidate *order = malloc((size_t)r->rings.n_rings * sizeof *order + 1);
    assert_non_null(order);
    int64_t n = 0;
    for (int64_t i = 0; i < r->rings.n_rings; i++) {
        colour[i] = -1;
        if (r->node[i] < 0)
            continue;
        order[n] = (candidate){0, hash_of((uint32_t)r->node[i]), i};
        for (int64_t j = r->rings.offset[i]; j < r->rings.offset[i + 1]; j++)
            order[n].degree += r->is_free[r->rings.neighbour[j]];
        n++;
    }
    qsort(order, (size_t)n, sizeof *order, compare);
    for (int64_t i = 0; i < n; i++) {
        int64_t ring = order[i].ring;
        int32_t c = 0;
        for (int taken = 1; taken; c += taken) {
            taken = 0;
            for (int64_t j = r->rings.offset[ring]; j < r->rings.offset[ring + 1]; j++) {
                int32_t neighbour = r->rings.neighbour[j];
                taken |= r->is_free[neighbour] && colour[ring_of(r, neighbour)] == c;
            }
        }
        colour[ring] = c;
    }
    free(order);
}

/* ---- tests -------------------------------------------------------------------------------- */

/** The colours equal those of the serial algorithm on any number of threads. */
static void check(const planish_mesh *mesh, const test_rings *r, int expected_colours) {
    size_t bytes = (size_t)r->rings.n_rings * sizeof(int32_t);
    int32_t *reference = malloc(bytes + 1), *colour = malloc(bytes + 1);
    assert_true(reference && colour);
    greedy(r, reference);
    int highest = -1;
    for (int64_t i = 0; i < r->rings.n_rings; i++)
        highest = reference[i] > highest ? reference[i] : highest;
    if (expected_colours)
        assert_int_equal(highest + 1, expected_colours);
    for (int threads = 1; threads <= 5; threads++) {
        int n_colours = -1;
        assert_int_equal(pl_colouring_create(&r->rings, r->node, NULL, mesh->n_nodes, NULL, threads,
                                             colour, &n_colours, NULL),
                         PLANISH_OK);
        assert_int_equal(n_colours, highest + 1);
        assert_memory_equal(colour, reference, bytes);
    }
    free(reference);
    free(colour);
}

static void boxes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_rings rings;
        test_mesh_box(&box, dim, dim == 3 ? 12 : 40);
        test_mesh_renumber(&box, 9, NULL);
        for (int all = 0; all < 2; all++) { /* all: not every ring has a node */
            test_rings_create(&rings, &box.mesh, all, 1);
            check(&box.mesh, &rings, 0);
            test_rings_destroy(&rings);
        }
        test_mesh_destroy(&box);
    }
}

static void garbage(void **state) {
    (void)state;
    for (unsigned seed = 1; seed <= 3; seed++) {
        test_mesh mesh;
        test_rings rings;
        test_mesh_garbage(&mesh, 3, 40 << (2 * seed), 1500, seed);
        test_rings_define(&rings, &mesh.mesh);
        check(&mesh.mesh, &rings, 0);
        test_rings_destroy(&rings);
        test_mesh_destroy(&mesh);
    }
}

/** All pairs of 100 nodes are neighbours: more colours than one mask holds. */
static void complete_graph(void **state) {
    (void)state;
    enum { N = 100 };
    int32_t elements[N * N][3];
    int64_t m = 0;
    for (int32_t i = 0; i < N; i++)
        for (int32_t j = 0; j < i; j++, m++) {
            elements[m][0] = i;
            elements[m][1] = j;
            elements[m][2] = i != 0 && j != 0 ? 0 : N - 1 - i - j;
            if (elements[m][2] == i || elements[m][2] == j)
                elements[m][2] = N / 2;
        }
    test_mesh mesh;
    test_rings rings;
    test_mesh_create(&mesh, 2, N, NULL, m, elements[0]);
    test_rings_define(&rings, &mesh.mesh);
    check(&mesh.mesh, &rings, N);
    test_rings_destroy(&rings);
    test_mesh_destroy(&mesh);
}

static int compare_hashes(const void *a, const void *b) {
    const uint32_t x = hash_of(*(const uint32_t *)a), y = hash_of(*(const uint32_t *)b);
    return x < y ? -1 : x > y;
}

/** A strip of triangles, each node of which waits for the next two: from the first ring on the way
 *  is longer than what a thread remembers. */
static void long_way(void **state) {
    (void)state;
    enum { N = 3000 };
    static int32_t node[N], elements[N - 2][3];
    for (int32_t i = 0; i < N; i++)
        node[i] = i;
    qsort(node, N, sizeof *node, compare_hashes);
    for (int32_t i = 0; i < N - 2; i++)
        for (int32_t j = 0; j < 3; j++)
            elements[i][j] = node[i + j];
    test_mesh mesh;
    test_rings rings;
    test_mesh_create(&mesh, 2, N, NULL, N - 2, elements[0]);
    test_rings_define(&rings, &mesh.mesh);
    assert_int_equal(rings.rings.n_rings, N);
    memcpy(rings.node, node, sizeof node);
    for (int64_t r = 0; r < N; r++)
        rings.rings.offset[r + 1] =
            rings.rings.offset[r] +
            test_ring_of_node(&mesh.mesh, node[r], rings.rings.neighbour + rings.rings.offset[r]);
    check(&mesh.mesh, &rings, 0);
    test_rings_destroy(&rings);
    test_mesh_destroy(&mesh);
}

/** The colour of a node does not depend on the place of its ring. */
static void any_order_of_rings(void **state) {
    (void)state;
    test_mesh box;
    test_rings rings;
    test_mesh_box(&box, 3, 8);
    test_rings_create(&rings, &box.mesh, 0, 1);
    int64_t n = rings.rings.n_rings;
    int32_t *forward = malloc((size_t)n * sizeof *forward);
    int32_t *backward = malloc((size_t)n * sizeof *backward);
    assert_true(forward && backward);
    int n_colours;
    assert_int_equal(pl_colouring_create(&rings.rings, rings.node, NULL, box.mesh.n_nodes, NULL, 1,
                                         forward, &n_colours, NULL),
                     PLANISH_OK);
    for (int64_t i = 0; i < n / 2; i++) {
        int32_t node = rings.node[i];
        rings.node[i] = rings.node[n - 1 - i];
        rings.node[n - 1 - i] = node;
    }
    pl_rings_destroy(&rings.rings);
    assert_int_equal(pl_rings_create(&box.mesh, &rings.incidence, NULL, NULL, rings.is_free,
                                     rings.node, n, 0, 1, &rings.rings, NULL),
                     PLANISH_OK);
    assert_int_equal(pl_colouring_create(&rings.rings, rings.node, NULL, box.mesh.n_nodes, NULL, 1,
                                         backward, &n_colours, NULL),
                     PLANISH_OK);
    for (int64_t i = 0; i < n; i++)
        assert_int_equal(forward[i], backward[n - 1 - i]);
    free(forward);
    free(backward);
    test_rings_destroy(&rings);
    test_mesh_destroy(&box);
}

/** No ring at all, or only rings without a node. */
static void no_node(void **state) {
    (void)state;
    for (int all = 0; all < 2; all++) {
        test_mesh box;
        test_rings rings;
        test_mesh_box(&box, 2, 1);
        test_rings_create(&rings, &box.mesh, all, 1);
        assert_int_equal(rings.rings.n_rings, all ? 4 : 0);
        assert_int_equal(rings.rings.n_free, 0);
        check(&box.mesh, &rings, 0);
        test_rings_destroy(&rings);
        test_mesh_destroy(&box);
    }
}

static void survives_without_memory(void **state) {
    (void)state;
    test_mesh box;
    test_rings rings;
    int32_t colour[27];
    test_mesh_box(&box, 3, 4);
    test_rings_create(&rings, &box.mesh, 0, 1);
    int status = PLANISH_ERROR_MEMORY, permitted = 0, n_colours = 0;
    for (; status; permitted++) {
        allocations_permit(permitted);
        status = pl_colouring_create(&rings.rings, rings.node, NULL, box.mesh.n_nodes, NULL, 2,
                                     colour, &n_colours, NULL);
        allocations_permit(-1);
        assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
    }
    assert_int_equal(permitted, 4);
    test_rings_destroy(&rings);
    test_mesh_destroy(&box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes),
        cmocka_unit_test(garbage),
        cmocka_unit_test(complete_graph),
        cmocka_unit_test(any_order_of_rings),
        cmocka_unit_test(long_way),
        cmocka_unit_test(no_node),
        cmocka_unit_test(survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
