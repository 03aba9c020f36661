/* planish_find_slides: the planes and lines of meshes whose shape is known. */
#include "support/allocations.h"
#include "support/cell_meshes.h"
#include "support/meshes.h"

#include "geometry/cell.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 4 };

/** What was found of a mesh. */
typedef struct found {
    uint8_t *constraint; /* [n] */
    double *direction;   /* [n][dim] */
    planish_slide_info info;
} found;

static found find_on(const planish_mesh *mesh, const planish_surface *surface, int threads) {
    found f;
    planish_error error = {.text = ""};
    f.constraint = malloc((size_t)mesh->n_nodes);
    f.direction = malloc((size_t)(mesh->n_nodes * mesh->dim) * sizeof(double));
    assert_int_equal(
        planish_find_slides(mesh, surface, threads, f.constraint, f.direction, &f.info, &error), 0);
    return f;
}

static found find(const planish_mesh *mesh, const planish_surface *surface) {
    return find_on(mesh, surface, 1);
}

static void release(found *f) {
    free(f->constraint);
    free(f->direction);
}

/** Whether x is on a side of the box across direction d. */
static int is_side(double x) {
    return x == 0 || x == CELLS;
}

/** The node at a place of the box. */
static int64_t node_at(const planish_mesh *mesh, double x, double y, double z) {
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        if (mesh->coordinates[3 * i] == x && mesh->coordinates[3 * i + 1] == y &&
            mesh->coordinates[3 * i + 2] == z)
            return i;
    fail_msg("no node at %g %g %g", x, y, z);
    return -1;
}

/** The directions are unit vectors, along an axis to the bit. */
static void expect_axis(const double *direction, int dim, int axis) {
    for (int d = 0; d < dim; d++)
        assert_true(d == axis ? fabs(direction[d]) == 1 : direction[d] == 0);
}

/** Node i of a box: as expected of how many planes through it cross which axes. */
static void expect_node(const found *f, int64_t i, int dim, const int *crosses) {
    int n = 0, axis = 0, rest = 0;
    for (int d = 0; d < dim; d++) {
        n += crosses[d];
        axis = crosses[d] ? d : axis;
        rest = crosses[d] ? rest : d;
    }
    if (n == 0) {
        assert_int_equal(f->constraint[i], PLANISH_CONSTRAINT_FREE);
    } else if (n == dim) {
        assert_int_equal(f->constraint[i], PLANISH_CONSTRAINT_FIXED);
    } else if (n == dim - 1) {
        assert_int_equal(f->constraint[i], PLANISH_CONSTRAINT_ON_LINE);
        expect_axis(f->direction + i * dim, dim, rest);
    } else {
        assert_int_equal(f->constraint[i], PLANISH_CONSTRAINT_ON_PLANE);
        expect_axis(f->direction + i * dim, dim, axis);
    }
}

/** The sides, edges and corners of a box, and a plane between regions at z = cut (y in 2-D). */
static void expect_box(const planish_mesh *mesh, const found *f, double cut) {
    const int dim = mesh->dim;
    int64_t planes = 0, lines = 0, surface = 0;
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const double *x = mesh->coordinates + i * dim;
        int crosses[3], any = 0;
        for (int d = 0; d < dim; d++) {
            crosses[d] = is_side(x[d]) || (d == dim - 1 && x[d] == cut);
            any |= crosses[d];
        }
        expect_node(f, i, dim, crosses);
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
            test_mesh_box(&box, dim, CELLS);
            if (renumber) {
                test_mesh_renumber(&box, 3, NULL);
                test_mesh_reverse_some(&box, 3, 8);
            }
            found f = find(&box.mesh, NULL), g = find_on(&box.mesh, NULL, 3);
            expect_box(&box.mesh, &f, -1);
            assert_memory_equal(f.constraint, g.constraint, (size_t)box.mesh.n_nodes);
            assert_memory_equal(f.direction, g.direction,
                                (size_t)(box.mesh.n_nodes * dim) * sizeof(double));
            release(&f);
            release(&g);
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
        test_mesh_box(&box, dim, CELLS);
        int32_t *region = two_regions(&box.mesh);
        const planish_surface surface = {.region = region};
        found f = find(&box.mesh, &surface);
        expect_box(&box.mesh, &f, 2);
        release(&f);
        free(region);
        test_mesh_destroy(&box);
    }
}

/** What a plan knows to be inside saves time and changes nothing. */
static void what_is_inside_may_be_told(void **state) {
    (void)state;
    test_mesh box;
    planish_plan *plan;
    test_mesh_box(&box, 3, CELLS);
    uint8_t *inside = malloc((size_t)box.mesh.n_nodes);
    assert_int_equal(planish_plan_create(&box.mesh, NULL, &plan, NULL), 0);
    planish_plan_get_free(plan, inside);
    int64_t n = 0;
    for (int64_t i = 0; i < box.mesh.n_nodes; i++)
        n += inside[i];
    assert_int_equal(n, (CELLS - 1) * (CELLS - 1) * (CELLS - 1));
    static const uint8_t marks[] = {1, 2, 255}; /* whatever is not 0 */
    for (size_t m = 0; m < sizeof marks; m++) {
        for (int64_t i = 0; i < box.mesh.n_nodes; i++)
            inside[i] = inside[i] ? marks[m] : 0;
        const planish_surface surface = {.is_inside = inside};
        found f = find(&box.mesh, &surface);
        expect_box(&box.mesh, &f, -1);
        release(&f);
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
    int32_t facets[3 * 2 * CELLS * CELLS + 3], tags[2 * CELLS * CELLS + 1];
    test_mesh box;
    test_mesh_box(&box, 3, CELLS);
    const planish_mesh *mesh = &box.mesh;
    planish_surface surface = {.facets = facets, .facet_tag = tags};
    surface.n_facets = bottom_facets(mesh, facets, tags);
    assert_int_equal(surface.n_facets, 2 * CELLS * CELLS);
    found f = find(mesh, &surface);
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const double *x = mesh->coordinates + 3 * i;
        const int on_line = x[2] == 0 && x[0] == 2; /* where the tags change */
        const int crosses[3] = {is_side(x[0]) || on_line, is_side(x[1]), is_side(x[2])};
        expect_node(&f, i, 3, crosses);
    }
    release(&f);
    surface.facet_tag = NULL; /* all the same */
    f = find(mesh, &surface);
    expect_box(mesh, &f, -1);
    release(&f);
    surface.facet_tag = tags; /* only on the bottom, but for its rim */
    surface.tagged_only = 1;
    f = find(mesh, &surface);
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const double *x = mesh->coordinates + 3 * i;
        const int bottom = x[2] == 0 && !is_side(x[0]) && !is_side(x[1]);
        const int side = is_side(x[0]) || is_side(x[1]) || is_side(x[2]);
        assert_int_equal(f.constraint[i], bottom ? x[0] == 2 ? PLANISH_CONSTRAINT_ON_LINE
                                                             : PLANISH_CONSTRAINT_ON_PLANE
                                          : side ? PLANISH_CONSTRAINT_FIXED
                                                 : PLANISH_CONSTRAINT_FREE);
    }
    release(&f);
    /* A facet that the mesh has not holds its nodes. */
    const int32_t stranger[3] = {(int32_t)node_at(mesh, 1, 1, 0), (int32_t)node_at(mesh, 3, 3, 0),
                                 (int32_t)node_at(mesh, 2, 2, 2)};
    memcpy(facets + 3 * surface.n_facets, stranger, sizeof stranger);
    tags[surface.n_facets++] = 1;
    surface.tagged_only = 0;
    f = find(mesh, &surface);
    for (int j = 0; j < 3; j++)
        assert_int_equal(f.constraint[stranger[j]], PLANISH_CONSTRAINT_FIXED);
    release(&f);
    test_mesh_destroy(&box);
}

/** Tagged edges are lines of the shape: inside a side, where tags differ corners; and those of no
 *  facet hold their nodes. */
static void tagged_edges_are_lines(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, CELLS);
    const planish_mesh *mesh = &box.mesh;
    int32_t edges[5][2], tags[] = {4, 4, 4, 4, 9};
    for (int k = 0; k < CELLS; k++) { /* across the side z = 0 at y = 1 */
        edges[k][0] = (int32_t)node_at(mesh, k + 1, 1, 0);
        edges[k][1] = (int32_t)node_at(mesh, k, 1, 0);
    }
    edges[4][0] = (int32_t)node_at(mesh, 2, 2, 2);
    edges[4][1] = (int32_t)node_at(mesh, 2, 2, 3);
    planish_surface surface = {.n_edges = 5, .edges = &edges[0][0], .edge_tag = tags};
    found f = find(mesh, &surface);
    for (int k = 1; k < CELLS; k++) {
        assert_int_equal(f.constraint[edges[k][1]], PLANISH_CONSTRAINT_ON_LINE);
        expect_axis(f.direction + 3 * edges[k][1], 3, 0);
    }
    assert_int_equal(f.constraint[edges[3][0]], PLANISH_CONSTRAINT_FIXED); /* it meets the rim */
    assert_int_equal(f.constraint[edges[4][0]], PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(f.constraint[edges[4][1]], PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(f.constraint[node_at(mesh, 1, 2, 0)], PLANISH_CONSTRAINT_ON_PLANE);
    release(&f);
    tags[2] = tags[3] = 5;
    f = find(mesh, &surface);
    assert_int_equal(f.constraint[edges[1][1]], PLANISH_CONSTRAINT_ON_LINE);
    assert_int_equal(f.constraint[edges[2][1]], PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(f.constraint[edges[3][1]], PLANISH_CONSTRAINT_ON_LINE);
    release(&f);
    test_mesh_destroy(&box);
}

static void nodes_that_are_held_stay_held(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, CELLS);
    planish_mesh mesh = box.mesh;
    uint8_t *held = calloc((size_t)mesh.n_nodes, 1);
    const int64_t side = node_at(&mesh, 2, 2, 0), inner = node_at(&mesh, 2, 2, 2);
    const int64_t own = node_at(&mesh, 1, 1, 0);
    held[side] = held[inner] = PLANISH_CONSTRAINT_FIXED;
    held[own] = PLANISH_CONSTRAINT_ON_SURFACE;
    mesh.constraint = held;
    found f = find(&mesh, NULL);
    assert_int_equal(f.constraint[side], PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(f.constraint[inner], PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(f.constraint[own], PLANISH_CONSTRAINT_ON_SURFACE);
    assert_int_equal(f.constraint[node_at(&mesh, 3, 3, 0)], PLANISH_CONSTRAINT_ON_PLANE);
    assert_int_equal(planish_find_slides(&mesh, NULL, 1, held, f.direction, NULL, NULL), 0);
    assert_memory_equal(held, f.constraint, (size_t)mesh.n_nodes); /* in place */
    release(&f);
    free(held);
    test_mesh_destroy(&box);
}

/** Of a side that is bent neither nodes within nor those of its rim slide. */
static void curved_sides_stay(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, CELLS);
    for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
        double *x = box.coordinates + 3 * i;
        if (x[2] == CELLS) /* the sides across x and y stay planar */
            x[2] += 0.2 * sin(x[0]) + 0.1 * sin(1.7 * x[1]);
    }
    found f = find(&box.mesh, NULL);
    for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
        const double *x = box.mesh.coordinates + 3 * i;
        const int top = x[2] > CELLS - 0.5;
        const int sides = is_side(x[0]) + is_side(x[1]) + (x[2] == 0);
        if (top)
            assert_int_equal(f.constraint[i], PLANISH_CONSTRAINT_FIXED);
        else if (sides == 1)
            assert_int_equal(f.constraint[i], PLANISH_CONSTRAINT_ON_PLANE);
        else if (sides == 2)
            assert_int_equal(f.constraint[i], PLANISH_CONSTRAINT_ON_LINE);
    }
    release(&f);
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
        found f = find(&box.mesh, &surface);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
            const double *x = box.mesh.coordinates + i * dim;
            if (x[dim - 1] >= 12)
                assert_int_equal(f.constraint[i], PLANISH_CONSTRAINT_FIXED);
        }
        release(&f);
        surface.tolerance = 1e-4;
        f = find(&box.mesh, &surface);
        int64_t sliding = 0;
        for (int64_t i = 0; i < box.mesh.n_nodes; i++)
            sliding += box.mesh.coordinates[i * dim + dim - 1] >= 12 &&
                       f.constraint[i] >= PLANISH_CONSTRAINT_ON_PLANE;
        assert_true(sliding > 10);
        release(&f);
        test_mesh_destroy(&box);
    }
}

/** Coordinates of few digits, turned, tiny, huge and far away: the same nodes slide. */
static void numbers_do_not_matter(void **state) {
    (void)state;
    static const double scales[] = {1, 0x1p-900, 0x1p900, 1e-140, 1e140, 1};
    static const double shifts[] = {0, 0, 0, 0, 0, 1e6};
    test_mesh plain;
    test_mesh_box(&plain, 3, CELLS);
    found f = find(&plain.mesh, NULL);
    for (int k = 0; k < 6; k++) {
        test_mesh box;
        test_mesh_box(&box, 3, CELLS);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
            double *x = box.coordinates + 3 * i;
            const double y[3] = {(2 * x[0] - 2 * x[1] + x[2]) / 3, (x[0] + 2 * x[1] + 2 * x[2]) / 3,
                                 (-2 * x[0] - x[1] + 2 * x[2]) / 3};
            for (int d = 0; d < 3; d++)
                x[d] = y[d] * scales[k] + shifts[k];
        }
        found g = find(&box.mesh, NULL);
        assert_memory_equal(f.constraint, g.constraint, (size_t)box.mesh.n_nodes);
        release(&g);
        test_mesh_destroy(&box);
    }
    release(&f);
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
        test_mesh_box(&box, dim, CELLS);
        test_mesh_box(&other, dim, CELLS);
        test_mesh_box(&alone, dim, CELLS);
        const int64_t n = box.mesh.n_nodes;
        for (int64_t i = 0; i < n; i++)
            other.coordinates[i * dim] += CELLS;
        test_mesh_append(&box, &other, 0);
        for (int64_t i = 0; i < n; i++) /* -0 is 0 */
            if (box.coordinates[(n + i) * dim + 1] == 0)
                box.coordinates[(n + i) * dim + 1] = -0.0;
        found f = find(&box.mesh, NULL), of_one = find(&alone.mesh, NULL);
        int64_t shared = 0;
        for (int64_t i = 0; i < n; i++) {
            const double x = box.coordinates[i * dim];
            shared += x == CELLS;
            assert_int_equal(f.constraint[i],
                             x == CELLS ? PLANISH_CONSTRAINT_FIXED : of_one.constraint[i]);
        }
        for (int64_t i = n; i < 2 * n; i++)
            if (box.coordinates[i * dim] == CELLS)
                assert_int_equal(f.constraint[i], PLANISH_CONSTRAINT_FIXED);
            else
                assert_int_equal(f.constraint[i], of_one.constraint[i - n]);
        assert_true(shared > 4);
        release(&f);
        release(&of_one);
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
        found f = find(&mesh, NULL);
        assert_int_equal(f.constraint[0], PLANISH_CONSTRAINT_FIXED);
        release(&f);
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
            found f = find(&mesh.mesh, NULL);
            planish_mesh sliding = mesh.mesh;
            sliding.constraint = f.constraint;
            sliding.direction = f.direction;
            assert_int_equal(planish_plan_create(&sliding, NULL, &plan, NULL), 0);
            assert_int_equal(planish_smooth(plan, mesh.coordinates, NULL, &result, NULL), 0);
            planish_plan_destroy(plan);
            release(&f);
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

/* ---- elements of other types ---------------------------------------------------------------- */

/** Make a box of a kind: straight, with mids, with those of faces, too (raise 0 to 2). */
static cell_box *box_of(int kind, int raise) {
    cell_box *box = cell_box_create((cell_box_kind)kind, CELLS);
    if (raise == 0)
        return box;
    cell_box *raised = cell_box_raise(box, raise == 2);
    cell_box_destroy(box);
    return raised;
}

/** Whether a node is a corner: those of the box are at whole places, centres of pyramids inside. */
static int is_corner(const planish_mesh *mesh, int64_t node) {
    int whole = 1, half = 1;
    for (int d = 0; d < mesh->dim; d++) {
        const double x = mesh->coordinates[node * mesh->dim + d];
        whole &= x == floor(x);
        half &= x != floor(x);
    }
    return whole || half;
}

/** As expect_box, of any cells; mids are free, as they follow. axis: of the cut. */
static void expect_box_of_cells(const planish_mesh *mesh, const found *f, int axis, double cut) {
    const int dim = mesh->dim;
    int64_t n[3] = {0};
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const double *x = mesh->coordinates + i * dim;
        int crosses[3] = {0};
        for (int d = 0; d < dim && is_corner(mesh, i); d++)
            crosses[d] = is_side(x[d]) || (d == axis && x[d] == cut);
        expect_node(f, i, dim, crosses);
        n[0] += f->constraint[i] == PLANISH_CONSTRAINT_ON_PLANE;
        n[1] += f->constraint[i] == PLANISH_CONSTRAINT_ON_LINE;
    }
    assert_int_equal(f->info.n_on_plane, n[0]);
    assert_int_equal(f->info.n_on_line, n[1]);
    assert_true(n[1] > 0 && (dim == 2 || n[0] > 0));
}

/** The region of a cell: by the last coordinate of the middle of its corners. */
static int32_t half_of(const planish_mesh *mesh, int64_t cell) {
    const int32_t *node = mesh->cells->node + mesh->cells->offset[cell];
    const int last = mesh->dim - 1;
    double middle = 0;
    for (int j = 0; j < 4; j++)
        middle += mesh->coordinates[(int64_t)node[j] * mesh->dim + last] / 4;
    for (int j = 4; j < mesh->cells->offset[cell + 1] - mesh->cells->offset[cell]; j++)
        middle = fmin(middle, mesh->coordinates[(int64_t)node[j] * mesh->dim + last]);
    return middle < 2 ? 7 : -3;
}

static void boxes_of_any_cells_have_sides(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int raise = 0; raise < 3; raise++) {
            cell_box *box = box_of(kind, raise);
            int32_t *region = malloc((size_t)box->cells.n * sizeof *region);
            for (int64_t i = 0; i < box->cells.n; i++)
                region[i] = half_of(&box->mesh, i);
            const planish_surface surface = {.region = region};
            for (int threads = 1; threads <= 3; threads += 2) {
                found f = find_on(&box->mesh, NULL, threads);
                expect_box_of_cells(&box->mesh, &f, 0, -1);
                release(&f);
                f = find_on(&box->mesh, &surface, threads);
                expect_box_of_cells(&box->mesh, &f, box->mesh.dim - 1, 2);
                release(&f);
            }
            free(region);
            cell_box_destroy(box);
        }
}

/** Quadrilaterals of which one node is off the plane are not planar: their nodes stay, and so do those
 *  of a whole side that is bent. */
static void quadrilaterals_that_are_not_planar_stay(void **state) {
    (void)state;
    static const int kinds[] = {BOX_HEXAHEDRA, BOX_PYRAMIDS, BOX_WEDGES};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        cell_box *box = box_of(kinds[k], 0);
        const int64_t off =
            node_at(&box->mesh, 2, 0, 2); /* wedges have quadrilaterals there, too */
        box->x[3 * off + 1] = -0.01;
        found f = find(&box->mesh, NULL);
        for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
            const double *x = box->mesh.coordinates + 3 * i;
            const int is_around = fabs(x[0] - 2) <= 1 && x[1] <= 0 && fabs(x[2] - 2) <= 1;
            const int crosses[3] = {is_side(x[0]) || is_around, is_side(x[1]) || is_around,
                                    is_side(x[2]) || is_around};
            expect_node(&f, i, 3, crosses);
        }
        release(&f);
        cell_box_destroy(box);
    }
}

/** A quadrilateral that is not convex is in its plane as others are. */
static void darts_are_planar(void **state) {
    (void)state;
    for (int corner = 0; corner < 4; corner++) {
        cell_box *box = box_of(BOX_HEXAHEDRA, 0);
        const double x = 1 + (corner == 1 || corner == 2), z = 1 + corner / 2;
        const int64_t node = node_at(&box->mesh, x, 0, z);
        box->x[3 * node] += x > 1 ? -0.7 : 0.7; /* past the diagonal of a side's quadrilateral */
        box->x[3 * node + 2] += z > 1 ? -0.7 : 0.7;
        found f = find(&box->mesh, NULL);
        for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
            const double *at = box->x + 3 * i;
            const int crosses[3] = {is_side(at[0]), is_side(at[1]), is_side(at[2])};
            expect_node(&f, i, 3, crosses);
        }
        release(&f);
        cell_box_destroy(box);
    }
}

/** Split the hexahedra of a box above z = 2 into tetrahedra, whose triangles meet quadrilaterals at
 *  z = 2. */
static void split_upper_half(cell_box *box) {
    static const uint8_t cut[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                      {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
    const int64_t n = box->cells.n;
    int32_t(*corner)[8] = malloc((size_t)n * sizeof *corner);
    memcpy(corner, box->node, (size_t)n * sizeof *corner);
    box->type = realloc(box->type, (size_t)(6 * n));
    box->offset = realloc(box->offset, (size_t)(6 * n + 1) * sizeof *box->offset);
    int64_t cells = 0;
    for (int64_t i = 0; i < n; i++) {
        const int is_upper = box->x[3 * (int64_t)corner[i][0] + 2] >= 2;
        for (int t = 0; t < (is_upper ? 6 : 1); t++, cells++) {
            int32_t *to = box->node + box->offset[cells];
            for (int j = 0; j < (is_upper ? 4 : 8); j++)
                to[j] = corner[i][is_upper ? cut[t][j] : j];
            box->type[cells] = is_upper ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_HEXAHEDRON;
            box->offset[cells + 1] = box->offset[cells] + (is_upper ? 4 : 8);
        }
    }
    free(corner);
    box->cells =
        (planish_cells){.n = cells, .type = box->type, .offset = box->offset, .node = box->node};
    box->mesh.n_elements = cells;
}

/** A quadrilateral against two triangles is a boundary of both sides: nodes there stay. */
static void quadrilaterals_against_triangles_stay(void **state) {
    (void)state;
    cell_box *box = box_of(BOX_HEXAHEDRA, 0);
    split_upper_half(box);
    found f = find(&box->mesh, NULL);
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        const double *x = box->mesh.coordinates + 3 * i;
        const int is_between = x[2] == 2;
        const int crosses[3] = {is_side(x[0]) || is_between, is_side(x[1]) || is_between,
                                is_side(x[2]) || is_between};
        expect_node(&f, i, 3, crosses);
    }
    release(&f);
    cell_box_destroy(box);
}

/** Tagged quadrilaterals end where the tag changes, by their corners alone; those that the mesh has
 *  not hold their corners. */
static void tagged_quadrilaterals_make_edges(void **state) {
    (void)state;
    for (int raise = 0; raise < 3; raise++) {
        cell_box *box = box_of(BOX_HEXAHEDRA, raise);
        const planish_mesh *mesh = &box->mesh;
        int32_t facets[4 * CELLS * CELLS + 4], tags[CELLS * CELLS + 1];
        int64_t offset[CELLS * CELLS + 2] = {0}, n = 0;
        for (int64_t i = 0; i < box->cells.n; i++) {
            const int32_t *node = box->node + box->offset[i];
            if (box->x[3 * (int64_t)node[0] + 2] != 0)
                continue;
            for (int j = 0; j < 4; j++) /* of the base, the other way round for some */
                facets[4 * n + j] = node[n % 2 ? 3 - j : j];
            tags[n] = box->x[3 * (int64_t)node[0]] < 2 ? 1 : 2;
            n++;
            offset[n] = 4 * n;
        }
        planish_surface surface = {
            .n_facets = n, .facets = facets, .facet_tag = tags, .facet_offset = offset};
        assert_int_equal(n, CELLS * CELLS);
        found f = find(mesh, &surface);
        for (int64_t i = 0; i < mesh->n_nodes; i++) {
            const double *x = mesh->coordinates + 3 * i;
            const int counts = is_corner(mesh, i), on_line = x[2] == 0 && x[0] == 2;
            const int crosses[3] = {counts && (is_side(x[0]) || on_line), counts && is_side(x[1]),
                                    counts && is_side(x[2])};
            expect_node(&f, i, 3, crosses);
        }
        release(&f);
        surface.tagged_only = 1;
        f = find(mesh, &surface);
        const int64_t bottom = node_at(mesh, 1, 1, 0), top = node_at(mesh, 1, 1, CELLS);
        assert_int_equal(f.constraint[bottom], PLANISH_CONSTRAINT_ON_PLANE);
        assert_int_equal(f.constraint[top], PLANISH_CONSTRAINT_FIXED);
        release(&f);
        surface.tagged_only = 0;
        for (int j = 0; j < 4; j++) /* a facet within */
            facets[4 * n + j] = (int32_t)node_at(mesh, 1 + (j == 1 || j == 2), 1, 1 + 2 * (j / 2));
        tags[n] = 3;
        offset[n + 1] = 4 * (n + 1);
        surface.n_facets++;
        f = find(mesh, &surface);
        for (int j = 0; j < 4; j++)
            assert_int_equal(f.constraint[facets[4 * n + j]], PLANISH_CONSTRAINT_FIXED);
        release(&f);
        cell_box_destroy(box);
    }
}

/** A mid of the surface that is off its edge fixes its ends; the middle of a face only if it is off
 *  the plane of the face, and then all of its corners. */
static void curved_cells_stay(void **state) {
    (void)state;
    static const struct {
        double at[3], off[3]; /* the mid, and by how much */
        int n_fixed;          /* nodes beside those that are always */
    } cases[] = {{{1.5, 0, 1}, {0, 0, 0.1}, 2},     {{1.5, 0, 1}, {0, -0.1, 0}, 6},
                 {{1.5, 0, 1.5}, {0.1, 0, 0}, 0},   {{1.5, 0, 1.5}, {0, -0.1, 0}, 4},
                 {{1.5, 1.5, 1.5}, {0, 0.1, 0}, 0}, {{1.5, 1, 1.5}, {0, 0.1, 0}, 0}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        cell_box *box = box_of(BOX_HEXAHEDRA, 2);
        const int64_t mid = node_at(&box->mesh, cases[k].at[0], cases[k].at[1], cases[k].at[2]);
        found f = find(&box->mesh, NULL);
        int64_t n = 0;
        for (int64_t i = 0; i < box->mesh.n_nodes; i++)
            n -= f.constraint[i] == PLANISH_CONSTRAINT_FIXED;
        release(&f);
        for (int d = 0; d < 3; d++)
            box->x[3 * mid + d] += cases[k].off[d];
        f = find(&box->mesh, NULL);
        for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
            n += f.constraint[i] == PLANISH_CONSTRAINT_FIXED;
            if (f.constraint[i] == PLANISH_CONSTRAINT_FIXED && cases[k].n_fixed == 4)
                assert_true(fabs(box->x[3 * i] - 1.5) <= 0.5 || is_side(box->x[3 * i]));
        }
        assert_int_equal(n, cases[k].n_fixed);
        release(&f);
        cell_box_destroy(box);
    }
}

/** Move a corner by way; mids, and nodes of faces and cells, follow. */
static void move_corner(cell_box *box, int64_t corner, const double way[3]) {
    uint8_t *is_moved = calloc((size_t)box->mesh.n_nodes, 1);
    for (int64_t i = 0; i < box->cells.n; i++) {
        const pl_cell_type *type = pl_cell_type_of(box->type[i]);
        const int32_t *node = box->node + box->offset[i];
        int at = 0;
        while (at < type->shape->n_corners && node[at] != corner)
            at++;
        for (int k = 0; at < type->shape->n_corners && k < type->n_nodes; k++) {
            const uint8_t parents = pl_cell_parents(type, k);
            if (!(parents >> at & 1) || is_moved[node[k]])
                continue;
            is_moved[node[k]] = 1;
            for (int d = 0; d < 3; d++)
                box->x[3 * (int64_t)node[k] + d] += way[d] / __builtin_popcount(parents);
        }
    }
    free(is_moved);
}

/** Faces whose corners have moved in their planes, and those inside, are straight where their middles
 *  have followed: nodes slide as before. */
static void middles_that_follow_are_straight(void **state) {
    (void)state;
    for (int raise = 1; raise < 3; raise++) {
        cell_box *box = box_of(BOX_HEXAHEDRA, raise);
        const planish_mesh *mesh = &box->mesh;
        found f = find(mesh, NULL);
        const int64_t corner[] = {node_at(mesh, 1, 0, 1), node_at(mesh, 3, 1, 1),
                                  node_at(mesh, 2, 2, 0)};
        const double way[3][3] = {{0.2, 0, 0.1}, {-0.1, 0.2, 0.2}, {0.3, -0.2, 0}};
        planish_plan *plan;
        planish_options options;
        planish_options_init(&options);
        for (int i = 0; i < 3; i++)
            move_corner(box, corner[i], way[i]);
        found g = find(mesh, NULL);
        assert_memory_equal(f.constraint, g.constraint, (size_t)mesh->n_nodes);
        planish_mesh slid = *mesh;
        slid.constraint = g.constraint;
        slid.direction = g.direction;
        uint8_t *held = malloc((size_t)mesh->n_nodes);
        assert_int_equal(planish_plan_create(&slid, &options, &plan, NULL), 0);
        assert_int_equal(planish_plan_get_held(plan, NULL, held, NULL), 0);
        for (int64_t i = 0; i < mesh->n_nodes; i++)
            if (g.constraint[i] == PLANISH_CONSTRAINT_ON_PLANE)
                assert_int_equal(held[i], 0);
        planish_plan_destroy(plan);
        free(held);
        release(&f);
        release(&g);
        cell_box_destroy(box);
    }
}

static void memory_for_cells_may_run_out(void **state) {
    (void)state;
    cell_box *box = box_of(BOX_MIXED, 0);
    const int32_t facets[] = {0, 1, 6, 5};
    const int64_t offset[] = {0, 4};
    const planish_surface surface = {.n_facets = 1, .facets = facets, .facet_offset = offset};
    uint8_t constraint[512];
    double direction[3 * 512];
    int failures = 0, status = PLANISH_ERROR_MEMORY;
    assert_true(box->mesh.n_nodes <= 512);
    for (; status == PLANISH_ERROR_MEMORY; failures++) {
        allocations_permit(failures);
        status = planish_find_slides(&box->mesh, &surface, 1, constraint, direction, NULL, NULL);
        allocations_permit(-1);
    }
    assert_int_equal(status, 0);
    assert_true(failures > 20);
    cell_box_destroy(box);
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
        cmocka_unit_test(boxes_of_any_cells_have_sides),
        cmocka_unit_test(quadrilaterals_that_are_not_planar_stay),
        cmocka_unit_test(darts_are_planar),
        cmocka_unit_test(quadrilaterals_against_triangles_stay),
        cmocka_unit_test(tagged_quadrilaterals_make_edges),
        cmocka_unit_test(curved_cells_stay),
        cmocka_unit_test(middles_that_follow_are_straight),
        cmocka_unit_test(memory_for_cells_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
