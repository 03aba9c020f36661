/* Tests of src/topology/rings.c. */
#include "topology/small_ring.h"
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

/** Whether two elements that have node have the same nodes. */
static int has_duplicates(const planish_mesh *mesh, int32_t node) {
    const int k = mesh->dim + 1;
    for (int64_t a = 0; a < mesh->n_elements * k; a++) {
        if (mesh->elements[a] != node)
            continue;
        for (int64_t b = 0; b < a / k; b++) {
            int same = 0;
            for (int i = 0; i < k; i++)
                for (int j = 0; j < k; j++)
                    same += mesh->elements[a / k * k + i] == mesh->elements[b * k + j];
            if (same == k)
                return 1;
        }
    }
    return 0;
}

/** Whether the facets of elements at node have two elements each, in opposite directions, and no
 *  duplicates: by comparing the directed edges of its link with one another (in 2-D: the nodes). */
static int is_inside(const planish_mesh *mesh, const int8_t *sign, int32_t node) {
    int dim = mesh->dim, closed = 1;
    int64_t n = 0;
    int32_t(*edge)[2] = malloc((size_t)mesh->n_elements * 3 * sizeof *edge + 1);
    assert_non_null(edge);
    for (int64_t e = 0; e < mesh->n_elements; e++) {
        const int32_t *element = mesh->elements + e * (dim + 1);
        int32_t others[3];
        int place = -1, count = 0;
        for (int j = 0; j <= dim; j++)
            if (element[j] == node)
                place = j;
            else if (count < 3)
                others[count++] = element[j];
        if (place < 0)
            continue;
        if ((place % 2 == 1) ^ (sign && sign[e] < 0)) {
            int32_t first = others[0];
            others[0] = others[1];
            others[1] = first;
        }
        for (int c = 0; c < dim; c++, n++) {
            edge[n][0] = dim == 3 || c == 0 ? others[c] : -1;
            edge[n][1] = dim == 3 ? others[(c + 1) % 3] : c == 0 ? -1 : others[1];
        }
    }
    for (int64_t i = 0; i < n; i++) {
        int same = 0, opposite = 0;
        for (int64_t j = 0; j < n; j++) {
            same += edge[i][0] == edge[j][0] && edge[i][1] == edge[j][1];
            opposite += edge[i][0] == edge[j][1] && edge[i][1] == edge[j][0];
        }
        closed &= same == 1 && opposite == 1;
    }
    free(edge);
    return n > 0 && closed && !has_duplicates(mesh, node);
}

/** Rings are those of the definition; returns how many nodes are inside. */
static int64_t check_against_definition(const planish_mesh *mesh, const test_rings *r) {
    int32_t *ring = malloc((size_t)mesh->n_nodes * sizeof *ring);
    int64_t inside = 0;
    assert_non_null(ring);
    for (int64_t i = 0, node = 0; i < r->rings.n_rings; i++, node++) {
        if (r->node[i] < 0)
            continue;
        int64_t n = test_ring_of_node(mesh, r->node[i], ring);
        assert_int_equal(r->rings.offset[i + 1] - r->rings.offset[i], n);
        assert_memory_equal(r->rings.neighbour + r->rings.offset[i], ring,
                            (size_t)n * sizeof *ring);
        assert_true(r->is_free[r->node[i]]);
        inside++;
    }
    assert_int_equal(inside, r->rings.n_free);
    free(ring);
    return inside;
}

static void check_threads(const planish_mesh *mesh, const test_rings *first, int all) {
    int64_t n = first->rings.n_rings;
    for (int threads = 2; threads <= 5; threads++) {
        test_rings other;
        test_rings_create(&other, mesh, all, threads);
        assert_int_equal(other.rings.n_rings, n);
        assert_int_equal(other.rings.n_free, first->rings.n_free);
        assert_memory_equal(first->node, other.node, (size_t)n * sizeof(int32_t));
        assert_memory_equal(first->rings.offset, other.rings.offset,
                            (size_t)(n + 1) * sizeof(int64_t));
        for (int64_t i = 0; i < n; i++)
            if (first->node[i] >= 0)
                assert_memory_equal(first->rings.neighbour + first->rings.offset[i],
                                    other.rings.neighbour + first->rings.offset[i],
                                    (size_t)(first->rings.offset[i + 1] - first->rings.offset[i]) *
                                        sizeof(int32_t));
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
        assert_int_equal(check_against_definition(&box.mesh, &rings),
                         dim == 3 ? 7 * 7 * 7 : 29 * 29);
        check_threads(&box.mesh, &rings, 0);
        test_rings_destroy(&rings);
        test_mesh_destroy(&box);
    }
}

/** Compare which nodes are inside, and their rings, with the definitions. Returns how many are. */
static int64_t check_any_shape(const planish_mesh *mesh) {
    test_rings rings, defined;
    test_rings_create(&rings, mesh, 1, 1);
    test_rings_define(&defined, mesh);
    assert_int_equal(rings.rings.n_rings, defined.rings.n_rings);
    for (int64_t i = 0; i < defined.rings.n_rings; i++) {
        int inside = is_inside(mesh, rings.sign, defined.node[i]);
        assert_int_equal(rings.is_free[defined.node[i]], inside);
        assert_int_equal(rings.node[i], inside ? defined.node[i] : -1);
    }
    int64_t inside = check_against_definition(mesh, &rings);
    check_threads(mesh, &rings, 1);
    test_rings_destroy(&rings);
    test_rings_destroy(&defined);
    return inside;
}

/** Open links, those of random elements, and closed ones that are no spheres. */
static void links_of_any_shape(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh mesh;
        test_mesh_box(&mesh, dim, 6);
        test_mesh_renumber(&mesh, 5, NULL);
        assert_int_equal(check_any_shape(&mesh.mesh), dim == 3 ? 125 : 25);
        for (int64_t i = 0; i < mesh.mesh.n_elements; i += 7)
            test_mesh_reverse(&mesh, i);
        assert_int_equal(check_any_shape(&mesh.mesh), dim == 3 ? 125 : 25);
        test_mesh_destroy(&mesh);
        for (unsigned seed = 1; seed < 4; seed++) {
            test_mesh_garbage(&mesh, dim, 12 << (2 * seed), 900, seed);
            check_any_shape(&mesh.mesh);
            test_mesh_destroy(&mesh);
        }
        /* Two nodes in one: two spheres (circles), and more nodes than Euler foretells. */
        const int32_t n = 7, away = dim == 3 ? n * n + n + 1 : n + 1;
        test_mesh_box(&mesh, dim, n - 1);
        test_mesh_join(&mesh, away, (int32_t)mesh.mesh.n_nodes - 1 - away);
        assert_int_equal(check_any_shape(&mesh.mesh), dim == 3 ? 124 : 24);
        test_mesh_destroy(&mesh);
    }
}

/** Every element twice, one after the other or all of them once more: no link is closed, although
 *  every edge of a link is there as often in one direction as in the other. */
static void doubled_elements(void **state) {
    (void)state;
    for (int32_t around = 5; around < 100; around += 65) /* small, and not */
        for (int in_turn = 0; in_turn < 2; in_turn++) {
            test_mesh one, doubled;
            test_mesh_double_pyramid(&one, around);
            assert_int_equal(check_any_shape(&one.mesh), 1);
            const int64_t n = one.mesh.n_elements;
            int32_t *elements = malloc((size_t)n * 8 * sizeof *elements);
            assert_non_null(elements);
            for (int64_t i = 0; i < 2 * n; i++)
                memcpy(elements + 4 * i, one.elements + 4 * (in_turn ? i / 2 : i % n),
                       4 * sizeof *elements);
            test_mesh_create(&doubled, 3, one.mesh.n_nodes, one.coordinates, 2 * n, elements);
            assert_int_equal(check_any_shape(&doubled.mesh), 0);
            free(elements);
            test_mesh_destroy(&one);
            test_mesh_destroy(&doubled);
        }
}

/** Make rings with all elements taken as positive, and compare which nodes are inside. */
static void check_inside(const planish_mesh *mesh) {
    test_rings rings;
    test_rings_define(&rings, mesh);
    int64_t n = rings.rings.n_rings;
    pl_rings_destroy(&rings.rings);
    assert_int_equal(pl_rings_create(mesh, &rings.incidence, NULL, NULL, rings.is_free, rings.node,
                                     n, 0, 1, &rings.rings, NULL),
                     PLANISH_OK);
    for (int32_t i = 0; i < mesh->n_nodes; i++)
        assert_int_equal(rings.is_free[i], is_inside(mesh, NULL, i));
    test_rings_destroy(&rings);
}

/** Two elements on the same nodes, in opposite order: all facets are closed, and nothing is inside;
 *  alone, and at a node that has a sphere around it besides. */
static void pillows(void **state) {
    (void)state;
    const int32_t elements[2][8] = {{0, 1, 2, 1, 0, 2}, {0, 1, 2, 3, 1, 0, 2, 3}};
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh pillow, sphere;
        test_mesh_create(&pillow, dim, dim + 1, NULL, 2, elements[dim - 2]);
        check_inside(&pillow.mesh);
        for (int32_t around = 5; around < 100; around += 65) {
            if (dim == 3)
                test_mesh_double_pyramid(&sphere, around);
            else
                test_mesh_box(&sphere, 2, 2);
            const int32_t centre = dim == 3 ? 0 : 4, nodes = (int32_t)sphere.mesh.n_nodes;
            assert_true(is_inside(&sphere.mesh, NULL, centre));
            test_mesh_append(&sphere, &pillow, 0);
            test_mesh_join(&sphere, centre, nodes);
            assert_false(is_inside(&sphere.mesh, NULL, centre));
            check_inside(&sphere.mesh);
            test_mesh_destroy(&sphere);
        }
        test_mesh_destroy(&pillow);
    }
}

/** An element in the other order, and nobody says so: edges of the link are there twice in the same
 *  direction. */
static void a_reversed_element(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int32_t around = 5; around < 100; around += 65) {
            test_mesh mesh;
            if (dim == 3)
                test_mesh_double_pyramid(&mesh, around);
            else
                test_mesh_box(&mesh, 2, 2);
            test_mesh_reverse(&mesh, 3);
            assert_false(is_inside(&mesh.mesh, NULL, dim == 3 ? 0 : 4));
            check_inside(&mesh.mesh);
            test_mesh_destroy(&mesh);
        }
}

/** Around the sizes at which a link is small and its positions are bytes. */
static void links_of_any_size(void **state) {
    (void)state;
    const int32_t around[] = {3, 4, 41, 42, 43, 61, 62, 63, 64, 84, 85, 86, 200};
    for (size_t i = 0; i < sizeof around / sizeof *around; i++) {
        test_mesh mesh;
        test_mesh_double_pyramid(&mesh, around[i]);
        assert_int_equal(check_any_shape(&mesh.mesh), 1);
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
        assert_int_equal(rings.rings.n_rings, n + 1);
        assert_int_equal(rings.rings.n_free, extra == 0);
        assert_int_equal(rings.node[0], extra ? -1 : 0);
        assert_int_equal(rings.rings.offset[1], extra ? 0 : n);
        test_rings_destroy(&rings);
        test_mesh_destroy(&mesh);
        free(elements);
    }
}

/** Numbers of former links count for nothing, by whichever hash they were found. */
static void tables_forget(void **state) {
    (void)state;
    static pl_small_ring table;
    const int32_t node[] = {7, 5, 7, 9};
    const uint8_t position[] = {0, 1, 0, 2};
    pl_small_ring_init(&table);
    uint8_t *of_0 = pl_small_ring_edges_of(&table, 0), *of_1 = pl_small_ring_edges_of(&table, 1),
            *of_2 = pl_small_ring_edges_of(&table, 2);
    for (int round = 0; round < 6; round++) {
        uint32_t n_edges = 0, unrepeated = PL_SMALL_NONE, n_nodes = 0, collision = 0;
        pl_small_ring_begin_nodes(&table, round % PL_SMALL_HASHES);
        for (int i = 0; i < 4; i++)
            assert_int_equal(
                pl_small_ring_node(&table, table.factor, node[i] + round / 2, &n_nodes, &collision),
                position[i]);
        assert_int_equal(collision, 0);
        assert_int_equal(n_nodes, 3);
        assert_int_equal(table.node[2], 9 + round / 2);
        table.n_nodes = n_nodes;
        pl_small_ring_begin_edges(&table);
        assert_int_equal(pl_small_ring_edge(of_0 + 1, of_1 + 0, &n_edges, &unrepeated), 0);
        assert_int_equal(pl_small_ring_edge(of_1 + 2, of_2 + 1, &n_edges, &unrepeated), 1);
        assert_int_equal(pl_small_ring_edge(of_1 + 0, of_0 + 1, &n_edges, &unrepeated), 0);
        assert_int_equal(n_edges, 2);
        assert_int_equal(unrepeated, PL_SMALL_NONE);
        pl_small_ring_edge(of_1 + 2, of_2 + 1, &n_edges, &unrepeated);
        assert_int_not_equal(unrepeated, PL_SMALL_NONE);
    }
}

/** Two nodes at one place are noticed, and told apart by the other hash. */
static void tables_notice_collisions(void **state) {
    (void)state;
    static pl_small_ring table;
    int32_t alike = 1;
    while (pl_small_ring_place(alike, pl_small_ring_factor(0)) !=
           pl_small_ring_place(0, pl_small_ring_factor(0)))
        alike++;
    pl_small_ring_init(&table);
    for (int i = 0; i < PL_SMALL_HASHES; i++) {
        uint32_t n_nodes = 0, collision = 0;
        pl_small_ring_begin_nodes(&table, i);
        pl_small_ring_node(&table, table.factor, 0, &n_nodes, &collision);
        assert_int_equal(collision, 0);
        pl_small_ring_node(&table, table.factor, alike, &n_nodes, &collision);
        assert_int_equal(collision != 0, i == 0);
        table.n_nodes = n_nodes;
    }
}

/** Whether each hash, up to the last one, has node at one of so many places. */
static int is_at_places(int32_t node, int last, uint32_t places) {
    int is = 1;
    for (int i = 0; i <= last; i++)
        is &= pl_small_ring_place(node, pl_small_ring_factor(i)) < places;
    return is;
}

/** The same mesh with its nodes numbered anew, by ascending numbers of which the table of small
 *  rings sees no more than so many by each hash up to the last one, all others being unused. */
static void number_alike(test_mesh *alike, const test_mesh *mesh, int last, uint32_t places) {
    const int64_t k = mesh->mesh.dim + 1, n = mesh->mesh.n_nodes, m = mesh->mesh.n_elements;
    int32_t *number = malloc((size_t)n * sizeof *number), next = 0;
    int32_t *elements = malloc((size_t)(m * k) * sizeof *elements);
    assert_true(number && elements);
    for (int64_t i = 0; i < n; i++) {
        while (!is_at_places(next, last, places))
            next++;
        number[i] = next++;
    }
    for (int64_t i = 0; i < m * k; i++)
        elements[i] = number[mesh->elements[i]];
    double *coordinates = calloc((size_t)(next * mesh->mesh.dim), sizeof *coordinates);
    assert_non_null(coordinates);
    for (int64_t i = 0; i < n; i++)
        for (int d = 0; d < mesh->mesh.dim; d++)
            coordinates[number[i] * mesh->mesh.dim + d] = mesh->coordinates[i * mesh->mesh.dim + d];
    test_mesh_create(alike, mesh->mesh.dim, next, coordinates, m, elements);
    free(coordinates);
    free(elements);
    free(number);
}

/** Nodes that the table of small rings takes for one another by the first hash, or by all: most
 *  links have two of them, or some. */
static void nodes_that_hash_alike(void **state) {
    (void)state;
    for (int last = 0; last < PL_SMALL_HASHES; last++)
        for (uint32_t places = last ? 64 : 16; places <= 1024; places *= 4)
            for (unsigned seed = 1; seed < 4; seed++) {
                test_mesh mesh, alike;
                test_mesh_box(&mesh, 3, 4);
                test_mesh_renumber(&mesh, seed, NULL);
                number_alike(&alike, &mesh, last, places);
                assert_int_equal(check_any_shape(&alike.mesh), 27);
                test_mesh_destroy(&alike);
                test_mesh_destroy(&mesh);
            }
}

/** Small boxes, nearly all of whose links are open: with two of its nodes taken for one another
 * such a link can look closed. */
static void open_links_that_hash_alike(void **state) {
    (void)state;
    for (int last = 0; last < PL_SMALL_HASHES; last++)
        for (unsigned seed = 1; seed <= 40; seed++) {
            test_mesh mesh, alike;
            test_mesh_box(&mesh, 3, 1 + (int)(seed % 3));
            test_mesh_renumber(&mesh, seed, NULL);
            number_alike(&alike, &mesh, last, (last ? 60 : 3) + seed * 4);
            check_any_shape(&alike.mesh);
            test_mesh_destroy(&alike);
            test_mesh_destroy(&mesh);
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
    test_mesh mesh, large;
    test_rings base;
    pl_rings rings;
    test_mesh_box(&mesh, 3, 6);
    test_mesh_join(&mesh, 57, 343 - 1 - 57); /* so that rings are filled again */
    test_mesh_double_pyramid(&large, 100);   /* so that maps grow */
    test_mesh_append(&mesh, &large, 10);
    test_rings_create(&base, &mesh.mesh, 0, 1);
    const int64_t n = base.rings.n_rings;
    const size_t bytes = (size_t)n * sizeof(int32_t);
    int32_t *node = malloc(bytes);
    assert_non_null(node);
    memcpy(node, base.node, bytes);
    int status = PLANISH_ERROR_MEMORY, permitted = 0;
    for (; status; permitted++) {
        for (int64_t i = 0; i < n; i++)
            base.is_free[node[i]] = 1;
        memcpy(base.node, node, bytes);
        allocations_permit(permitted);
        status = pl_rings_create(&mesh.mesh, &base.incidence, base.sign, NULL, base.is_free,
                                 base.node, n, 0, 1, &rings, NULL);
        allocations_permit(-1);
        assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
    }
    assert_true(permitted > 8);
    assert_memory_equal(base.node, node, bytes);
    free(node);
    pl_rings_destroy(&rings);
    test_rings_destroy(&base);
    test_mesh_destroy(&large);
    test_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(interior_of_boxes),          cmocka_unit_test(links_of_any_shape),
        cmocka_unit_test(doubled_elements),           cmocka_unit_test(a_reversed_element),
        cmocka_unit_test(links_of_any_size),          cmocka_unit_test(pillows),
        cmocka_unit_test(holds_giant_links),          cmocka_unit_test(tables_forget),
        cmocka_unit_test(tables_notice_collisions),   cmocka_unit_test(nodes_that_hash_alike),
        cmocka_unit_test(open_links_that_hash_alike), cmocka_unit_test(no_free_node),
        cmocka_unit_test(survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
