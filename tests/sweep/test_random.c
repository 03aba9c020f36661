/* Valid in, valid out: random meshes, each smoothed with options, plan and callbacks drawn at
 * random from all there are, and every promise of planish.h measured afterwards.
 *
 * PLANISH_CASE=NUMBER does one case alone, and says what it is. Cases are the same whatever ran
 * before them.
 */
#include "support/effort.h"
#include "support/promises.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

enum { POINTS = 120, DESCRIPTION = 2000 };

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

/* ---- kernels that this machine lacks ------------------------------------------------------- */

static int has_isa(int isa) {
    static const double x[] = {0, 0, 1, 0, 0, 1};
    static const int32_t nodes[] = {0, 1, 2};
    const planish_mesh mesh = {
        .dim = 2, .n_nodes = 3, .n_elements = 1, .coordinates = x, .elements = nodes};
    planish_options options;
    planish_plan *plan;
    planish_options_init(&options);
    options.isa = (planish_isa)isa;
    if (planish_plan_create(&mesh, &options, &plan, NULL))
        return 0;
    planish_plan_destroy(plan);
    return 1;
}

static int is_allowed(int a, int level_a, int b, int level_b) {
    if ((a == OF_ISA && !has_isa(level_a)) || (b == OF_ISA && !has_isa(level_b)))
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
    t->sums->moved += result.moved_nodes;
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

static void run_case(int64_t number, tally *sums) {
    uint64_t state = effort_seed((uint64_t)number);
    int level[N_FACTORS];
    planish_error error = {.text = ""};
    trial t = {.number = number, .sums = sums};
    pairs_draw(&sums->seen, &state, level);
    if (!has_isa(level[OF_ISA]))
        level[OF_ISA] = PLANISH_ISA_AUTO;
    random_call_create(&t.call, level, POINTS, &state);
    const size_t values = (size_t)(t.call.dense.n_nodes * t.call.dense.dim) + 1;
    t.start = calloc(3 * values, sizeof *t.start);
    t.before = t.start + values;
    t.after = t.before + values;
    random_call_get(&t.call, t.start);
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

/* ---- the tests ----------------------------------------------------------------------------- */

static void promises_are_kept(void **state) {
    static tally sums = {.seen = {.n_factors = N_FACTORS, .factor = random_factors}};
    const char *one = getenv("PLANISH_CASE");
    const int64_t n = getenv("N") ? atoi(getenv("N")) : effort(300, 100000);
    int64_t missing;
    (void)state;
    for (int64_t i = one ? strtoll(one, NULL, 10) : 0; i < n; i++) {
        const clock_t begin = clock();
        run_case(i, &sums);
        const double seconds = (double)(clock() - begin) / CLOCKS_PER_SEC;
        if (seconds > 1 || one)
            printf("case %lld: %g s\n", (long long)i, seconds);
        if (one)
            break;
    }
    const int64_t all = pairs_count(&sums.seen, is_allowed, 0, &missing);
    figure("%lld meshes, %lld smoothed of %lld elements on average, %lld calls, %lld nodes moved",
           (long long)n, (long long)sums.smoothed, (long long)(sums.elements / (sums.smoothed + 1)),
           (long long)sums.calls, (long long)sums.moved);
    figure("%lld refused, %lld without memory, %lld stopped", (long long)sums.refused,
           (long long)sums.without_memory, (long long)sums.stopped);
    figure("%lld of %lld pairs of levels occurred", (long long)(all - missing), (long long)all);
    assert_int_equal(sums.broken, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(promises_are_kept)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
