/* Soak: the same call on one plan many times over, a mesh that moves for long, and many small meshes in many
 * threads at once.
 *
 *     test_soak [TETRAHEDRA CALLS MESHES STEPS]        CALLS: 3 or more, STEPS: 200 or more
 *
 * Memory must stay what it was after the second call, and results the same. tools/reliability/soak
 * runs this for long.
 */
#define _GNU_SOURCE /* sysconf */
#include "support/effort.h"
#include "support/large_meshes.h"
#include "support/random_calls.h"
#include "support/random_cells.h"

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
/* Calls until all has been allocated that ever is; steps after which the box that moves is as it was. */
enum { SETTLED = 2, PERIOD = 100 };

/** How much is done; of other elements there are fewer than tetrahedra. */
static int64_t n_tetrahedra = 100000, n_calls = 10, n_meshes = 200, n_steps = 200;

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

/** What the process and the plan have, and the mesh they have made. */
typedef struct footprint {
    int64_t pages, bytes;
    uint64_t checksum;
} footprint;

static footprint footprint_of(const planish_plan *plan, const planish_mesh *mesh, const double *x) {
    planish_plan_info info;
    planish_mesh moved = *mesh;
    moved.coordinates = x;
    planish_plan_get_info(plan, &info);
    return (footprint){resident_pages(), info.bytes, planish_checksum(&moved)};
}

static void expect_no_growth(int64_t pages, const footprint *before, const footprint *after) {
    const int64_t more = after->pages - before->pages;
    assert_true(after->bytes == before->bytes);
    assert_true(KEEPS_FREED_MEMORY || (more <= pages && more >= -pages));
}

/** Smooth a mesh of a kind by one sweep, again and again from the same start. */
static void repeat(large_kind kind, const char *name, int64_t n_elements) {
    large_mesh *m = large_mesh_create(kind, n_elements);
    const size_t size = (size_t)(m->mesh.n_nodes * 3) * sizeof(double);
    double *x = malloc(size);
    planish_plan *plan;
    planish_options options;
    planish_result result;
    footprint first = {0}, now = {0};
    uint64_t checksum = 0; /* of the first call */
    assert_non_null(x);
    planish_options_init(&options);
    options.max_sweeps = 1;
    options.shape = m->shape;
    assert_int_equal(planish_plan_create(&m->mesh, &options, &plan, NULL), 0);
    for (int64_t call = 1; call <= n_calls; call++) {
        memcpy(x, m->x, size);
        assert_int_equal(planish_smooth(plan, x, &options, &result, NULL), 0);
        assert_true(result.n_moved_nodes > 0 && result.n_inverted == 0);
        now = footprint_of(plan, &m->mesh, x);
        if (call == SETTLED)
            first = now;
        checksum = call == 1 ? now.checksum : checksum;
        assert_true(now.checksum == checksum);
    }
    figure("%lld %s, %lld calls: resident %.1f MB after call %d, %+lld pages after the last; the "
           "plan has "
           "%.1f MB; checksum %016llx",
           (long long)m->mesh.n_elements, name, (long long)n_calls,
           (double)first.pages * (double)sysconf(_SC_PAGESIZE) * 1e-6, SETTLED,
           (long long)(now.pages - first.pages), (double)first.bytes * 1e-6,
           (unsigned long long)first.checksum);
    expect_no_growth(SLACK_PAGES, &first, &now);
    planish_plan_destroy(plan);
    large_mesh_destroy(m);
    free(x);
}

static void memory_and_results_stay(void **state) {
    (void)state;
    repeat(LARGE_TETRAHEDRA, "tetrahedra", n_tetrahedra);
    repeat(LARGE_HEXAHEDRA, "hexahedra", n_tetrahedra * 3 / 10);
    repeat(LARGE_QUADRATIC, "quadratic tetrahedra", n_tetrahedra / 10);
    repeat(LARGE_BALL, "hexahedra in a ball that slides", n_tetrahedra / 10);
}

/* ---- a mesh that moves ------------------------------------------------------------------------- */

/** Stretch the surface of the lattice, which was a cube, as a step of a period has it. */
static void move_surface(const large_mesh *m, int64_t step, double *x) {
    const double stretch = 1 + 0.4 * sin(2 * M_PI * (double)step / PERIOD);
    for (int64_t i = 0; i < m->mesh.n_nodes; i++) {
        const int64_t at[3] = {i % m->side, i / m->side % m->side, i / m->side / m->side};
        int is_inside = 1;
        for (int d = 0; d < 3; d++)
            is_inside &= at[d] > 0 && at[d] < m->side - 1;
        if (!is_inside)
            x[3 * i] = (2 * (double)at[0] / (m->side - 1) - 1) * stretch;
    }
}

/** A box becomes longer and shorter, and the nodes inside follow by smoothing alone. */
static void a_moving_mesh_stays_good(void **state) {
    (void)state;
    large_mesh *m = large_mesh_create(LARGE_TETRAHEDRA, n_tetrahedra / 10 < 6000 ? 6000 : 20000);
    planish_plan *plan;
    planish_options options;
    planish_result result;
    footprint early = {0}, late = {0};
    double early_rms = 0, worst = 0;
    /* Half-way, but whole periods before the end. */
    const int64_t early_step = n_steps - n_steps / (2 * PERIOD) * PERIOD;
    planish_options_init(&options);
    assert_int_equal(planish_plan_create(&m->mesh, &options, &plan, NULL), 0);
    for (int64_t step = 1; step <= n_steps; step++) {
        move_surface(m, step, m->x);
        assert_int_equal(planish_smooth(plan, m->x, &options, &result, NULL), 0);
        assert_int_equal(result.n_inverted, 0);
        worst = fmax(worst, result.rms);
        if (step == early_step) {
            early = footprint_of(plan, &m->mesh, m->x);
            early_rms = result.rms;
        }
    }
    late = footprint_of(plan, &m->mesh, m->x);
    figure(
        "%lld steps of a box that is stretched, %lld tetrahedra: RMS %.6f after step %lld, %.6f at "
        "the end, at most %.4f; %+lld pages",
        (long long)n_steps, (long long)m->mesh.n_elements, early_rms, (long long)early_step,
        result.rms, worst, (long long)(late.pages - early.pages));
    assert_true(fabs(result.rms - early_rms) < 1e-3 * early_rms);
    expect_no_growth(SLACK_PAGES, &early, &late);
    planish_plan_destroy(plan);
    large_mesh_destroy(m);
}

/* ---- many small meshes at once --------------------------------------------------------------- */

/** The meshes, which threads take one by one, and what became of them. */
typedef struct crowd {
    pairs choices, of_cells;
    int64_t next, n, different; /* shared */
    uint64_t *checksum;         /* [n] */
    int is_first;               /* they are noted, else compared */
} crowd;

/** A number for what became of a mesh. */
static uint64_t outcome_of(const planish_mesh *given, const double *coordinates, int status,
                           const planish_result *result) {
    planish_mesh moved = *given;
    moved.coordinates = coordinates;
    return planish_checksum(&moved) ^ (uint64_t)status << 32 ^ (uint64_t)result->sweeps;
}

/** Smooth mesh number i, of elements of any type, made for the occasion. */
static uint64_t smooth_cells(const crowd *c, int64_t i) {
    uint64_t seed = effort_seed((uint64_t)i);
    int level[N_CELLS_FACTORS];
    planish_plan *plan = NULL;
    planish_result result = {.sweeps = -1};
    pairs_draw(&c->of_cells, &seed, level);
    level[CELLS_ISA] = PLANISH_ISA_AUTO;
    level[CELLS_TIME_LIMIT] = level[CELLS_PROGRESS] = 0; /* matters of luck */
    cells_call *call = cells_call_create(level, &seed);
    int status = planish_plan_create(&call->given, &call->plan_options, &plan, NULL);
    if (!status)
        status = planish_smooth(plan, call->coordinates, &call->options, &result, NULL);
    const uint64_t outcome = outcome_of(&call->given, call->coordinates, status, &result);
    planish_plan_destroy(plan);
    cells_call_destroy(call);
    return outcome;
}

/** Smooth mesh number i, of triangles or tetrahedra. */
static uint64_t smooth_simplices(const crowd *c, int64_t i) {
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
    const uint64_t outcome = outcome_of(&call.given, call.coordinates, status, &result);
    planish_plan_destroy(plan);
    random_call_destroy(&call);
    return outcome;
}

static void *work(void *data) {
    crowd *c = data;
    for (;;) {
        const int64_t i = __atomic_fetch_add(&c->next, 1, __ATOMIC_RELAXED);
        if (i >= c->n)
            return NULL;
        const uint64_t checksum = i % 2 ? smooth_cells(c, i) : smooth_simplices(c, i);
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
    crowd c = {.choices = {.n_factors = N_FACTORS, .factor = random_factors},
               .of_cells = {.n_factors = N_CELLS_FACTORS, .factor = cells_factors},
               .n = n_meshes};
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
    large_mesh *box;
    uint64_t checksum; /* of the mesh smoothed alone */
    int64_t different; /* shared */
} shared;

static uint64_t smooth_shared(const shared *s) {
    planish_plan *plan;
    planish_mesh moved = s->box->mesh;
    planish_options options;
    planish_options_init(&options);
    options.threads = 2;
    const size_t size = (size_t)(moved.n_nodes * 3) * sizeof(double);
    double *x = malloc(size);
    uint64_t checksum = 0;
    if (x && planish_plan_create(&s->box->mesh, &options, &plan, NULL) == 0) {
        memcpy(x, s->box->x, size);
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
    shared s = {.box = large_mesh_create(LARGE_TETRAHEDRA, 6 * 8 * 8 * 8)};
    s.checksum = smooth_shared(&s);
    assert_true(s.checksum != 0);
    run_threads(work_on_shared, &s);
    assert_int_equal(s.different, 0);
    large_mesh_destroy(s.box);
}

int main(int argc, char **argv) {
    if (argc == 5) {
        n_tetrahedra = strtoll(argv[1], NULL, 10);
        n_calls = strtoll(argv[2], NULL, 10);
        n_meshes = strtoll(argv[3], NULL, 10);
        n_steps = strtoll(argv[4], NULL, 10);
    }
    if ((argc != 1 && argc != 5) || n_calls <= SETTLED || n_steps < 2 * PERIOD) {
        fprintf(stderr,
                "usage: test_soak [TETRAHEDRA CALLS MESHES STEPS]\n"
                "CALLS: %d or more, STEPS: %d or more\n",
                SETTLED + 1, 2 * PERIOD);
        return 64;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_and_results_stay),
        cmocka_unit_test(a_moving_mesh_stays_good),
        cmocka_unit_test(meshes_at_once_are_as_alone),
        cmocka_unit_test(plans_of_one_mesh_do_not_meet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
