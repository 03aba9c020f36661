/* What is told of single nodes and elements: why nodes do not move, each reason, their identity with
 * what the plan says, and any threads; which elements are numbered the other way round than most
 * (planish_find_reversed, planish_quality.n_reversed), by the textbook's determinant. */
#include "support/both.h"
#include "support/meshes.h"

#include <math.h>
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

/* ---- elements that are numbered the other way round ------------------------------------------- */

/** Twice the area, or six times the volume, of an element at x. */
static double determinant(const planish_mesh *mesh, const double *x, int64_t element) {
    const int dim = mesh->dim;
    const int32_t *node = mesh->elements + element * (dim + 1);
    double e[3][3] = {{0}};
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = x[node[j + 1] * dim + d] - x[node[0] * dim + d];
    if (dim == 2)
        return e[0][0] * e[1][1] - e[0][1] * e[1][0];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
           e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

/** reversed [n_elements], and their number. */
static int64_t expect(const planish_mesh *mesh, const double *x, uint8_t *reversed) {
    int64_t n_positive = 0, n_negative = 0, n = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        n_positive += determinant(mesh, x, i) > 0;
        n_negative += determinant(mesh, x, i) < 0;
    }
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const double d = determinant(mesh, x, i);
        reversed[i] = n_positive >= n_negative ? d < 0 : d > 0;
        n += reversed[i];
    }
    return n;
}

/** Compare what the library finds at x with what is expected; returns the number. */
static int64_t check(const planish_mesh *mesh, const double *x) {
    uint8_t *expected = malloc((size_t)mesh->n_elements), *found = malloc((size_t)mesh->n_elements);
    const int64_t n_expected = expect(mesh, x, expected);
    planish_plan *plan;
    planish_quality quality;
    int64_t n = -1;
    assert_int_equal(planish_plan_create(mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_find_reversed(plan, x, found, &n, NULL), 0);
    assert_int_equal(n, n_expected);
    assert_memory_equal(found, expected, (size_t)mesh->n_elements);
    n = -1;
    assert_int_equal(planish_find_reversed(plan, x, NULL, &n, NULL), 0);
    assert_int_equal(n, n_expected);
    assert_int_equal(planish_measure(plan, x, &quality, NULL), 0);
    assert_int_equal(quality.n_reversed, n_expected);
    planish_plan_destroy(plan);
    free(expected);
    free(found);
    return n_expected;
}

static void mirror(test_mesh *m) {
    for (int64_t i = 0; i < m->mesh.n_elements; i++)
        test_mesh_reverse(m, i);
}

/** Valid meshes with elements of the other order, mirrored as a whole or not, of any size. */
static void elements_of_the_other_order_are_found(void **state) {
    static const double scales[] = {1, 1e-200, 1e150};
    const int dim = *(int *)*state;
    for (int i = 0; i < 12; i++) {
        test_mesh m;
        test_mesh_box(&m, dim, dim == 3 ? 5 : 12);
        test_mesh_perturb(&m, 0.1, (unsigned)i + 1);
        if (i % 2)
            mirror(&m);
        assert_int_equal(check(&m.mesh, m.coordinates), 0);
        test_mesh_reverse_some(&m, 7, (unsigned)i + 1);
        assert_true(check(&m.mesh, m.coordinates) > 0);
        uint8_t *expected = malloc((size_t)m.mesh.n_elements),
                *found = malloc((size_t)m.mesh.n_elements);
        expect(&m.mesh, m.coordinates, expected);
        test_mesh_transform(&m, scales[i % 3], 0);
        planish_plan *plan;
        assert_int_equal(planish_plan_create(&m.mesh, NULL, &plan, NULL), 0);
        assert_int_equal(planish_find_reversed(plan, m.coordinates, found, NULL, NULL), 0);
        assert_memory_equal(found, expected, (size_t)m.mesh.n_elements);
        planish_plan_destroy(plan);
        free(expected);
        free(found);
        test_mesh_destroy(&m);
    }
}

/** Tangled meshes: signs of measures decide, whatever the plan takes for the orientation. */
static void inverted_elements_count_as_they_are_listed(void **state) {
    const int dim = *(int *)*state;
    int64_t n = 0;
    for (int i = 0; i < 8; i++) {
        test_mesh m;
        test_mesh_box(&m, dim, dim == 3 ? 4 : 9);
        test_mesh_perturb(&m, 1.2, (unsigned)i + 1);
        if (i % 2)
            test_mesh_reverse_some(&m, 3, (unsigned)i + 1);
        n += check(&m.mesh, m.coordinates);
        test_mesh_destroy(&m);
    }
    assert_true(n > 0);
}

/** In a tie most are positive; flat elements are neither. */
static void ties_and_flat_elements(void **state) {
    static const double square[] = {0, 0, 1, 0, 1, 1, 0, 1, 2, 0};
    static const int32_t pair[] = {0, 1, 2, 0, 3, 2}, with_flat[] = {0, 1, 2, 0, 2, 3, 0, 1, 4};
    test_mesh m;
    (void)state;
    test_mesh_create(&m, 2, 4, square, 2, pair);
    assert_int_equal(check(&m.mesh, m.coordinates), 1);
    test_mesh_destroy(&m);
    test_mesh_create(&m, 2, 5, square, 3, with_flat);
    assert_int_equal(check(&m.mesh, m.coordinates), 0);
    test_mesh_destroy(&m);
}

/** Folded elements that were renumbered so that each is positive: repaired, they are reversed. */
static void repaired_elements_are_reversed(void **state) {
    const int dim = *(int *)*state;
    test_mesh m;
    uint8_t *reversed;
    planish_result result;
    planish_plan *plan;
    int64_t n_folded = 0, n = -1;
    test_mesh_box(&m, dim, 4);
    const int64_t middle = dim == 3 ? (5 * 5 + 5 + 1) * 2 : 2 * 5 + 2;
    for (int d = 0; d < dim; d++)
        m.coordinates[middle * dim + d] += d == 0 ? 1.3 : 0.1;
    uint8_t *folded = calloc((size_t)m.mesh.n_elements, 1);
    for (int64_t i = 0; i < m.mesh.n_elements; i++)
        if (determinant(&m.mesh, m.coordinates, i) < 0) {
            test_mesh_reverse(&m, i);
            folded[i] = 1;
            n_folded++;
        }
    assert_true(n_folded > 0);
    assert_int_equal(check(&m.mesh, m.coordinates), 0);
    assert_int_equal(planish_plan_create(&m.mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, m.coordinates, NULL, &result, NULL), 0);
    assert_int_equal(result.n_inverted, 0);
    reversed = malloc((size_t)m.mesh.n_elements);
    assert_int_equal(planish_find_reversed(plan, m.coordinates, reversed, &n, NULL), 0);
    assert_int_equal(n, n_folded);
    assert_memory_equal(reversed, folded, (size_t)m.mesh.n_elements);
    planish_plan_destroy(plan);
    free(reversed);
    free(folded);
    test_mesh_destroy(&m);
}

/** A plan for some elements counts these; a selective one counts all; strides do not matter. */
static void parts_and_strides(void **state) {
    const int dim = *(int *)*state;
    test_mesh m;
    planish_options options;
    planish_plan *plan;
    int64_t n = -1, n_all, n_around = 0;
    test_mesh_box(&m, dim, 6);
    test_mesh_perturb(&m, 0.14, 5);
    test_mesh_reverse_some(&m, 3, 5);
    uint8_t *expected = malloc((size_t)m.mesh.n_elements),
            *found = malloc((size_t)m.mesh.n_elements);
    n_all = expect(&m.mesh, m.coordinates, expected);
    planish_options_init(&options);
    options.only_worse_than = 2;
    assert_int_equal(planish_plan_create(&m.mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_find_reversed(plan, m.coordinates, found, &n, NULL), 0);
    assert_int_equal(n, n_all);
    assert_memory_equal(found, expected, (size_t)m.mesh.n_elements);
    planish_plan_destroy(plan);

    const int64_t middle = dim == 3 ? (7 * 7 + 7 + 1) * 3 : 3 * 7 + 3;
    planish_options_init(&options);
    options.around = &middle;
    options.n_around = 1;
    assert_int_equal(planish_plan_create(&m.mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_find_reversed(plan, m.coordinates, found, &n, NULL), 0);
    for (int64_t i = 0; i < m.mesh.n_elements; i++) {
        int has = 0;
        for (int j = 0; j <= dim; j++)
            has |= m.mesh.elements[i * (dim + 1) + j] == middle;
        assert_int_equal(found[i], has && expected[i]);
        n_around += found[i];
    }
    assert_true(n_around > 0);
    assert_int_equal(n, n_around);
    planish_plan_destroy(plan);

    double *apart = malloc((size_t)(m.mesh.n_nodes * dim) * sizeof *apart);
    for (int64_t i = 0; i < m.mesh.n_nodes; i++)
        for (int d = 0; d < dim; d++)
            apart[d * m.mesh.n_nodes + i] = m.coordinates[i * dim + d];
    planish_mesh strided = m.mesh;
    strided.coordinates = apart;
    strided.node_stride = 1;
    strided.component_stride = m.mesh.n_nodes;
    assert_int_equal(planish_plan_create(&strided, NULL, &plan, NULL), 0);
    assert_int_equal(planish_find_reversed(plan, apart, found, &n, NULL), 0);
    assert_int_equal(n, n_all);
    assert_memory_equal(found, expected, (size_t)m.mesh.n_elements);
    planish_plan_destroy(plan);
    free(apart);
    free(expected);
    free(found);
    test_mesh_destroy(&m);
}

static void errors_leave_everything(void **state) {
    test_mesh m;
    planish_plan *plan;
    planish_error error;
    uint8_t found[6] = {7, 7, 7, 7, 7, 7};
    int64_t n = -1;
    (void)state;
    test_mesh_box(&m, 3, 1);
    assert_int_equal(planish_plan_create(&m.mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_find_reversed(NULL, m.coordinates, found, &n, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_find_reversed(plan, NULL, found, &n, &error), PLANISH_ERROR_ARGUMENT);
    m.coordinates[4] = (double)NAN;
    assert_int_equal(planish_find_reversed(plan, m.coordinates, found, &n, &error),
                     PLANISH_ERROR_MESH);
    assert_int_equal(n, -1);
    for (int i = 0; i < 6; i++)
        assert_int_equal(found[i], 7);
    planish_plan_destroy(plan);
    test_mesh_destroy(&m);
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
        BOTH(elements_of_the_other_order_are_found),
        BOTH(inverted_elements_count_as_they_are_listed),
        cmocka_unit_test(ties_and_flat_elements),
        BOTH(repaired_elements_are_reversed),
        BOTH(parts_and_strides),
        cmocka_unit_test(errors_leave_everything),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
