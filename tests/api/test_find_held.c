/* planish_find_held: which movable nodes a call of planish_smooth holds, and why. */
#include "support/allocations.h"
#include "support/barrel.h"
#include "support/run.h"

#include "shape/curved.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { UNTOUCHED = 77 };

/** Find what holds the nodes of mesh at x; held [n_nodes] is to be freed. */
static uint8_t *find(const planish_mesh *mesh, const planish_options *options, const double *x) {
    planish_plan *plan;
    planish_error e = {.text = ""};
    uint8_t *held = malloc((size_t)mesh->n_nodes);
    memset(held, UNTOUCHED, (size_t)mesh->n_nodes);
    if (planish_plan_create(mesh, options, &plan, &e) ||
        planish_find_held(plan, x, options, held, &e))
        fail_msg("%s", e.text);
    planish_plan_destroy(plan);
    return held;
}

static int64_t count(const uint8_t *held, int64_t n, uint8_t by) {
    int64_t found = 0;
    for (int64_t i = 0; i < n; i++)
        found += held[i] == by;
    return found;
}

/* ---- bounds --------------------------------------------------------------------------------- */

static void nodes_outside_of_a_box_are_held(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        planish_options o = test_options(2);
        test_bad_box(&box, dim, 5, 3);
        o.box_lower[0] = 1.9;
        uint8_t *held = find(&box.mesh, &o, box.coordinates);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
            const double *x = box.coordinates + i * dim;
            assert_int_equal(held[i], test_is_inside_box(x, dim, 5) && x[0] < 1.9
                                          ? PLANISH_HELD_BY_BOUNDS
                                          : PLANISH_HELD_BY_NONE);
        }
        test_run run = test_smooth(&box.mesh, &o);
        assert_int_equal(count(held, box.mesh.n_nodes, PLANISH_HELD_BY_BOUNDS),
                         run.result.n_held_outside);
        assert_true(run.result.n_held_outside > 0);
        free(run.coordinates);
        free(held);
        test_mesh_destroy(&box);
    }
}

/** Nodes that a plan does not know are not held by a call, with other strides, too. */
static void plans_of_few_nodes_and_strides(void **state) {
    (void)state;
    enum { DIM = 3, WIDE = 4, NODES = 6 * 6 * 6 };
    test_mesh box;
    test_bad_box(&box, DIM, 5, 3);
    assert_int_equal(box.mesh.n_nodes, NODES);
    int64_t around[2] = {-1,
                         -1}; /* nodes inside: the first that is outside of the box, and the last */
    for (int64_t i = 0; i < NODES; i++)
        if (test_is_inside_box(box.coordinates + i * DIM, DIM, 5)) {
            around[0] = around[0] < 0 && box.coordinates[i * DIM] < 1.9 ? i : around[0];
            around[1] = i;
        }
    static double wide[NODES][WIDE];
    for (int64_t i = 0; i < NODES; i++)
        memcpy(wide[i], box.coordinates + i * DIM, DIM * sizeof **wide);
    planish_mesh mesh = box.mesh;
    mesh.coordinates = wide[0];
    mesh.node_stride = WIDE;
    mesh.component_stride = 1;
    planish_options o = test_options(1);
    o.box_lower[0] = 1.9;
    o.around = around;
    o.n_around = 2;
    uint8_t *held = find(&mesh, &o, wide[0]);
    for (int64_t i = 0; i < NODES; i++) {
        const int is_outside = (i == around[0] || i == around[1]) && wide[i][0] < 1.9;
        assert_int_equal(held[i], is_outside ? PLANISH_HELD_BY_BOUNDS : PLANISH_HELD_BY_NONE);
    }
    assert_int_equal(held[around[0]], PLANISH_HELD_BY_BOUNDS);
    assert_int_equal(held[around[1]], PLANISH_HELD_BY_NONE);
    free(held);
    test_mesh_destroy(&box);
}

/* ---- the surface ---------------------------------------------------------------------------- */

/** Whether a facet of the surface joins two nodes, or they are the same. */
static int are_joined(const barrel *m, int64_t a, int64_t b) {
    for (int64_t f = 0; f < m->info.n_facets; f++) {
        int has_a = 0, has_b = 0;
        for (int k = 0; k < 3; k++) {
            const int32_t node = m->shape->node[m->shape->facet[f][k]];
            has_a |= node == a;
            has_b |= node == b;
        }
        if (has_a && has_b)
            return 1;
    }
    return 0;
}

/** The node of the side nearest to the middle of its height. */
static int64_t node_of_side(const barrel *m) {
    int64_t best = -1;
    for (int64_t i = 0; i < m->mesh.n_nodes; i++)
        if (m->constraint[i] == PLANISH_CONSTRAINT_ON_PATCH &&
            (best < 0 || fabs(m->mesh.coordinates[3 * i + 2] - 1) <
                             fabs(m->mesh.coordinates[3 * best + 2] - 1)))
            best = i;
    return best;
}

/** Nodes at a facet that is too far off are held, all others may move; planish_smooth does the same. */
static void facets_that_are_too_far_off_hold_their_nodes(void **state) {
    (void)state;
    barrel m;
    barrel_create(&m, 2);
    const int64_t out = node_of_side(&m), n = m.mesh.n_nodes;
    double *x = test_copy_of(&m.mesh);
    x[3 * out] *= 1.1;
    x[3 * out + 1] *= 1.1;
    uint8_t *held = find(&m.mesh, &m.options, x);
    for (int64_t i = 0; i < n; i++) {
        const int is_movable = m.constraint[i] > PLANISH_CONSTRAINT_FIXED;
        assert_int_equal(held[i], is_movable && are_joined(&m, i, out) ? PLANISH_HELD_BY_TOLERANCE
                                                                       : PLANISH_HELD_BY_NONE);
    }
    assert_true(count(held, n, PLANISH_HELD_BY_TOLERANCE) >= 6);
    double *smooth = malloc((size_t)n * 3 * sizeof *smooth);
    memcpy(smooth, x, (size_t)n * 3 * sizeof *smooth);
    const planish_result r = test_smooth_in_place(&m.mesh, smooth, &m.options);
    for (int64_t i = 0; i < n; i++)
        assert_true(!held[i] || !memcmp(smooth + 3 * i, x + 3 * i, 3 * sizeof *x));
    assert_true(r.n_moved_nodes > n / 2);
    free(held);
    m.options.surface_tolerance = 1; /* and nobody is held */
    held = find(&m.mesh, &m.options, x);
    assert_int_equal(count(held, n, PLANISH_HELD_BY_NONE), n);
    free(held);
    free(smooth);
    free(x);
    barrel_destroy(&m);
}

static planish_constraint stay(int64_t node, double *point, double *direction, void *user) {
    (void)node, (void)point, (void)direction, (void)user;
    return PLANISH_CONSTRAINT_FIXED;
}

/** Without a shape, and without a function, nobody says where nodes may go. */
static void nodes_without_a_surface_are_held(void **state) {
    (void)state;
    barrel m;
    barrel_create(&m, 1);
    const int64_t n = m.mesh.n_nodes;
    m.options.shape = NULL;
    for (int64_t i = 0, is_first = 1; i < n; i++)
        if (m.constraint[i] == PLANISH_CONSTRAINT_ON_PATCH && is_first) {
            m.constraint[i] = PLANISH_CONSTRAINT_ON_SURFACE;
            is_first = 0;
        }
    for (int has_function = 0; has_function < 2; has_function++) {
        m.options.project = has_function ? stay : NULL;
        uint8_t *held = find(&m.mesh, &m.options, m.mesh.coordinates);
        for (int64_t i = 0; i < n; i++)
            assert_int_equal(held[i],
                             m.constraint[i] >= PLANISH_CONSTRAINT_ON_SURFACE + has_function
                                 ? PLANISH_HELD_BY_SURFACE
                                 : PLANISH_HELD_BY_NONE);
        assert_true(count(held, n, PLANISH_HELD_BY_SURFACE) > 20);
        free(held);
    }
    barrel_destroy(&m);
}

/** The skin does not move nodes beside those that it knows nothing of. */
static void neighbours_of_nodes_that_slide_otherwise_are_held(void **state) {
    (void)state;
    barrel m;
    barrel_create(&m, 1);
    const int64_t other = node_of_side(&m), n = m.mesh.n_nodes;
    m.constraint[other] = PLANISH_CONSTRAINT_ON_SURFACE;
    m.options.project = stay;
    uint8_t *held = find(&m.mesh, &m.options, m.mesh.coordinates);
    for (int64_t i = 0; i < n; i++) {
        const int is_beside =
            i != other && m.constraint[i] > PLANISH_CONSTRAINT_FIXED && are_joined(&m, i, other);
        assert_int_equal(held[i], is_beside ? PLANISH_HELD_BY_SURFACE : PLANISH_HELD_BY_NONE);
    }
    assert_true(count(held, n, PLANISH_HELD_BY_SURFACE) >= 5);
    free(held);
    barrel_destroy(&m);
}

/* ---- the call ------------------------------------------------------------------------------- */

/** The call changes no coordinates, no later measure, and no bit of a later result. */
static void the_call_changes_nothing(void **state) {
    (void)state;
    test_mesh box;
    planish_options o = test_options(1);
    test_bad_box(&box, 3, 5, 3);
    const planish_mesh *mesh = &box.mesh;
    double *size = malloc((size_t)mesh->n_nodes * sizeof *size);
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        size[i] = 1 + 0.2 * mesh->coordinates[3 * i];
    box.mesh.size = size;
    o.size_weight = 0.5;
    o.max_sweeps = 3;
    uint8_t *held = malloc((size_t)mesh->n_nodes);
    double *x[2];
    double rms[2];
    for (int k = 0; k < 2; k++) {
        planish_plan *plan;
        planish_quality quality;
        x[k] = test_copy_of(mesh);
        assert_int_equal(planish_plan_create(mesh, &o, &plan, NULL), 0);
        for (int i = 0; i < 2; i++) {
            if (k == 1)
                assert_int_equal(planish_find_held(plan, x[k], &o, held, NULL), 0);
            assert_int_equal(planish_smooth(plan, x[k], &o, NULL, NULL), 0);
        }
        if (k == 1)
            assert_int_equal(planish_find_held(plan, mesh->coordinates, &o, held, NULL), 0);
        assert_int_equal(planish_measure(plan, x[k], &quality, NULL), 0);
        rms[k] = quality.rms_radius_ratio;
        planish_plan_destroy(plan);
    }
    assert_memory_equal(x[0], x[1], test_bytes_of(mesh));
    assert_true(rms[0] == rms[1]);
    for (int k = 0; k < 2; k++)
        free(x[k]);
    free(held);
    free(size);
    test_mesh_destroy(&box);
}

static void wrong_arguments_are_refused(void **state) {
    (void)state;
    barrel m;
    planish_plan *plan;
    planish_error e;
    barrel_create(&m, 1);
    double *x = test_copy_of(&m.mesh);
    uint8_t *held = malloc((size_t)m.mesh.n_nodes);
    memset(held, UNTOUCHED, (size_t)m.mesh.n_nodes);
    assert_int_equal(planish_plan_create(&m.mesh, &m.options, &plan, NULL), 0);
    assert_int_equal(planish_find_held(NULL, x, &m.options, held, &e), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_find_held(plan, NULL, &m.options, held, &e), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_find_held(plan, x, &m.options, NULL, &e), PLANISH_ERROR_ARGUMENT);
    planish_options o = m.options;
    o.tolerance = -1;
    assert_int_equal(planish_find_held(plan, x, &o, held, &e), PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(e.text, "options.tolerance"));
    x[7] = (double)NAN;
    assert_int_equal(planish_find_held(plan, x, &m.options, held, &e), PLANISH_ERROR_MESH);
    assert_int_equal(count(held, m.mesh.n_nodes, UNTOUCHED), m.mesh.n_nodes);
    planish_plan_destroy(plan);
    free(held);
    free(x);
    barrel_destroy(&m);
}

static void without_memory_the_call_says_so(void **state) {
    (void)state;
    barrel m;
    planish_plan *plan;
    int n = 0;
    barrel_create(&m, 1);
    m.options.box_upper[2] = 1.5;
    uint8_t *held = malloc((size_t)m.mesh.n_nodes);
    for (int status = 1; status; n++) {
        assert_int_equal(planish_plan_create(&m.mesh, &m.options, &plan, NULL), 0);
        memset(held, UNTOUCHED, (size_t)m.mesh.n_nodes);
        allocations_permit(n);
        status = planish_find_held(plan, m.mesh.coordinates, &m.options, held, NULL);
        allocations_permit(-1);
        assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
        if (status)
            assert_int_equal(count(held, m.mesh.n_nodes, UNTOUCHED), m.mesh.n_nodes);
        planish_plan_destroy(plan); /* it keeps memory for the next call */
    }
    assert_true(n > 10 && count(held, m.mesh.n_nodes, PLANISH_HELD_BY_BOUNDS) > 0);
    free(held);
    barrel_destroy(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_outside_of_a_box_are_held),
        cmocka_unit_test(plans_of_few_nodes_and_strides),
        cmocka_unit_test(facets_that_are_too_far_off_hold_their_nodes),
        cmocka_unit_test(nodes_without_a_surface_are_held),
        cmocka_unit_test(neighbours_of_nodes_that_slide_otherwise_are_held),
        cmocka_unit_test(the_call_changes_nothing),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(without_memory_the_call_says_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
