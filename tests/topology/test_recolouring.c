/* Tests of what only several threads come to in src/topology/colouring.c: a node that another one
 * has coloured in the meantime, and nodes that waited for it. Its parts are taken one by one, as no
 * two threads could be made to meet there. */
#include "topology/colouring.c"

#include "support/meshes.h"
#include "support/rings.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdlib.h>
#include <cmocka.h>

/** The graph of rings on one thread; colour [n_rings]. */
static work graph_of(const planish_mesh *mesh, const test_rings *r, int32_t *colour) {
    work w = {.rings = &r->rings,
              .n_nodes = mesh->n_nodes,
              .n_all = r->rings.n_rings,
              .node = r->node,
              .colour = colour,
              .blocked = UNCOLOURED - 1,
              .max_colour = UNCOLOURED};
    assert_true(allocate(&w, 0));
    clear_ring_of(&w, 0, mesh->n_nodes, 0);
    set_ring_of(&w, 0, r->rings.n_rings, 0);
    make_graph(&w, 0, r->rings.n_rings, 0);
    return w;
}

/** A node has the same colour whether those of lower priority have theirs or not. */
static void colours_of_later_nodes_do_not_count(void **state) {
    (void)state;
    test_mesh box;
    test_rings rings;
    test_mesh_box(&box, 3, 8);
    test_mesh_perturb(&box, 0.1, 1);
    test_rings_create(&rings, &box.mesh, 0, 1);
    const int64_t n = rings.rings.n_rings;
    int32_t *expected = malloc((size_t)n * sizeof *expected),
            *colour = malloc((size_t)n * sizeof *colour);
    int n_colours;
    assert_true(expected && colour);
    assert_int_equal(pl_colouring_create(&rings.rings, rings.node, NULL, box.mesh.n_nodes, NULL, 1,
                                         expected, &n_colours, NULL),
                     PLANISH_OK);
    work w = graph_of(&box.mesh, &rings, colour);
    memcpy(colour, expected, (size_t)n * sizeof *colour);
    int64_t n_lower = 0;
    for (int32_t r = 0; r < n; r++) {
        int64_t max_colour = UNCOLOURED;
        for (int32_t i = 0; i < degree(&w, r); i++)
            n_lower += colour[w.neighbour[rings.rings.offset[r] + i]] < expected[r];
        assert_int_equal(smallest_colour(&w, r, 0), expected[r]);
        colour_from(&w, r, &max_colour); /* as a thread that was late */
        assert_int_equal(colour[r], expected[r]);
        assert_int_equal(max_colour, expected[r]);
    }
    assert_true(n_lower > 0);
    release(&w);
    free(expected);
    free(colour);
    test_rings_destroy(&rings);
    test_mesh_destroy(&box);
}

/** A way that is longer than what is remembered of it is not gone again and again: of what is
 *  forgotten there is little near the end, and the first stays. */
static void ways_are_forgotten_evenly(void **state) {
    (void)state;
    enum { LONG = 100000 };
    wanted way[MOST_WANTED];
    int n = 0;
    for (int64_t depth = 0; depth < LONG; depth++) {
        if (n == MOST_WANTED) {
            forget_one(way);
            n--;
        }
        way[n++] = (wanted){.depth = depth};
    }
    assert_int_equal(n, MOST_WANTED);
    assert_int_equal(way[0].depth, 0);
    assert_int_equal(way[n - 1].depth, LONG - 1);
    for (int k = 1; k < n; k++) {
        const int64_t gap = way[k].depth - way[k - 1].depth, left = LONG - way[k - 1].depth;
        assert_true(gap >= 1 && gap <= 1 + left / 2);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colours_of_later_nodes_do_not_count),
        cmocka_unit_test(ways_are_forgotten_evenly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
