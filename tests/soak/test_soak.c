/* Soak: the same call on one plan many times over, and many small meshes in many threads at once.
 *
 *     test_soak [TETRAHEDRA CALLS MESHES]
 *
 * Memory must stay what it was after the second call, and results the same. tools/reliability/soak
 * runs this for long.
 */
#define _GNU_SOURCE /* sysconf */
#include "support/effort.h"
#include "support/random_calls.h"

#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

enum { THREADS = 8, POINTS = 60 };

/** How much is done. */
static int64_t n_tetrahedra = 100000, n_calls = 10, n_meshes = 200;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define KEEPS_FREED_MEMORY 1 /* the sanitizers do, so that the process grows */
#else
#define KEEPS_FREED_MEMORY 0
#endif
/* What else the process may take between two calls: stacks, the C library's own. */
#define SLACK_PAGES 64

/* ---- one plan, the same call many times over ------------------------------------------------- */

/** Pages that the process has in memory; 0: the system does not say. */
static int64_t resident_pages(void) {
    long long size = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file)
        return 0;
    if (fscanf(file, "%lld %lld", &size, &resident) != 2)
        resident = 0;
    fclose(file);
    return resident;
}

/** A box of about so many tetrahedra, its inner nodes pushed. */
static void make_large(test_mesh *box, int64_t n) {
    test_mesh_box(box, 3, (int)fmax(2, round(cbrt((double)n / 6))));
    test_mesh_perturb(box, 0.14, 4321);
}

static void memory_and_results_stay(void **state) {
    (void)state;
    enum { SETTLED = 2 }; /* calls until all has been allocated that ever is */
    test_mesh box;
    planish_plan *plan;
    planish_options options;
    planish_result result;
    planish_plan_info info;
    int64_t pages = 0, bytes = 0;
    uint64_t checksum = 0;
    make_large(&box, n_tetrahedra);
    const size_t size = (size_t)(box.mesh.n_nodes * 3) * sizeof(double);
    double *x = malloc(size);
    assert_non_null(x);
    planish_mesh moved = box.mesh;
    moved.coordinates = x;
    planish_options_init(&options);
    options.max_sweeps = 1;
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    for (int64_t call = 1; call <= n_calls; call++) {
        memcpy(x, box.coordinates, size);
        assert_int_equal(planish_smooth(plan, x, &options, &result, NULL), 0);
        planish_plan_get_info(plan, &info);
        if (call == SETTLED) {
            pages = resident_pages();
            bytes = info.bytes;
            checksum = planish_checksum(&moved);
            assert_true(result.n_moved_nodes > 0);
        }
        if (call > SETTLED) {
            assert_true(planish_checksum(&moved) == checksum);
            assert_true(info.bytes == bytes);
        }
    }
    const int64_t more = resident_pages() - pages;
    figure("%lld tetrahedra, %lld calls: resident %.1f MB after call %d, %+lld pages after the "
           "last; the plan has %.1f MB; checksum %016llx",
           (long long)box.mesh.n_elements, (long long)n_calls,
           (double)pages * (double)sysconf(_SC_PAGESIZE) * 1e-6, SETTLED, (long long)more,
           (double)bytes * 1e-6, (unsigned long long)checksum);
    assert_true(KEEPS_FREED_MEMORY || (more <= SLACK_PAGES && more >= -SLACK_PAGES));
    planish_plan_destroy(plan);
    test_mesh_destroy(&box);
    free(x);
}

/* ---- many small meshes at once --------------------------------------------------------------- */

/** The meshes, which threads take one by one, and what became of them. */
typedef struct crowd {
    pairs choices;
    int64_t next, n, different; /* shared */
    uint64_t *checksum;         /* [n] */
    int is_first;               /* they are noted, else compared */
} crowd;

/** Smooth mesh number i, made for the occasion; a number for what became of it. */
static uint64_t smooth_one(const crowd *c, int64_t i) {
    uint64_t seed = effort_seed((uint64_t)i);
    int level[N_FACTORS];
    random_call call;
    planish_plan *plan = NULL;
    planish_result result = {.sweeps = -1};
    pairs_draw(&c->choices, &seed, level);
    level[OF_ISA] = PLANISH_ISA_AUTO;
    level[OF_TIME_LIMIT] = 0; /* what happens is then a matter of luck */
    level[OF_TANGLE] = RANDOM_VALID;
    if (level[OF_SHAPE] == RANDOM_GARBAGE)
        level[OF_SHAPE] = RANDOM_DELAUNAY;
    random_call_create(&call, level, random_call_points(level, POINTS, &seed), &seed);
    call.heap.failing = -1;
    call.watch.stop_at = -1; /* long phases ask by the clock, so that is luck, too */
    int status = planish_plan_create(&call.given, &call.plan_options, &plan, NULL);
    call.watch.plan = plan;
    if (!status)
        status = planish_smooth(plan, call.coordinates, &call.options, &result, NULL);
    planish_mesh moved = call.given;
    moved.coordinates = call.coordinates;
    const uint64_t checksum =
        planish_checksum(&moved) ^ (uint64_t)status << 32 ^ (uint64_t)result.sweeps;
    planish_plan_destroy(plan);
    random_call_destroy(&call);
    return checksum;
}

static void *work(void *data) {
    crowd *c = data;
    for (;;) {
        const int64_t i = __atomic_fetch_add(&c->next, 1, __ATOMIC_RELAXED);
        if (i >= c->n)
            return NULL;
        const uint64_t checksum = smooth_one(c, i);
        if (c->is_first)
            c->checksum[i] = checksum;
        else if (c->checksum[i] != checksum)
            __atomic_fetch_add(&c->different, 1, __ATOMIC_RELAXED);
    }
}

static void run_threads(void *(*body)(void *), void *data) {
    pthread_t thread[THREADS];
    for (int i = 0; i < THREADS; i++)
        assert_int_equal(pthread_create(&thread[i], NULL, body, data), 0);
    for (int i = 0; i < THREADS; i++)
        pthread_join(thread[i], NULL);
}

static void meshes_at_once_are_as_alone(void **state) {
    (void)state;
    crowd c = {.choices = {.n_factors = N_FACTORS, .factor = random_factors}, .n = n_meshes};
    c.checksum = calloc((size_t)n_meshes, sizeof *c.checksum);
    assert_non_null(c.checksum);
    c.is_first = 1;
    work(&c);
    c.is_first = 0;
    c.next = 0;
    run_threads(work, &c);
    figure("%lld small meshes in %d threads at once: %lld other than alone", (long long)n_meshes,
           THREADS, (long long)c.different);
    assert_int_equal(c.different, 0);
    free(c.checksum);
}

/* ---- one mesh, many plans of it at once --------------------------------------------------------
 */

/** What threads share is read only: a plan serves one thread at a time, a mesh any number. */
typedef struct shared {
    test_mesh box;
    uint64_t checksum; /* of the mesh smoothed alone */
    int64_t different; /* shared */
} shared;

static uint64_t smooth_shared(const shared *s) {
    planish_plan *plan;
    planish_mesh moved = s->box.mesh;
    planish_options options;
    planish_options_init(&options);
    options.threads = 2;
    const size_t size = (size_t)(moved.n_nodes * 3) * sizeof(double);
    double *x = malloc(size);
    uint64_t checksum = 0;
    if (x && planish_plan_create(&s->box.mesh, &options, &plan, NULL) == 0) {
        memcpy(x, s->box.coordinates, size);
        moved.coordinates = x;
        if (planish_smooth(plan, x, &options, NULL, NULL) == 0)
            checksum = planish_checksum(&moved);
        planish_plan_destroy(plan);
    }
    free(x);
    return checksum;
}

static void *work_on_shared(void *data) {
    shared *s = data;
    enum { TIMES = 3 };
    for (int i = 0; i < TIMES; i++)
        if (smooth_shared(s) != s->checksum)
            __atomic_fetch_add(&s->different, 1, __ATOMIC_RELAXED);
    return NULL;
}

static void plans_of_one_mesh_do_not_meet(void **state) {
    (void)state;
    shared s = {.different = 0};
    make_large(&s.box, 6 * 8 * 8 * 8);
    s.checksum = smooth_shared(&s);
    assert_true(s.checksum != 0);
    run_threads(work_on_shared, &s);
    assert_int_equal(s.different, 0);
    test_mesh_destroy(&s.box);
}

int main(int argc, char **argv) {
    if (argc == 4) {
        n_tetrahedra = strtoll(argv[1], NULL, 10);
        n_calls = strtoll(argv[2], NULL, 10);
        n_meshes = strtoll(argv[3], NULL, 10);
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_and_results_stay),
        cmocka_unit_test(meshes_at_once_are_as_alone),
        cmocka_unit_test(plans_of_one_mesh_do_not_meet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
