/* Tests of src/topology/boundary.c, facets.c and orientation.c. */
#include "topology/topology.h"

#include "geometry/simplex.h"
#include "support/allocations.h"
#include "support/boundary_reference.h"
#include "support/meshes.h"
#include "support/rings.h"
#include "support/tangles.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

static void create(const planish_mesh *mesh, int threads, pl_boundary *boundary) {
    pl_incidence incidence;
    assert_int_equal(pl_incidence_create(mesh, NULL, threads, &incidence, NULL), PLANISH_OK);
    assert_int_equal(pl_boundary_create(mesh, 0, threads, boundary, NULL), PLANISH_OK);
    assert_int_equal(pl_boundary_find(mesh, &incidence, NULL, threads, boundary, NULL), PLANISH_OK);
    pl_incidence_destroy(&incidence);
}

/** The same by links; where these say nothing returns 0. Every third node is a candidate only. */
static int create_by_links(const planish_mesh *mesh, int threads, pl_boundary *boundary) {
    test_rings rings;
    pl_rings links;
    assert_int_equal(pl_boundary_create(mesh, 0, threads, boundary, NULL), PLANISH_OK);
    if (!boundary->is_guess) {
        pl_boundary_destroy(boundary);
        return 0;
    }
    test_rings_define(&rings, mesh);
    int64_t n = 0;
    for (int64_t i = 0; i < rings.rings.n_rings; i++)
        if (i % 3 == 0)
            rings.is_free[rings.node[i]] = 0;
        else
            rings.node[n++] = rings.node[i];
    assert_int_equal(pl_rings_create(mesh, &rings.incidence, boundary->sign, NULL, rings.is_free,
                                     rings.node, n, 0, threads, &links, NULL),
                     PLANISH_OK);
    assert_int_equal(
        pl_boundary_find(mesh, &rings.incidence, rings.is_free, threads, boundary, NULL),
        PLANISH_OK);
    pl_rings_destroy(&links);
    test_rings_destroy(&rings);
    return 1;
}

static int sign_of(const pl_boundary *boundary, int64_t element) {
    return boundary->sign ? boundary->sign[element] : 1;
}

static void compare(const planish_mesh *mesh, const pl_boundary *b, const pl_boundary *expected) {
    assert_memory_equal(b->on_boundary, expected->on_boundary, (size_t)mesh->n_nodes);
    assert_int_equal(b->n_boundary_facets, expected->n_boundary_facets);
    assert_int_equal(b->n_nonmanifold_facets, expected->n_nonmanifold_facets);
    assert_int_equal(b->n_duplicate_elements, expected->n_duplicate_elements);
    assert_int_equal(b->n_reversed, expected->n_reversed);
    if (b->n_components)
        assert_int_equal(b->n_components, expected->n_components);
    for (int64_t e = 0; e < mesh->n_elements; e++)
        assert_int_equal(sign_of(b, e), expected->sign[e]);
}

/** Compare with the reference, on several numbers of threads. */
static void check(const planish_mesh *mesh) {
    boundary_reference r;
    boundary_reference_create(mesh, &r);
    for (int threads = 1; threads <= 5; threads++) {
        pl_boundary b;
        create(mesh, threads, &b);
        compare(mesh, &b, &r.boundary);
        pl_boundary_destroy(&b);
        if (create_by_links(mesh, threads, &b)) {
            compare(mesh, &b, &r.boundary);
            pl_boundary_destroy(&b);
        }
    }
    boundary_reference_destroy(&r);
}

/* ---- boxes -------------------------------------------------------------------------------- */

static void consistent_boxes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        pl_boundary b;
        int cells = 6;
        test_mesh_box(&box, dim, cells);
        test_mesh_perturb(&box, 0.15, 1);
        create(&box.mesh, 2, &b);
        assert_null(b.sign);
        assert_int_equal(b.n_components, 0);
        assert_int_equal(b.n_boundary_facets, dim == 3 ? 2 * 6 * cells * cells : 4 * cells);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
            int outside = 0;
            for (int d = 0; d < dim; d++)
                outside |=
                    box.coordinates[i * dim + d] == 0 || box.coordinates[i * dim + d] == cells;
            assert_int_equal(b.on_boundary[i], outside);
        }
        pl_boundary_destroy(&b);
        for (int64_t i = 0; i < box.mesh.n_elements; i++)
            test_mesh_reverse(&box, i);
        create(&box.mesh, 2, &b);
        assert_non_null(b.sign);
        assert_int_equal(b.n_components, 0);
        assert_int_equal(b.n_reversed, box.mesh.n_elements);
        for (int64_t i = 0; i < box.mesh.n_elements; i++)
            assert_int_equal(b.sign[i], -1);
        pl_boundary_destroy(&b);
        test_mesh_destroy(&box);
    }
}

/** Whatever the numbering, and with many inverted elements: exactly the reversed ones have -1. */
static void mixed_boxes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (unsigned seed = 1; seed <= 3; seed++) {
            test_mesh box;
            test_mesh_box(&box, dim, dim == 3 ? 12 : 60);
            test_mesh_perturb(&box, 0.2 * seed, seed); /* the last one is tangled */
            test_mesh_renumber(&box, seed, NULL);
            int32_t *before = malloc((size_t)(box.mesh.n_elements * (dim + 1)) * sizeof *before);
            assert_non_null(before);
            memcpy(before, box.elements,
                   (size_t)(box.mesh.n_elements * (dim + 1)) * sizeof *before);
            test_mesh_reverse_some(&box, 2 + seed, seed);
            for (int threads = 1; threads <= 5; threads++) {
                pl_boundary b;
                create(&box.mesh, threads, &b);
                assert_int_equal(b.n_components, 1);
                for (int64_t i = 0; i < box.mesh.n_elements; i++) {
                    int reversed = before[i * (dim + 1) + dim] != box.elements[i * (dim + 1) + dim];
                    assert_int_equal(sign_of(&b, i), reversed ? -1 : 1);
                }
                pl_boundary_destroy(&b);
            }
            free(before);
            test_mesh_destroy(&box);
        }
}

/** The scale of the coordinates does not matter, nor where the box is. */
static void extreme_coordinates(void **state) {
    (void)state;
    const double scales[] = {1e-300, 1e-120, 1e120, 1e300, 1e-3};
    const double shifts[] = {0, 0, 0, 0, 1e6};
    for (int dim = 2; dim <= 3; dim++)
        for (int i = 0; i < 5; i++) {
            test_mesh box;
            pl_boundary b;
            test_mesh_box(&box, dim, 3);
            test_mesh_transform(&box, scales[i], shifts[i]);
            test_mesh_reverse(&box, 5);
            create(&box.mesh, 1, &b);
            assert_int_equal(b.n_reversed, 1);
            assert_int_equal(b.sign[5], -1);
            pl_boundary_destroy(&b);
            test_mesh_destroy(&box);
        }
}

/** Neither does a node of no element, nor where interior nodes have been thrown, however far. */
static void nodes_far_away(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int inside = 0; inside < 2; inside++) {
            test_mesh box, far;
            pl_boundary b;
            test_mesh_box(&box, dim, 3);
            const int64_t n = box.mesh.n_nodes, interior = dim == 3 ? 21 : 5;
            double *x = calloc((size_t)((n + 1) * dim), sizeof *x);
            memcpy(x, box.coordinates, (size_t)(n * dim) * sizeof *x);
            x[(inside ? interior : n) * dim] = 1e170;
            test_mesh_create(&far, dim, n + 1, x, box.mesh.n_elements, box.elements);
            for (int64_t i = 0; i < far.mesh.n_elements; i++)
                test_mesh_reverse(&far, i);
            create(&far.mesh, 1, &b);
            assert_int_equal(b.n_reversed, far.mesh.n_elements);
            pl_boundary_destroy(&b);
            free(x);
            test_mesh_destroy(&box);
            test_mesh_destroy(&far);
        }
}

/* ---- special meshes ----------------------------------------------------------------------- */

static void parts_of_opposite_order(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh mesh, other;
        pl_boundary b;
        test_mesh_box(&mesh, dim, 2);
        test_mesh_box(&other, dim, 3);
        for (int64_t i = 0; i < other.mesh.n_elements; i++)
            test_mesh_reverse(&other, i);
        int64_t n_first = mesh.mesh.n_elements;
        test_mesh_append(&mesh, &other, 10);
        create(&mesh.mesh, 2, &b);
        assert_int_equal(b.n_components, 2);
        assert_int_equal(b.n_reversed, other.mesh.n_elements);
        for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
            assert_int_equal(b.sign[i], i < n_first ? 1 : -1);
        pl_boundary_destroy(&b);
        check(&mesh.mesh);
        test_mesh_destroy(&mesh);
        test_mesh_destroy(&other);
    }
}

static void five_tetrahedra_in_a_cube(void **state) {
    (void)state;
    const double x[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
    const int32_t elements[] = {0, 1, 2, 4, 3, 2, 1, 7, 5, 4, 7, 1, 6, 7, 4, 2, 1, 2, 4, 7};
    test_mesh cube;
    pl_boundary b;
    test_mesh_create(&cube, 3, 8, x, 5, elements);
    create(&cube.mesh, 1, &b);
    assert_int_equal(b.n_boundary_facets, 12);
    assert_int_equal(b.n_nonmanifold_facets, 0);
    for (int i = 0; i < 8; i++)
        assert_int_equal(b.on_boundary[i], 1);
    pl_boundary_destroy(&b);
    check(&cube.mesh);
    test_mesh_destroy(&cube);
}

static void three_tetrahedra_on_a_facet(void **state) {
    (void)state;
    const int32_t elements[] = {0, 1, 2, 3, 4, 0, 1, 2, 2, 0, 5, 1};
    test_mesh mesh;
    pl_boundary b;
    test_mesh_create(&mesh, 3, 6, NULL, 3, elements);
    create(&mesh.mesh, 1, &b);
    assert_int_equal(b.n_boundary_facets, 9);
    assert_int_equal(b.n_nonmanifold_facets, 1);
    assert_int_equal(b.n_duplicate_elements, 0);
    pl_boundary_destroy(&b);
    check(&mesh.mesh);
    test_mesh_destroy(&mesh);
}

/** An element of the inside twice, and again: its nodes are held, all others stay as they were. */
static void duplicates(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box, twice;
        pl_boundary b;
        int k = dim + 1;
        test_mesh_box(&box, dim, 4);
        int64_t m = box.mesh.n_elements, inner = m / 2 + (dim == 3 ? 31 : 5);
        int32_t *elements = malloc((size_t)((m + 2) * k) * sizeof *elements);
        assert_non_null(elements);
        memcpy(elements, box.elements, (size_t)(m * k) * sizeof *elements);
        for (int j = 0; j < k; j++) {
            elements[m * k + j] = box.elements[inner * k + (j + 1) % k];
            elements[(m + 1) * k + j] = box.elements[inner * k + (j + 2) % k];
        }
        for (int64_t extra = 0; extra <= 2; extra++) {
            test_mesh_create(&twice, dim, box.mesh.n_nodes, box.coordinates, m + extra, elements);
            create(&twice.mesh, 2, &b);
            assert_int_equal(b.n_duplicate_elements, extra);
            assert_int_equal(b.n_nonmanifold_facets, extra ? k : 0);
            for (int j = 0; j < k && extra; j++)
                assert_int_equal(b.on_boundary[box.elements[inner * k + j]], 1);
            pl_boundary_destroy(&b);
            check(&twice.mesh);
            test_mesh_destroy(&twice);
        }
        free(elements);
        test_mesh_destroy(&box);
    }
}

/** Nothing but two copies of one element: they do not orient one another. */
static void lonely_twins(void **state) {
    (void)state;
    const double x[] = {0, 0, 1, 0, 0, 1};
    const int32_t elements[] = {0, 1, 2, 1, 2, 0};
    test_mesh mesh;
    pl_boundary b;
    test_mesh_create(&mesh, 2, 3, x, 2, elements);
    create(&mesh.mesh, 1, &b);
    assert_int_equal(b.n_duplicate_elements, 1);
    assert_int_equal(b.n_reversed, 0);
    for (int i = 0; i < 3; i++)
        assert_int_equal(b.on_boundary[i], 1);
    pl_boundary_destroy(&b);
    test_mesh_destroy(&mesh);
}

/** A band of triangles closed with a twist, and wide enough that it has nodes inside: it keeps its
 *  order, and the nodes where that contradicts itself are held. A sound part beside it is oriented
 *  all the same. */
static void moebius_strip(void **state) {
    (void)state;
    enum { LENGTH = 9, WIDTH = 5 };
    int32_t elements[LENGTH * (WIDTH - 1) * 2][3];
    double x[LENGTH * WIDTH * 2];
    int64_t m = 0;
    for (int32_t i = 0; i < LENGTH; i++)
        for (int32_t j = 0; j < WIDTH; j++) {
            x[(i * WIDTH + j) * 2] = i;
            x[(i * WIDTH + j) * 2 + 1] = j;
            if (j == WIDTH - 1)
                continue;
            int last = i == LENGTH - 1; /* its right side is the first column upside down */
            int32_t a = i * WIDTH + j, d = a + 1;
            int32_t b = last ? WIDTH - 1 - j : a + WIDTH, c = last ? b - 1 : b + 1;
            memcpy(elements[m++], (int32_t[]){a, b, c}, sizeof elements[0]);
            memcpy(elements[m++], (int32_t[]){a, c, d}, sizeof elements[0]);
        }
    test_mesh strip, box;
    pl_boundary b;
    test_mesh_create(&strip, 2, LENGTH * WIDTH, x, m, elements[0]);
    test_mesh_box(&box, 2, 4);
    test_mesh_reverse(&box, 7);
    test_mesh_append(&strip, &box, 100);
    create(&strip.mesh, 2, &b);
    assert_int_equal(b.n_boundary_facets, 2 * LENGTH + 16);
    assert_int_equal(b.n_components, 2);
    int64_t inside_held = 0;
    for (int64_t i = 0; i < LENGTH * WIDTH; i++)
        if (i % WIDTH != 0 && i % WIDTH != WIDTH - 1)
            inside_held += b.on_boundary[i];
    assert_int_equal(inside_held, WIDTH - 2); /* the column at which the strip was closed */
    int sign = b.sign[0];
    for (int64_t i = 0; i < strip.mesh.n_elements; i++)
        assert_int_equal(b.sign[i], i < m ? sign : i == m + 7 ? -1 : 1);
    pl_boundary_destroy(&b);
    check(&strip.mesh);
    test_mesh_destroy(&strip);
    test_mesh_destroy(&box);
}

/* ---- elements that wrap around ------------------------------------------------------------ */

/** Those that wrap around, and no others, are found, and all the rest has one sign. */
static void expect_wrapped(const test_mesh *mesh, const uint8_t *is_wrapped) {
    const int k = mesh->mesh.dim + 1;
    for (int threads = 1; threads <= 3; threads++) {
        pl_boundary b;
        create(&mesh->mesh, threads, &b);
        int64_t n = 0;
        for (int64_t i = 0; i < mesh->mesh.n_elements; i++) {
            n += is_wrapped[i];
            assert_int_equal(b.flags && b.flags[i] & PL_WRAPPED, is_wrapped[i]);
            if (!is_wrapped[i])
                assert_true(
                    sign_of(&b, i) * test_measure_of(&mesh->mesh, mesh->mesh.coordinates, i) > 0);
            for (int j = 0; j < k && is_wrapped[i]; j++)
                assert_int_equal(b.on_boundary[mesh->elements[i * k + j]], 1);
        }
        assert_int_equal(b.n_wrapped, n);
        pl_boundary_destroy(&b);
    }
}

/** Periodic in one direction, in several, in all; whatever the order and the sides of the box. */
static void periodic_boxes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int cells = 3; cells <= (dim == 3 ? 6 : 20); cells += cells < 5 ? 1 : 5)
            for (unsigned directions = 1; directions < 1u << dim; directions++)
                for (int order = 0; order < 3; order++) {
                    test_mesh box;
                    test_mesh_box(&box, dim, cells);
                    test_mesh_perturb(&box, 0.1, directions);
                    uint8_t *is_wrapped = malloc((size_t)box.mesh.n_elements);
                    test_mesh_wrap(&box, cells, directions, is_wrapped);
                    for (int64_t i = 0; i < box.mesh.n_nodes; i++)
                        box.coordinates[i * dim + dim - 1] *= 1e-3;
                    if (order == 1)
                        test_mesh_reverse_some(&box, 3, directions);
                    for (int64_t i = 0; order == 2 && i < box.mesh.n_elements; i++)
                        test_mesh_reverse(&box, i);
                    expect_wrapped(&box, is_wrapped);
                    free(is_wrapped);
                    test_mesh_destroy(&box);
                }
}

/** Nodes thrown across the domain, or changed with others, are no seam, with or without a hole in
 *  the mesh; nor is a box that is mirrored inside. */
static void tangles_do_not_wrap(void **state) {
    (void)state;
    static const test_tangling tanglings[] = {TEST_MOVED_FEW, TEST_MOVED_ALL,  TEST_GROUPS,
                                              TEST_SWAPPED,   TEST_DUPLICATES, TEST_THROWN};
    for (int dim = 2; dim <= 3; dim++)
        for (int shape = 0; shape < TEST_SHAPES; shape++) {
            test_tangle t;
            test_tangle_create(&t, dim, (test_shape)shape, 1, (unsigned)shape);
            for (size_t i = 0; i < sizeof tanglings / sizeof *tanglings; i++) {
                pl_boundary b;
                test_tangle_apply(&t, tanglings[i], (unsigned)i);
                for (int64_t k = 0; k < t.mesh.mesh.n_nodes && i == 0; k++) /* from side to side */
                    if (t.is_inner[k] && k % 3 == 0)
                        t.mesh.coordinates[k * dim] *= -7;
                create(&t.mesh.mesh, 2, &b);
                assert_int_equal(b.n_wrapped, 0);
                pl_boundary_destroy(&b);
            }
            test_tangle_destroy(&t);
        }
}

/** The sum of measures decides against most elements, where the boundary is that of a valid mesh.
 */
static void a_mirrored_interior(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        enum { CELLS = 8 };
        test_mesh box;
        pl_boundary b;
        int64_t n_inverted = 0;
        test_mesh_box(&box, dim, CELLS);
        create(&box.mesh, 1, &b);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++)
            if (!b.on_boundary[i])
                box.coordinates[i * dim] = CELLS - box.coordinates[i * dim];
        pl_boundary_destroy(&b);
        create(&box.mesh, 2, &b);
        for (int64_t i = 0; i < box.mesh.n_elements; i++) {
            n_inverted += !(test_measure_of(&box.mesh, (&box.mesh)->coordinates, i) > 0);
            assert_int_equal(sign_of(&b, i), 1);
        }
        assert_true(n_inverted > box.mesh.n_elements / 2);
        assert_int_equal(b.n_wrapped, 0);
        pl_boundary_destroy(&b);
        test_mesh_destroy(&box);
    }
}

/** A torus whose seam is not recognised, as one of its elements is divided about it: there is no
 *  boundary that says anything, and nine elements of ten decide. */
static void most_elements_decide(void **state) {
    (void)state;
    enum { CELLS = 40 };
    for (int order = 0; order < 2; order++) {
        test_mesh box;
        pl_boundary b;
        int64_t n_negative = 0;
        test_mesh_box(&box, 2, CELLS);
        uint8_t *is_wrapped = malloc((size_t)box.mesh.n_elements);
        test_mesh_wrap(&box, CELLS, 3, is_wrapped);
        box.coordinates[0] = box.coordinates[1] = 0.45 * CELLS;
        for (int64_t i = 0; order && i < box.mesh.n_elements; i++)
            test_mesh_reverse(&box, i);
        create(&box.mesh, 2, &b);
        assert_int_equal(b.n_wrapped, 0);
        for (int64_t i = 0; i < box.mesh.n_elements; i++)
            n_negative +=
                sign_of(&b, i) * test_measure_of(&box.mesh, (&box.mesh)->coordinates, i) < 0;
        assert_true(n_negative < box.mesh.n_elements / 5);
        pl_boundary_destroy(&b);
        free(is_wrapped);
        test_mesh_destroy(&box);
    }
}

static void garbage(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (unsigned seed = 1; seed <= 40; seed++) {
            test_mesh mesh;
            int64_t n_nodes = seed % 4 ? 5 + seed : 400; /* most of these have no element */
            test_mesh_garbage(&mesh, dim, n_nodes, 20 + 2 * seed, seed);
            check(&mesh.mesh);
            test_mesh_destroy(&mesh);
        }
}

/** All elements share an edge: a map of facets far larger than usual. */
static void a_giant_star(void **state) {
    (void)state;
    enum { N = 3000 };
    int32_t(*elements)[4] = malloc(N * sizeof *elements);
    assert_non_null(elements);
    for (int32_t i = 0; i < N; i++)
        memcpy(elements[i], (int32_t[]){0, 1, 2 + i, 2 + (i + 1) % N}, sizeof elements[i]);
    test_mesh mesh;
    pl_boundary b;
    test_mesh_create(&mesh, 3, N + 2, NULL, N, elements[0]);
    create(&mesh.mesh, 2, &b);
    assert_int_equal(b.n_boundary_facets, 2 * N);
    assert_int_equal(b.n_nonmanifold_facets, 0);
    pl_boundary_destroy(&b);
    test_mesh_destroy(&mesh);
    free(elements);
}

/** An element and its copy in the other order, so flat that both measure something positive: a
 * guess that looks consistent, but they are duplicates. */
static void flat_duplicates(void **state) {
    (void)state;
    const double x[] = {0.057988419157800286, 0.14667681988187187, 0.97675343928259806,
                        0.58895225912093685,  0.29079705181590981, 0.25874632406644071};
    const int32_t elements[] = {0, 1, 2, 1, 0, 2};
    test_mesh mesh;
    pl_boundary b;
    test_mesh_create(&mesh, 2, 3, x, 2, elements);
    assert_int_equal(create_by_links(&mesh.mesh, 1, &b), 1);
    assert_int_equal(b.n_duplicate_elements, 1);
    for (int i = 0; i < 3; i++)
        assert_int_equal(b.on_boundary[i], 1);
    pl_boundary_destroy(&b);
    test_mesh_destroy(&mesh);
}

static void survives_without_memory(void **state) {
    (void)state;
    for (unsigned seed = 0; seed < 2; seed++) {
        test_mesh mesh;
        pl_incidence incidence;
        pl_boundary b;
        if (seed == 0)
            test_mesh_box(&mesh, 3, 2);
        else
            test_mesh_garbage(&mesh, 3, 6, 40, seed);
        assert_int_equal(pl_incidence_create(&mesh.mesh, NULL, 1, &incidence, NULL), PLANISH_OK);
        int status = PLANISH_ERROR_MEMORY, permitted = 0;
        for (; status; permitted++) {
            allocations_permit(permitted);
            status = pl_boundary_create(&mesh.mesh, 0, 1, &b, NULL);
            if (!status) {
                status = pl_boundary_find(&mesh.mesh, &incidence, NULL, 1, &b, NULL);
                if (status)
                    pl_boundary_destroy(&b);
            }
            allocations_permit(-1);
            assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
        }
        assert_true(permitted > (seed ? 9 : 5));
        pl_boundary_destroy(&b);
        pl_incidence_destroy(&incidence);
        test_mesh_destroy(&mesh);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(consistent_boxes),
        cmocka_unit_test(mixed_boxes),
        cmocka_unit_test(extreme_coordinates),
        cmocka_unit_test(nodes_far_away),
        cmocka_unit_test(parts_of_opposite_order),
        cmocka_unit_test(five_tetrahedra_in_a_cube),
        cmocka_unit_test(three_tetrahedra_on_a_facet),
        cmocka_unit_test(duplicates),
        cmocka_unit_test(lonely_twins),
        cmocka_unit_test(moebius_strip),
        cmocka_unit_test(periodic_boxes),
        cmocka_unit_test(tangles_do_not_wrap),
        cmocka_unit_test(a_mirrored_interior),
        cmocka_unit_test(most_elements_decide),
        cmocka_unit_test(garbage),
        cmocka_unit_test(a_giant_star),
        cmocka_unit_test(flat_duplicates),
        cmocka_unit_test(survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
