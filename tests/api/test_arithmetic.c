/* Callers that round upwards, flush subnormals to zero, trap what is inexact: the bits are those of
 * the usual arithmetic, and the caller finds his own again, on each of the threads. */
#include "support/arithmetic.h"
#include "support/effort.h"
#include "support/problems.h"

#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { THREADS = 2 };

/** Whose threads work. */
typedef enum team { CALLER, OPENMP, POOL, TEAMS } team;

static int same_state(const test_arithmetic_state *a, const test_arithmetic_state *b) {
    return memcmp(a, b, sizeof *a) == 0;
}

/* ---- a pool of the caller's -------------------------------------------------------------------
 */

typedef struct pool {
    const test_arithmetic *arithmetic; /* of its threads, and of the one that calls planish */
    _Atomic int changed;               /* threads that found another one after a task, */
    _Atomic int unusual;               /* and calls that were not in the usual one */
} pool;

typedef struct job {
    pool *of;
    planish_task_fn *task;
    void *data;
    int index;
} job;

static void *run_job(void *a_job) {
    job *j = a_job;
    j->of->arithmetic->set();
    const test_arithmetic_state before = test_arithmetic_now();
    j->task(j->data, j->index);
    const test_arithmetic_state after = test_arithmetic_now();
    j->of->changed += !same_state(&before, &after);
    return NULL;
}

static void pool_run(int n_tasks, planish_task_fn *task, void *data, void *user) {
    pool *p = user;
    pthread_t thread[THREADS];
    job jobs[THREADS];
    p->unusual += !test_arithmetic_is_usual();
    for (int i = 0; i < n_tasks; i++) {
        jobs[i] = (job){p, task, data, i};
        if (pthread_create(&thread[i], NULL, run_job, &jobs[i]))
            abort();
    }
    for (int i = 0; i < n_tasks; i++)
        pthread_join(thread[i], NULL);
}

static int watch(const planish_progress *progress, void *user) {
    pool *p = user;
    (void)progress;
    p->unusual += !test_arithmetic_is_usual();
    return 0;
}

static pool
    *watched; /* what planish_plan_destroy releases is seen, too, after its options are gone */

static void *take(size_t bytes, void *user) {
    (void)user;
    watched->unusual += !test_arithmetic_is_usual();
    return malloc(bytes);
}

static void give(void *block, void *user) {
    (void)user;
    watched->unusual += !test_arithmetic_is_usual();
    free(block);
}

/* ---- the same bits ----------------------------------------------------------------------------
 */

/** Everything but the time that it took. */
static void expect_same(const test_problem *p, test_outcome *a, test_outcome *b) {
    const size_t m = (size_t)p->mesh.n_elements * sizeof(double);
    const size_t n = (size_t)(p->mesh.n_nodes * p->mesh.dim) * sizeof(double);
    a->result.seconds = b->result.seconds = 0;
    assert_memory_equal(a->coordinates, b->coordinates, n);
    assert_memory_equal(a->ratio_before, b->ratio_before, m);
    assert_memory_equal(a->ratio, b->ratio, m);
    assert_memory_equal(&a->before, &b->before, sizeof a->before);
    assert_memory_equal(&a->after, &b->after, sizeof a->after);
    assert_memory_equal(&a->result, &b->result, sizeof a->result);
    assert_int_equal(a->unfixable, b->unfixable);
    assert_int_equal(a->below, b->below);
}

/** Give OpenMP's threads an arithmetic, or see whether they have it still. */
static void set_on_all(const test_arithmetic *arithmetic) {
#ifdef _OPENMP
#pragma omp parallel num_threads(THREADS)
#endif
    {
        test_arithmetic_reset();
        arithmetic->set();
    }
}

static int is_changed_on_any(const test_arithmetic_state *expected) {
    _Atomic int changed = 0;
#ifdef _OPENMP
#pragma omp parallel num_threads(THREADS)
#endif
    {
        const test_arithmetic_state now = test_arithmetic_now();
        changed += !same_state(&now, expected);
    }
    return changed;
}

static void reset_on_all(void) {
    static const test_arithmetic usual = {"usual", test_arithmetic_reset};
    set_on_all(&usual);
}

/** Solve p with what this team has for threads while their arithmetic is this one. */
static void solve_with(test_problem *p, const test_arithmetic *arithmetic, team t,
                       test_outcome *usual) {
    pool own = {.arithmetic = arithmetic};
    planish_options *options = &p->options;
    options->threads = t == CALLER ? 1 : THREADS;
    options->parallel = t == POOL ? pool_run : NULL;
    options->parallel_user = options->progress_user = &own;
    options->progress = watch;
    static const planish_allocator allocator = {.allocate = take, .release = give};
    options->allocator = &allocator;
    watched = &own;
    set_on_all(arithmetic);
    const test_arithmetic_state before = test_arithmetic_now();
    test_outcome o = test_problem_solve(p);
    const int changed = is_changed_on_any(&before);
    reset_on_all();
    if (changed || own.changed || own.unusual)
        fail_msg("%s: changed on %d threads, of the pool %d; %d calls saw it", arithmetic->name,
                 changed, own.changed, own.unusual);
    options->allocator = NULL;
    expect_same(p, usual, &o);
    test_outcome_destroy(&o);
}

/** With the threads of all teams in the long form, in the short one with those of others in turn.
 */
static void solve_in_all(test_wish wish, int dim, int exponent) {
    test_problem p;
    test_problem_create(&p, dim, dim == 3 ? 3 : 5, wish, 5);
    test_problem_scale(&p, exponent);
    test_arithmetic_reset();
    test_outcome usual = test_problem_solve(&p);
    assert_true(exponent || usual.result.n_moved_nodes > 0);
    int turn = (int)wish;
    for (const test_arithmetic *a = test_arithmetics; a->name; a++, turn++)
        for (int t = 0; t < TEAMS; t++)
            if (t == turn % 5 || (t == CALLER && turn % 5 >= TEAMS) || effort(0, 1))
                solve_with(&p, a, (team)t, &usual);
    test_outcome_destroy(&usual);
    test_problem_destroy(&p);
}

/** In the size of 1, and so small that coordinates are subnormal. */
static void bits_do_not_depend_on_the_callers(void **state) {
    const int dim = *(int *)*state;
    for (int wish = 0; wish < WISHES; wish++)
        if (wish != WISH_HOPELESS || effort(0, 1)) /* which takes hundreds of sweeps */
            solve_in_all((test_wish)wish, dim, 0);
    solve_in_all(WISH_PLAIN, dim, -1045);
    solve_in_all(WISH_EDGE_RATIO, dim, -1030);
}

/* ---- calls without a plan ---------------------------------------------------------------------
 */

typedef struct findings {
    uint8_t constraint[1000], is_layer[4000];
    double direction[3000];
    planish_quality quality;
    planish_slide_info slides;
    int64_t n_layer;
    int refused;
} findings;

/** What the calls without a plan find; one is refused, for a number that is none. */
static void find(const test_problem *p, int threads, findings *f) {
    planish_options options = p->options;
    memset(f, 0, sizeof *f);
    options.threads = threads;
    planish_find_slides(&p->mesh, NULL, threads, f->constraint, f->direction, &f->slides, NULL);
    planish_find_layers(&p->mesh, threads, f->is_layer, &f->n_layer, NULL);
    planish_measure_mesh(&p->mesh, &options, &f->quality, NULL);
    options.tolerance = (double)NAN;
    f->refused = planish_measure_mesh(&p->mesh, &options, &f->quality, NULL);
}

static void calls_without_a_plan(void **state) {
    const int dim = *(int *)*state;
    test_problem p;
    findings usual, other;
    test_problem_create(&p, dim, dim == 3 ? 6 : 20, WISH_PLAIN, 5);
    for (int64_t i = 0; i < p.mesh.n_nodes; i++) /* thin below: layers */
        p.coordinates[i * dim] *= p.coordinates[i * dim] < 4 ? 0.01 : 1;
    find(&p, 1, &usual);
    assert_int_equal(usual.refused, PLANISH_ERROR_ARGUMENT);
    assert_true(usual.n_layer > 0 && usual.slides.n_on_plane + usual.slides.n_on_line > 0);
    for (const test_arithmetic *a = test_arithmetics; a->name; a++)
        for (int threads = 1; threads <= THREADS; threads++) {
            set_on_all(a);
            const test_arithmetic_state before = test_arithmetic_now();
            find(&p, threads, &other);
            const int changed = is_changed_on_any(&before);
            reset_on_all();
            if (changed)
                fail_msg("%s: changed on %d threads", a->name, changed);
            assert_memory_equal(&usual, &other, sizeof usual);
        }
    test_problem_destroy(&p);
}

/** The test is worth something: each of the arithmetics but that of flags and traps computes
 *  otherwise, and each differs from the usual one. */
static void they_are_others(void **state) {
    (void)state;
    const test_arithmetic_state usual = test_arithmetic_now();
    for (const test_arithmetic *a = test_arithmetics; a->name; a++) {
        a->set();
        const test_arithmetic_state now = test_arithmetic_now();
        test_arithmetic_reset();
        if (strcmp(a->name, "traps") != 0 || test_arithmetic_can_trap())
            assert_false(same_state(&usual, &now));
    }
}

int main(void) {
    static int two = 2, three = 3;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(they_are_others),
        {"bits 2-D", bits_do_not_depend_on_the_callers, NULL, NULL, &two},
        {"bits 3-D", bits_do_not_depend_on_the_callers, NULL, NULL, &three},
        {"without a plan 2-D", calls_without_a_plan, NULL, NULL, &two},
        {"without a plan 3-D", calls_without_a_plan, NULL, NULL, &three},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
