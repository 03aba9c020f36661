/* Why nodes do not move: each reason, their identity with what the plan says, and any threads. */
#include "support/meshes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 5, SIDE = CELLS + 1 };

static planish_options defaults(int threads) {
    planish_options options;
    planish_options_init(&options);
    options.threads = threads;
    return options;
}

/** The reasons on several threads, which agree, and agree with the plan's own counts. */
static uint8_t *reasons_of(const planish_mesh *mesh, const planish_options *given) {
    const size_t n = (size_t)mesh->n_nodes;
    uint8_t *reason[2] = {malloc(n), malloc(n)}, *is_free = malloc(n);
    for (int i = 0; i < 2; i++) {
        planish_options options = *given;
        planish_plan *plan;
        planish_plan_info info;
        int64_t moves = 0;
        options.threads = i ? 5 : 1;
        assert_int_equal(planish_plan_create(mesh, &options, &plan, NULL), 0);
        planish_plan_get_info(plan, &info);
        planish_plan_get_free(plan, is_free);
        assert_int_equal(planish_plan_get_held(plan, mesh->coordinates, reason[i], NULL), 0);
        for (size_t k = 0; k < n; k++) {
            moves += reason[i][k] == 0;
            assert_true(!is_free[k] || reason[i][k] == 0);
            assert_true(reason[i][k] != PLANISH_HELD_DOUBLED);
        }
        assert_int_equal(moves, info.n_free + info.n_sliding);
        planish_plan_destroy(plan);
    }
    assert_memory_equal(reason[0], reason[1], n);
    free(is_free);
    free(reason[1]);
    return reason[0];
}

static int64_t count(const uint8_t *reason, int64_t n, unsigned bit) {
    int64_t found = 0;
    for (int64_t i = 0; i < n; i++)
        found += (reason[i] & bit) != 0;
    return found;
}

static int is_on_box(const planish_mesh *mesh, int64_t node) {
    int on = 0;
    for (int d = 0; d < mesh->dim; d++) {
        const double x = mesh->coordinates[node * mesh->dim + d];
        on |= x <= 0 || x >= CELLS;
    }
    return on;
}

/** A node in the middle of the box. */
static int64_t middle(int dim) {
    const int64_t at = SIDE / 2;
    return dim == 3 ? (at * SIDE + at) * SIDE + at : at * SIDE + at;
}

static void nodes_of_the_surface_are_on_the_boundary(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const planish_options options = defaults(1);
        test_mesh box;
        test_mesh_box(&box, dim, CELLS);
        uint8_t *reason = reasons_of(&box.mesh, &options);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++)
            assert_int_equal(reason[i], is_on_box(&box.mesh, i) ? PLANISH_HELD_BOUNDARY : 0);
        free(reason);
        test_mesh_destroy(&box);
    }
}

static void a_node_has_all_its_reasons(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const planish_options options = defaults(1);
        test_mesh box;
        test_mesh_box(&box, dim, CELLS);
        uint8_t *constraint = calloc((size_t)box.mesh.n_nodes, 1);
        constraint[0] = constraint[middle(dim)] = PLANISH_CONSTRAINT_FIXED;
        box.mesh.constraint = constraint;
        uint8_t *reason = reasons_of(&box.mesh, &options);
        assert_int_equal(reason[0], PLANISH_HELD_BOUNDARY | PLANISH_HELD_FIXED);
        assert_int_equal(reason[middle(dim)], PLANISH_HELD_FIXED);
        assert_int_equal(count(reason, box.mesh.n_nodes, PLANISH_HELD_FIXED), 2);
        free(reason);
        free(constraint);
        test_mesh_destroy(&box);
    }
}

static void nodes_that_slide_have_no_reason(void **state) {
    (void)state;
    const planish_options options = defaults(1);
    test_mesh box;
    test_mesh_box(&box, 3, CELLS);
    const size_t n = (size_t)box.mesh.n_nodes;
    uint8_t *constraint = malloc(n);
    double *direction = malloc(3 * n * sizeof *direction);
    assert_int_equal(planish_find_slides(&box.mesh, NULL, 1, constraint, direction, NULL, NULL), 0);
    box.mesh.constraint = constraint;
    box.mesh.direction = direction;
    uint8_t *reason = reasons_of(&box.mesh, &options);
    for (size_t i = 0; i < n; i++)
        assert_int_equal(reason[i] != 0, constraint[i] == PLANISH_CONSTRAINT_FIXED);
    assert_int_equal(count(reason, box.mesh.n_nodes, PLANISH_HELD_BOUNDARY), 8);
    free(reason);
    free(direction);
    free(constraint);
    test_mesh_destroy(&box);
}

/** Two boxes side by side that do not share the nodes between them; and unused nodes. */
static void nodes_at_one_place_are_doubled(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const planish_options options = defaults(1);
        test_mesh box, other;
        test_mesh_box(&box, dim, CELLS);
        test_mesh_box(&other, dim, CELLS);
        for (int64_t i = 0; i < other.mesh.n_nodes; i++)
            other.coordinates[i * dim] += CELLS;
        test_mesh_append(&box, &other, 0);
        uint8_t *reason = reasons_of(&box.mesh, &options);
        const int64_t on_side = dim == 3 ? SIDE * SIDE : SIDE;
        assert_int_equal(count(reason, box.mesh.n_nodes, PLANISH_HELD_DOUBLED), 2 * on_side);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++)
            if (reason[i] & PLANISH_HELD_DOUBLED)
                assert_true(box.coordinates[i * dim] == CELLS && reason[i] & PLANISH_HELD_BOUNDARY);
        free(reason);
        test_mesh_destroy(&other);
        test_mesh_destroy(&box);
    }
}

/** Each element has its own points. */
static void each_element_has_its_own_points(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const planish_options options = defaults(1);
        test_mesh box, apart;
        test_mesh_box(&box, dim, CELLS);
        const int64_t n = box.mesh.n_elements * (dim + 1);
        int32_t *elements = malloc((size_t)n * sizeof *elements);
        double *x = malloc((size_t)(n * dim) * sizeof *x);
        for (int64_t i = 0; i < n; i++) {
            elements[i] = (int32_t)i;
            memcpy(x + i * dim, box.coordinates + (int64_t)box.elements[i] * dim,
                   (size_t)dim * sizeof *x);
        }
        test_mesh_create(&apart, dim, n, x, box.mesh.n_elements, elements);
        uint8_t *reason = reasons_of(&apart.mesh, &options);
        assert_int_equal(count(reason, n, PLANISH_HELD_BOUNDARY), n);
        assert_true(count(reason, n, PLANISH_HELD_DOUBLED) >= n - 4);
        free(reason);
        free(x);
        free(elements);
        test_mesh_destroy(&apart);
        test_mesh_destroy(&box);
    }
}

/** No facet says why a node with too many elements is held. */
static void too_many_elements_and_unused_nodes(void **state) {
    (void)state;
    const planish_options options = defaults(1);
    const int32_t n = 22000;
    test_mesh hub, other;
    test_mesh_double_pyramid(&hub, n);
    test_mesh_create(&other, 3, hub.mesh.n_nodes + 1, NULL, hub.mesh.n_elements, hub.elements);
    memcpy(other.coordinates, hub.coordinates,
           (size_t)(3 * hub.mesh.n_nodes) * sizeof *hub.coordinates);
    uint8_t *reason = reasons_of(&other.mesh, &options);
    assert_int_equal(reason[0], PLANISH_HELD_NONMANIFOLD);
    assert_int_equal(reason[hub.mesh.n_nodes], PLANISH_HELD_UNUSED);
    assert_int_equal(count(reason, other.mesh.n_nodes, PLANISH_HELD_BOUNDARY),
                     hub.mesh.n_nodes - 1);
    free(reason);
    test_mesh_destroy(&other);
    test_mesh_destroy(&hub);
}

/** A duplicate in the middle of the box. */
static void duplicates_are_no_manifold(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const planish_options options = defaults(1);
        test_mesh box, more;
        test_mesh_box(&box, dim, CELLS);
        const int64_t m = box.mesh.n_elements, k = dim + 1;
        int32_t *elements = malloc((size_t)((m + 1) * k) * sizeof *elements);
        memcpy(elements, box.elements, (size_t)(m * k) * sizeof *elements);
        int64_t copied = 0;
        for (int64_t i = 0, inside = 0; i < m && !inside; i++) {
            inside = 1;
            for (int64_t j = 0; j < k; j++)
                inside &= !is_on_box(&box.mesh, box.elements[i * k + j]);
            copied = i;
        }
        memcpy(elements + m * k, elements + copied * k, (size_t)k * sizeof *elements);
        test_mesh_create(&more, dim, box.mesh.n_nodes, box.coordinates, m + 1, elements);
        uint8_t *reason = reasons_of(&more.mesh, &options);
        assert_int_equal(count(reason, box.mesh.n_nodes, PLANISH_HELD_NONMANIFOLD), k);
        for (int64_t j = 0; j < k; j++)
            assert_int_equal(reason[elements[copied * k + j]], PLANISH_HELD_NONMANIFOLD);
        free(reason);
        free(elements);
        test_mesh_destroy(&more);
        test_mesh_destroy(&box);
    }
}

static void periodic_pairs_are_told(void **state) {
    (void)state;
    const planish_options options = defaults(1);
    test_mesh box;
    test_mesh_box(&box, 2, CELLS);
    const int32_t inside = (int32_t)middle(2);
    const int32_t pairs[2][2] = {{0, 1}, {inside, inside + 1}};
    box.mesh.n_periodic = 2;
    box.mesh.periodic = pairs[0];
    uint8_t *reason = reasons_of(&box.mesh, &options);
    assert_int_equal(reason[0], PLANISH_HELD_BOUNDARY | PLANISH_HELD_PERIODIC);
    assert_int_equal(reason[inside], PLANISH_HELD_PERIODIC);
    assert_int_equal(count(reason, box.mesh.n_nodes, PLANISH_HELD_PERIODIC), 4);
    free(reason);
    test_mesh_destroy(&box);
}

/** Few bad elements: the plan knows a part of the mesh alone, and still the boundary of all. Many:
 *  it knows all. */
static void nodes_that_are_not_chosen(void **state) {
    static const double limits[] = {1.5, 2.2, 2.6, 1e6};
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
            planish_options options = defaults(1);
            test_mesh box;
            test_mesh_box(&box, dim, CELLS);
            test_mesh_perturb(&box, 0.14, 12345);
            options.only_worse_than = limits[i];
            uint8_t *reason = reasons_of(&box.mesh, &options);
            for (int64_t k = 0; k < box.mesh.n_nodes; k++)
                if (is_on_box(&box.mesh, k))
                    assert_true(reason[k] & PLANISH_HELD_BOUNDARY);
                else
                    assert_true(reason[k] == 0 || reason[k] == PLANISH_HELD_NOT_CHOSEN);
            free(reason);
            test_mesh_destroy(&box);
        }
}

static void a_plan_around_a_node(void **state) {
    (void)state;
    planish_options options = defaults(1);
    test_mesh box;
    test_mesh_box(&box, 3, CELLS);
    const int64_t around[] = {0, middle(3)};
    options.around = around;
    options.n_around = 2;
    uint8_t *reason = reasons_of(&box.mesh, &options);
    assert_int_equal(reason[around[0]], PLANISH_HELD_BOUNDARY);
    assert_int_equal(reason[around[1]], 0);
    assert_int_equal(count(reason, box.mesh.n_nodes, PLANISH_HELD_NOT_CHOSEN),
                     box.mesh.n_nodes - 2);
    free(reason);
    test_mesh_destroy(&box);
}

static void without_coordinates_nothing_is_doubled(void **state) {
    (void)state;
    test_mesh box, other;
    planish_plan *plan;
    planish_error error;
    uint8_t reason[2 * SIDE * SIDE];
    test_mesh_box(&box, 2, CELLS);
    test_mesh_box(&other, 2, CELLS);
    test_mesh_append(&box, &other, 0);
    assert_int_equal(planish_plan_create(&box.mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_plan_get_held(plan, NULL, reason, NULL), 0);
    assert_int_equal(count(reason, box.mesh.n_nodes, PLANISH_HELD_DOUBLED), 0);
    assert_int_equal(planish_plan_get_held(plan, box.coordinates, reason, NULL), 0);
    assert_int_equal(count(reason, box.mesh.n_nodes, PLANISH_HELD_DOUBLED), 2 * 4 * CELLS);
    assert_int_equal(planish_plan_get_held(NULL, NULL, reason, &error), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_plan_get_held(plan, NULL, NULL, &error), PLANISH_ERROR_ARGUMENT);
    planish_plan_destroy(plan);
    test_mesh_destroy(&other);
    test_mesh_destroy(&box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_of_the_surface_are_on_the_boundary),
        cmocka_unit_test(a_node_has_all_its_reasons),
        cmocka_unit_test(nodes_that_slide_have_no_reason),
        cmocka_unit_test(nodes_at_one_place_are_doubled),
        cmocka_unit_test(each_element_has_its_own_points),
        cmocka_unit_test(too_many_elements_and_unused_nodes),
        cmocka_unit_test(duplicates_are_no_manifold),
        cmocka_unit_test(periodic_pairs_are_told),
        cmocka_unit_test(nodes_that_are_not_chosen),
        cmocka_unit_test(a_plan_around_a_node),
        cmocka_unit_test(without_coordinates_nothing_is_doubled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
