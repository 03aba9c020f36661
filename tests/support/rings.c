/* rings: what the tests of rings, colouring and stars start from. */
#include "support/rings.h"

#include "base/memory.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>

void test_rings_create(test_rings *rings, const planish_mesh *mesh, int all, int threads) {
    pl_boundary boundary;
    *rings = (test_rings){.is_free = pl_alloc(mesh->n_nodes, 1),
                          .node = pl_alloc(mesh->n_nodes, sizeof *rings->node)};
    assert_int_equal(pl_incidence_create(mesh, threads, &rings->incidence, NULL), PLANISH_OK);
    assert_int_equal(pl_boundary_create(mesh, &rings->incidence, threads, &boundary, NULL),
                     PLANISH_OK);
    for (int32_t i = 0; i < mesh->n_nodes; i++) {
        int used = rings->incidence.offset[i + 1] > rings->incidence.offset[i];
        rings->is_free[i] = used && (all || !boundary.on_boundary[i]);
        if (rings->is_free[i])
            rings->node[rings->n_free++] = i;
    }
    assert_int_equal(pl_rings_create(mesh, &rings->incidence, boundary.sign, rings->is_free,
                                     rings->node, &rings->n_free, threads, &rings->rings, NULL),
                     PLANISH_OK);
    pl_boundary_destroy(&boundary);
}

void test_rings_destroy(test_rings *rings) {
    pl_incidence_destroy(&rings->incidence);
    pl_rings_destroy(&rings->rings);
    pl_free(rings->is_free);
    pl_free(rings->node);
}
