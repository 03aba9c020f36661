/* Plans made with only_worse_than: what they choose, and that nothing else moves. */
#include "support/allocations.h"
#include "support/meshes.h"
#include "support/run.h"

#include "geometry/simplex.h"
#include "sweep/sweep.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 7 };

/** RR of an element; infinite if it is not positive. */
static double ratio_of(const planish_mesh *mesh, int64_t element) {
    const int dim = mesh->dim;
    const int32_t *node = mesh->elements + element * (dim + 1);
    const double *x[4] = {NULL};
    for (int j = 0; j <= dim; j++)
        x[j] = mesh->coordinates + (int64_t)node[j] * dim;
    return pl_simplex_measure(dim, x) > 0 ? sqrt(pl_radius_ratio_square(dim, x)) : INFINITY;
}

/** chosen [n]: the nodes of elements worse than limit, and of rings around. */
static void choose(const planish_mesh *mesh, double limit, int rings, uint8_t *chosen) {
    const int corners = mesh->dim + 1;
    memset(chosen, 0, (size_t)mesh->n_nodes);
    for (int ring = 0; ring <= rings; ring++) {
        uint8_t *next = malloc((size_t)mesh->n_nodes);
        memcpy(next, chosen, (size_t)mesh->n_nodes);
        for (int64_t i = 0; i < mesh->n_elements; i++) {
            int any = ring == 0 && ratio_of(mesh, i) > limit;
            for (int j = 0; ring > 0 && j < corners; j++)
                any |= chosen[mesh->elements[i * corners + j]];
            for (int j = 0; any && j < corners; j++)
                next[mesh->elements[i * corners + j]] = 1;
        }
        memcpy(chosen, next, (size_t)mesh->n_nodes);
        free(next);
    }
}

static int is_inside(const planish_mesh *mesh, const double *original, int64_t node) {
    int inside = 1;
    for (int d = 0; d < mesh->dim; d++)
        inside &= original[node * mesh->dim + d] != 0 && original[node * mesh->dim + d] != CELLS;
    return inside;
}

/** Only chosen interior nodes move, and are the free ones. Returns how many moved. */
static int64_t expect_chosen(const planish_mesh *mesh, const test_run *r, const uint8_t *chosen) {
    const int dim = mesh->dim;
    int64_t n = 0, moved = 0;
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const int same = memcmp(r->coordinates + i * dim, mesh->coordinates + i * dim,
                                (size_t)dim * sizeof(double)) == 0;
        const int free = chosen[i] && is_inside(mesh, mesh->coordinates, i);
        n += free;
        moved += !same;
        assert_true(free || same);
    }
    assert_int_equal(r->info.n_free, n);
    return moved;
}

static void bad_box(test_mesh *mesh, int dim) {
    test_mesh_box(mesh, dim, CELLS);
    test_mesh_perturb(mesh, 0.14, 12345);
}

static void only_nodes_of_bad_elements_move(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int rings = 0; rings < 3; rings++) {
            test_mesh box;
            planish_options options = test_options(1);
            bad_box(&box, dim);
            uint8_t *chosen = malloc((size_t)box.mesh.n_nodes);
            options.only_worse_than = dim == 3 ? 1.8 : 1.4;
            options.rings = rings;
            choose(&box.mesh, options.only_worse_than, rings, chosen);
            test_run r = test_smooth(&box.mesh, &options);
            const int64_t moved = expect_chosen(&box.mesh, &r, chosen);
            if (moved <= 3)
                fail_msg("dim %d rings %d: %d of %d", dim, rings, (int)moved, (int)r.info.n_free);
            assert_int_equal(r.after.n_inverted, 0);
            assert_true(r.after.max_radius_ratio <= r.before.max_radius_ratio);
            assert_true(r.after.rms_radius_ratio < r.before.rms_radius_ratio);
            assert_int_equal(r.result.stop, PLANISH_STOP_CONVERGED);
            assert_int_equal(r.info.n_unused, -1);
            for (int threads = 2; threads < 4; threads++) {
                options.threads = threads;
                test_run s = test_smooth(&box.mesh, &options);
                assert_memory_equal(r.coordinates, s.coordinates,
                                    (size_t)(box.mesh.n_nodes * dim) * sizeof(double));
                free(s.coordinates);
            }
            free(r.coordinates);
            free(chosen);
            test_mesh_destroy(&box);
        }
}

static void nothing_bad_nothing_done(void **state) {
    (void)state;
    test_mesh box;
    planish_options options = test_options(1);
    bad_box(&box, 3);
    options.only_worse_than = 1e6;
    test_run r = test_smooth(&box.mesh, &options);
    assert_int_equal(r.info.n_free, 0);
    assert_int_equal(r.result.n_moved_nodes, 0);
    assert_int_equal(r.result.stop, PLANISH_STOP_CONVERGED);
    free(r.coordinates);
    test_mesh_destroy(&box);
}

/** Whatever the order of the elements. */
static void orientation_does_not_matter(void **state) {
    (void)state;
    test_mesh plain;
    planish_options options = test_options(1);
    bad_box(&plain, 3);
    options.only_worse_than = 1.8;
    test_run expected = test_smooth(&plain.mesh, &options);
    for (int which = 0; which < 2; which++) {
        test_mesh box;
        bad_box(&box, 3);
        if (which)
            test_mesh_reverse_some(&box, 3, 4);
        else
            for (int64_t i = 0; i < box.mesh.n_elements; i++)
                test_mesh_reverse(&box, i);
        test_run r = test_smooth(&box.mesh, &options);
        assert_int_equal(r.info.n_free, expected.info.n_free);
        assert_int_equal(r.before.n_inverted, 0);
        assert_true(fabs(r.after.rms_radius_ratio / expected.after.rms_radius_ratio - 1) < 1e-6);
        free(r.coordinates);
        test_mesh_destroy(&box);
    }
    free(expected.coordinates);
    test_mesh_destroy(&plain);
}

/** Tangled elements are repaired, with four rings of room, where no ratio is bad. */
static void tangles_are_chosen(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        planish_options options = test_options(1);
        test_mesh_box(&box, dim, CELLS);
        int64_t node = 0;
        while (!is_inside(&box.mesh, box.coordinates, node))
            node++;
        for (int d = 0; d < dim; d++)
            box.coordinates[node * dim + d] += 1.3;
        uint8_t *chosen = malloc((size_t)box.mesh.n_nodes);
        choose(&box.mesh, 1e6, 4, chosen);
        options.only_worse_than = 1e5;
        test_run r = test_smooth(&box.mesh, &options);
        assert_true(r.before.n_inverted > 0);
        assert_int_equal(r.after.n_inverted, 0);
        assert_true(expect_chosen(&box.mesh, &r, chosen) > 0);
        free(r.coordinates);
        free(chosen);
        test_mesh_destroy(&box);
    }
}

/** Elements below their minimum volume are bad as well, by whatever that is given. */
static void low_elements_are_chosen(void **state) {
    (void)state;
    test_mesh box;
    bad_box(&box, 3);
    double *least = calloc((size_t)box.mesh.n_elements, sizeof *least);
    for (int which = 0; which < 3; which++) {
        planish_options options = test_options(1);
        planish_mesh mesh = box.mesh;
        options.only_worse_than = 1e6;
        if (which == 0)
            options.min_volume = 0.1;
        if (which == 1)
            options.min_volume_fraction = 0.1 / (CELLS * CELLS * CELLS);
        for (int64_t i = 0; which == 2 && i < mesh.n_elements; i++)
            least[i] = 0.1;
        mesh.min_volume = which == 2 ? least : NULL;
        test_run r = test_smooth(&mesh, &options);
        assert_true(r.info.n_free > 10 && r.info.n_free < 6 * 6 * 6);
        assert_true(r.result.n_moved_nodes > 0);
        free(r.coordinates);
    }
    free(least);
    test_mesh_destroy(&box);
}

/** Minimum volumes are compared in all of the mesh, as by a plan for all of it in which the same
 * nodes are free. */
static void judge_volumes(int dim) {
    planish_options options = test_options(1);
    test_mesh mesh;
    planish_plan *plan[2];
    planish_plan_info info;
    int64_t n[2], count[3] = {0};
    bad_box(&mesh, dim);
    const size_t n_nodes = (size_t)mesh.mesh.n_nodes, n_elements = (size_t)mesh.mesh.n_elements;
    uint8_t *constraint = malloc(n_nodes), *of[2] = {malloc(n_elements), malloc(n_elements)};
    options.only_worse_than = dim == 3 ? 2.2 : 1.6;
    options.rings = 0;
    assert_int_equal(planish_plan_create(&mesh.mesh, &options, &plan[0], NULL), 0);
    planish_plan_get_info(plan[0], &info);
    assert_true(info.n_free > 0 && info.n_free < mesh.mesh.n_nodes / 4);
    planish_plan_get_free(plan[0], constraint);
    for (size_t i = 0; i < n_nodes; i++)
        constraint[i] = constraint[i] ? PLANISH_CONSTRAINT_FREE : PLANISH_CONSTRAINT_FIXED;
    mesh.mesh.constraint = constraint;
    options.only_worse_than = 0;
    assert_int_equal(planish_plan_create(&mesh.mesh, &options, &plan[1], NULL), 0);
    options.min_volume = dim == 3 ? 0.15 : 0.45; /* regular ones of a box: 1/6, 1/2 */
    for (int i = 0; i < 2; i++) {
        assert_int_equal(
            planish_check_volumes(plan[i], mesh.coordinates, &options, of[i], &n[i], NULL, NULL),
            0);
        planish_plan_destroy(plan[i]);
    }
    assert_int_equal(n[0], n[1]);
    assert_memory_equal(of[0], of[1], n_elements);
    for (size_t i = 0; i < n_elements; i++)
        count[of[0][i]]++;
    assert_true(count[PLANISH_VOLUME_MET] > 0 && count[PLANISH_VOLUME_BELOW] > 0 &&
                count[PLANISH_VOLUME_INFEASIBLE] > 0);
    free(constraint);
    free(of[0]);
    free(of[1]);
    test_mesh_destroy(&mesh);
}

static void all_volumes_are_judged(void **state) {
    (void)state;
    judge_volumes(2);
    judge_volumes(3);
}

/** A sweep that is watched. */
typedef struct watch {
    const planish_plan *plan;
    pl_star_problem problem;
    double *before;   /* [n][dim] coordinates before the colour */
    uint8_t *wakes;   /* [n] 1: the star was told of a change since its last visit, good or bad */
    uint8_t *was_bad; /* [n] 1: it was bad after that visit */
    uint8_t *flags;   /* [n] before the colour */
    int64_t n_bad, n_good; /* such stars that want a visit, and that do not, after each colour */
} watch;

static double worst_of(const watch *w, int64_t star) {
    pl_star_value value;
    w->plan->kernel->evaluate[w->plan->dim - 2](&w->problem, star, w->plan->scratch.kernels, 0,
                                                &value);
    return value.max;
}

/** A star of the colour: if its node has moved, and far enough, others are to hear of that. */
static void note_visit(watch *w, int64_t star) {
    const pl_stars *stars = &w->plan->interior.stars;
    const int32_t node = w->plan->interior.centre[star];
    const size_t size = (size_t)w->plan->dim * sizeof(double);
    const int64_t at = (int64_t)node * w->plan->dim;
    if (!(w->flags[node] & PL_CHANGED))
        return;
    const int moved = memcmp(w->before + at, w->plan->scratch.coordinates + at, size) != 0;
    w->wakes[node] = 0;
    w->was_bad[node] = worst_of(w, star) > w->problem.rr2_skip;
    memcpy(w->before + at, w->plan->scratch.coordinates + at, size);
    if (!(w->problem.still > 0 ? w->plan->scratch.changed[node] & PL_TOLD : moved))
        return;
    w->wakes[node] = 1;
    for (int64_t i = stars->ring_offset[star]; i < stars->ring_offset[star + 1]; i++)
        w->wakes[stars->ring[i]] = 1;
}

/** Stars that have changed and are bad want another visit. */
static int after_colour(void *context, int colours, int64_t visits) {
    watch *w = context;
    const pl_visits *interior = &w->plan->interior;
    (void)visits;
    for (int64_t s = interior->colour_begin[colours - 1]; s < interior->colour_begin[colours]; s++)
        note_visit(w, s);
    for (int64_t s = 0; s < interior->stars.n_stars; s++) {
        const int32_t node = interior->centre[s];
        /* What came with moves that nobody was told of may be overlooked. */
        const int is_bad =
            w->problem.still > 0 ? w->was_bad[node] : worst_of(w, s) > w->problem.rr2_skip;
        const int is_wanted = (w->plan->scratch.changed[node] & PL_CHANGED) != 0;
        assert_true(is_wanted || !w->wakes[node] || !is_bad);
        w->n_bad += is_wanted;
        w->n_good += !is_wanted && w->wakes[node];
    }
    memcpy(w->flags, w->plan->scratch.changed, (size_t)w->plan->work.n_nodes);
    return 0;
}

/** Sweeps in which only bad stars are improved look again at each bad one that has changed, also
 *  where a node next to it that has moved is in no bad element; but not at all the others. */
static void watch_sweeps(int dim, double still) {
    const planish_options options = test_options(1);
    planish_plan *plan;
    test_mesh box;
    test_mesh_box(&box, dim, dim == 3 ? 8 : 24);
    test_mesh_perturb(&box, 0.2, 12345);
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    const size_t n = (size_t)box.mesh.n_nodes, size = n * (size_t)dim * sizeof(double);
    watch w = {.plan = plan, .problem = pl_plan_problem(plan, &plan->interior)};
    w.before = malloc(size);
    w.wakes = malloc(n);
    w.was_bad = malloc(n);
    w.flags = malloc(n);
    w.problem.rr2_skip = dim == 3 ? 4 : 1.6;
    w.problem.still = still;
    pl_plan_order(plan, box.coordinates, plan->scratch.coordinates);
    memcpy(w.before, plan->scratch.coordinates, size);
    memset(w.wakes, 1, n);
    memset(w.was_bad, 1, n);
    memset(plan->scratch.changed, PL_CHANGED, n);
    memcpy(w.flags, plan->scratch.changed, n);
    for (int sweep = 0; sweep < 5; sweep++) {
        pl_sweep_tally tally = {.stopped = 0};
        pl_sweep(plan, &plan->interior, &w.problem, PLANISH_METHOD_PLANISH, after_colour, &w,
                 &tally);
    }
    assert_true(w.n_bad > 100 && w.n_good > 100);
    free(w.before);
    free(w.wakes);
    free(w.was_bad);
    free(w.flags);
    planish_plan_destroy(plan);
    test_mesh_destroy(&box);
}

static void bad_stars_are_not_forgotten(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int i = 0; i < 2; i++)
            watch_sweeps(dim, i == 0 ? 0 : 0.1);
}

static void sliding_nodes_are_chosen_too(void **state) {
    (void)state;
    test_mesh box;
    planish_options options = test_options(1);
    bad_box(&box, 3);
    planish_mesh mesh = box.mesh;
    const size_t n = (size_t)mesh.n_nodes;
    uint8_t *constraint = malloc(n), *chosen = malloc(n);
    double *direction = malloc(3 * n * sizeof *direction);
    assert_int_equal(planish_find_slides(&mesh, NULL, 1, constraint, direction, NULL, NULL), 0);
    mesh.constraint = constraint;
    mesh.direction = direction;
    options.only_worse_than = 1.8;
    choose(&mesh, 1.8, 0, chosen);
    test_run r = test_smooth(&mesh, &options);
    int64_t sliding = 0;
    for (size_t i = 0; i < n; i++)
        sliding += chosen[i] && constraint[i] >= PLANISH_CONSTRAINT_ON_PLANE;
    assert_true(sliding > 0);
    assert_int_equal(r.info.n_sliding, sliding);
    for (size_t i = 0; i < n; i++)
        assert_true(chosen[i] || memcmp(r.coordinates + 3 * i, mesh.coordinates + 3 * i,
                                        3 * sizeof(double)) == 0);
    free(r.coordinates);
    free(constraint);
    free(chosen);
    free(direction);
    test_mesh_destroy(&box);
}

static void rings_are_checked(void **state) {
    (void)state;
    test_mesh box;
    planish_plan *plan;
    planish_error error;
    planish_options options = test_options(1);
    bad_box(&box, 2);
    for (int rings = -1; rings < 102; rings += 102) {
        options.rings = rings;
        assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, &error),
                         PLANISH_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, "rings"));
    }
    test_mesh_destroy(&box);
}

static void memory_may_run_out(void **state) {
    (void)state;
    test_mesh box;
    planish_options options = test_options(1);
    bad_box(&box, 3);
    options.only_worse_than = 1.8;
    options.min_volume = 0.01;
    int failures = 0, status = PLANISH_ERROR_MEMORY;
    for (; status == PLANISH_ERROR_MEMORY; failures++) {
        planish_plan *plan = NULL;
        allocations_permit(failures);
        status = planish_plan_create(&box.mesh, &options, &plan, NULL);
        allocations_permit(-1);
        planish_plan_destroy(plan);
    }
    assert_int_equal(status, 0);
    assert_true(failures > 20);
    test_mesh_destroy(&box);
}

static int note_inverted(const planish_progress *progress, void *user) {
    *(int64_t *)user = progress->n_inverted;
    return 0;
}

static int has_node(const planish_mesh *mesh, int64_t element, int64_t node) {
    int any = 0;
    for (int j = 0; j <= mesh->dim; j++)
        any |= mesh->elements[element * (mesh->dim + 1) + j] == node;
    return any;
}

/** What is inverted elsewhere counts, though the plan may not touch it. */
static void inverted_elements_elsewhere_are_counted(void **state) {
    (void)state;
    test_mesh box;
    planish_plan *plan;
    planish_quality quality;
    planish_result result;
    planish_options options = test_options(1);
    bad_box(&box, 3);
    const size_t n = (size_t)box.mesh.n_nodes;
    assert_int_equal(planish_measure_mesh(&box.mesh, &options, &quality, NULL), 0);
    options.only_worse_than = quality.max_radius_ratio * 0.999;
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    uint8_t *is_free = malloc(n);
    double *x = malloc(3 * n * sizeof *x);
    memcpy(x, box.coordinates, 3 * n * sizeof *x);
    planish_plan_get_free(plan, is_free);
    int pushed = 0;
    for (size_t i = 0; i < n; i++)
        if (!is_free[i] && is_inside(&box.mesh, box.coordinates, (int64_t)i) && i % 7 == 0) {
            x[3 * i] += 3;
            pushed++;
        }
    assert_true(pushed > 0);
    int64_t told = -1;
    options.progress = note_inverted;
    options.progress_user = &told;
    assert_int_equal(planish_smooth(plan, x, &options, &result, NULL), 0);
    assert_int_equal(planish_measure(plan, x, &quality, NULL), 0);
    assert_true(quality.n_inverted > pushed);
    assert_int_equal(result.n_inverted, quality.n_inverted);
    assert_int_equal(told, quality.n_inverted);
    free(x);
    free(is_free);
    planish_plan_destroy(plan);
    test_mesh_destroy(&box);
}

/** Errors of plans of a part name elements and nodes by their numbers in the mesh. */
static void errors_name_what_the_mesh_calls_it(void **state) {
    (void)state;
    test_mesh box;
    planish_error error;
    planish_plan *plan = NULL;
    planish_options options = test_options(1);
    test_mesh_box(&box, 3, CELLS);
    const int64_t line = CELLS + 1, inside = ((line * 5) + 5) * line + 5;
    const size_t n = (size_t)box.mesh.n_nodes;
    options.around = &inside;
    options.n_around = 1;
    int64_t element = box.mesh.n_elements - 1;
    while (!has_node(&box.mesh, element, inside))
        element--;
    double *least = calloc((size_t)box.mesh.n_elements, sizeof *least);
    for (int which = 0; which < 2; which++) {
        least[element] = which ? -1 : NAN;
        box.mesh.min_volume = least;
        assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, &error),
                         PLANISH_ERROR_MESH);
        assert_int_equal(error.element, element);
    }
    box.mesh.min_volume = NULL;
    uint8_t *constraint = calloc(1, n);
    constraint[inside] = 9;
    box.mesh.constraint = constraint;
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(error.node, inside);
    constraint[inside] = PLANISH_CONSTRAINT_FREE;
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, &error), 0);
    double *lower = malloc(3 * n * sizeof *lower);
    for (size_t i = 0; i < 3 * n; i++)
        lower[i] = -INFINITY;
    lower[3 * inside + 1] = NAN;
    options.lower = lower;
    assert_int_not_equal(planish_smooth(plan, box.coordinates, &options, NULL, &error), 0);
    assert_int_equal(error.node, inside);
    planish_plan_destroy(plan);
    free(lower);
    free(constraint);
    free(least);
    test_mesh_destroy(&box);
}

static void unused_nodes_are_counted(void **state) {
    (void)state;
    test_mesh box;
    planish_options options = test_options(1);
    bad_box(&box, 2);
    planish_mesh mesh = box.mesh;
    double *x = calloc((size_t)(mesh.n_nodes + 3) * 2, sizeof *x);
    memcpy(x, box.coordinates, (size_t)mesh.n_nodes * 2 * sizeof *x);
    mesh.coordinates = x;
    mesh.n_nodes += 3;
    planish_plan *plan;
    planish_plan_info info;
    assert_int_equal(planish_plan_create(&mesh, &options, &plan, NULL), 0);
    planish_plan_get_info(plan, &info);
    assert_int_equal(info.n_unused, 3);
    planish_plan_destroy(plan);
    free(x);
    test_mesh_destroy(&box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_nodes_of_bad_elements_move),
        cmocka_unit_test(nothing_bad_nothing_done),
        cmocka_unit_test(orientation_does_not_matter),
        cmocka_unit_test(tangles_are_chosen),
        cmocka_unit_test(low_elements_are_chosen),
        cmocka_unit_test(all_volumes_are_judged),
        cmocka_unit_test(bad_stars_are_not_forgotten),
        cmocka_unit_test(sliding_nodes_are_chosen_too),
        cmocka_unit_test(rings_are_checked),
        cmocka_unit_test(memory_may_run_out),
        cmocka_unit_test(inverted_elements_elsewhere_are_counted),
        cmocka_unit_test(errors_name_what_the_mesh_calls_it),
        cmocka_unit_test(unused_nodes_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
