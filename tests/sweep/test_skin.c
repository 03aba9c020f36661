/* The skin: nodes that slide on the shape of a surface, and how far that comes off it meanwhile. */
#include "sweep/begin_end.h"
#include "support/barrel.h"
#include "support/run.h"
#include "support/sheets.h"

#include "base/context.h"
#include "improve/improve.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Distance of the surface at coordinates from the shape, proved, in edges. */
static planish_shape_distance distance_of(const barrel *m, const double *coordinates) {
    planish_shape_distance distance;
    planish_mesh mesh = m->mesh;
    mesh.coordinates = coordinates;
    assert_int_equal(planish_shape_measure(m->shape, &mesh, 1, &distance, NULL), 0);
    return distance;
}

static int has_moved(const barrel *m, const double *coordinates, int64_t node) {
    return memcmp(coordinates + 3 * node, m->mesh.coordinates + 3 * node, 3 * sizeof(double)) != 0;
}

/** Count the nodes of a constraint that have moved. */
static int64_t count_moved(const barrel *m, const double *coordinates, int constraint) {
    int64_t n = 0;
    for (int64_t i = 0; i < m->mesh.n_nodes; i++)
        n += m->constraint[i] == constraint && has_moved(m, coordinates, i);
    return n;
}

#define TOLERANCE 0.05

static void curved_surfaces_keep_their_shape(void **state) {
    (void)state;
    barrel m;
    barrel_create(&m, 1);
    assert_true(m.slides.n_on_patch > 0 && m.slides.n_on_curve > 0 && m.slides.n_on_plane > 0);
    test_run run = test_smooth(&m.mesh, &m.options);
    const planish_shape_distance distance = distance_of(&m, run.coordinates);
    assert_true(distance.in_edges > 0 && distance.in_edges <= TOLERANCE);
    assert_true(distance.n_unproved == 0 && distance.max_bend < 40.01);
    assert_true(count_moved(&m, run.coordinates, PLANISH_CONSTRAINT_ON_PATCH) >
                m.slides.n_on_patch / 2);
    assert_true(count_moved(&m, run.coordinates, PLANISH_CONSTRAINT_ON_CURVE) > 0);
    assert_int_equal(count_moved(&m, run.coordinates, PLANISH_CONSTRAINT_FIXED), 0);
    for (int64_t i = 0; i < m.mesh.n_nodes; i++) { /* ends stay plane, rims round */
        const double *x = run.coordinates + 3 * i, *from = m.mesh.coordinates + 3 * i;
        if (from[2] == 0 || from[2] == 2)
            assert_true(fabs(x[2] - from[2]) < 1e-14);
        if (m.constraint[i] == PLANISH_CONSTRAINT_ON_CURVE)
            assert_true(fabs(hypot(x[0], x[1]) - 1) < 0.01);
    }
    m.options.shape = NULL;
    test_run flat = test_smooth(&m.mesh, &m.options);
    assert_true(run.after.rms_radius_ratio < 0.97 * flat.after.rms_radius_ratio);
    assert_int_equal(count_moved(&m, flat.coordinates, PLANISH_CONSTRAINT_ON_PATCH), 0);
    assert_int_equal(count_moved(&m, flat.coordinates, PLANISH_CONSTRAINT_ON_CURVE), 0);
    free(run.coordinates);
    free(flat.coordinates);
    barrel_destroy(&m);
}

static void bits_do_not_depend_on_threads(void **state) {
    (void)state;
    const int threads[] = {1, 2, 3, 8};
    uint64_t first = 0;
    for (int i = 0; i < 4; i++) {
        barrel m;
        barrel_create(&m, threads[i]);
        m.options.worst = PLANISH_WORST_ANGLE;
        test_run run = test_smooth(&m.mesh, &m.options);
        planish_mesh after = m.mesh;
        after.coordinates = run.coordinates;
        if (i == 0)
            first = planish_checksum(&after);
        assert_true(planish_checksum(&after) == first);
        free(run.coordinates);
        barrel_destroy(&m);
    }
}

/** Colour of a sliding star. */
static int colour_of(const planish_plan *plan, int64_t star) {
    int colour = 0;
    while (star >= plan->sliding.colour_begin[colour + 1])
        colour++;
    return colour;
}

static void nodes_across_an_edge_have_two_colours(void **state) {
    (void)state;
    barrel m;
    planish_plan *plan;
    barrel_create(&m, 1);
    assert_int_equal(planish_plan_create(&m.mesh, &m.options, &plan, NULL), 0);
    int *colour = malloc((size_t)m.mesh.n_nodes * sizeof *colour);
    for (int64_t i = 0; i < m.mesh.n_nodes; i++)
        colour[i] = -1;
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++)
        colour[plan->slide[s].node] = colour_of(plan, s);
    int64_t n = 0;
    for (int64_t t = 0; t < m.shape->n_facets; t++)
        for (int k = 0; k < 3; k++) {
            const int32_t g = m.shape->across[t][k];
            const int32_t *f = m.shape->facet[t], a = f[k], b = f[(k + 1) % 3], v = f[(k + 2) % 3];
            for (int j = 0; g >= 0 && j < 3; j++) {
                const int32_t w = m.shape->facet[g][j];
                if (w == a || w == b || colour[m.shape->node[v]] < 0 ||
                    colour[m.shape->node[w]] < 0)
                    continue;
                assert_int_not_equal(colour[m.shape->node[v]], colour[m.shape->node[w]]);
                n++;
            }
        }
    assert_true(n > 100);
    free(colour);
    planish_plan_destroy(plan);
    barrel_destroy(&m);
}

/** A run on the barrel that is begun. */
typedef struct round_run {
    barrel m;
    planish_plan *plan;
    planish_result result;
    double *coordinates;
    pl_run r;
} round_run;

/** Begin a run; tolerance in edges, 0: the default. */
static void begin_run(round_run *t, int threads, double tolerance) {
    *t = (round_run){.plan = NULL};
    barrel_create(&t->m, threads);
    if (tolerance > 0)
        t->m.options.surface_tolerance = tolerance;
    t->coordinates = test_copy_of(&t->m.mesh);
    assert_int_equal(planish_plan_create(&t->m.mesh, &t->m.options, &t->plan, NULL), 0);
    pl_context_enter(t->plan->context);
    t->r = (pl_run){.plan = t->plan,
                    .coordinates = t->coordinates,
                    .options = &t->m.options,
                    .accelerate = pl_run_accelerate,
                    .result = &t->result};
    assert_int_equal(pl_run_begin(&t->r, NULL), 0);
}

static void end_run(round_run *t) {
    pl_run_destroy(&t->r);
    pl_context_enter(NULL);
    planish_plan_destroy(t->plan);
    free(t->coordinates);
    barrel_destroy(&t->m);
}

/** The first node on a patch; *x: its coordinates in the plan. */
static int64_t node_on_patch(const round_run *t, double **x) {
    int64_t node = 0;
    while (t->m.constraint[node] != PLANISH_CONSTRAINT_ON_PATCH)
        node++;
    *x = t->plan->scratch.coordinates + 3 * (int64_t)t->plan->inner[node];
    return node;
}

/** No sampled point of a facet is farther from its patch than its bound says. Returns the largest part of
 *  the tolerance that a bound is. */
static double check_bounds(const pl_skin *skin, const sheet_judge *judge) {
    const planish_shape *shape = skin->shape;
    enum { N = 6 };
    double most = 0;
    for (int32_t t = 0; t < shape->n_facets; t++) {
        double x[3][3];
        for (int j = 0; j < 3; j++)
            pl_skin_place_of(skin, shape->facet[t][j], x[j]);
        for (int a = 0; a <= N; a++)
            for (int b = 0; a + b <= N; b++) {
                double p[3];
                for (int d = 0; d < 3; d++)
                    p[d] = (a * x[0][d] + b * x[1][d] + (N - a - b) * x[2][d]) / N;
                assert_true(sheet_judge_distance(judge, shape->patch[t], p) <=
                            skin->bound[t] + 1e-12);
            }
        most = fmax(most, skin->bound[t] / skin->tolerance[t]);
    }
    return most;
}

static void bounds_hold_after_every_sweep(void **state) {
    (void)state;
    round_run t;
    begin_run(&t, 2, 0);
    const sheet_judge judge = sheet_judge_create(t.m.shape, (const double(*)[3])t.m.shape->x);
    double most = 0;
    for (int i = 0; i < 6; i++) {
        int64_t visits;
        assert_int_equal(pl_run_sweep(&t.r, &visits), 0);
        most = fmax(most, check_bounds(&t.r.skin, &judge));
    }
    assert_true(most > 0.5 && most <= 1); /* it was not in vain */
    assert_int_equal(pl_skin_check(&t.r.skin), 0);
    sheet_judge_destroy((sheet_judge *)&judge);
    end_run(&t);
}

/** Let a visit of a star, as it would be in a sweep, bring its node near to point, in the mesh's units.
 *  Returns how far it went in mean edges. */
static double visit_to(pl_skin *skin, int64_t star, const double point[3]) {
    pl_skin_visit visit;
    double to[3], direction[3];
    memcpy(to, point, sizeof to);
    pl_skin_prepare(skin, 0, &visit);
    pl_skin_begin_visit(&visit, star);
    pl_skin_project(skin->slide[star].node, to, direction, &visit);
    double *x = skin->coordinates + 3 * (int64_t)skin->inner[visit.node];
    memcpy(x, to, sizeof to);
    assert_true(pl_skin_end_visit(&visit));
    return pl_distance(3, to, visit.start) * skin->shape->scale /
           skin->shape->edge_length[visit.node];
}

static void visits_go_no_farther_than_seven_tenths(void **state) {
    (void)state;
    round_run t;
    double most = 0;
    begin_run(&t, 1, 100);
    int64_t n = 0;
    for (int64_t s = 0; s < t.r.skin.n_stars; s++)
        for (int k = 0; k < 8; k++) {
            const int32_t node = t.r.skin.node[s];
            double to[3], was[3];
            if (node < 0 || t.r.skin.moves[node] < PLANISH_CONSTRAINT_ON_PATCH)
                continue;
            memcpy(was, pl_skin_at(&t.r.skin, node), sizeof was);
            memcpy(to, was, sizeof to);
            const double far = (0.8 + 0.05 * k) * t.m.shape->edge_length[node] / t.m.shape->scale;
            to[2] += k % 2 ? far : -far;
            const double went = visit_to(&t.r.skin, s, to);
            most = fmax(most, went);
            n += went > 0.1;
            visit_to(&t.r.skin, s, was);
        }
    assert_true(n > 100 && most > 0.6 && most < 0.72);
    end_run(&t);
}

static void facets_turn_by_sixty_degrees_at_most(void **state) {
    (void)state;
    round_run t;
    double least = 1;
    begin_run(&t, 1, 100);
    for (int step = 0; step < 120; step++) /* all around the axis, by a degree */
        for (int64_t s = 0; s < t.r.skin.n_stars; s++) {
            const int32_t node = t.r.skin.node[s];
            double to[3];
            if (node < 0 || t.r.skin.moves[node] != PLANISH_CONSTRAINT_ON_PATCH)
                continue;
            memcpy(to, pl_skin_at(&t.r.skin, node), sizeof to);
            const double x = to[0], y = to[1];
            to[0] = x - 0.0175 * y;
            to[1] = y + 0.0175 * x;
            visit_to(&t.r.skin, s, to);
        }
    for (int64_t f = 0; f < t.m.shape->n_facets; f++) {
        double x[3][3], a[3], b[3], normal[3], first[3];
        pl_facet_normal(t.m.shape, (int32_t)f, first);
        for (int j = 0; j < 3; j++)
            pl_skin_place_of(&t.r.skin, t.m.shape->facet[f][j], x[j]);
        pl_from_to(3, x[0], x[1], a);
        pl_from_to(3, x[0], x[2], b);
        pl_cross(a, b, normal);
        least = fmin(least, pl_dot(3, normal, first) / pl_length(normal));
    }
    assert_true(least >= 0.5 - 1e-12 && least < 0.55); /* they did turn */
    end_run(&t);
}

static void nodes_that_are_moved_otherwise_are_noticed(void **state) {
    (void)state;
    round_run t;
    begin_run(&t, 1, 0);
    int64_t visits;
    pl_run_sweep(&t.r, &visits);
    void *saved = pl_skin_save(&t.r.skin);
    double *x, was[3];
    const int64_t node = node_on_patch(&t, &x);
    memcpy(was, x, sizeof was);
    for (int d = 0; d < 2; d++)
        x[d] *= 1.2;
    assert_true(pl_skin_follow(&t.r.skin) > 0);
    memcpy(x, was, sizeof was);
    pl_skin_restore(&t.r.skin, saved);
    assert_int_equal(pl_skin_follow(&t.r.skin), 0);
    for (int d = 0; d < 2; d++)
        x[d] *= 1.2;
    assert_true(pl_skin_put_back(&t.r.skin, t.r.given) > 0);
    assert_memory_equal(x, t.r.given + 3 * node, sizeof was);
    pl_plan_order(t.plan, t.r.given, t.plan->scratch.coordinates);
    assert_int_equal(pl_skin_follow(&t.r.skin), 0);
    for (int64_t f = 0; f < t.m.shape->n_facets; f++)
        assert_true(!(t.r.skin.bound[f] > 0));
    pl_free(saved);
    end_run(&t);
}

/** Nodes that go back alone may leave a smooth edge sharp: the nodes there go back, too. */
static void nodes_at_edges_that_became_sharp_go_back(void **state) {
    (void)state;
    round_run t;
    begin_run(&t, 1, 100);
    assert_int_equal(pl_skin_check_bends(&t.r.skin, t.r.given), 0);
    assert_int_equal(pl_skin_put_back(&t.r.skin, t.r.given), 0);
    double *x, was[3];
    node_on_patch(&t, &x);
    memcpy(was, x, sizeof was);
    for (int d = 0; d < 2; d++)
        x[d] *= 1.3; /* a spike */
    assert_true(pl_skin_check_bends(&t.r.skin, t.r.given) > 0);
    pl_skin_follow(&t.r.skin);
    assert_true(pl_skin_put_back(&t.r.skin, t.r.given) > 0);
    assert_memory_equal(x, was, sizeof was);
    assert_int_equal(pl_skin_check_bends(&t.r.skin, t.r.given), 0);
    end_run(&t);
}

/** End a call after so many colours. */
typedef struct interruption {
    int colours;
} interruption;

static int interrupt(const planish_progress *progress, void *user) {
    interruption *when = user;
    (void)progress;
    return --when->colours < 0;
}

static void stopping_at_any_time_keeps_the_shape(void **state) {
    (void)state;
    barrel m;
    barrel_create(&m, 1);
    for (int n = 0; n < 60; n += 7) {
        interruption when = {n};
        m.options.progress = interrupt;
        m.options.progress_user = &when;
        m.options.worst = PLANISH_WORST_RADIUS_RATIO;
        test_run run = test_smooth(&m.mesh, &m.options);
        assert_true(distance_of(&m, run.coordinates).in_edges <= TOLERANCE);
        free(run.coordinates);
    }
    barrel_destroy(&m);
}

static void runs_in_a_row_do_not_drift(void **state) {
    (void)state;
    barrel m;
    barrel_create(&m, 1);
    planish_mesh first = m.mesh;
    double *coordinates = test_copy_of(&m.mesh);
    for (int i = 0; i < 4; i++) {
        planish_plan *plan;
        m.mesh.coordinates = coordinates;
        m.options.search = i % 2 ? PLANISH_SEARCH_FLETCHER_REEVES : PLANISH_SEARCH_NEWTON;
        m.options.objective = i % 2 ? PLANISH_OBJECTIVE_MEAN_RATIO : PLANISH_OBJECTIVE_RADIUS_RATIO;
        assert_int_equal(planish_plan_create(&m.mesh, &m.options, &plan, NULL), 0);
        assert_int_equal(planish_smooth(plan, coordinates, &m.options, NULL, NULL), 0);
        planish_plan_destroy(plan);
        m.mesh = first;
        assert_true(distance_of(&m, coordinates).in_edges <= TOLERANCE);
    }
    free(coordinates);
    barrel_destroy(&m);
}

static void what_is_too_far_off_at_the_start_stays(void **state) {
    (void)state;
    barrel m;
    barrel_create(&m, 1);
    planish_mesh first = m.mesh;
    double *coordinates = test_copy_of(&m.mesh);
    int64_t node = m.mesh.n_nodes / 2;
    while (m.constraint[node] != PLANISH_CONSTRAINT_ON_PATCH)
        node++;
    coordinates[3 * node] *= 1.05; /* by a sixth of an edge */
    coordinates[3 * node + 1] *= 1.05;
    m.mesh.coordinates = coordinates;
    test_run run = test_smooth(&m.mesh, &m.options);
    assert_memory_equal(run.coordinates + 3 * node, coordinates + 3 * node, 3 * sizeof(double));
    m.mesh = first;
    assert_true(count_moved(&m, run.coordinates, PLANISH_CONSTRAINT_ON_PATCH) >
                m.slides.n_on_patch / 2);
    free(run.coordinates);
    free(coordinates);
    barrel_destroy(&m);
}

/** The caller's surface: a node stays on the plane that it is on; *user counts. */
static planish_constraint project(int64_t node, double *point, double *direction, void *user) {
    int64_t *of = user;
    assert_int_equal(node, of[0]);
    (void)point;
    __atomic_fetch_add(&of[1], 1, __ATOMIC_RELAXED);
    direction[0] = 1;
    direction[1] = direction[2] = 0;
    return PLANISH_CONSTRAINT_ON_PLANE;
}

static void other_options_go_with_it(void **state) {
    (void)state;
    for (int which = 0; which < 6; which++) {
        barrel m;
        barrel_create(&m, 2);
        int64_t of[2] = {m.mesh.n_nodes / 2, 0};
        if (which == 0)
            m.options.precision = PLANISH_PRECISION_FLOAT;
        if (which == 1)
            m.options.only_worse_than = 2.2;
        if (which == 2) {
            m.options.max_displacement = 0.1;
            m.options.displacement_unit = PLANISH_UNIT_EDGE;
        }
        if (which == 3)
            m.options.min_volume_fraction = 1e-4;
        if (which == 4)
            m.options.box_lower[2] = 0.5;
        if (which == 5) {
            while (m.constraint[of[0]] != PLANISH_CONSTRAINT_FREE)
                of[0]++;
            m.constraint[of[0]] = PLANISH_CONSTRAINT_ON_SURFACE;
            m.options.project = project;
            m.options.project_user = of;
        }
        test_run run = test_smooth(&m.mesh, &m.options);
        assert_true(distance_of(&m, run.coordinates).in_edges <= TOLERANCE);
        assert_true(count_moved(&m, run.coordinates, PLANISH_CONSTRAINT_ON_PATCH) > 0);
        assert_true(run.after.n_inverted == 0);
        for (int64_t i = 0; i < 3 * m.mesh.n_nodes; i++) {
            if (which == 0 && has_moved(&m, run.coordinates, i / 3))
                assert_true(run.coordinates[i] == (double)(float)run.coordinates[i]);
            if (which == 4 && i % 3 == 2 && m.mesh.coordinates[i] >= 0.5)
                assert_true(run.coordinates[i] >= 0.5);
        }
        if (which == 5)
            assert_true(of[1] > 0);
        free(run.coordinates);
        barrel_destroy(&m);
    }
}

static void wrong_shapes_are_refused(void **state) {
    (void)state;
    barrel m;
    planish_plan *plan;
    planish_error error;
    barrel_create(&m, 1);
    /* of a mesh of another number of nodes */
    test_mesh other;
    test_mesh_box(&other, 3, 2);
    assert_int_equal(planish_plan_create(&other.mesh, &m.options, &plan, &error),
                     PLANISH_ERROR_ARGUMENT);
    test_mesh_destroy(&other);
    test_mesh_box(&other, 2, 2);
    assert_int_equal(planish_plan_create(&other.mesh, &m.options, &plan, &error),
                     PLANISH_ERROR_ARGUMENT);
    test_mesh_destroy(&other);
    /* of a mesh of other facets */
    test_mesh_box(&other, 3, BARREL_CELLS);
    test_mesh_renumber(&other, 5, NULL);
    planish_mesh renumbered = m.mesh;
    renumbered.elements = other.elements;
    assert_int_equal(planish_plan_create(&renumbered, &m.options, &plan, &error),
                     PLANISH_ERROR_ARGUMENT);
    test_mesh_destroy(&other);
    /* of a node of another class */
    int64_t node = 0;
    while (m.constraint[node] != PLANISH_CONSTRAINT_ON_CURVE)
        node++;
    m.constraint[node] = PLANISH_CONSTRAINT_ON_PATCH;
    assert_int_equal(planish_plan_create(&m.mesh, &m.options, &plan, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(error.node, node);
    m.constraint[node] = PLANISH_CONSTRAINT_ON_CURVE;
    /* of a call with another one */
    planish_shape *twin;
    planish_options options = m.options;
    assert_int_equal(planish_shape_create(&m.mesh, NULL, 1, &twin, NULL, NULL), 0);
    options.shape = twin;
    double *coordinates = test_copy_of(&m.mesh);
    assert_int_equal(planish_plan_create(&m.mesh, &m.options, &plan, &error), 0);
    assert_int_equal(planish_smooth(plan, coordinates, &options, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    const double tolerances[] = {-1, NAN, INFINITY};
    for (int i = 0; i < 3; i++) {
        options = m.options;
        options.surface_tolerance = tolerances[i];
        assert_int_equal(planish_smooth(plan, coordinates, &options, NULL, &error),
                         PLANISH_ERROR_ARGUMENT);
    }
    options = m.options;
    options.surface_tolerance_unit = (planish_length_unit)2;
    assert_int_equal(planish_smooth(plan, coordinates, &options, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    options.shape = NULL; /* nodes of shapes stay */
    options.surface_tolerance_unit = PLANISH_UNIT_MESH;
    assert_int_equal(planish_smooth(plan, coordinates, &options, NULL, &error), 0);
    assert_int_equal(count_moved(&m, coordinates, PLANISH_CONSTRAINT_ON_PATCH), 0);
    planish_plan_destroy(plan);
    planish_shape_destroy(twin);
    free(coordinates);
    barrel_destroy(&m);
}

static void tolerances_are_kept(void **state) {
    (void)state;
    barrel m;
    barrel_create(&m, 1);
    double before = 0;
    const double tolerances[] = {1e-4, 3e-3, 2e-2};
    for (int i = 0; i < 3; i++) {
        m.options.surface_tolerance = tolerances[i];
        m.options.surface_tolerance_unit = PLANISH_UNIT_MESH;
        test_run run = test_smooth(&m.mesh, &m.options);
        const double distance = distance_of(&m, run.coordinates).distance;
        assert_true(distance <= 1.3 * tolerances[i] && distance > before);
        before = distance;
        free(run.coordinates);
    }
    barrel_destroy(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curved_surfaces_keep_their_shape),
        cmocka_unit_test(bits_do_not_depend_on_threads),
        cmocka_unit_test(nodes_across_an_edge_have_two_colours),
        cmocka_unit_test(bounds_hold_after_every_sweep),
        cmocka_unit_test(visits_go_no_farther_than_seven_tenths),
        cmocka_unit_test(facets_turn_by_sixty_degrees_at_most),
        cmocka_unit_test(nodes_that_are_moved_otherwise_are_noticed),
        cmocka_unit_test(nodes_at_edges_that_became_sharp_go_back),
        cmocka_unit_test(stopping_at_any_time_keeps_the_shape),
        cmocka_unit_test(runs_in_a_row_do_not_drift),
        cmocka_unit_test(what_is_too_far_off_at_the_start_stays),
        cmocka_unit_test(other_options_go_with_it),
        cmocka_unit_test(wrong_shapes_are_refused),
        cmocka_unit_test(tolerances_are_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
