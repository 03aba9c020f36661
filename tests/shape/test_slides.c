/* planish_find_slides: the planes and lines of meshes whose shape is known. */
#include "support/allocations.h"
#include "support/meshes.h"
#include "support/slides.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** The sides, edges and corners of a box, and a plane between regions at z = cut (y in 2-D). */
static void expect_box(const planish_mesh *mesh, const slides_found *f, double cut) {
    const int dim = mesh->dim;
    int64_t planes = 0, lines = 0, surface = 0;
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const double *x = mesh->coordinates + i * dim;
        int crosses[3], any = 0;
        for (int d = 0; d < dim; d++) {
            crosses[d] = slides_is_side(x[d]) || (d == dim - 1 && x[d] == cut);
            any |= crosses[d];
        }
        slides_expect_node(f, i, dim, crosses);
        planes += f->constraint[i] == PLANISH_CONSTRAINT_ON_PLANE;
        lines += f->constraint[i] == PLANISH_CONSTRAINT_ON_LINE;
        surface += any;
    }
    assert_int_equal(f->info.n_on_plane, planes);
    assert_int_equal(f->info.n_on_line, lines);
    assert_int_equal(f->info.n_surface, surface);
    assert_true(lines > 0 && (dim == 2 || planes > 0));
}

static void a_box_has_sides_edges_and_corners(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int renumber = 0; renumber < 2; renumber++) {
            test_mesh box;
            test_mesh_box(&box, dim, SLIDES_CELLS);
            if (renumber) {
                test_mesh_renumber(&box, 3, NULL);
                test_mesh_reverse_some(&box, 3, 8);
            }
            slides_found f = slides_find(&box.mesh, NULL), g = slides_find_on(&box.mesh, NULL, 3);
            expect_box(&box.mesh, &f, -1);
            assert_memory_equal(f.constraint, g.constraint, (size_t)box.mesh.n_nodes);
            assert_memory_equal(f.direction, g.direction,
                                (size_t)(box.mesh.n_nodes * dim) * sizeof(double));
            slides_release(&f);
            slides_release(&g);
            test_mesh_destroy(&box);
        }
}

/** Regions by the last coordinate of the elements' first nodes' layer. */
static int32_t *two_regions(const planish_mesh *mesh) {
    const int dim = mesh->dim;
    int32_t *region = malloc((size_t)mesh->n_elements * sizeof *region);
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        double middle = 0;
        for (int j = 0; j <= dim; j++) {
            const int64_t node = mesh->elements[i * (dim + 1) + j];
            middle += mesh->coordinates[node * dim + dim - 1] / (dim + 1);
        }
        region[i] = middle < 2 ? 7 : -3;
    }
    return region;
}

static void interfaces_are_slid_on(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, SLIDES_CELLS);
        int32_t *region = two_regions(&box.mesh);
        const planish_surface surface = {.region = region};
        slides_found f = slides_find(&box.mesh, &surface);
        expect_box(&box.mesh, &f, 2);
        slides_release(&f);
        free(region);
        test_mesh_destroy(&box);
    }
}

/** What a plan knows to be inside saves time and changes nothing. */
static void what_is_inside_may_be_told(void **state) {
    (void)state;
    test_mesh box;
    planish_plan *plan;
    test_mesh_box(&box, 3, SLIDES_CELLS);
    uint8_t *inside = malloc((size_t)box.mesh.n_nodes);
    assert_int_equal(planish_plan_create(&box.mesh, NULL, &plan, NULL), 0);
    planish_plan_get_free(plan, inside);
    int64_t n = 0;
    for (int64_t i = 0; i < box.mesh.n_nodes; i++)
        n += inside[i];
    assert_int_equal(n, (SLIDES_CELLS - 1) * (SLIDES_CELLS - 1) * (SLIDES_CELLS - 1));
    static const uint8_t marks[] = {1, 2, 255}; /* whatever is not 0 */
    for (size_t m = 0; m < sizeof marks; m++) {
        for (int64_t i = 0; i < box.mesh.n_nodes; i++)
            inside[i] = inside[i] ? marks[m] : 0;
        const planish_surface surface = {.is_inside = inside};
        slides_found f = slides_find(&box.mesh, &surface);
        expect_box(&box.mesh, &f, -1);
        slides_release(&f);
    }
    planish_plan_destroy(plan);
    free(inside);
    test_mesh_destroy(&box);
}

/** The facets of the side z = 0, those with x < 2 tagged 1, the others 2; how many. */
static int64_t bottom_facets(const planish_mesh *mesh, int32_t *facets, int32_t *tags) {
    int64_t n = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++)
        for (int j = 0; j < 4; j++) {
            int32_t nodes[3];
            double middle = 0;
            int bottom = 1;
            for (int k = 0, c = 0; k < 4; k++) {
                const int32_t node = mesh->elements[4 * i + k];
                if (k == j)
                    continue;
                nodes[c++] = node;
                bottom &= mesh->coordinates[3 * node + 2] == 0;
                middle += mesh->coordinates[3 * node] / 3;
            }
            if (!bottom)
                continue;
            memcpy(facets + 3 * n, nodes, sizeof nodes);
            tags[n++] = middle < 2 ? 1 : 2;
        }
    return n;
}

static void tags_make_edges(void **state) {
    (void)state;
    int32_t facets[3 * 2 * SLIDES_CELLS * SLIDES_CELLS + 3],
        tags[2 * SLIDES_CELLS * SLIDES_CELLS + 1];
    test_mesh box;
    test_mesh_box(&box, 3, SLIDES_CELLS);
    const planish_mesh *mesh = &box.mesh;
    planish_surface surface = {.facets = facets, .facet_tag = tags};
    surface.n_facets = bottom_facets(mesh, facets, tags);
    assert_int_equal(surface.n_facets, 2 * SLIDES_CELLS * SLIDES_CELLS);
    slides_found f = slides_find(mesh, &surface);
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const double *x = mesh->coordinates + 3 * i;
        const int on_line = x[2] == 0 && x[0] == 2; /* where the tags change */
        const int crosses[3] = {slides_is_side(x[0]) || on_line, slides_is_side(x[1]),
                                slides_is_side(x[2])};
        slides_expect_node(&f, i, 3, crosses);
    }
    slides_release(&f);
    surface.facet_tag = NULL; /* all the same */
    f = slides_find(mesh, &surface);
    expect_box(mesh, &f, -1);
    slides_release(&f);
    surface.facet_tag = tags; /* only on the bottom, but for its rim */
    surface.tagged_only = 1;
    f = slides_find(mesh, &surface);
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const double *x = mesh->coordinates + 3 * i;
        const int bottom = x[2] == 0 && !slides_is_side(x[0]) && !slides_is_side(x[1]);
        const int side = slides_is_side(x[0]) || slides_is_side(x[1]) || slides_is_side(x[2]);
        assert_int_equal(f.constraint[i], bottom ? x[0] == 2 ? PLANISH_CONSTRAINT_ON_LINE
                                                             : PLANISH_CONSTRAINT_ON_PLANE
                                          : side ? PLANISH_CONSTRAINT_FIXED
                                                 : PLANISH_CONSTRAINT_FREE);
    }
    slides_release(&f);
    /* A facet that the mesh has not holds its nodes. */
    const int32_t stranger[3] = {(int32_t)slides_node_at(mesh, 1, 1, 0),
                                 (int32_t)slides_node_at(mesh, 3, 3, 0),
                                 (int32_t)slides_node_at(mesh, 2, 2, 2)};
    memcpy(facets + 3 * surface.n_facets, stranger, sizeof stranger);
    tags[surface.n_facets++] = 1;
    surface.tagged_only = 0;
    f = slides_find(mesh, &surface);
    for (int j = 0; j < 3; j++)
        assert_int_equal(f.constraint[stranger[j]], PLANISH_CONSTRAINT_FIXED);
    slides_release(&f);
    test_mesh_destroy(&box);
}

/** Tagged edges are lines of the shape: inside a side, where tags differ corners; and those of no
 *  facet hold their nodes. */
static void tagged_edges_are_lines(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, SLIDES_CELLS);
    const planish_mesh *mesh = &box.mesh;
    int32_t edges[5][2], tags[] = {4, 4, 4, 4, 9};
    for (int k = 0; k < SLIDES_CELLS; k++) { /* across the side z = 0 at y = 1 */
        edges[k][0] = (int32_t)slides_node_at(mesh, k + 1, 1, 0);
        edges[k][1] = (int32_t)slides_node_at(mesh, k, 1, 0);
    }
    edges[4][0] = (int32_t)slides_node_at(mesh, 2, 2, 2);
    edges[4][1] = (int32_t)slides_node_at(mesh, 2, 2, 3);
    planish_surface surface = {.n_edges = 5, .edges = &edges[0][0], .edge_tag = tags};
    slides_found f = slides_find(mesh, &surface);
    for (int k = 1; k < SLIDES_CELLS; k++) {
        assert_int_equal(f.constraint[edges[k][1]], PLANISH_CONSTRAINT_ON_LINE);
        slides_expect_axis(f.direction + 3 * edges[k][1], 3, 0);
    }
    assert_int_equal(f.constraint[edges[3][0]], PLANISH_CONSTRAINT_FIXED); /* it meets the rim */
    assert_int_equal(f.constraint[edges[4][0]], PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(f.constraint[edges[4][1]], PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(f.constraint[slides_node_at(mesh, 1, 2, 0)], PLANISH_CONSTRAINT_ON_PLANE);
    slides_release(&f);
    tags[2] = tags[3] = 5;
    f = slides_find(mesh, &surface);
    assert_int_equal(f.constraint[edges[1][1]], PLANISH_CONSTRAINT_ON_LINE);
    assert_int_equal(f.constraint[edges[2][1]], PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(f.constraint[edges[3][1]], PLANISH_CONSTRAINT_ON_LINE);
    slides_release(&f);
    test_mesh_destroy(&box);
}

static void nodes_that_are_held_stay_held(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, SLIDES_CELLS);
    planish_mesh mesh = box.mesh;
    uint8_t *held = calloc((size_t)mesh.n_nodes, 1);
    const int64_t side = slides_node_at(&mesh, 2, 2, 0), inner = slides_node_at(&mesh, 2, 2, 2);
    const int64_t own = slides_node_at(&mesh, 1, 1, 0);
    held[side] = held[inner] = PLANISH_CONSTRAINT_FIXED;
    held[own] = PLANISH_CONSTRAINT_ON_SURFACE;
    mesh.constraint = held;
    slides_found f = slides_find(&mesh, NULL);
    assert_int_equal(f.constraint[side], PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(f.constraint[inner], PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(f.constraint[own], PLANISH_CONSTRAINT_ON_SURFACE);
    assert_int_equal(f.constraint[slides_node_at(&mesh, 3, 3, 0)], PLANISH_CONSTRAINT_ON_PLANE);
    assert_int_equal(planish_find_slides(&mesh, NULL, 1, held, f.direction, NULL, NULL), 0);
    assert_memory_equal(held, f.constraint, (size_t)mesh.n_nodes); /* in place */
    slides_release(&f);
    free(held);
    test_mesh_destroy(&box);
}

/** Of a side that is bent neither nodes within nor those of its rim slide. */
static void curved_sides_stay(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, SLIDES_CELLS);
    for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
        double *x = box.coordinates + 3 * i;
        if (x[2] == SLIDES_CELLS) /* the sides across x and y stay planar */
            x[2] += 0.2 * sin(x[0]) + 0.1 * sin(1.7 * x[1]);
    }
    slides_found f = slides_find(&box.mesh, NULL);
    for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
        const double *x = box.mesh.coordinates + 3 * i;
        const int top = x[2] > SLIDES_CELLS - 0.5;
        const int sides = slides_is_side(x[0]) + slides_is_side(x[1]) + (x[2] == 0);
        if (top)
            assert_int_equal(f.constraint[i], PLANISH_CONSTRAINT_FIXED);
        else if (sides == 1)
            assert_int_equal(f.constraint[i], PLANISH_CONSTRAINT_ON_PLANE);
        else if (sides == 2)
            assert_int_equal(f.constraint[i], PLANISH_CONSTRAINT_ON_LINE);
    }
    slides_release(&f);
    test_mesh_destroy(&box);
}

/** A finely meshed cylinder joins facet by facet, but is no plane as a whole. */
static void gentle_curves_are_no_planes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 12);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
            double *x = box.coordinates + i * dim;
            if (x[dim - 1] == 12)
                x[dim - 1] += 1e-6 * x[0] * x[0];
        }
        planish_surface surface = {.tolerance = 5e-7};
        slides_found f = slides_find(&box.mesh, &surface);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
            const double *x = box.mesh.coordinates + i * dim;
            if (x[dim - 1] >= 12)
                assert_int_equal(f.constraint[i], PLANISH_CONSTRAINT_FIXED);
        }
        slides_release(&f);
        surface.tolerance = 1e-4;
        f = slides_find(&box.mesh, &surface);
        int64_t sliding = 0;
        for (int64_t i = 0; i < box.mesh.n_nodes; i++)
            sliding += box.mesh.coordinates[i * dim + dim - 1] >= 12 &&
                       f.constraint[i] >= PLANISH_CONSTRAINT_ON_PLANE;
        assert_true(sliding > 10);
        slides_release(&f);
        test_mesh_destroy(&box);
    }
}

/** Coordinates of few digits, turned, tiny, huge and far away: the same nodes slide. */
static void numbers_do_not_matter(void **state) {
    (void)state;
    static const double scales[] = {1, 0x1p-900, 0x1p900, 1e-140, 1e140, 1};
    static const double shifts[] = {0, 0, 0, 0, 0, 1e6};
    test_mesh plain;
    test_mesh_box(&plain, 3, SLIDES_CELLS);
    slides_found f = slides_find(&plain.mesh, NULL);
    for (int k = 0; k < 6; k++) {
        test_mesh box;
        test_mesh_box(&box, 3, SLIDES_CELLS);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
            double *x = box.coordinates + 3 * i;
            const double y[3] = {(2 * x[0] - 2 * x[1] + x[2]) / 3, (x[0] + 2 * x[1] + 2 * x[2]) / 3,
                                 (-2 * x[0] - x[1] + 2 * x[2]) / 3};
            for (int d = 0; d < 3; d++)
                x[d] = y[d] * scales[k] + shifts[k];
        }
        slides_found g = slides_find(&box.mesh, NULL);
        assert_memory_equal(f.constraint, g.constraint, (size_t)box.mesh.n_nodes);
        slides_release(&g);
        test_mesh_destroy(&box);
    }
    slides_release(&f);
    test_mesh_destroy(&plain);
}

/** Two bodies that touch at a node in the flat top of one and the flat bottom of the other, however
 *  little that is tilted: no direction keeps both. */
/** Two boxes side by side that do not share the nodes between them: these stay, and all others
 * slide as those of a box alone. */
static void nodes_at_one_place_stay(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box, other, alone;
        test_mesh_box(&box, dim, SLIDES_CELLS);
        test_mesh_box(&other, dim, SLIDES_CELLS);
        test_mesh_box(&alone, dim, SLIDES_CELLS);
        const int64_t n = box.mesh.n_nodes;
        for (int64_t i = 0; i < n; i++)
            other.coordinates[i * dim] += SLIDES_CELLS;
        test_mesh_append(&box, &other, 0);
        for (int64_t i = 0; i < n; i++) /* -0 is 0 */
            if (box.coordinates[(n + i) * dim + 1] == 0)
                box.coordinates[(n + i) * dim + 1] = -0.0;
        slides_found f = slides_find(&box.mesh, NULL), of_one = slides_find(&alone.mesh, NULL);
        int64_t shared = 0;
        for (int64_t i = 0; i < n; i++) {
            const double x = box.coordinates[i * dim];
            shared += x == SLIDES_CELLS;
            assert_int_equal(f.constraint[i],
                             x == SLIDES_CELLS ? PLANISH_CONSTRAINT_FIXED : of_one.constraint[i]);
        }
        for (int64_t i = n; i < 2 * n; i++)
            if (box.coordinates[i * dim] == SLIDES_CELLS)
                assert_int_equal(f.constraint[i], PLANISH_CONSTRAINT_FIXED);
            else
                assert_int_equal(f.constraint[i], of_one.constraint[i - n]);
        assert_true(shared > 4);
        slides_release(&f);
        slides_release(&of_one);
        test_mesh_destroy(&box);
        test_mesh_destroy(&other);
        test_mesh_destroy(&alone);
    }
}

static void touching_sheets_stay(void **state) {
    (void)state;
    static const double corner[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    for (double tilt = 5e-5; tilt < 1; tilt *= 10) {
        double x[11][3] = {{0.2, 0, 0}, [5] = {0, 0, -1}, [10] = {0.2, 0, 1}};
        int32_t elements[8][4];
        for (int i = 0; i < 4; i++) {
            const int next = (i + 1) % 4;
            for (int d = 0; d < 2; d++) {
                x[1 + i][d] = corner[i][d];
                x[6 + i][d] = corner[i][d] + (d == 0 ? 0.2 : 0);
            }
            x[6 + i][2] = tilt * corner[i][0];
            memcpy(elements[i], (int32_t[]){0, 1 + i, 1 + next, 5}, sizeof elements[i]);
            memcpy(elements[4 + i], (int32_t[]){0, 6 + next, 6 + i, 10}, sizeof elements[i]);
        }
        const planish_mesh mesh = {.dim = 3,
                                   .n_nodes = 11,
                                   .n_elements = 8,
                                   .coordinates = &x[0][0],
                                   .elements = &elements[0][0]};
        slides_found f = slides_find(&mesh, NULL);
        assert_int_equal(f.constraint[0], PLANISH_CONSTRAINT_FIXED);
        slides_release(&f);
    }
}

static void garbage_does_no_harm(void **state) {
    (void)state;
    for (unsigned seed = 1; seed < 40; seed++)
        for (int dim = 2; dim <= 3; dim++) {
            test_mesh mesh;
            planish_plan *plan;
            planish_result result;
            test_mesh_garbage(&mesh, dim, 12, 25, seed);
            slides_found f = slides_find(&mesh.mesh, NULL);
            planish_mesh sliding = mesh.mesh;
            sliding.constraint = f.constraint;
            sliding.direction = f.direction;
            assert_int_equal(planish_plan_create(&sliding, NULL, &plan, NULL), 0);
            assert_int_equal(planish_smooth(plan, mesh.coordinates, NULL, &result, NULL), 0);
            planish_plan_destroy(plan);
            slides_release(&f);
            test_mesh_destroy(&mesh);
        }
}

static void expect_refusal(const planish_mesh *mesh, const planish_surface *surface,
                           const char *text) {
    planish_error error = {.text = ""};
    uint8_t constraint[200];
    double direction[600];
    assert_int_equal(planish_find_slides(mesh, surface, 1, constraint, direction, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    if (!strstr(error.text, text))
        fail_msg("'%s' lacks '%s'", error.text, text);
}

static void wrong_arguments_are_refused(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, 2);
    const int32_t facet[] = {0, 1, 27}, edge[] = {-1, 2};
    planish_surface surface = {.n_facets = 1, .facets = facet};
    expect_refusal(&box.mesh, &surface, "surface.facets has the node 27");
    surface = (planish_surface){.n_edges = 1, .edges = edge};
    expect_refusal(&box.mesh, &surface, "surface.edges has the node -1");
    /* Three times the first and twice the second are beyond 64 bits. */
    surface = (planish_surface){.n_facets = INT64_MAX / 3 + 1, .facets = facet};
    expect_refusal(&box.mesh, &surface, "surface.n_facets is ");
    surface = (planish_surface){.n_edges = (int64_t)1 << 62, .edges = edge};
    expect_refusal(&box.mesh, &surface, "surface.n_edges is ");
    surface = (planish_surface){.n_edges = 1};
    expect_refusal(&box.mesh, &surface, "surface.edges must not be NULL");
    surface = (planish_surface){.n_facets = -1};
    expect_refusal(&box.mesh, &surface, "must not be negative");
    surface = (planish_surface){.tolerance = 0.5};
    expect_refusal(&box.mesh, &surface, "surface.tolerance");
    surface.tolerance = NAN;
    expect_refusal(&box.mesh, &surface, "surface.tolerance");
    uint8_t constraint[27] = {0};
    double direction[81];
    assert_int_equal(planish_find_slides(&box.mesh, NULL, 1, constraint, NULL, NULL, NULL),
                     PLANISH_ERROR_ARGUMENT);
    for (int threads = -1; threads < 1026; threads += 1026)
        assert_int_equal(
            planish_find_slides(&box.mesh, NULL, threads, constraint, direction, NULL, NULL),
            PLANISH_ERROR_ARGUMENT);
    planish_mesh held = box.mesh;
    planish_error error;
    held.constraint = constraint;
    constraint[7] = 7;
    assert_int_equal(planish_find_slides(&held, NULL, 1, constraint, direction, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(error.node, 7);
    test_mesh_destroy(&box);
}

static void memory_may_run_out(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, 3);
    const int32_t edge[] = {0, 1};
    const planish_surface surface = {.n_edges = 1, .edges = edge};
    uint8_t constraint[64], untouched[64];
    double direction[192];
    int failures = 0, status = PLANISH_ERROR_MEMORY;
    memset(untouched, 77, sizeof untouched);
    memset(constraint, 77, sizeof constraint);
    for (; status == PLANISH_ERROR_MEMORY; failures++) {
        allocations_permit(failures);
        status = planish_find_slides(&box.mesh, &surface, 1, constraint, direction, NULL, NULL);
        allocations_permit(-1);
        if (status)
            assert_memory_equal(constraint, untouched, sizeof untouched);
    }
    assert_int_equal(status, 0);
    assert_true(failures > 20);
    test_mesh_destroy(&box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_has_sides_edges_and_corners),
        cmocka_unit_test(interfaces_are_slid_on),
        cmocka_unit_test(what_is_inside_may_be_told),
        cmocka_unit_test(tags_make_edges),
        cmocka_unit_test(tagged_edges_are_lines),
        cmocka_unit_test(nodes_that_are_held_stay_held),
        cmocka_unit_test(curved_sides_stay),
        cmocka_unit_test(gentle_curves_are_no_planes),
        cmocka_unit_test(numbers_do_not_matter),
        cmocka_unit_test(nodes_at_one_place_stay),
        cmocka_unit_test(touching_sheets_stay),
        cmocka_unit_test(garbage_does_no_harm),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
