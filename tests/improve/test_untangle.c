/* What planish_smooth promises of tangled meshes: valid where they can be, and then as good as they
 * were; only free nodes move, the same bits, stoppable at any call, never more inverted elements.
 */
#include "support/allocations.h"
#include "support/both.h"
#include "support/effort.h"
#include "support/run.h"
#include "support/tangles.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* The RMS of a mesh that was untangled may be larger than that of the test_run original by
 * this factor: both are local optima. */
#define AS_GOOD 1.02

static void expect_fixed_nodes(const test_tangle *t, const double *coordinates) {
    const int dim = t->mesh.mesh.dim;
    for (int64_t i = 0; i < t->mesh.mesh.n_nodes; i++)
        if (!t->is_inner[i])
            assert_memory_equal(coordinates + i * dim, t->mesh.coordinates + i * dim,
                                (size_t)dim * sizeof *coordinates);
}

/* ---- families ------------------------------------------------------------------------------ */

/** The RMS of the test_run mesh before it was tangled. */
static double rms_of_original(const test_tangle *t, const planish_options *options) {
    test_run s;
    planish_mesh valid = t->mesh.mesh;
    valid.coordinates = t->valid;
    s = test_smooth(&valid, options);
    assert_int_equal(s.before.n_inverted, 0);
    assert_int_equal(s.result.untangling_sweeps, 0);
    free(s.coordinates);
    return s.after.rms_radius_ratio;
}

/** Where most nodes are tangled, nothing is left that tells how the mesh was graded: smoothing then
 *  takes more sweeps than it is given. */
static int forgets_grading(int shape, int tangling) {
    return shape == TEST_GRADED && (tangling == TEST_MOVED_HALF || tangling == TEST_MOVED_ALL ||
                                    tangling == TEST_GROUPS || tangling == TEST_ALL_IN_ONE);
}

static void all_is_untangled(void **state) {
    enum { SEEDS = 3 };
    int dim = *(int *)*state;
    planish_options options = test_options(1);
    options.max_sweeps = 100;
    for (int shape = 0; shape < TEST_SHAPES; shape++) {
        test_tangle t;
        test_tangle_create(&t, dim, (test_shape)shape, 1, (unsigned)shape + 1);
        const double wanted = rms_of_original(&t, &options);
        for (int i = 0; i < TEST_TANGLINGS * SEEDS; i += effort_step(SEEDS)) {
            const int tangling = i / SEEDS;
            test_run s;
            if (tangling == TEST_LEFT_BEHIND && !test_shape_is_deformed((test_shape)shape))
                continue;
            test_tangle_apply(&t, (test_tangling)tangling, (unsigned)i);
            s = test_smooth(&t.mesh.mesh, &options);
            assert_true(s.before.n_inverted > 0);
            assert_int_equal(s.after.n_inverted, 0);
            assert_true(s.result.untangling_sweeps > 0);
            if (!forgets_grading(shape, tangling))
                assert_true(s.after.rms_radius_ratio < AS_GOOD * wanted);
            expect_fixed_nodes(&t, s.coordinates);
            free(s.coordinates);
        }
        test_tangle_destroy(&t);
    }
}

/** Finer meshes in shapes far from their lattice's: more than sweeps can do. */
static void deformed_shapes_are_untangled(void **state) {
    int dim = *(int *)*state;
    for (int shape = 0; shape < TEST_SHAPES; shape++) {
        planish_options options = test_options(1);
        test_tangle t;
        test_run s;
        if (!test_shape_is_deformed((test_shape)shape))
            continue;
        test_tangle_create(&t, dim, (test_shape)shape, 2, (unsigned)shape + 1);
        test_tangle_apply(&t, TEST_LEFT_BEHIND, 1);
        options.max_sweeps = 5;
        s = test_smooth(&t.mesh.mesh, &options);
        assert_true(s.before.n_inverted > 0);
        assert_int_equal(s.after.n_inverted, 0);
        expect_fixed_nodes(&t, s.coordinates);
        free(s.coordinates);
        test_tangle_destroy(&t);
    }
}

/* ---- the same bits ------------------------------------------------------------------------- */

/** Some that are untangled in different ways. */
static const struct {
    test_shape shape;
    test_tangling tangling;
} cases[] = {
    {TEST_BOX, TEST_MOVED_ALL},    {TEST_GRADED, TEST_MOVED_HALF}, {TEST_BENT, TEST_LEFT_BEHIND},
    {TEST_WAVY, TEST_LEFT_BEHIND}, {TEST_RING, TEST_GROUPS},       {TEST_BAR, TEST_MOVED_FEW},
};
enum { N_CASES = sizeof cases / sizeof *cases };

static void create_case(test_tangle *t, int dim, int i, int fineness) {
    test_tangle_create(t, dim, cases[i].shape, fineness, (unsigned)i);
    test_tangle_apply(t, cases[i].tangling, (unsigned)i);
}

static void bits_do_not_depend_on_threads_or_kernel(void **state) {
    static const int threads[] = {1, 2, 3, 5};
    int dim = *(int *)*state;
    planish_options options = test_options(1);
    for (int i = 0; i < N_CASES; i += effort_step(2)) {
        test_tangle t;
        test_run first, other;
        create_case(&t, dim, i, dim == 3 && cases[i].shape == TEST_GRADED ? 1 : 2);
        options = test_options(1);
        options.isa = PLANISH_ISA_PLAIN;
        options.max_sweeps = 3;
        first = test_smooth(&t.mesh.mesh, &options);
        assert_true(first.result.untangling_sweeps > 0);
        for (int k = PLANISH_ISA_AUTO; k <= PLANISH_ISA_AVX512; k++) {
            options.isa = (planish_isa)k;
            options.threads = threads[(i + k) % 4];
            if (!test_has_isa((int)options.isa))
                continue;
            other = test_smooth(&t.mesh.mesh, &options);
            assert_memory_equal(first.coordinates, other.coordinates, test_bytes_of(&t.mesh.mesh));
            assert_int_equal(first.result.sweeps, other.result.sweeps);
            assert_int_equal(first.result.untangling_sweeps, other.result.untangling_sweeps);
            assert_int_equal(first.result.visits, other.result.visits);
            assert_true(first.result.rms == other.result.rms);
            free(other.coordinates);
        }
        free(first.coordinates);
        test_tangle_destroy(&t);
    }
}

static void powers_of_two_change_no_bit(void **state) {
    static const int exponents[] = {-300, -9, 1, 300};
    int dim = *(int *)*state;
    const planish_options options = test_options(1);
    for (int i = 0; i < N_CASES; i++)
        for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k += (size_t)effort_step(4)) {
            test_tangle t;
            test_run a, b;
            create_case(&t, dim, i, 1);
            a = test_smooth(&t.mesh.mesh, &options);
            test_mesh_transform(&t.mesh, ldexp(1, exponents[k]), 0);
            b = test_smooth(&t.mesh.mesh, &options);
            for (int64_t n = 0; n < t.mesh.mesh.n_nodes * dim; n++)
                assert_true(ldexp(a.coordinates[n], exponents[k]) == b.coordinates[n]);
            free(a.coordinates);
            free(b.coordinates);
            test_tangle_destroy(&t);
        }
}

/** Elements of 1e-3 a million away, but for the graded ones: they have not that many digits. */
static void far_from_the_origin_it_works(void **state) {
    int dim = *(int *)*state;
    const planish_options options = test_options(1);
    for (int i = 0; i < N_CASES; i++) {
        test_tangle t;
        test_run near, far;
        create_case(&t, dim, i, 1);
        const double shift = cases[i].shape == TEST_GRADED ? 1e2 : 1e6;
        near = test_smooth(&t.mesh.mesh, &options);
        test_mesh_transform(&t.mesh, 1e-3, shift);
        far = test_smooth(&t.mesh.mesh, &options);
        assert_int_equal(far.after.n_inverted, 0);
        if (cases[i].shape != TEST_GRADED)
            assert_true(fabs(far.after.rms_radius_ratio / near.after.rms_radius_ratio - 1) < 1e-3);
        free(near.coordinates);
        free(far.coordinates);
        test_tangle_destroy(&t);
    }
}

/* ---- what is left alone -------------------------------------------------------------------- */

static void without_untangling_nothing_tangled_moves(void **state) {
    int dim = *(int *)*state, some_moved = 0;
    planish_options options = test_options(1);
    options.untangle = 0;
    for (int shape = 0; shape < TEST_SHAPES; shape++)
        for (int tangling = TEST_MOVED_FEW; tangling < TEST_TANGLINGS; tangling++) {
            test_tangle t;
            test_run s;
            test_tangle_create(&t, dim, (test_shape)shape, 1, 1);
            test_tangle_apply(&t, (test_tangling)tangling, 1);
            s = test_smooth(&t.mesh.mesh, &options);
            assert_int_equal(s.result.untangling_sweeps, 0);
            assert_int_equal(s.after.n_inverted, s.before.n_inverted);
            for (int64_t i = 0; i < t.mesh.mesh.n_elements; i++)
                for (int j = 0;
                     test_measure_of(&t.mesh.mesh, t.mesh.coordinates, i) < 0 && j <= dim; j++) {
                    const int32_t node = t.mesh.elements[i * (dim + 1) + j];
                    assert_memory_equal(s.coordinates + node * dim, t.mesh.coordinates + node * dim,
                                        (size_t)dim * sizeof(double));
                }
            some_moved += s.result.n_moved_nodes > 0;
            free(s.coordinates);
            test_tangle_destroy(&t);
        }
    assert_true(some_moved > 20);
}

static void valid_meshes_need_no_untangling(void **state) {
    int dim = *(int *)*state;
    for (int shape = 0; shape < TEST_SHAPES; shape++) {
        planish_options options = test_options(1);
        test_tangle t;
        test_run with, without;
        test_tangle_create(&t, dim, (test_shape)shape, 1, 2);
        with = test_smooth(&t.mesh.mesh, &options);
        options.untangle = 0;
        without = test_smooth(&t.mesh.mesh, &options);
        assert_int_equal(with.before.n_inverted, 0);
        assert_int_equal(with.result.untangling_sweeps, 0);
        assert_true(with.result.n_moved_nodes > 0);
        assert_memory_equal(with.coordinates, without.coordinates, test_bytes_of(&t.mesh.mesh));
        free(with.coordinates);
        free(without.coordinates);
        test_tangle_destroy(&t);
    }
}

/* ---- progress ------------------------------------------------------------------------------ */

/** What the callback has seen, and when it wants to stop. */
typedef struct watch {
    int calls, done, sweep, restoring_sweeps; /* so far */
    int64_t visits;                           /* in this sweep, by its colours */
    int stop_at;                              /* call; 0: never */
    int stopped_in_sweep, calls_after;        /* it stopped there; calls since */
    planish_progress last;
} watch;

static int look(const planish_progress *progress, void *user) {
    watch *w = user;
    w->calls++;
    if (w->stop_at > 0 && w->calls > w->stop_at) { /* nothing but the end of that sweep */
        w->calls_after++;
        assert_true(w->stopped_in_sweep && progress->sweep_done);
        assert_int_equal(progress->sweep, w->sweep);
    }
    if (progress->sweep != w->sweep) {
        assert_int_equal(progress->sweep, w->sweep + 1);
        assert_int_equal(w->done, w->sweep);           /* each sweep is ended before the next */
        if (progress->phase == PLANISH_PHASE_UNTANGLE) /* untangling comes first */
            assert_int_equal(w->restoring_sweeps, w->sweep);
        w->restoring_sweeps += progress->phase == PLANISH_PHASE_UNTANGLE;
        w->sweep = progress->sweep;
    } else {
        assert_int_equal(progress->phase, w->last.phase);
    }
    if (w->done > 0 && progress->sweep_done && progress->phase != PLANISH_PHASE_UNTANGLE &&
        w->last.phase != PLANISH_PHASE_UNTANGLE)
        assert_true(progress->rms <= w->last.rms);
    w->visits += progress->colour_visits;
    if (progress->sweep_done) {
        assert_int_equal(progress->visits, w->visits);
        w->visits = 0;
    }
    w->done += progress->sweep_done != 0;
    w->last = *progress;
    w->stopped_in_sweep = !progress->sweep_done;
    return w->calls == w->stop_at;
}

static void watch_run(const test_tangle *t, watch *w, test_run *s) {
    planish_options options = test_options(1);
    options.progress = look;
    options.progress_user = w;
    options.max_sweeps = 4;
    *s = test_smooth(&t->mesh.mesh, &options);
    assert_int_equal(w->sweep, s->result.sweeps);
    assert_int_equal(w->done, s->result.sweeps);
    assert_int_equal(w->restoring_sweeps, s->result.untangling_sweeps);
}

static void progress_says_what_is_done(void **state) {
    int dim = *(int *)*state;
    for (int i = 0; i < N_CASES; i++) {
        test_tangle t;
        test_run s;
        watch w = {0};
        create_case(&t, dim, i, 1);
        watch_run(&t, &w, &s);
        assert_true(s.result.untangling_sweeps > 0);
        assert_true(s.result.sweeps > s.result.untangling_sweeps);
        assert_int_equal(w.last.n_inverted, 0);
        assert_true(fabs(w.last.rms / s.result.rms - 1) < 1e-12);
        free(s.coordinates);
        test_tangle_destroy(&t);
    }
}

/** Stopping at the first call, the second, ...: until the run comes to its end. At most a few
 *  hundred of them are tried. */
static void any_call_can_stop(void **state) {
    int dim = *(int *)*state;
    for (int i = 0; i < N_CASES; i++) {
        test_tangle t;
        create_case(&t, dim, i, 1);
        int ended = 0;
        for (int call = 1; !ended; call += effort_step(5) * (1 + call / 50)) {
            test_run s;
            watch w = {.stop_at = call};
            watch_run(&t, &w, &s);
            ended = w.calls < call;
            assert_true(s.after.n_inverted <= s.before.n_inverted);
            assert_true(w.calls_after <= 1);
            assert_true(ended || s.result.stop == PLANISH_STOP_INTERRUPTED);
            expect_fixed_nodes(&t, s.coordinates);
            free(s.coordinates);
        }
        test_tangle_destroy(&t);
    }
}

/** Expect the first sweep to end the run. Where a busy machine held the call up, the search for proofs may
 *  have ended it before: it looks at the limit after 0.05 seconds. Returns whether the call was shorter. */
static int expect_one_sweep(const planish_result *result) {
    const int is_prompt = result->seconds < 0.05;
    assert_int_equal(result->stop, PLANISH_STOP_TIME_LIMIT);
    assert_in_range(result->sweeps, is_prompt ? 1 : 0, 1);
    assert_int_equal(result->untangling_sweeps, result->sweeps);
    assert_true(result->sweeps == 1 || result->n_moved_nodes == 0);
    return is_prompt;
}

static void time_limits_stop(void **state) {
    enum { TRIES = 3 };
    int dim = *(int *)*state;
    for (int i = 0; i < N_CASES; i++) {
        planish_options options = test_options(1);
        test_tangle t;
        create_case(&t, dim, i, 1);
        options.time_limit = 1e-9;
        for (int k = 0, is_prompt = 0; k < TRIES && !is_prompt; k++) {
            test_run s = test_smooth(&t.mesh.mesh, &options);
            is_prompt = expect_one_sweep(&s.result);
            assert_true(s.after.n_inverted <= s.before.n_inverted);
            expect_fixed_nodes(&t, s.coordinates);
            free(s.coordinates);
        }
        test_tangle_destroy(&t);
    }
}

/* ---- memory -------------------------------------------------------------------------------- */

/** Smooth with an allocation that fails; what is promised then. Returns whether it failed. The plan
 *  is its own: plans keep the memory of their last call. */
static int without_one_allocation(const test_tangle *t, double *copy, int64_t permitted,
                                  int only_one, int64_t inverted) {
    planish_options options = test_options(1);
    planish_plan *plan;
    options.max_sweeps = 1;
    planish_error error = {.text = ""};
    planish_quality after;
    memcpy(copy, t->mesh.coordinates, test_bytes_of(&t->mesh.mesh));
    assert_int_equal(planish_plan_create(&t->mesh.mesh, &options, &plan, NULL), 0);
    if (only_one)
        allocations_fail_one(permitted);
    else
        allocations_permit(permitted);
    const int status = planish_smooth(plan, copy, &options, NULL, &error);
    allocations_permit(-1);
    const int failed = allocations_failed();
    assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
    assert_int_equal(planish_measure(plan, copy, &after, NULL), 0);
    assert_true(after.n_inverted <= inverted);
    planish_plan_destroy(plan);
    expect_fixed_nodes(t, copy);
    if (status == PLANISH_ERROR_MEMORY)
        assert_memory_equal(copy, t->mesh.coordinates, test_bytes_of(&t->mesh.mesh));
    return only_one ? failed : status == PLANISH_ERROR_MEMORY;
}

static void without_memory_nothing_is_spoilt(void **state) {
    int dim = *(int *)*state;
    const planish_options options = test_options(1);
    for (int i = 0; i < N_CASES; i++) {
        test_tangle t;
        planish_plan *plan;
        planish_quality before;
        create_case(&t, dim, i, 1);
        double *copy = malloc(test_bytes_of(&t.mesh.mesh));
        assert_int_equal(planish_plan_create(&t.mesh.mesh, &options, &plan, NULL), 0);
        assert_int_equal(planish_measure(plan, t.mesh.coordinates, &before, NULL), 0);
        int64_t n = 0;
        while (without_one_allocation(&t, copy, n, 1, before.n_inverted))
            n++;
        assert_true(n > 10);
        for (int64_t k = 0; k < n; k += effort_step(7))
            without_one_allocation(&t, copy, k, 0, before.n_inverted);
        planish_plan_destroy(plan);
        free(copy);
        test_tangle_destroy(&t);
    }
}

/* ---- other options ------------------------------------------------------------------------- */

static void every_objective_and_direction_untangles(void **state) {
    int dim = *(int *)*state;
    for (int i = 0; i < N_CASES; i++)
        for (int objective = 0; objective < 3; objective++)
            for (int direction = 0; direction < 2; direction++) {
                planish_options options = test_options(1);
                test_tangle t;
                test_run s;
                create_case(&t, dim, i, 1);
                options.objective = (planish_objective)objective;
                options.search = (planish_search)direction;
                options.max_sweeps = 20;
                s = test_smooth(&t.mesh.mesh, &options);
                assert_int_equal(s.after.n_inverted, 0);
                assert_true(s.result.untangling_sweeps > 0);
                expect_fixed_nodes(&t, s.coordinates);
                free(s.coordinates);
                test_tangle_destroy(&t);
            }
}

static void averages_do_not_untangle(void **state) {
    int dim = *(int *)*state;
    for (int method = PLANISH_METHOD_LAPLACIAN; method <= PLANISH_METHOD_LENGTH_LAPLACIAN; method++)
        for (int untangle = 0; untangle < 2; untangle++) {
            planish_options options = test_options(1);
            test_tangle t;
            test_run s;
            test_tangle_create(&t, dim, TEST_BOX, 1, 1);
            test_tangle_apply(&t, TEST_MOVED_ALL, 1);
            options.method = (planish_method)method;
            options.untangle = untangle;
            options.max_sweeps = 1;
            s = test_smooth(&t.mesh.mesh, &options);
            assert_int_equal(s.result.untangling_sweeps, 0);
            assert_int_equal(s.result.sweeps, 1);
            assert_true(s.after.n_inverted > 0);
            free(s.coordinates);
            test_tangle_destroy(&t);
        }
}

static int64_t count_below(const test_tangle *t, const double *coordinates, double least) {
    int64_t n = 0;
    for (int64_t i = 0; i < t->mesh.mesh.n_elements; i++)
        n += fabs(test_measure_of(&t->mesh.mesh, coordinates, i)) < 0.997 * (1 - 1e-12) * least;
    return n;
}

static void minimum_volumes_are_reached(void **state) {
    int dim = *(int *)*state;
    for (int tangling = TEST_MOVED_FEW; tangling < TEST_TANGLINGS; tangling++)
        for (int weight = 0; weight < 2; weight++) {
            planish_options options = test_options(1);
            test_tangle t;
            test_run s;
            test_tangle_create(&t, dim, TEST_BOX, 1, 1);
            test_tangle_apply(&t, (test_tangling)tangling, 2);
            const double least = 0.5 * test_regular_volume(dim);
            options.area_weight = 0.3 * weight;
            if (weight)
                options.min_volume = least;
            else
                options.min_volume_fraction = least / pow(dim == 3 ? 6 : 12, dim);
            s = test_smooth(&t.mesh.mesh, &options);
            assert_true(s.before.n_inverted > 0);
            assert_int_equal(s.after.n_inverted, 0);
            assert_int_equal(s.result.n_below_min_volume, 0);
            assert_int_equal(count_below(&t, s.coordinates, least), 0);
            expect_fixed_nodes(&t, s.coordinates);
            free(s.coordinates);
            test_tangle_destroy(&t);
        }
}

/** More than there is: what can be untangled is, all the same. */
static void hopeless_volumes_come_to_an_end(void **state) {
    int dim = *(int *)*state;
    for (int tangling = TEST_MOVED_FEW; tangling < TEST_TANGLINGS; tangling++) {
        planish_options options = test_options(1);
        test_tangle t;
        test_run s;
        test_tangle_create(&t, dim, TEST_BOX, 1, 1);
        test_tangle_apply(&t, (test_tangling)tangling, 3);
        options.min_volume = 3 * test_regular_volume(dim);
        s = test_smooth(&t.mesh.mesh, &options);
        assert_int_equal(s.after.n_inverted, 0);
        assert_true(s.result.n_below_min_volume > 0);
        assert_int_equal(s.result.n_below_min_volume,
                         count_below(&t, s.coordinates, options.min_volume));
        free(s.coordinates);
        test_tangle_destroy(&t);
    }
}

/** Nodes that start within the box stay within it, those that do not stay where they are; none goes
 *  farther than it may. */
static void expect_bounds(const test_tangle *t, const planish_options *options,
                          const double *coordinates) {
    const int dim = t->mesh.mesh.dim;
    for (int64_t i = 0; i < t->mesh.mesh.n_nodes; i++) {
        const double *x = t->mesh.coordinates + i * dim, *y = coordinates + i * dim;
        int was_inside = 1, is_inside = 1;
        double far = 0;
        for (int d = 0; d < dim; d++) {
            was_inside &= x[d] >= options->box_lower[d] && x[d] <= options->box_upper[d];
            is_inside &= y[d] >= options->box_lower[d] && y[d] <= options->box_upper[d];
            far = hypot(far, x[d] - y[d]);
        }
        if (was_inside)
            assert_true(is_inside);
        else
            assert_memory_equal(x, y, (size_t)dim * sizeof *x);
        if (options->max_displacement > 0)
            assert_true(far <= options->max_displacement * (1 + 1e-12));
    }
}

/** Smooth with a box, or a distance, as bounds; returns how many elements are inverted less. */
static int64_t smooth_within(const test_tangle *t, int by_distance, double low, double high) {
    planish_options options = test_options(1);
    test_run s;
    options.max_displacement = by_distance ? high : 0;
    options.max_sweeps = 5;
    for (int d = 0; d < t->mesh.mesh.dim && !by_distance; d++) {
        options.box_lower[d] = low;
        options.box_upper[d] = high;
    }
    s = test_smooth(&t->mesh.mesh, &options);
    expect_bounds(t, &options, s.coordinates);
    expect_fixed_nodes(t, s.coordinates);
    free(s.coordinates);
    return s.before.n_inverted - s.after.n_inverted;
}

static int64_t count_inverted(const test_tangle *t) {
    planish_plan *plan;
    planish_quality quality;
    assert_int_equal(planish_plan_create(&t->mesh.mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_measure(plan, t->mesh.coordinates, &quality, NULL), 0);
    planish_plan_destroy(plan);
    return quality.n_inverted;
}

static void wide_bounds_leave_room(void **state) {
    int dim = *(int *)*state;
    for (int i = 0; i < N_CASES; i++)
        for (int by_distance = 0; by_distance < 2; by_distance++) {
            test_tangle t;
            create_case(&t, dim, i, 1);
            assert_int_equal(smooth_within(&t, by_distance, -50, 50), count_inverted(&t));
            test_tangle_destroy(&t);
        }
}

/** What can be done within narrow bounds is not said; but that they are kept. */
static void narrow_bounds_are_kept(void **state) {
    static const test_tangling tanglings[] = {TEST_MOVED_FEW, TEST_DUPLICATES};
    int dim = *(int *)*state;
    const double cells = dim == 3 ? 6 : 12;
    int64_t won = 0;
    for (size_t i = 0; i < sizeof tanglings / sizeof *tanglings; i++)
        for (int by_distance = 0; by_distance < 2; by_distance++) {
            test_tangle t;
            test_tangle_create(&t, dim, TEST_BOX, 1, 1);
            test_tangle_apply(&t, tanglings[i], 4);
            const int64_t less =
                smooth_within(&t, by_distance, 0.25 * cells, by_distance ? 0.7 : 0.75 * cells);
            assert_true(less >= 0);
            won += less;
            test_tangle_destroy(&t);
        }
    assert_true(won > 0);
}

static void floats_are_valid(void **state) {
    int dim = *(int *)*state;
    for (int shape = 0; shape < TEST_SHAPES; shape++)
        for (int tangling = TEST_MOVED_FEW; tangling < TEST_TANGLINGS; tangling++) {
            planish_options options = test_options(1);
            test_tangle t;
            test_run s;
            test_tangle_create(&t, dim, (test_shape)shape, 1, 1);
            test_tangle_apply(&t, (test_tangling)tangling, 5);
            const int64_t n = t.mesh.mesh.n_nodes * dim;
            for (int64_t i = 0; i < n; i++) {
                volatile float rounded = (float)t.mesh.coordinates[i];
                t.mesh.coordinates[i] = rounded;
            }
            options.precision = PLANISH_PRECISION_FLOAT;
            options.max_sweeps = 20;
            s = test_smooth(&t.mesh.mesh, &options);
            for (int64_t i = 0; i < n; i++) {
                volatile float rounded = (float)s.coordinates[i];
                assert_true(s.coordinates[i] == rounded);
            }
            assert_int_equal(s.after.n_inverted, 0);
            free(s.coordinates);
            test_tangle_destroy(&t);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(all_is_untangled),
        BOTH(deformed_shapes_are_untangled),
        BOTH(bits_do_not_depend_on_threads_or_kernel),
        BOTH(powers_of_two_change_no_bit),
        BOTH(far_from_the_origin_it_works),
        BOTH(without_untangling_nothing_tangled_moves),
        BOTH(valid_meshes_need_no_untangling),
        BOTH(progress_says_what_is_done),
        BOTH(any_call_can_stop),
        BOTH(time_limits_stop),
        BOTH(without_memory_nothing_is_spoilt),
        BOTH(every_objective_and_direction_untangles),
        BOTH(averages_do_not_untangle),
        BOTH(minimum_volumes_are_reached),
        BOTH(hopeless_volumes_come_to_an_end),
        BOTH(wide_bounds_leave_room),
        BOTH(narrow_bounds_are_kept),
        BOTH(floats_are_valid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
