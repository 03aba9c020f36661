/* What planish_smooth promises: better, valid, only free nodes, the same bits, stoppable. */
#include "support/both.h"
#include "support/meshes.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 8 };

static void same_coordinates(const planish_mesh *mesh, const test_run *a, const test_run *b) {
    assert_memory_equal(a->coordinates, b->coordinates, test_bytes_of(mesh));
}

/* ---- better and valid --------------------------------------------------------------------- */

static int rms_falls(const planish_progress *progress, void *user) {
    double *last = user;
    if (progress->sweep_done) {
        assert_true(progress->rms <= *last);
        *last = progress->rms;
    }
    return 0;
}

static void the_mesh_becomes_better(void **state) {
    int dim = *(int *)*state;
    for (int direction = 0; direction < 2; direction++) {
        test_mesh mesh;
        test_run s;
        test_bad_box(&mesh, dim, CELLS, 0);
        double last = INFINITY;
        planish_options options = test_options(1);
        options.search = (planish_search)direction;
        options.progress = rms_falls;
        options.progress_user = &last;
        s = test_smooth(&mesh.mesh, &options);
        assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
        assert_true(s.after.rms_radius_ratio < 0.98 * s.before.rms_radius_ratio);
        assert_true(s.after.max_radius_ratio <= s.before.max_radius_ratio);
        assert_int_equal(s.after.n_inverted, 0);
        assert_true(fabs(s.after.total_volume / s.before.total_volume - 1) < 1e-12);
        assert_true(fabs(s.result.rms / s.after.rms_radius_ratio - 1) < 1e-12);
        assert_int_equal(s.info.n_free, dim == 3 ? 7 * 7 * 7 : 7 * 7);
        free(s.coordinates);
        test_mesh_destroy(&mesh);
    }
}

static void only_free_nodes_move(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, CELLS, 0);
    uint8_t *constraint = calloc((size_t)mesh.mesh.n_nodes, 1);
    for (int64_t i = 0; i < mesh.mesh.n_nodes; i += 3)
        constraint[i] = PLANISH_CONSTRAINT_FIXED;
    mesh.mesh.constraint = constraint;
    planish_options options = test_options(1);
    s = test_smooth(&mesh.mesh, &options);
    int64_t moved = 0;
    double farthest = 0;
    for (int64_t i = 0; i < mesh.mesh.n_nodes; i++) {
        const double *x = mesh.coordinates + i * dim, *y = s.coordinates + i * dim;
        double distance = 0;
        for (int d = 0; d < dim; d++)
            distance += (x[d] - y[d]) * (x[d] - y[d]);
        if (constraint[i] || !test_is_inside_box(x, dim, CELLS))
            assert_memory_equal(x, y, (size_t)dim * sizeof *x);
        moved += distance > 0;
        farthest = distance > farthest ? distance : farthest;
    }
    assert_true(moved > s.info.n_free / 2);
    assert_int_equal(moved, s.result.n_moved_nodes);
    assert_true(fabs(s.result.max_displacement - sqrt(farthest)) < 1e-14);
    free(constraint);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/* ---- the same bits ------------------------------------------------------------------------ */

static void bits_do_not_depend_on_threads_or_kernel(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run first, other;
    test_bad_box(&mesh, dim, CELLS, 0);
    for (int direction = 0; direction < 2; direction++) {
        planish_options options = test_options(1);
        options.search = (planish_search)direction;
        options.isa = PLANISH_ISA_PLAIN;
        first = test_smooth(&mesh.mesh, &options);
        static const int threads[] = {1, 2, 3, 4, 7};
        for (int isa = PLANISH_ISA_AUTO; isa <= PLANISH_ISA_AVX512; isa++)
            for (size_t t = 0; t < sizeof threads / sizeof *threads; t++) {
                planish_plan *plan;
                options.threads = threads[t];
                options.isa = (planish_isa)isa;
                if (planish_plan_create(&mesh.mesh, &options, &plan, NULL) != 0)
                    continue; /* this CPU has no such instructions */
                planish_plan_destroy(plan);
                other = test_smooth(&mesh.mesh, &options);
                same_coordinates(&mesh.mesh, &first, &other);
                assert_true(first.result.rms == other.result.rms);
                assert_int_equal(first.result.visits, other.result.visits);
                free(other.coordinates);
            }
        free(first.coordinates);
    }
    test_mesh_destroy(&mesh);
}

static void powers_of_two_change_no_bit(void **state) {
    int dim = *(int *)*state;
    static const int exponents[] = {-900, -300, -1, 7, 300, 900};
    planish_options options = test_options(1);
    test_mesh mesh;
    test_run plain, scaled;
    test_bad_box(&mesh, dim, CELLS, 0);
    plain = test_smooth(&mesh.mesh, &options);
    for (size_t e = 0; e < sizeof exponents / sizeof *exponents; e++) {
        test_mesh other;
        test_bad_box(&other, dim, CELLS, 0);
        test_mesh_transform(&other, ldexp(1, exponents[e]), 0);
        scaled = test_smooth(&other.mesh, &options);
        for (int64_t i = 0; i < mesh.mesh.n_nodes * dim; i++)
            assert_true(scaled.coordinates[i] == ldexp(plain.coordinates[i], exponents[e]));
        free(scaled.coordinates);
        test_mesh_destroy(&other);
    }
    free(plain.coordinates);
    test_mesh_destroy(&mesh);
}

/** Elements of 1e-3 a million away: only the digits that such coordinates have are lost. */
static void far_from_the_origin_it_works(void **state) {
    int dim = *(int *)*state;
    planish_options options = test_options(1);
    test_mesh near, far;
    test_run a, b;
    test_bad_box(&near, dim, CELLS, 0);
    test_bad_box(&far, dim, CELLS, 0);
    test_mesh_transform(&near, 1e-3, 0);
    test_mesh_transform(&far, 1e-3, 1e6);
    a = test_smooth(&near.mesh, &options);
    b = test_smooth(&far.mesh, &options);
    assert_int_equal(b.after.n_inverted, 0);
    assert_true(fabs(a.after.rms_radius_ratio / b.after.rms_radius_ratio - 1) < 1e-5);
    free(a.coordinates);
    free(b.coordinates);
    test_mesh_destroy(&near);
    test_mesh_destroy(&far);
}

static void element_order_does_not_invert(void **state) {
    int dim = *(int *)*state;
    planish_options options = test_options(1);
    test_mesh mesh, mixed;
    test_run a, b;
    test_bad_box(&mesh, dim, CELLS, 0);
    test_bad_box(&mixed, dim, CELLS, 0);
    test_mesh_reverse_some(&mixed, 2, 5);
    a = test_smooth(&mesh.mesh, &options);
    b = test_smooth(&mixed.mesh, &options);
    assert_int_equal(b.before.n_inverted, 0);
    assert_true(b.info.n_negative_order > 0);
    assert_true(fabs(a.after.rms_radius_ratio / b.after.rms_radius_ratio - 1) < 1e-6);
    free(a.coordinates);
    free(b.coordinates);
    test_mesh_destroy(&mesh);
    test_mesh_destroy(&mixed);
}

static void floats_stay_floats(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, CELLS, 0);
    for (int64_t i = 0; i < mesh.mesh.n_nodes * dim; i++) {
        volatile float rounded = (float)mesh.coordinates[i];
        mesh.coordinates[i] = rounded;
    }
    planish_options options = test_options(1);
    options.precision = PLANISH_PRECISION_FLOAT;
    s = test_smooth(&mesh.mesh, &options);
    for (int64_t i = 0; i < mesh.mesh.n_nodes * dim; i++) {
        volatile float rounded = (float)s.coordinates[i];
        assert_true(s.coordinates[i] == rounded);
    }
    assert_true(s.result.n_moved_nodes > s.info.n_free / 2);
    assert_int_equal(s.after.n_inverted, 0);
    assert_true(s.after.rms_radius_ratio < s.before.rms_radius_ratio);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/** Also where rounding is on the other side: of regular triangles, turned by chance. */
static void ratios_are_one_or_more(void **state) {
    enum { N = 300 };
    const double third = 2.0943951023931955; /* of a turn */
    double x[N][3][2], ratio[N];
    int32_t triangle[N][3];
    planish_plan *plan;
    (void)state;
    srand(5);
    for (int i = 0; i < N; i++) {
        const double turn = rand() % 1000, size = 1 + rand() % 1000;
        for (int j = 0; j < 3; j++) {
            triangle[i][j] = 3 * i + j;
            x[i][j][0] = 5000.0 * i + size * cos(turn + j * third);
            x[i][j][1] = size * sin(turn + j * third);
        }
    }
    const planish_mesh mesh = {.dim = 2,
                               .n_nodes = 3 * N,
                               .n_elements = N,
                               .coordinates = &x[0][0][0],
                               .elements = triangle[0]};
    assert_int_equal(planish_plan_create(&mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_measure_elements(plan, &x[0][0][0], ratio, NULL), 0);
    for (int i = 0; i < N; i++)
        assert_true(ratio[i] >= 1 && ratio[i] < 1 + 1e-9);
    planish_plan_destroy(plan);
}

static void ratios_of_inverted_elements_are_none(void **state) {
    int dim = *(int *)*state;
    planish_plan *plan;
    planish_quality quality;
    test_mesh box;
    test_bad_box(&box, dim, CELLS, 0);
    planish_options options = test_options(1);
    for (int64_t i = 0; i < box.mesh.n_nodes; i++)
        if (test_is_inside_box(box.coordinates + i * dim, dim, CELLS))
            box.coordinates[i * dim] += i % 7 ? 0 : 1.3;
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_measure(plan, box.coordinates, &quality, NULL), 0);
    double *ratio = malloc((size_t)box.mesh.n_elements * sizeof *ratio);
    assert_int_equal(planish_measure_elements(plan, box.coordinates, ratio, NULL), 0);
    int64_t none = 0;
    for (int64_t i = 0; i < box.mesh.n_elements; i++)
        none += ratio[i] == 0;
    assert_true(none > 0);
    assert_int_equal(none, quality.n_inverted);
    assert_int_equal(planish_measure_elements(NULL, box.coordinates, ratio, NULL),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_measure_elements(plan, NULL, ratio, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_measure_elements(plan, box.coordinates, NULL, NULL),
                     PLANISH_ERROR_ARGUMENT);
    planish_plan_destroy(plan);
    free(ratio);
    test_mesh_destroy(&box);
}

/** Three digits behind the point; how often it was asked. */
static double to_thousandths(double value, void *user) {
    __atomic_fetch_add((int64_t *)user, 1, __ATOMIC_RELAXED);
    return rint(value * 1000) / 1000;
}

static void coordinates_are_rounded_as_the_caller_says(void **state) {
    int dim = *(int *)*state;
    int64_t asked = 0;
    test_mesh mesh;
    test_run s, alone, bounded;
    test_bad_box(&mesh, dim, CELLS, 0);
    planish_options options = test_options(1);
    options.precision = PLANISH_PRECISION_ROUNDED;
    options.round = to_thousandths;
    options.round_user = &asked;
    s = test_smooth(&mesh.mesh, &options);
    for (int64_t i = 0; i < mesh.mesh.n_nodes * dim; i++)
        assert_true(s.coordinates[i] == mesh.coordinates[i] ||
                    s.coordinates[i] == to_thousandths(s.coordinates[i], &asked));
    assert_true(asked > 0 && s.result.n_moved_nodes > s.info.n_free / 2);
    assert_int_equal(s.after.n_inverted, 0);
    assert_true(s.after.rms_radius_ratio < s.before.rms_radius_ratio);
    options.threads = 1;
    alone = test_smooth(&mesh.mesh, &options);
    assert_memory_equal(alone.coordinates, s.coordinates,
                        (size_t)(mesh.mesh.n_nodes * dim) * sizeof *s.coordinates);
    /* Bounds between two such numbers: what is rounded to does not leave them. */
    for (int d = 0; d < dim; d++) {
        options.box_lower[d] = 0.9004;
        options.box_upper[d] = CELLS - 0.9004;
    }
    bounded = test_smooth(&mesh.mesh, &options);
    for (int64_t i = 0; i < mesh.mesh.n_nodes * dim; i++)
        assert_true(bounded.coordinates[i] == mesh.coordinates[i] ||
                    (bounded.coordinates[i] >= 0.9004 && bounded.coordinates[i] <= CELLS - 0.9004));
    assert_true(bounded.result.n_moved_nodes > 0);
    free(s.coordinates);
    free(alone.coordinates);
    free(bounded.coordinates);
    test_mesh_destroy(&mesh);
}

/** Two boxes whose sizes differ by a factor of 2^400, and a node of no element far away: each star
 * is seen in its own scale. */
static void sizes_do_not_disturb_one_another(void **state) {
    int dim = *(int *)*state;
    planish_options options = test_options(1);
    test_mesh large, both;
    test_run alone, s;
    test_bad_box(&large, dim, CELLS, 0);
    test_bad_box(&both, dim, CELLS, 0);
    test_mesh_transform(&both, ldexp(1, -400), 0);
    test_mesh_append(&both, &large, 0);
    options.max_sweeps = 5;
    alone = test_smooth(&large.mesh, &options);
    s = test_smooth(&both.mesh, &options);
    int64_t n = large.mesh.n_nodes * dim;
    for (int64_t i = 0; i < n; i++) /* the small one has the numbers, so the colours, of alone */
        assert_true(s.coordinates[i] == ldexp(alone.coordinates[i], -400));
    assert_int_equal(s.result.n_moved_nodes, 2 * alone.result.n_moved_nodes);
    free(alone.coordinates);
    free(s.coordinates);
    test_mesh_destroy(&large);
    test_mesh_destroy(&both);
}

/** Coordinates that are small multiples of the smallest double: what was judged is what is stored.
 */
static void subnormal_meshes_stay_valid(void **state) {
    int dim = *(int *)*state;
    planish_options options = test_options(1);
    for (unsigned seed = 0; seed < 30; seed++) {
        test_mesh mesh;
        test_run s;
        test_mesh_box(&mesh, dim, 4);
        test_mesh_perturb(&mesh, 0.14, seed);
        test_mesh_transform(&mesh, ldexp(1, -1070), 0);
        s = test_smooth(&mesh.mesh, &options);
        assert_int_equal(s.after.n_inverted, s.before.n_inverted);
        assert_int_equal(s.result.n_inverted, s.after.n_inverted);
        assert_true(s.after.max_radius_ratio <= s.before.max_radius_ratio);
        assert_true(s.after.rms_radius_ratio <= s.before.rms_radius_ratio);
        free(s.coordinates);
        test_mesh_destroy(&mesh);
    }
}

/** Boxes squeezed to 1e-9 of their height: radius ratios of 1e9 and more, whose rounding is seen.
 */
static void flat_meshes_keep_the_promises(void **state) {
    int dim = *(int *)*state;
    planish_options options = test_options(1);
    for (unsigned seed = 0; seed < 20; seed++) {
        test_mesh mesh;
        test_run s, again;
        options.search = (planish_search)(seed % 2);
        test_mesh_box(&mesh, dim, 4);
        test_mesh_perturb(&mesh, 0.14, seed);
        for (int64_t i = 0; i < mesh.mesh.n_nodes; i++) {
            double *x = mesh.coordinates + i * dim;
            x[dim - 1] = 0.3 * x[0] + 1e-9 * x[dim - 1]; /* oblique, so that coordinates round */
        }
        s = test_smooth(&mesh.mesh, &options);
        memcpy(mesh.coordinates, s.coordinates,
               (size_t)mesh.mesh.n_nodes * (size_t)dim * sizeof(double));
        again = test_smooth(&mesh.mesh, &options);
        assert_int_equal(s.after.n_inverted, s.before.n_inverted);
        assert_true(s.after.max_radius_ratio <= s.before.max_radius_ratio);
        assert_true(s.after.rms_radius_ratio <= s.before.rms_radius_ratio);
        assert_true(again.after.max_radius_ratio <= again.before.max_radius_ratio);
        assert_true(again.after.rms_radius_ratio <= again.before.rms_radius_ratio);
        free(s.coordinates);
        free(again.coordinates);
        test_mesh_destroy(&mesh);
    }
}

/* ---- what is left alone ------------------------------------------------------------------- */

/** A node pushed out of its star: without untangling its elements stay as they are, the others
 *  become better. */
static void inverted_stars_are_left_alone(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, CELLS, 0);
    int64_t middle = 0;
    for (int64_t i = 0; i < mesh.mesh.n_nodes; i++) {
        int central = 1;
        for (int d = 0; d < dim; d++)
            central &= fabs(mesh.coordinates[i * dim + d] - CELLS / 2) < 0.5;
        middle = central ? i : middle;
    }
    mesh.coordinates[middle * dim] += 1.6;
    planish_options options = test_options(1);
    options.untangle = 0;
    s = test_smooth(&mesh.mesh, &options);
    assert_true(s.before.n_inverted > 0);
    assert_int_equal(s.after.n_inverted, s.before.n_inverted);
    assert_int_equal(s.result.n_inverted, s.before.n_inverted);
    assert_memory_equal(s.coordinates + middle * dim, mesh.coordinates + middle * dim,
                        (size_t)dim * sizeof(double));
    assert_true(s.after.rms_radius_ratio < s.before.rms_radius_ratio);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

static void only_worse_stars_are_touched(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run all, some, none;
    test_bad_box(&mesh, dim, CELLS, 0);
    planish_options options = test_options(1);
    all = test_smooth(&mesh.mesh, &options);
    options.only_worse_than = all.before.max_radius_ratio * 0.8;
    some = test_smooth(&mesh.mesh, &options);
    options.only_worse_than = all.before.max_radius_ratio * 1.01;
    none = test_smooth(&mesh.mesh, &options);
    assert_true(some.result.n_moved_nodes > 0);
    assert_true(some.result.n_moved_nodes < all.result.n_moved_nodes);
    assert_int_equal(none.result.n_moved_nodes, 0);
    free(all.coordinates);
    free(some.coordinates);
    free(none.coordinates);
    test_mesh_destroy(&mesh);
}

static void without_free_nodes_nothing_happens(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_mesh_box(&mesh, dim, 1);
    planish_options options = test_options(1);
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.info.n_free, 0);
    assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
    assert_int_equal(s.result.visits, 0);
    assert_int_equal(s.after.n_fixed_elements, s.after.n_elements);
    assert_true(s.after.fixed_max_radius_ratio == s.after.max_radius_ratio);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/** What brings less than half of the tolerance sets off no visits: that costs less than all of it.
 */
static void calm_stars_are_left_alone(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run some, all;
    test_bad_box(&mesh, dim, CELLS, 0);
    planish_options options = test_options(1);
    some = test_smooth(&mesh.mesh, &options);
    const double tolerance = options.tolerance;
    options.tolerance = 0;
    options.max_sweeps = some.result.sweeps;
    all = test_smooth(&mesh.mesh, &options);
    assert_int_equal(some.result.stop, PLANISH_STOP_CONVERGED);
    assert_int_equal(all.result.sweeps, some.result.sweeps);
    assert_true((double)some.result.visits < 0.95 * (double)all.result.visits);
    assert_true(some.result.rms_movable < all.result.rms_movable * (1 + tolerance));
    free(some.coordinates);
    free(all.coordinates);
    test_mesh_destroy(&mesh);
}

/** Where nothing else moves a node goes to its very best place, not a step around it. */
static void a_node_alone_finds_its_place(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run once, again;
    test_mesh_box(&mesh, dim, 2);
    test_mesh_perturb(&mesh, 0.3, 1);
    planish_options options = test_options(1);
    once = test_smooth(&mesh.mesh, &options);
    assert_int_equal(once.info.n_free, 1);
    assert_int_equal(once.result.stop, PLANISH_STOP_CONVERGED);
    memcpy(mesh.coordinates, once.coordinates,
           (size_t)mesh.mesh.n_nodes * (size_t)dim * sizeof(double));
    options.tolerance = 0;
    again = test_smooth(&mesh.mesh, &options);
    assert_true(once.result.max_displacement > 0.01);
    assert_true(again.result.max_displacement < 1e-5 * once.result.max_displacement);
    free(once.coordinates);
    free(again.coordinates);
    test_mesh_destroy(&mesh);
}

/* ---- stopping ----------------------------------------------------------------------------- */

static int stop_at_third(const planish_progress *progress, void *user) {
    int *calls = user;
    (void)progress;
    return ++*calls == 3;
}

static void a_callback_stops_after_a_colour(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, CELLS, 0);
    int calls = 0;
    planish_options options = test_options(1);
    options.progress = stop_at_third;
    options.progress_user = &calls;
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.result.stop, PLANISH_STOP_INTERRUPTED);
    assert_true(s.result.n_moved_nodes > 0 && s.result.n_moved_nodes < s.info.n_free);
    assert_int_equal(s.after.n_inverted, 0);
    assert_true(s.after.rms_radius_ratio < s.before.rms_radius_ratio);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/** How many calls, and what the last one said. */
typedef struct calls {
    int n, sweep_done, colour;
} calls;

static int refuse_everything(const planish_progress *progress, void *user) {
    calls *c = user;
    c->n++;
    c->sweep_done = progress->sweep_done;
    c->colour = progress->colour;
    return 1;
}

/** The call that closes a sweep cut short says how far it came, and its answer changes nothing. */
static void the_last_call_tells_the_truth(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, CELLS, 0);
    calls c = {0, 0, 0};
    planish_options options = test_options(1);
    options.progress = refuse_everything;
    options.progress_user = &c;
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.result.stop, PLANISH_STOP_INTERRUPTED);
    assert_int_equal(c.n, 2);
    assert_true(c.sweep_done);
    assert_int_equal(c.colour, 1);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/** What the calls of a sweep said of its colours. */
typedef struct colour_counts {
    int64_t visits, first; /* so far in this sweep; of the first sweep's first colour */
    int calls;
} colour_counts;

static int count_colours(const planish_progress *progress, void *user) {
    colour_counts *c = user;
    if (progress->sweep_done) {
        assert_int_equal(progress->colour_visits, 0);
        assert_int_equal(progress->visits, c->visits);
        c->visits = 0;
        return 0;
    }
    c->visits += progress->colour_visits;
    c->first = c->calls++ == 0 ? progress->colour_visits : c->first;
    return 0;
}

static void colours_say_what_they_visit(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, CELLS, 0);
    colour_counts c = {0, 0, 0};
    planish_options options = test_options(1);
    options.progress = count_colours;
    options.progress_user = &c;
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(c.calls, s.result.sweeps * s.info.n_colours);
    assert_true(c.first > 0 && c.first < s.info.n_free);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

static void limits_stop(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, CELLS, 0);
    planish_options options = test_options(1);
    options.max_sweeps = 2;
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.result.stop, PLANISH_STOP_MAX_SWEEPS);
    assert_int_equal(s.result.sweeps, 2);
    free(s.coordinates);
    options.max_sweeps = 0;
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.result.n_moved_nodes, 0);
    free(s.coordinates);
    options.max_sweeps = 100;
    options.time_limit = 1e-9;
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.result.stop, PLANISH_STOP_TIME_LIMIT);
    assert_int_equal(s.result.sweeps, 1);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/* ---- a plan used again --------------------------------------------------------------------- */

static void a_plan_serves_many_coordinates(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    planish_plan *plan;
    planish_options options = test_options(1);
    test_bad_box(&mesh, dim, CELLS, 0);
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(planish_plan_create(&mesh.mesh, &options, &plan, NULL), 0);
    size_t size = (size_t)mesh.mesh.n_nodes * (size_t)dim * sizeof(double);
    double *copy = malloc(size);
    for (int i = 0; i < 3; i++) {
        memcpy(copy, mesh.coordinates, size);
        assert_int_equal(planish_smooth(plan, copy, &options, NULL, NULL), 0);
        assert_memory_equal(copy, s.coordinates, size);
    }
    planish_plan_destroy(plan);
    free(copy);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(the_mesh_becomes_better),
        BOTH(only_free_nodes_move),
        BOTH(bits_do_not_depend_on_threads_or_kernel),
        BOTH(powers_of_two_change_no_bit),
        BOTH(far_from_the_origin_it_works),
        BOTH(element_order_does_not_invert),
        cmocka_unit_test(ratios_are_one_or_more),
        BOTH(floats_stay_floats),
        BOTH(coordinates_are_rounded_as_the_caller_says),
        BOTH(ratios_of_inverted_elements_are_none),
        BOTH(sizes_do_not_disturb_one_another),
        BOTH(subnormal_meshes_stay_valid),
        BOTH(flat_meshes_keep_the_promises),
        BOTH(inverted_stars_are_left_alone),
        BOTH(only_worse_stars_are_touched),
        BOTH(calm_stars_are_left_alone),
        BOTH(a_node_alone_finds_its_place),
        BOTH(without_free_nodes_nothing_happens),
        BOTH(a_callback_stops_after_a_colour),
        BOTH(the_last_call_tells_the_truth),
        BOTH(colours_say_what_they_visit),
        BOTH(limits_stop),
        BOTH(a_plan_serves_many_coordinates),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
