/* What a program that embeds the library relies on: memory, callbacks, what is left as found. */
#define _GNU_SOURCE /* sched.h: affinities */
#include "support/meshes.h"
#include "support/run.h"

#include <fenv.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _OPENMP
#include <omp.h>
#endif
#ifdef __linux__
#include <sched.h>
#endif

#include <cmocka.h>

enum { CELLS = TEST_THREADS_CELLS };

/* ---- memory -------------------------------------------------------------------------------- */

/** An allocator that counts, and whose memory is aligned no better than malloc's. */
typedef struct heap {
    _Atomic int64_t calls, live, left;
    int64_t missing; /* this call and the next have no memory: one is asked again; or -1 */
} heap;

static void *heap_allocate(size_t bytes, void *user) {
    heap *h = user;
    const int64_t call = h->calls++;
    if ((h->missing >= 0 && (call == h->missing || call == h->missing + 1)) || h->left-- <= 0)
        return NULL;
    char *block = malloc(bytes + 16);
    h->live += block != NULL;
    return block ? block + 16 : NULL;
}

static void heap_release(void *block, void *user) {
    heap *h = user;
    assert_non_null(block);
    h->live--;
    free((char *)block - 16);
}

static planish_allocator allocator_of(heap *h) {
    h->left = INT64_MAX;
    h->missing = -1;
    return (planish_allocator){heap_allocate, heap_release, h};
}

static void *ones_allocate(size_t bytes, void *user) {
    char *block = heap_allocate(bytes, user);
    return block ? memset(block, 0xff, bytes) : NULL;
}

/** A mesh so large that arrays share pages and find what others have left there: twice on one plan,
 *  the bits are those of memory that is full of ones. */
static void shared_pages_do_not_show(void **state) {
    (void)state;
    for (int is_tangled = 0; is_tangled < 2; is_tangled++) {
        test_mesh box;
        heap h = {0};
        planish_allocator ones = allocator_of(&h);
        planish_options options = test_options(2);
        planish_plan *plan;
        ones.allocate = ones_allocate;
        test_mesh_box(&box, 3, 16);
        test_mesh_perturb(&box, is_tangled ? 0.5 : 0.14, 12345);
        double *expected = test_copy_of(&box.mesh), *x = test_copy_of(&box.mesh);
        options.allocator = &ones;
        assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
        assert_int_equal(planish_smooth(plan, expected, &options, NULL, NULL), 0);
        assert_memory_not_equal(expected, x, test_bytes_of(&box.mesh));
        planish_plan_destroy(plan);
        options.allocator = NULL;
        for (options.threads = 1; options.threads <= 3; options.threads += 2) {
            assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
            for (int i = 0; i < 2; i++) {
                memcpy(x, box.mesh.coordinates, test_bytes_of(&box.mesh));
                assert_int_equal(planish_smooth(plan, x, &options, NULL, NULL), 0);
                assert_memory_equal(x, expected, test_bytes_of(&box.mesh));
            }
            planish_plan_destroy(plan);
        }
        free(expected);
        free(x);
        test_mesh_destroy(&box);
    }
}

/** Calls on one plan, from the same coordinates and from others. */
static void calls_allocate_once(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int which = 0; which < 6; which++) {
            test_mesh box;
            heap h = {0};
            const planish_allocator allocator = allocator_of(&h);
            planish_options options = test_options(2);
            planish_plan *plan;
            planish_error error;
            planish_quality quality;
            planish_result first, again;
            (which == 1 ? test_tangled_box_for_threads : test_bad_box_for_threads)(&box, dim);
            options.allocator = &allocator;
            if (which == 2)
                options.worst = PLANISH_WORST_ANGLE;
            if (which == 3)
                options.min_volume = 0.05, options.area_weight = 0.1;
            if (which == 4)
                options.box_lower[0] = -1, options.max_displacement = 0.1;
            if (which == 5)
                options.only_worse_than = 1.8;
            assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, &error), 0);
            double *a = test_copy_of(&box.mesh), *b = test_copy_of(&box.mesh);
            assert_int_equal(planish_smooth(plan, a, &options, &first, &error), 0);
            assert_int_equal(planish_measure(plan, a, &quality, &error), 0);
            assert_true(first.n_moved_nodes > 0);
            const int64_t calls = h.calls;
            for (int i = 0; i < 3; i++) {
                memcpy(b, box.mesh.coordinates, test_bytes_of(&box.mesh));
                for (int64_t k = 0; i == 2 && k < box.mesh.n_nodes * dim; k++)
                    b[k] *= 0.75;
                assert_int_equal(planish_smooth(plan, b, &options, &again, &error), 0);
                assert_int_equal(planish_measure(plan, b, &quality, &error), 0);
                if (h.calls != calls)
                    fail_msg("dim %d, options %d, call %d: %d allocations", dim, which, i,
                             (int)(h.calls - calls));
                if (i < 2)
                    assert_memory_equal(a, b, test_bytes_of(&box.mesh));
            }
            planish_plan_destroy(plan);
            assert_int_equal(h.live, 0);
            free(a);
            free(b);
            test_mesh_destroy(&box);
        }
}

/** An allocator that fails at any call: one clear error, nothing changed, nothing lost. */
static void allocators_may_fail(void **state) {
    (void)state;
    test_mesh box;
    heap h = {0};
    const planish_allocator allocator = allocator_of(&h);
    planish_options options = test_options(2);
    test_tangled_box_for_threads(&box, 3);
    options.allocator = &allocator;
    options.max_sweeps = 2;
    double *copy = test_copy_of(&box.mesh);
    int64_t n = 0, failures = 0;
    for (int status = PLANISH_ERROR_MEMORY; status == PLANISH_ERROR_MEMORY; n++) {
        planish_plan *plan = NULL;
        planish_error error = {.text = ""};
        h.left = n;
        status = planish_plan_create(&box.mesh, &options, &plan, &error);
        if (!status)
            status = planish_smooth(plan, copy, &options, NULL, &error);
        if (status) {
            assert_int_equal(status, PLANISH_ERROR_MEMORY);
            assert_int_equal(error.code, PLANISH_ERROR_MEMORY);
            assert_memory_equal(copy, box.mesh.coordinates, test_bytes_of(&box.mesh));
            failures++;
        }
        planish_plan_destroy(plan);
        assert_int_equal(h.live, 0);
        planish_quality quality;
        h.left = n;
        const int measured = planish_measure_mesh(&box.mesh, &options, &quality, NULL);
        assert_true(measured == 0 || measured == PLANISH_ERROR_MEMORY);
        assert_int_equal(h.live, 0);
    }
    assert_true(failures > 40);
    free(copy);
    test_mesh_destroy(&box);
}

/** An allocation that fails changes no bit: it is an error, or it did no harm. */
static void results_do_not_depend_on_memory(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        heap h = {0};
        const planish_allocator allocator = allocator_of(&h);
        planish_options options = test_options(2);
        planish_plan *plan;
        test_tangled_box_for_threads(&box, dim);
        options.allocator = &allocator;
        options.max_sweeps = 3;
        double *expected = test_copy_of(&box.mesh), *x = test_copy_of(&box.mesh);
        assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
        const int64_t calls = h.calls;
        assert_int_equal(planish_smooth(plan, expected, &options, NULL, NULL), 0);
        const int64_t n = h.calls - calls;
        planish_plan_destroy(plan);
        assert_true(n > 10);
        int failures = 0;
        for (int64_t k = 0; k < n; k++) {
            memcpy(x, box.mesh.coordinates, test_bytes_of(&box.mesh));
            assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
            h.missing = h.calls + k;
            const int status = planish_smooth(plan, x, &options, NULL, NULL);
            h.missing = -1;
            failures += status != 0;
            if (status)
                assert_memory_equal(x, box.mesh.coordinates, test_bytes_of(&box.mesh));
            else
                assert_memory_equal(x, expected, test_bytes_of(&box.mesh));
            memcpy(x, box.mesh.coordinates, test_bytes_of(&box.mesh));
            assert_int_equal(planish_smooth(plan, x, &options, NULL, NULL), 0);
            assert_memory_equal(x, expected, test_bytes_of(&box.mesh));
            planish_plan_destroy(plan);
        }
        assert_true(failures > 5);
        assert_int_equal(h.live, 0);
        free(expected);
        free(x);
        test_mesh_destroy(&box);
    }
}

/** Calls that want something else each time do not pile up what the ones before wanted. */
static void kept_memory_is_bounded(void **state) {
    (void)state;
    test_mesh box;
    planish_options options = test_options(2);
    planish_plan *plan;
    planish_plan_info info;
    test_mesh_box(&box, 3, CELLS);
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    planish_plan_get_info(plan, &info);
    const int64_t bytes = info.bytes;
    double *x = test_copy_of(&box.mesh);
    unsigned random = 1;
    int64_t most = 0;
    for (int i = 0; i < 60; i++) {
        memcpy(x, box.mesh.coordinates, test_bytes_of(&box.mesh));
        for (int k = 0; k <= i % 20; k++) {
            const int64_t node = (int64_t)(test_random(&random) * (double)box.mesh.n_nodes);
            int inside = 1;
            for (int d = 0; d < 3; d++)
                inside &= x[3 * node + d] > 0 && x[3 * node + d] < CELLS;
            x[3 * node] += inside ? 1.2 : 0;
        }
        assert_int_equal(planish_smooth(plan, x, &options, NULL, NULL), 0);
        planish_plan_get_info(plan, &info);
        if (i < 20)
            most = info.bytes > most ? info.bytes : most;
    }
    assert_true(bytes > 0 && info.bytes <= most + most / 10);
    for (int i = 0; i < 3; i++) {
        memcpy(x, box.mesh.coordinates, test_bytes_of(&box.mesh));
        assert_int_equal(planish_smooth(plan, x, &options, NULL, NULL), 0);
    }
    planish_plan_get_info(plan, &info);
    assert_true(info.bytes < bytes + bytes / 4);
    planish_plan_destroy(plan);
    free(x);
    test_mesh_destroy(&box);
}

typedef struct asker {
    planish_plan *plan;
    const double *coordinates;
    heap *heap;
    int failures;
} asker;

static int ask_without_memory(const planish_progress *progress, void *user) {
    asker *a = user;
    int64_t n;
    (void)progress;
    a->heap->left = 0;
    a->failures += planish_check_volumes(a->plan, a->coordinates, NULL, NULL, &n, NULL, NULL) != 0;
    a->heap->left = INT64_MAX;
    return 0;
}

/** What fails in a callback is no failure of what called it. */
static void failures_in_callbacks_stay_there(void **state) {
    (void)state;
    test_mesh box;
    heap h = {0};
    const planish_allocator allocator = allocator_of(&h);
    planish_options options = test_options(2);
    asker a = {.heap = &h};
    test_bad_box_for_threads(&box, 3);
    options.allocator = &allocator;
    double *x = test_copy_of(&box.mesh), *expected = test_copy_of(&box.mesh);
    assert_int_equal(planish_plan_create(&box.mesh, &options, &a.plan, NULL), 0);
    a.coordinates = box.coordinates;
    options.progress = ask_without_memory;
    options.progress_user = &a;
    assert_int_equal(planish_smooth(a.plan, x, &options, NULL, NULL), 0);
    assert_true(a.failures > 0);
    options.progress = NULL;
    assert_int_equal(planish_smooth(a.plan, expected, &options, NULL, NULL), 0);
    assert_memory_equal(x, expected, test_bytes_of(&box.mesh));
    planish_plan_destroy(a.plan);
    free(x);
    free(expected);
    test_mesh_destroy(&box);
}

/** What a callback allocates is not the plan's, and may outlive it. */
typedef struct inner {
    planish_plan *plan;
    const planish_mesh *mesh;
} inner;

static int make_a_plan(const planish_progress *progress, void *user) {
    inner *in = user;
    planish_options options = test_options(2);
    (void)progress;
    if (!in->plan)
        assert_int_equal(planish_plan_create(in->mesh, &options, &in->plan, NULL), 0);
    return 0;
}

static void callbacks_may_call_the_library(void **state) {
    (void)state;
    test_mesh box;
    planish_options options = test_options(2);
    planish_plan *plan;
    test_bad_box_for_threads(&box, 3);
    inner in = {NULL, &box.mesh};
    options.progress = make_a_plan;
    options.progress_user = &in;
    double *a = test_copy_of(&box.mesh), *b = test_copy_of(&box.mesh);
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, a, &options, NULL, NULL), 0);
    planish_plan_destroy(plan);
    assert_int_equal(planish_smooth(in.plan, b, NULL, NULL, NULL), 0);
    planish_plan_destroy(in.plan);
    assert_memory_equal(a, b, test_bytes_of(&box.mesh));
    free(a);
    free(b);
    test_mesh_destroy(&box);
}

/** Asks what planish.h permits in a callback; results are as without, and times go on. */
typedef struct reader_on_the_way {
    planish_plan *plan;
    const planish_options *volumes;
    double *coordinates; /* [n_nodes][dim] of the caller, from which nothing moves meanwhile */
    double *start;
    size_t bytes;
    uint8_t *state;
    double *ratio, *positions;
    pthread_t thread;
    int64_t below;
    int calls;
    double seconds;
} reader_on_the_way;

static int ask_on_the_way(const planish_progress *progress, void *user) {
    reader_on_the_way *a = user;
    planish_quality quality;
    assert_true(pthread_equal(a->thread, pthread_self()));
    assert_int_equal(
        planish_check_volumes(a->plan, a->coordinates, a->volumes, a->state, &a->below, NULL, NULL),
        0);
    assert_true(a->below > 0);
    assert_int_equal(planish_measure(a->plan, a->coordinates, &quality, NULL), 0);
    if (progress->sweep_done)
        assert_int_equal(planish_progress_get_coordinates(progress, a->positions, NULL), 0);
    assert_int_equal(planish_measure_elements(a->plan, a->positions, a->ratio, NULL), 0);
    assert_memory_equal(a->coordinates, a->start, a->bytes);
    assert_true(progress->seconds >= 0 && progress->seconds < 3600);
    a->calls++;
    return 0;
}

static int count_calls(const planish_progress *progress, void *user) {
    (void)progress;
    (*(int *)user)++;
    return 0;
}

static void callbacks_may_ask_of_the_mesh(void **state) {
    (void)state;
    for (int which = 0; which < 3; which++) {
        test_mesh box;
        planish_options options = test_options(2), volumes = test_options(2);
        planish_result result;
        int calls = 0;
        (which == 1 ? test_tangled_box_for_threads : test_bad_box_for_threads)(&box, 3);
        options.min_volume = which == 2 ? 0.1 : 0;
        volumes.min_volume = 0.2;
        double *expected = test_copy_of(&box.mesh);
        reader_on_the_way a = {.volumes = &volumes,
                               .coordinates = test_copy_of(&box.mesh),
                               .start = test_copy_of(&box.mesh),
                               .bytes = test_bytes_of(&box.mesh),
                               .state = malloc((size_t)box.mesh.n_elements),
                               .ratio = malloc((size_t)box.mesh.n_elements * sizeof(double)),
                               .positions = test_copy_of(&box.mesh),
                               .thread = pthread_self()};
        assert_int_equal(planish_plan_create(&box.mesh, &options, &a.plan, NULL), 0);
        options.progress = count_calls;
        options.progress_user = &calls;
        assert_int_equal(planish_smooth(a.plan, expected, &options, NULL, NULL), 0);
        options.progress = ask_on_the_way;
        options.progress_user = &a;
        assert_int_equal(planish_smooth(a.plan, a.coordinates, &options, &result, NULL), 0);
        assert_memory_equal(a.coordinates, expected, test_bytes_of(&box.mesh));
        assert_int_equal(a.calls, calls);
        assert_true(result.seconds > 0);
        planish_plan_destroy(a.plan);
        free(a.coordinates);
        free(a.start);
        free(a.state);
        free(a.ratio);
        free(a.positions);
        free(expected);
        test_mesh_destroy(&box);
    }
}

/* ---- left as found -------------------------------------------------------------------------- */

static void count_signal(int number) {
    (void)number;
}

static void the_process_is_left_as_found(void **state) {
    (void)state;
    test_mesh box;
    planish_plan *plan;
    planish_options options = test_options(2);
    struct sigaction action = {.sa_handler = count_signal}, found;
    fenv_t before, after;
    test_tangled_box_for_threads(&box, 3);
    double *x = test_copy_of(&box.mesh);
    options.bind = 1;
    sigaction(SIGINT, &action, NULL);
    setlocale(LC_ALL, "C.UTF-8");
    const char *locale = setlocale(LC_ALL, NULL);
    char *kept = strdup(locale);
    fesetround(FE_TONEAREST);
    feclearexcept(FE_ALL_EXCEPT);
    fegetenv(&before);
#ifdef __linux__
    cpu_set_t places, now;
    sched_getaffinity(0, sizeof places, &places);
#endif
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, x, &options, NULL, NULL), 0);
    planish_plan_destroy(plan);
    sigaction(SIGINT, NULL, &found);
    assert_true(found.sa_handler == count_signal);
    assert_string_equal(setlocale(LC_ALL, NULL), kept);
    assert_int_equal(fegetround(), FE_TONEAREST);
    fegetenv(&after);
#if defined(__x86_64__)
    assert_int_equal(before.__control_word, after.__control_word);
    assert_int_equal(before.__mxcsr, after.__mxcsr);
#endif
#ifdef __linux__
    sched_getaffinity(0, sizeof now, &now);
    assert_true(CPU_EQUAL(&places, &now));
#endif
    signal(SIGINT, SIG_DFL);
    free(kept);
    free(x);
    test_mesh_destroy(&box);
}

/* ---- what is said --------------------------------------------------------------------------- */

typedef struct notes {
    int n[3];
    char all[4096];
} notes;

static void note(planish_log_level level, const char *text, void *user) {
    notes *n = user;
    assert_true(level == PLANISH_LOG_NOTE || level == PLANISH_LOG_DETAIL);
    assert_null(strchr(text, '\n'));
    n->n[level]++;
    strncat(n->all, text, sizeof n->all - strlen(n->all) - 2);
    strcat(n->all, "\n");
}

static void a_log_tells_what_is_done(void **state) {
    (void)state;
    test_mesh box;
    notes n = {0};
    planish_plan *plan;
    planish_options options = test_options(2);
    test_bad_box_for_threads(&box, 3);
    options.log = note;
    options.log_user = &n;
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    assert_non_null(strstr(n.all, "216 of 512 nodes may move"));
    planish_plan_info info;
    char megabytes[32];
    planish_plan_get_info(plan, &info);
    snprintf(megabytes, sizeof megabytes, "; %.3g MB", (double)info.bytes / 1e6);
    assert_non_null(strstr(n.all, megabytes));
    assert_int_equal(planish_smooth(plan, box.coordinates, &options, NULL, NULL), 0);
    assert_non_null(strstr(n.all, "converged after"));
    assert_int_equal(n.n[PLANISH_LOG_NOTE], 0);
    planish_plan_destroy(plan);

    box.elements[4] = box.elements[0]; /* two elements with the same nodes, and facets of three */
    memcpy(box.elements + 4, box.elements, 4 * sizeof *box.elements);
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    assert_true(n.n[PLANISH_LOG_NOTE] > 0);
    assert_non_null(strstr(n.all, "have the nodes of an earlier one"));
    planish_plan_destroy(plan);
    test_mesh_destroy(&box);
}

static void features_are_told(void **state) {
    (void)state;
    char numbers[32];
    snprintf(numbers, sizeof numbers, "%d.%d.%d", PLANISH_VERSION_MAJOR, PLANISH_VERSION_MINOR,
             PLANISH_VERSION_PATCH);
    assert_string_equal(planish_version(), PLANISH_VERSION);
    assert_string_equal(planish_version(), numbers);
#ifdef _OPENMP
    assert_int_equal(planish_has_feature(PLANISH_FEATURE_OPENMP), 1);
#endif
    assert_int_equal(planish_has_feature((planish_feature)99), 0);
    assert_true(planish_has_feature(PLANISH_FEATURE_HWLOC) == 0 ||
                planish_has_feature(PLANISH_FEATURE_HWLOC) == 1);
}

/* ---- measures without a plan ---------------------------------------------------------------- */

static void meshes_are_measured_without_a_plan(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int which = 0; which < 4; which++) {
            test_mesh box;
            planish_plan *plan;
            planish_quality expected, quality;
            (which == 1 ? test_tangled_box_for_threads : test_bad_box_for_threads)(&box, dim);
            if (which == 2)
                test_mesh_reverse_some(&box, 3, 5);
            planish_mesh mesh = box.mesh;
            uint8_t *constraint = calloc(1, (size_t)mesh.n_nodes);
            for (int64_t i = 0; i < mesh.n_nodes; i += 3)
                constraint[i] = PLANISH_CONSTRAINT_FIXED;
            mesh.constraint = which == 3 ? constraint : NULL;
            assert_int_equal(planish_plan_create(&mesh, NULL, &plan, NULL), 0);
            assert_int_equal(planish_measure(plan, mesh.coordinates, &expected, NULL), 0);
            assert_int_equal(planish_measure_mesh(&mesh, NULL, &quality, NULL), 0);
            assert_memory_equal(&quality, &expected, sizeof quality);
            planish_plan_destroy(plan);
            free(constraint);
            test_mesh_destroy(&box);
        }
    planish_quality quality;
    planish_error error;
    assert_int_equal(planish_measure_mesh(NULL, NULL, &quality, &error), PLANISH_ERROR_ARGUMENT);
}

static void checksums_tell_bits_apart(void **state) {
    (void)state;
    test_mesh box;
    test_bad_box_for_threads(&box, 3);
    planish_mesh mesh = box.mesh;
    const int64_t n = mesh.n_nodes;
    const uint64_t sum = planish_checksum(&mesh);
    double *x = calloc((size_t)(4 * n), sizeof *x);
    for (int form = 0; form < 2; form++) {
        mesh = box.mesh;
        mesh.coordinates = x;
        mesh.node_stride = form ? 1 : 4;
        mesh.component_stride = form ? n : 1;
        for (int64_t i = 0; i < 3 * n; i++)
            x[i / 3 * mesh.node_stride + i % 3 * mesh.component_stride] = box.coordinates[i];
        assert_true(planish_checksum(&mesh) == sum);
    }
    assert_true(sum != 0);
    for (int64_t i = 0; i < 3 * n; i++) {
        const double was = box.coordinates[i];
        box.coordinates[i] = was == 0 ? -0.0 : nextafter(was, 100);
        assert_true(planish_checksum(&box.mesh) != sum);
        box.coordinates[i] = was;
    }
    assert_true(planish_checksum(NULL) == 0);
    const planish_mesh view = {.dim = 3, .n_nodes = n, .coordinates = box.coordinates};
    assert_true(planish_checksum(&view) == sum); /* whatever there is besides */
    free(x);
    test_mesh_destroy(&box);
}

/** Arrays may be one and the same where one of them is only read. */
static void arrays_may_be_the_same(void **state) {
    (void)state;
    test_mesh box;
    planish_plan *plan;
    planish_options options = test_options(2);
    planish_result result;
    test_bad_box_for_threads(&box, 3);
    double *start = test_copy_of(&box.mesh);
    options.lower = options.upper = box.coordinates; /* every node stays where it is */
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, box.coordinates, &options, &result, NULL), 0);
    assert_int_equal(result.n_moved_nodes, 0);
    assert_memory_equal(box.coordinates, start, test_bytes_of(&box.mesh));
    planish_plan_destroy(plan);

    planish_mesh mesh = box.mesh;
    const size_t n = (size_t)mesh.n_nodes;
    uint8_t *expected = malloc(n), *constraint = calloc(1, n);
    double *direction = malloc(3 * n * sizeof *direction);
    constraint[5] = PLANISH_CONSTRAINT_FIXED;
    mesh.constraint = constraint;
    assert_int_equal(planish_find_slides(&mesh, NULL, 1, expected, direction, NULL, NULL), 0);
    assert_int_equal(planish_find_slides(&mesh, NULL, 1, constraint, direction, NULL, NULL), 0);
    assert_memory_equal(constraint, expected, n);
    free(expected);
    free(constraint);
    free(direction);
    free(start);
    test_mesh_destroy(&box);
}

static int cancel(const planish_progress *progress, void *user) {
    (void)progress;
    (*(int *)user)++;
    return 1;
}

/** A callback that cancels at once leaves a mesh that is no worse. */
static void cancelling_at_once_is_safe(void **state) {
    (void)state;
    for (int which = 0; which < 2; which++) {
        test_mesh box;
        planish_plan *plan;
        planish_options options = test_options(2);
        planish_result result;
        planish_quality before, after;
        int calls = 0;
        (which ? test_tangled_box_for_threads : test_bad_box_for_threads)(&box, 3);
        options.progress = cancel;
        options.progress_user = &calls;
        assert_int_equal(planish_measure_mesh(&box.mesh, NULL, &before, NULL), 0);
        assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
        assert_int_equal(planish_smooth(plan, box.coordinates, &options, &result, NULL), 0);
        assert_int_equal(result.stop, PLANISH_STOP_INTERRUPTED);
        assert_true(calls == 1 || calls == 2); /* and once more at the end of the sweep */
        assert_int_equal(planish_measure_mesh(&box.mesh, NULL, &after, NULL), 0);
        assert_true(after.n_inverted <= before.n_inverted);
        assert_true(which || after.rms_radius_ratio <= before.rms_radius_ratio);
        planish_plan_destroy(plan);
        test_mesh_destroy(&box);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(calls_allocate_once),
        cmocka_unit_test(shared_pages_do_not_show),
        cmocka_unit_test(allocators_may_fail),
        cmocka_unit_test(results_do_not_depend_on_memory),
        cmocka_unit_test(kept_memory_is_bounded),
        cmocka_unit_test(failures_in_callbacks_stay_there),
        cmocka_unit_test(callbacks_may_call_the_library),
        cmocka_unit_test(callbacks_may_ask_of_the_mesh),
        cmocka_unit_test(the_process_is_left_as_found),
        cmocka_unit_test(a_log_tells_what_is_done),
        cmocka_unit_test(features_are_told),
        cmocka_unit_test(meshes_are_measured_without_a_plan),
        cmocka_unit_test(checksums_tell_bits_apart),
        cmocka_unit_test(arrays_may_be_the_same),
        cmocka_unit_test(cancelling_at_once_is_safe),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
