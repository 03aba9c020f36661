/* Valid in, valid out: random meshes, each smoothed with options, plan and callbacks drawn at
 * random from all there are, and every promise of planish.h measured afterwards.
 *
 * PLANISH_CASE=NUMBER does one case alone, and says what it is. Cases are the same whatever ran
 * before them.
 */
#include "support/delaunay.h"
#include "support/effort.h"
#include "support/promises.h"
#include "support/run.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { POINTS = 100, DESCRIPTION = 2000 };

/** What the cases came to. */
typedef struct tally {
    pairs seen;
    int64_t broken, refused, without_memory, smoothed, calls, elements, moved, stopped;
} tally;

typedef struct trial {
    int64_t number;
    random_call call;
    planish_plan *plan;
    promise promise;
    double *start, *before, *after; /* [n_nodes][dim] */
    tally *sums;
} trial;

/** Print what is wrong, and go on. */
static void complain(const trial *t, const char *what) {
    char text[DESCRIPTION];
    random_call_describe(&t->call, text, sizeof text);
    print_error("PLANISH_CASE=%lld: %s\n    %s\n", (long long)t->number, what, text);
    t->sums->broken++;
}

static void expect(const trial *t, int holds, const char *what) {
    if (!holds)
        complain(t, what);
}

static int is_allowed(int a, int level_a, int b, int level_b) {
    if ((a == OF_ISA && !test_has_isa(level_a)) || (b == OF_ISA && !test_has_isa(level_b)))
        return 0;
    return random_levels_allowed(a, level_a, b, level_b);
}

/* ---- a case -------------------------------------------------------------------------------- */

/** Whether the call failed in a way that is one of those written down; it then changed nothing. */
static int has_failed(const trial *t, int status, const planish_error *error) {
    const int refusal = promise_refusal(&t->call);
    if (status == PLANISH_OK) {
        expect(t, refusal < 1, "options that exclude each other were taken");
        return 0;
    }
    expect(t, error->code == status && error->text[0] != '\0', "an error that says nothing");
    if (status == PLANISH_ERROR_MEMORY && t->call.heap.failing >= 0) {
        t->sums->without_memory++;
        return 1;
    }
    if (status != PLANISH_ERROR_ARGUMENT || refusal == 0)
        complain(t, error->text);
    t->sums->refused++;
    return 1;
}

/** Smooth once more from where the mesh is; 0 if that was refused. */
static int smooth(trial *t, const planish_options *options) {
    planish_result result = {.sweeps = -1};
    planish_error error = {.text = ""};
    random_call_get(&t->call, t->before);
    random_call_rewind(&t->call);
    const int status = planish_smooth(t->plan, t->call.coordinates, options, &result, &error);
    random_call_get(&t->call, t->after);
    expect(t, random_call_is_untouched(&t->call), "the caller's arrays were written to");
    if (has_failed(t, status, &error)) {
        const size_t size = (size_t)(t->call.dense.n_nodes * t->call.dense.dim) * sizeof(double);
        expect(t, memcmp(t->before, t->after, size) == 0, "an error moved nodes");
        expect(t, result.sweeps == -1, "an error wrote a result");
        return 0;
    }
    const char *broken = promise_broken(&t->promise, options, t->before, t->after, &result);
    if (broken)
        complain(t, broken);
    t->sums->calls++;
    t->sums->moved += result.n_moved_nodes;
    t->sums->stopped += result.stop == PLANISH_STOP_INTERRUPTED;
    return 1;
}

/** As drawn, once more, and with defaults. */
static void smooth_thrice(trial *t, uint64_t *state) {
    planish_options defaults;
    planish_options_init(&defaults);
    promise_create(&t->promise, &t->call, t->plan, t->start);
    if (t->promise.text[0])
        complain(t, t->promise.text);
    if (smooth(t, &t->call.options)) {
        pairs_note(&t->sums->seen, t->call.level);
        t->sums->smoothed++;
        t->sums->elements += t->call.dense.n_elements;
        smooth(t, &t->call.options);
        if (random_below(state, 4) == 0) {
            t->call.heap.failing = -1;
            smooth(t, &defaults);
        }
    }
    promise_destroy(&t->promise);
}

/** Room for coordinates, and those that the call starts from. */
static void make_room(trial *t) {
    const size_t values = (size_t)(t->call.dense.n_nodes * t->call.dense.dim) + 1;
    t->start = calloc(3 * values, sizeof *t->start);
    assert_non_null(t->start);
    t->before = t->start + values;
    t->after = t->before + values;
    random_call_get(&t->call, t->start);
}

static void run_case(int64_t number, tally *sums) {
    uint64_t state = effort_seed((uint64_t)number);
    int level[N_FACTORS];
    planish_error error = {.text = ""};
    trial t = {.number = number, .sums = sums};
    pairs_draw(&sums->seen, &state, level);
    if (!test_has_isa(level[OF_ISA]))
        level[OF_ISA] = PLANISH_ISA_AUTO;
    random_call_create(&t.call, level, random_call_points(level, POINTS, &state), &state);
    make_room(&t);
    const int status = planish_plan_create(&t.call.given, &t.call.plan_options, &t.plan, &error);
    if (status) {
        has_failed(&t, status, &error);
    } else {
        t.call.watch.plan = t.plan;
        if (level[OF_PROGRESS] == PROGRESS_MEASURE)
            t.call.watch.coordinates = t.call.given.coordinates;
        smooth_thrice(&t, &state);
    }
    planish_plan_destroy(t.plan);
    expect(&t, t.call.heap.live == 0, "memory was not given back");
    expect(&t, random_call_is_untouched(&t.call), "the caller's arrays were written to");
    random_call_destroy(&t.call);
    free(t.start);
}

/* ---- the same bits --------------------------------------------------------------------------- */

/** A call whose end is no matter of luck or patience. */
static void make_repeatable(random_call *call) {
    enum { ENOUGH = 400 }; /* calls of progress */
    call->options.time_limit = call->plan_options.time_limit = 0;
    call->heap.failing = -1;
    call->options.progress = random_call_progress;
    if (call->watch.stop_at < 0)
        call->watch.stop_at = ENOUGH;
}

/** Smooth with so many threads and this kernel. */
static void repeat(trial *t, int threads, planish_isa isa, planish_result *result) {
    random_call *call = &t->call;
    planish_options of_plan = call->plan_options;
    planish_error error = {.text = ""};
    of_plan.threads = threads;
    of_plan.isa = isa;
    random_call_put(call, t->start);
    random_call_rewind(call);
    *result = (planish_result){.sweeps = -1};
    int status = planish_plan_create(&call->given, &of_plan, &t->plan, &error);
    if (!status)
        status = planish_smooth(t->plan, call->coordinates, &call->options, result, &error);
    expect(t, !status || promise_refusal(call) != 0, error.text);
    result->seconds = 0;
    planish_plan_destroy(t->plan);
    t->plan = NULL;
}

static void expect_same(trial *t, const planish_result *first, const planish_result *other) {
    const size_t size = (size_t)(t->call.dense.n_nodes * t->call.dense.dim) * sizeof(double);
    random_call_get(&t->call, t->after);
    expect(t, memcmp(t->before, t->after, size) == 0, "other bits");
    expect(t, memcmp(first, other, sizeof *first) == 0, "the same bits, but another result");
}

static void repeat_case(int64_t number, tally *sums) {
    static const int threads[] = {1, 2, 3, 5, 8};
    enum { THREADS = 5, LARGE_EVERY = 4, LARGE = 2000 }; /* several chunks for each colour */
    const int64_t repetitions = effort(5, 20);
    uint64_t state = effort_seed((uint64_t)number + (UINT64_C(1) << 32));
    int level[N_FACTORS];
    planish_result first, other;
    trial t = {.number = number, .sums = sums};
    pairs_draw(&sums->seen, &state, level);
    const int is_large = number % LARGE_EVERY == LARGE_EVERY - 1;
    if (is_large) {
        level[OF_SHAPE] = RANDOM_BOX;
        level[OF_TANGLE] = RANDOM_VALID;
    }
    const int n_points = is_large ? LARGE : random_call_points(level, POINTS, &state);
    random_call_create(&t.call, level, n_points, &state);
    make_repeatable(&t.call);
    make_room(&t);
    repeat(&t, 1, PLANISH_ISA_AUTO, &first);
    random_call_get(&t.call, t.before);
    sums->moved += first.n_moved_nodes;
    for (int i = 1; i < THREADS + repetitions; i++) {
        const int isa = (int)random_below(&state, PLANISH_ISA_AVX512 + 1);
        repeat(&t, i < THREADS ? threads[i] : 3,
               test_has_isa(isa) ? (planish_isa)isa : PLANISH_ISA_AUTO, &other);
        expect_same(&t, &first, &other);
    }
    random_call_destroy(&t.call);
    free(t.start);
}

/* ---- the tests ----------------------------------------------------------------------------- */

/** Do n cases, or the one that is asked for. */
static void do_cases(void (*body)(int64_t, tally *), int64_t n, tally *sums) {
    const char *one = getenv("PLANISH_CASE");
    sums->seen = (pairs){.n_factors = N_FACTORS, .factor = random_factors};
    if (one)
        body(strtoll(one, NULL, 10), sums);
    for (int64_t i = 0; !one && i < n; i++)
        body(i, sums);
}

static void promises_are_kept(void **state) {
    static tally sums;
    const int64_t n = effort(200, 100000);
    int64_t missing;
    (void)state;
    do_cases(run_case, n, &sums);
    const int64_t all =
        pairs_count(&sums.seen, is_allowed, getenv("PLANISH_LONG") != NULL, &missing);
    figure("%lld meshes, %lld smoothed, of %lld elements on average: %lld calls, %lld nodes moved",
           (long long)n, (long long)sums.smoothed, (long long)(sums.elements / (sums.smoothed + 1)),
           (long long)sums.calls, (long long)sums.moved);
    figure("%lld refused, %lld without memory, %lld calls stopped", (long long)sums.refused,
           (long long)sums.without_memory, (long long)sums.stopped);
    figure("%lld of %lld pairs of levels of %d factors occurred", (long long)(all - missing),
           (long long)all, N_FACTORS);
    assert_int_equal(sums.broken, 0);
    if (getenv("PLANISH_LONG") && !getenv("PLANISH_CASE"))
        assert_int_equal(missing, 0);
}

static void bits_are_the_same(void **state) {
    static tally sums;
    const int64_t n = effort(10, 1000);
    (void)state;
    do_cases(repeat_case, n, &sums);
    figure("%lld meshes, %lld nodes moved: the same bits with 1, 2, 3, 5 and 8 threads and in %lld "
           "repetitions",
           (long long)n, (long long)sums.moved, (long long)effort(5, 20));
    assert_int_equal(sums.broken, 0);
}

/** What the cases are made of: the meshes are Delaunay, and fill the box. */
static void delaunay_meshes_are_such(void **state) {
    (void)state;
    uint64_t bits = effort_seed(0);
    for (int dim = 2; dim <= 3; dim++) {
        delaunay d;
        test_mesh mesh;
        planish_quality quality;
        delaunay_begin(&d, dim);
        for (int i = 0; i < 80; i++) {
            int32_t point[3];
            for (int k = 0; k < 3; k++) /* every fourth on a lattice */
                point[k] =
                    (int32_t)random_below(&bits, i % 4 ? DELAUNAY_GRID : 4) * (i % 4 ? 1 : 256);
            delaunay_insert(&d, point);
        }
        for (int64_t i = 0; i < d.n_elements; i++)
            for (int32_t k = 0; k < d.n_points; k++)
                assert_true(delaunay_depth(&d, i, d.point + 3 * k) <= 0);
        delaunay_take(&d, &mesh);
        assert_int_equal(planish_measure_mesh(&mesh.mesh, NULL, &quality, NULL), 0);
        assert_int_equal(quality.n_inverted, 0);
        assert_true(quality.total_volume > 1 - 1e-12 && quality.total_volume < 1 + 1e-12);
        test_mesh_destroy(&mesh);
        delaunay_end(&d);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(delaunay_meshes_are_such),
        cmocka_unit_test(promises_are_kept),
        cmocka_unit_test(bits_are_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
