/* rings: what the tests of rings, colouring and stars start from. */
#include "support/rings.h"

#include "base/memory.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>

/** is_free and node: those not on the boundary, or all; returns how many. */
static int64_t list_nodes(test_rings *rings, int64_t n, const uint8_t *on_boundary) {
    int64_t n_listed = 0;
    for (int32_t i = 0; i < n; i++) {
        int used = rings->incidence.offset[i + 1] > rings->incidence.offset[i];
        rings->is_free[i] = used && !(on_boundary && on_boundary[i]);
        if (rings->is_free[i])
            rings->node[n_listed++] = i;
    }
    return n_listed;
}

static void prepare(test_rings *rings, const planish_mesh *mesh, int threads) {
    *rings = (test_rings){.is_free = pl_alloc(mesh->n_nodes, 1),
                          .node = pl_alloc(mesh->n_nodes, sizeof *rings->node)};
    assert_true(rings->is_free && rings->node);
    assert_int_equal(pl_incidence_create(mesh, NULL, threads, &rings->incidence, NULL), PLANISH_OK);
}

void test_rings_create(test_rings *rings, const planish_mesh *mesh, int all, int threads) {
    pl_boundary boundary;
    prepare(rings, mesh, threads);
    assert_int_equal(pl_boundary_create(mesh, 0, threads, &boundary, NULL), PLANISH_OK);
    assert_int_equal(pl_boundary_find(mesh, &rings->incidence, NULL, threads, &boundary, NULL),
                     PLANISH_OK);
    int64_t n = list_nodes(rings, mesh->n_nodes, all ? NULL : boundary.on_boundary);
    rings->sign = boundary.sign;
    boundary.sign = NULL;
    pl_boundary_destroy(&boundary);
    assert_int_equal(pl_rings_create(mesh, &rings->incidence, rings->sign, NULL, rings->is_free,
                                     rings->node, n, 0, threads, &rings->rings, NULL),
                     PLANISH_OK);
    if (!all) /* all of them are inside */
        assert_int_equal(rings->rings.n_free, n);
}

int64_t test_ring_of_node(const planish_mesh *mesh, int32_t node, int32_t *ring) {
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

void test_rings_define(test_rings *rings, const planish_mesh *mesh) {
    prepare(rings, mesh, 1);
    int64_t n = list_nodes(rings, mesh->n_nodes, NULL), total = 0;
    rings->rings = (pl_rings){.n_rings = n,
                              .n_free = n,
                              .offset = pl_alloc(n + 1, sizeof(int64_t)),
                              .neighbour = pl_alloc(n * mesh->n_nodes, sizeof(int32_t))};
    assert_true(rings->rings.offset && rings->rings.neighbour);
    for (int64_t r = 0; r < n; r++) {
        rings->rings.offset[r] = total;
        total += test_ring_of_node(mesh, rings->node[r], rings->rings.neighbour + total);
    }
    rings->rings.offset[n] = total;
}

void test_rings_destroy(test_rings *rings) {
    pl_incidence_destroy(&rings->incidence);
    pl_rings_destroy(&rings->rings);
    pl_free(rings->is_free);
    pl_free(rings->node);
    pl_free(rings->sign);
}
