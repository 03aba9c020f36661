/* planish_progress_get_coordinates: where nodes are at the end of each sweep. */
#include "support/both.h"
#include "support/cell_meshes.h"
#include "support/meshes.h"
#include "support/problems.h"
#include "support/run.h"
#include "support/snapshots.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { THREADS = 3 };

/** A problem that was smoothed with snapshots. */
typedef struct recorded {
    test_problem problem;
    planish_plan *plan;
    planish_result result;
    double *x; /* smoothed */
    snapshots taken;
} recorded;

static void expect(int status, const planish_error *error) {
    if (status)
        fail_msg("%s", error->text);
}

static size_t length_of(const planish_mesh *mesh) {
    return (size_t)(mesh->n_nodes * mesh->dim);
}

/** Smooth x of mesh, with snapshots or (taken NULL) without. */
static planish_plan *smooth(const planish_mesh *mesh, const planish_options *given, int threads,
                            double *x, snapshots *taken, planish_result *result) {
    planish_error error = {.text = ""};
    planish_options options = *given;
    planish_plan *plan = NULL;
    options.threads = threads;
    expect(planish_plan_create(mesh, &options, &plan, &error), &error);
    options.progress = taken ? snapshots_take : NULL;
    options.progress_user = taken;
    expect(planish_smooth(plan, x, &options, result, &error), &error);
    return plan;
}

static recorded record(int dim, test_wish wish, int threads) {
    recorded r = {.plan = NULL};
    test_problem_create(&r.problem, dim, dim == 3 ? 4 : 7, wish, 3);
    r.x = test_copy_of(&r.problem.mesh);
    r.taken = snapshots_begin(r.x, length_of(&r.problem.mesh));
    r.plan = smooth(&r.problem.mesh, &r.problem.options, threads, r.x, &r.taken, &r.result);
    return r;
}

static void end(recorded *r) {
    planish_plan_destroy(r->plan);
    snapshots_free(&r->taken);
    test_problem_destroy(&r->problem);
    free(r->x);
}

/* ---- every problem ---------------------------------------------------------------------------- */

/** Snapshots set the places of all nodes that the plan moves; the others are where they were. */
static void check_nodes(const recorded *r) {
    const planish_mesh *mesh = &r->problem.mesh;
    const size_t bytes = (size_t)mesh->dim * sizeof(double);
    uint8_t *reason = malloc((size_t)mesh->n_nodes);
    assert_int_equal(planish_plan_get_held(r->plan, NULL, reason, NULL), 0);
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const int64_t at = i * mesh->dim;
        for (int d = 0; d < mesh->dim; d++)
            assert_true(r->taken.is_set[at + d] || reason[i] != 0);
        for (int s = 0; s < r->taken.n && reason[i] != 0; s++)
            assert_memory_equal(r->taken.x[s] + at, r->taken.given + at, bytes);
    }
    free(reason);
}

/** The figures of progress are those of the snapshot: inverted elements by its own determinants. */
static void check_figures(const recorded *r, test_wish wish) {
    const planish_mesh *mesh = &r->problem.mesh;
    for (int i = 0; i < r->taken.n; i++) {
        const planish_progress *figures = &r->taken.figures[i];
        planish_quality quality;
        int64_t n_inverted = 0;
        for (int64_t e = 0; e < mesh->n_elements; e++)
            n_inverted += !(test_measure_of(mesh, r->taken.x[i], e) > 0);
        assert_int_equal(planish_measure(r->plan, r->taken.x[i], &quality, NULL), 0);
        if (!r->problem.options.around)
            assert_int_equal(figures->n_inverted, n_inverted);
        assert_int_equal(figures->n_inverted, quality.n_inverted);
        if (r->problem.options.objective == PLANISH_OBJECTIVE_RADIUS_RATIO &&
            !(fabs(figures->rms / quality.rms_radius_ratio - 1) < 1e-9))
            fail_msg("%s: RMS %.17g after sweep %d, of the snapshot %.17g", test_wish_names[wish],
                     figures->rms, figures->sweep, quality.rms_radius_ratio);
    }
}

/** Whether the last sweep's mesh is the result: no trial was accepted later, no node put back. */
static int ends_with_result(test_wish wish) {
    return wish != WISH_WORST_RATIO && wish != WISH_WORST_ANGLE && wish != WISH_TANGLED &&
           wish != WISH_HOPELESS && wish != WISH_TANGLED_SLIDING && wish != WISH_LEAST_VOLUME &&
           wish != WISH_OWN_VOLUMES && wish != WISH_FRACTION;
}

static void snapshots_are_the_mesh_of_the_figures(void **state) {
    const int dim = *(int *)*state;
    int n_results = 0;
    for (int wish = 0; wish < WISHES; wish++) {
        recorded r = record(dim, (test_wish)wish, 1);
        const size_t bytes = test_bytes_of(&r.problem.mesh);
        double *without = test_copy_of(&r.problem.mesh);
        planish_result result;
        planish_plan_destroy(
            smooth(&r.problem.mesh, &r.problem.options, 1, without, NULL, &result));
        assert_memory_equal(r.x, without, bytes);
        assert_int_equal(r.taken.n, result.sweeps);
        assert_true(r.taken.n > 0 && r.taken.n_refused > 0);
        check_nodes(&r);
        check_figures(&r, (test_wish)wish);
        if (ends_with_result((test_wish)wish) && result.n_put_back == 0) {
            assert_memory_equal(r.taken.x[r.taken.n - 1], r.x, bytes);
            n_results++;
        }
        free(without);
        end(&r);
    }
    assert_true(n_results >= 10);
}

static void snapshots_are_the_same_on_any_number_of_threads(void **state) {
    const int dim = *(int *)*state;
    static const test_wish wishes[] = {WISH_PLAIN, WISH_TANGLED, WISH_SLIDING, WISH_WORST_RATIO,
                                       WISH_PERIODIC};
    for (size_t i = 0; i < sizeof wishes / sizeof *wishes; i++) {
        recorded one = record(dim, wishes[i], 1);
        for (int threads = 2; threads <= THREADS; threads++) {
            recorded more = record(dim, wishes[i], threads);
            snapshots_assert_same(&one.taken, &more.taken);
            end(&more);
        }
        end(&one);
    }
}

/** A mesh without inverted elements stays so in each snapshot, and the RMS that planish_measure finds never
 *  rises. */
static void snapshots_of_a_valid_mesh_are_valid(void **state) {
    const int dim = *(int *)*state;
    recorded r = record(dim, WISH_PLAIN, 2);
    double before = INFINITY;
    for (int i = 0; i < r.taken.n; i++) {
        planish_quality quality;
        for (int64_t e = 0; e < r.problem.mesh.n_elements; e++)
            assert_true(test_measure_of(&r.problem.mesh, r.taken.x[i], e) > 0);
        assert_int_equal(planish_measure(r.plan, r.taken.x[i], &quality, NULL), 0);
        assert_true(quality.rms_radius_ratio <= before);
        before = quality.rms_radius_ratio;
    }
    assert_true(r.taken.n > 2 &&
                memcmp(r.taken.x[0], r.taken.x[1], test_bytes_of(&r.problem.mesh)) != 0);
    end(&r);
}

/** Sweeps for the worst elements are trials: snapshots have the accepted mesh, and change where a trial is
 *  accepted alone. */
static void snapshots_of_a_trial_are_the_accepted_mesh(void **state) {
    const int dim = *(int *)*state;
    recorded r = record(dim, WISH_WORST_RATIO, 1);
    const size_t bytes = test_bytes_of(&r.problem.mesh);
    int first = 0, n_worst = 0, n_changes = 0;
    while (first < r.taken.n && r.taken.figures[first].phase != PLANISH_PHASE_WORST)
        first++;
    assert_true(first > 0 && r.result.n_put_back == 0);
    for (int i = first; i < r.taken.n; i++) {
        planish_quality before, now;
        const int is_other = memcmp(r.taken.x[i], r.taken.x[i - 1], bytes) != 0;
        assert_int_equal(planish_measure(r.plan, r.taken.x[i - 1], &before, NULL), 0);
        assert_int_equal(planish_measure(r.plan, r.taken.x[i], &now, NULL), 0);
        assert_true(now.max_radius_ratio <= before.max_radius_ratio);
        assert_true(i > first || !is_other);
        n_worst++;
        n_changes += is_other;
    }
    assert_int_equal(n_worst, r.result.worst_sweeps);
    assert_true(n_changes < n_worst && r.result.worst_after < r.result.worst_before);
    end(&r);
}

/* ---- other layouts and elements -------------------------------------------------------------- */

/** Spread dense coordinates [n][dim] out with strides; what is between them is -7. */
static double *spread(const planish_mesh *mesh, const double *dense, size_t length) {
    double *x = malloc(length * sizeof *x);
    assert_non_null(x);
    for (size_t i = 0; i < length; i++)
        x[i] = -7;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        for (int d = 0; d < mesh->dim; d++)
            x[i * mesh->node_stride + d * mesh->component_stride] = dense[i * mesh->dim + d];
    return x;
}

static void strides_change_the_layout_alone(void **state) {
    const int dim = *(int *)*state;
    recorded dense = record(dim, WISH_PLAIN, 2);
    for (int by_component = 0; by_component < 2; by_component++) {
        planish_mesh mesh = dense.problem.mesh;
        planish_result result;
        mesh.node_stride = by_component ? 1 : dim + 2;
        mesh.component_stride = by_component ? mesh.n_nodes : 1;
        const size_t length = (size_t)(mesh.n_nodes * (dim + 2));
        double *x = spread(&mesh, mesh.coordinates, length);
        mesh.coordinates = x;
        snapshots taken = snapshots_begin(x, length);
        planish_plan_destroy(smooth(&mesh, &dense.problem.options, 2, x, &taken, &result));
        assert_int_equal(taken.n, dense.taken.n);
        for (int i = 0; i < taken.n; i++) {
            double *expected = spread(&mesh, dense.taken.x[i], length);
            assert_memory_equal(taken.x[i], expected, length * sizeof *expected);
            free(expected);
        }
        snapshots_free(&taken);
        free(x);
    }
    end(&dense);
}

/** Whether a mid is in the middle of some pair of corners of its cell at x, as it is at given. */
static int is_between(const planish_mesh *mesh, int64_t cell, int32_t mid, int corners,
                      const double *given, const double *x) {
    const int32_t *node = mesh->cells->node + mesh->cells->offset[cell];
    const int dim = mesh->dim;
    int found = 0;
    for (int a = 0; a < corners; a++)
        for (int b = 0; b < a; b++) {
            double off_given = 0, off = 0;
            for (int d = 0; d < dim; d++) {
                const double *g[] = {given + (int64_t)node[a] * dim,
                                     given + (int64_t)node[b] * dim};
                const double *now[] = {x + (int64_t)node[a] * dim, x + (int64_t)node[b] * dim};
                off_given = fmax(off_given, fabs((g[0][d] + g[1][d]) / 2 - given[mid * dim + d]));
                off = fmax(off, fabs((now[0][d] + now[1][d]) / 2 - x[mid * dim + d]));
            }
            found |= off_given < 1e-14 && off < 1e-12;
        }
    return found;
}

/** Mids of cells of order 2 are in the middle of their edges in each snapshot, and the last snapshot is the
 *  result. */
static void mids_are_where_their_ends_are(void **state) {
    (void)state;
    static const cell_box_kind kinds[] = {BOX_QUADRILATERALS, BOX_HEXAHEDRA, BOX_WEDGES};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        cell_box *linear = cell_box_create(kinds[k], 4);
        cell_box_shake(linear, 0.2, 5);
        cell_box *box = cell_box_raise(linear, 0);
        const int corners = kinds[k] == BOX_QUADRILATERALS ? 4 : kinds[k] == BOX_WEDGES ? 6 : 8;
        const planish_options options = test_options(2);
        planish_result result;
        double *x = test_copy_of(&box->mesh);
        snapshots taken = snapshots_begin(x, length_of(&box->mesh));
        planish_plan_destroy(smooth(&box->mesh, &options, 2, x, &taken, &result));
        assert_true(taken.n > 1 && result.n_put_back == 0);
        for (int i = 0; i < taken.n; i++) {
            planish_mesh mesh = box->mesh;
            planish_cell_quality quality;
            mesh.coordinates = taken.x[i];
            assert_int_equal(planish_measure_cells(&mesh, 0, 1, &quality, NULL, NULL), 0);
            assert_int_equal(quality.all.n_inverted, 0);
            for (int64_t c = 0; c < box->cells.n; c++)
                for (int64_t j = box->offset[c] + corners; j < box->offset[c + 1]; j++)
                    assert_true(is_between(&mesh, c, box->node[j], corners, box->x, taken.x[i]));
        }
        assert_memory_equal(taken.x[taken.n - 1], x, test_bytes_of(&box->mesh));
        snapshots_free(&taken);
        cell_box_destroy(box);
        cell_box_destroy(linear);
        free(x);
    }
}

/* ---- periodic nodes --------------------------------------------------------------------------- */

/** A periodic box of curved hexahedra. */
typedef struct curved_box {
    cell_box *box; /* its sides x = 0 and x = CUBES are pairs */
    int32_t (*pair)[2];
    uint8_t *constraint;
    double *direction;
} curved_box;

enum { CUBES = 3 };

/** Pair the nodes of order 1 of x = 0 and x = CUBES; those within these sides slide on their planes. */
static void make_periodic(curved_box *p, int64_t n_corners) {
    planish_mesh *mesh = &p->box->mesh;
    const double *x = p->box->x;
    p->pair = calloc((size_t)n_corners, sizeof *p->pair);
    p->constraint = calloc((size_t)mesh->n_nodes, 1);
    p->direction = calloc((size_t)mesh->n_nodes * 3, sizeof *p->direction);
    for (int32_t a = 0; a < n_corners; a++)
        for (int32_t b = 0; b < n_corners; b++) {
            const double *at[] = {x + (int64_t)a * 3, x + (int64_t)b * 3};
            if (at[0][0] != 0 || at[1][0] != CUBES || at[0][1] != at[1][1] || at[0][2] != at[1][2])
                continue;
            p->pair[mesh->n_periodic][0] = a;
            p->pair[mesh->n_periodic++][1] = b;
            if (!(at[0][1] > 0 && at[0][1] < CUBES && at[0][2] > 0 && at[0][2] < CUBES))
                continue;
            p->constraint[a] = p->constraint[b] = PLANISH_CONSTRAINT_ON_PLANE;
            p->direction[(int64_t)a * 3] = p->direction[(int64_t)b * 3] = 1;
        }
    mesh->periodic = &p->pair[0][0];
    mesh->constraint = p->constraint;
    mesh->direction = p->direction;
}

/** Move both nodes of each pair within x = 0 and x = CUBES alike. */
static void shift_within_sides(const cell_box *box, unsigned seed) {
    double way[CUBES][CUBES][2];
    for (int i = 0; i < CUBES * CUBES * 2; i++)
        (&way[0][0][0])[i] = test_random(&seed) - 0.5;
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        double *x = box->x + i * 3;
        const int j = (int)x[1] % CUBES, k = (int)x[2] % CUBES;
        for (int d = 1; d < 3 && (x[0] == 0 || x[0] == CUBES) && j > 0 && k > 0; d++)
            x[d] += way[j][k][d - 1];
    }
}

/** Move mids next to x = CUBES about, where all elements stay valid. */
static void bend(const cell_box *box, int64_t n_corners, unsigned seed) {
    for (int64_t i = n_corners * 3; i < box->mesh.n_nodes * 3; i++) {
        planish_cell_quality quality;
        if (box->x[i / 3 * 3] < CUBES - 1 || box->x[i / 3 * 3] == CUBES)
            continue;
        const double was = box->x[i];
        box->x[i] += 0.7 * (test_random(&seed) - 0.5);
        assert_int_equal(planish_measure_cells(&box->mesh, 0, 1, &quality, NULL, NULL), 0);
        if (quality.all.n_inverted > 0)
            box->x[i] = was;
    }
}

/** Elements at nodes that follow are judged with their leaders: in each snapshot all are valid, and no node
 *  goes back. */
static void elements_at_followers_are_valid(void **state) {
    (void)state;
    for (unsigned seed = 1; seed <= 6; seed++) {
        cell_box *linear = cell_box_create(BOX_HEXAHEDRA, CUBES);
        shift_within_sides(linear, seed);
        curved_box p = {.box = cell_box_raise(linear, 0)};
        const planish_options options = test_options(2);
        planish_result result;
        bend(p.box, linear->mesh.n_nodes, seed);
        make_periodic(&p, linear->mesh.n_nodes);
        double *x = test_copy_of(&p.box->mesh);
        snapshots taken = snapshots_begin(x, length_of(&p.box->mesh));
        planish_plan_destroy(smooth(&p.box->mesh, &options, 2, x, &taken, &result));
        assert_int_equal(result.n_put_back, 0);
        assert_true(taken.n > 1);
        for (int i = 0; i < taken.n; i++) {
            planish_mesh mesh = p.box->mesh;
            planish_cell_quality quality;
            mesh.coordinates = taken.x[i];
            assert_int_equal(planish_measure_cells(&mesh, 0, 1, &quality, NULL, NULL), 0);
            assert_int_equal(quality.all.n_inverted, 0);
        }
        snapshots_free(&taken);
        free(x);
        free(p.pair);
        free(p.constraint);
        free(p.direction);
        cell_box_destroy(p.box);
        cell_box_destroy(linear);
    }
}

/* ---- refusals -------------------------------------------------------------------------------- */

/** Ask for nothing, and for the array that is smoothed; end the run. */
static int ask_wrongly(const planish_progress *progress, void *user) {
    planish_error error = {.text = ""};
    double *x = user;
    if (!progress->sweep_done)
        return 0;
    assert_int_equal(planish_progress_get_coordinates(progress, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "NULL"));
    assert_int_equal(planish_progress_get_coordinates(NULL, x, &error), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_progress_get_coordinates(progress, x, &error), PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "another array"));
    return 1;
}

static void what_has_no_positions_is_refused(void **state) {
    (void)state;
    test_mesh box;
    planish_options options = test_options(1);
    const planish_progress nowhere = {.sweep_done = 1};
    test_bad_box(&box, 3, 4, 2);
    double *x = test_copy_of(&box.mesh);
    options.progress = ask_wrongly;
    options.progress_user = x;
    assert_int_equal(test_smooth_in_place(&box.mesh, x, &options).stop, PLANISH_STOP_INTERRUPTED);
    assert_int_equal(planish_progress_get_coordinates(&nowhere, x, NULL), PLANISH_ERROR_ARGUMENT);
    test_mesh_destroy(&box);
    free(x);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(snapshots_are_the_mesh_of_the_figures),
        BOTH(snapshots_are_the_same_on_any_number_of_threads),
        BOTH(snapshots_of_a_valid_mesh_are_valid),
        BOTH(snapshots_of_a_trial_are_the_accepted_mesh),
        BOTH(strides_change_the_layout_alone),
        cmocka_unit_test(mids_are_where_their_ends_are),
        cmocka_unit_test(elements_at_followers_are_valid),
        cmocka_unit_test(what_has_no_positions_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
