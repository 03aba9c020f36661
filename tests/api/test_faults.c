/* Every function of planish.h, with every option: whichever allocation fails, the call says so and
 * leaves everything as it was, or gives what it would have given, and so does the next call. */
#include "support/blocks.h"
#include "support/effort.h"
#include "support/faults.h"
#include "support/run.h"
#include "support/worlds.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- the calls ------------------------------------------------------------------------------- */

/** A copy of the coordinates, to be freed. */
static double *copy_of(const test_world *w) {
    double *x = malloc((size_t)w->n_doubles * sizeof *x);
    memcpy(x, w->mesh.coordinates, (size_t)w->n_doubles * sizeof *x);
    return x;
}

static int is_original(const test_world *w, const double *x) {
    return memcmp(x, w->mesh.coordinates, (size_t)w->n_doubles * sizeof *x) == 0;
}

/** planish_measure_layers, as if all elements were in layers. */
static void measure_heights(const test_world *w, uint8_t *layer, faults *f) {
    planish_mesh mesh = w->mesh;
    planish_layer_heights heights;
    planish_error error;
    int status;
    memset(layer, 1, (size_t)mesh.n_elements);
    mesh.is_layer = layer;
    do {
        status = planish_measure_layers(&mesh, w->options.threads, &heights, NULL, &error);
        assert_true(!status || (heights.all.n == 0 && heights.reference.n == 0));
    } while (faults_refused(f, status, &error));
    faults_add(f, &heights.all, sizeof heights.all);
}

/** planish_find_slides, planish_find_layers and planish_measure_layers. */
static void look_at_shape(const test_world *w, faults *f) {
    const int64_t n = w->mesh.n_nodes, dim = w->mesh.dim;
    const size_t bytes = (size_t)(n * dim) * sizeof(double);
    uint8_t *constraint = malloc((size_t)n), *layer = malloc((size_t)w->mesh.n_elements);
    double *direction = calloc((size_t)(n * dim), sizeof *direction);
    planish_slide_info info = {0};
    planish_error error;
    int64_t n_layer = -1;
    int status;
    do {
        faults_mark(constraint, (size_t)n);
        faults_mark(direction, bytes);
        status = planish_find_slides(&w->mesh, NULL, w->options.threads, constraint, direction,
                                     &info, &error);
        assert_true(!status || (faults_is_marked(constraint, (size_t)n) &&
                                faults_is_marked(direction, bytes) && info.n_surface == 0));
    } while (faults_refused(f, status, &error));
    faults_add(f, constraint, (size_t)n);
    faults_add(f, &info, sizeof info);
    do {
        faults_mark(layer, (size_t)w->mesh.n_elements);
        status = planish_find_layers(&w->mesh, w->options.threads, layer, &n_layer, &error);
        assert_true(!status ||
                    (faults_is_marked(layer, (size_t)w->mesh.n_elements) && n_layer == -1));
    } while (faults_refused(f, status, &error));
    faults_add(f, layer, (size_t)w->mesh.n_elements);
    faults_add(f, &n_layer, sizeof n_layer);
    measure_heights(w, layer, f);
    free(constraint);
    free(direction);
    free(layer);
}

/** planish_measure and planish_measure_elements. */
static void measure(const test_world *w, faults *f, const planish_plan *plan, const double *x) {
    const size_t bytes = (size_t)w->mesh.n_elements * sizeof(double);
    double *ratio = malloc(bytes);
    planish_quality quality;
    planish_error error;
    int status;
    do {
        faults_mark(&quality, sizeof quality);
        status = planish_measure(plan, x, &quality, &error);
        assert_true(!status || faults_is_marked(&quality, sizeof quality));
    } while (faults_refused(f, status, &error));
    faults_add(f, &quality, sizeof quality);
    do {
        faults_mark(ratio, bytes);
        status = planish_measure_elements(plan, x, ratio, &error);
        assert_true(!status || faults_is_marked(ratio, bytes));
    } while (faults_refused(f, status, &error));
    faults_add(f, ratio, bytes);
    free(ratio);
}

/** planish_check_volumes and planish_find_infeasible. */
static void check(const test_world *w, faults *f, const planish_options *options,
                  const planish_plan *plan, const double *x) {
    const size_t n = (size_t)w->mesh.n_elements;
    uint8_t *state = malloc(n);
    int64_t count = -1;
    planish_error error;
    int status;
    do {
        faults_mark(state, n);
        status = planish_check_volumes(plan, x, options, state, &count, NULL, &error);
        assert_true(!status || (faults_is_marked(state, n) && count == -1));
    } while (faults_refused(f, status, &error));
    faults_add(f, state, n);
    faults_add(f, &count, sizeof count);
    count = -1;
    do {
        faults_mark(state, n);
        status = planish_find_infeasible(plan, x, NULL, state, &count, NULL, &error);
        assert_true(!status || (faults_is_marked(state, n) && count == -1));
    } while (faults_refused(f, status, &error));
    faults_add(f, state, n);
    faults_add(f, &count, sizeof count);
    free(state);
}

static void smooth(const test_world *w, faults *f, const planish_options *options,
                   planish_plan *plan, double *x) {
    planish_result result;
    planish_error error;
    int status;
    do {
        faults_mark(&result, sizeof result);
        status = planish_smooth(plan, x, options, &result, &error);
        assert_true(!status || (is_original(w, x) && faults_is_marked(&result, sizeof result)));
    } while (faults_refused(f, status, &error));
    result.seconds = 0;
    faults_add(f, x, (size_t)w->n_doubles * sizeof *x);
    faults_add(f, &result, sizeof result);
}

static planish_plan *make_plan(const test_world *w, faults *f, const planish_options *options) {
    planish_plan *plan = NULL;
    planish_plan_info info;
    planish_error error;
    int status;
    uint8_t *is_free = malloc((size_t)w->mesh.n_nodes);
    do {
        status = planish_plan_create(&w->mesh, options, &plan, &error);
        assert_true(!status || plan == NULL);
    } while (faults_refused(f, status, &error));
    planish_plan_get_info(plan, &info);
    planish_plan_get_free(plan, is_free);
    faults_add(f, &info.n_free, sizeof info.n_free);
    faults_add(f, is_free, (size_t)w->mesh.n_nodes);
    free(is_free);
    return plan;
}

/** All calls, smoothing twice: once from the start and once from where that led. */
static void call_all(const void *context, faults *f) {
    const test_world *w = context;
    planish_options options = w->options;
    planish_quality quality;
    planish_error error;
    int status;
    if (w->has_allocator)
        options.allocator = &f->allocator;
    if (!w->mesh.elements64)
        look_at_shape(w, f);
    do {
        faults_mark(&quality, sizeof quality);
        status = planish_measure_mesh(&w->mesh, &options, &quality, &error);
        assert_true(!status || faults_is_marked(&quality, sizeof quality));
    } while (faults_refused(f, status, &error));
    faults_add(f, &quality, sizeof quality);
    double *x = copy_of(w);
    planish_plan *plan = make_plan(w, f, &options);
    measure(w, f, plan, x);
    check(w, f, &options, plan, x);
    smooth(w, f, &options, plan, x);
    const uint64_t checksum = planish_checksum(&w->mesh);
    faults_add(f, &checksum, sizeof checksum);
    measure(w, f, plan, x);
    check(w, f, &options, plan, x);
    planish_plan_destroy(plan);
    free(x);
}

static void every_allocation_fails_once(void **state) {
    (void)state;
    int64_t runs = 0;
    for (int dim = 2; dim <= 3; dim++)
        for (int i = 0; i < test_world_count(); i++) {
            test_world w;
            char name[64];
            test_world_create(&w, dim, i);
            snprintf(name, sizeof name, "%s, %d-D", w.name, dim);
            runs += faults_try(name, call_all, &w, 20 / effort_step(2));
            test_world_destroy(&w);
        }
    figure("%d scenarios, %d runs without some memory", 2 * test_world_count(), (int)runs);
}

/* ---- fits -------------------------------------------------------------------------------------- */

/** A block that is fitted to a surface. */
typedef struct fit_world {
    block b;
    block_target onto;
} fit_world;

/** Move the nodes of a fit; a call that is refused leaves them, and the fit, as they were. */
static void move(const fit_world *w, faults *f, planish_fit *fit, double *x) {
    const size_t bytes = test_bytes_of(&w->b.mesh);
    const planish_options options = test_options(1);
    planish_fit_info info;
    planish_error error;
    double *before = malloc(bytes);
    int status;
    memcpy(before, x, bytes);
    do {
        faults_mark(&info, sizeof info);
        status = planish_fit_move(fit, &w->b.mesh, x, &options, &info, &error);
        assert_true(!status ||
                    (memcmp(x, before, bytes) == 0 && faults_is_marked(&info, sizeof info)));
    } while (faults_refused(f, status, &error));
    faults_add(f, x, bytes);
    faults_add(f, &info, sizeof info);
    free(before);
}

/** All calls of a fit. */
static void call_fit(const void *context, faults *f) {
    const fit_world *w = context;
    const planish_options options = test_options(1);
    planish_fit *fit = NULL;
    planish_fit_info info;
    planish_shape_distance distance;
    planish_error error;
    int status;
    do {
        faults_mark(&info, sizeof info);
        status = planish_fit_create(&w->b.mesh, w->b.shape, w->onto.shape, 5, &options, &fit, &info,
                                    &error);
        assert_true(!status || (fit == NULL && faults_is_marked(&info, sizeof info)));
    } while (faults_refused(f, status, &error));
    faults_add(f, &info, sizeof info);
    double *x = test_copy_of(&w->b.mesh);
    move(w, f, fit, x);
    planish_mesh mesh = w->b.mesh;
    mesh.coordinates = x;
    do {
        faults_mark(&distance, sizeof distance);
        status = planish_fit_measure(fit, &mesh, &distance, &error);
        assert_true(!status || faults_is_marked(&distance, sizeof distance));
    } while (faults_refused(f, status, &error));
    faults_add(f, &distance, sizeof distance);
    planish_fit_destroy(fit);
    free(x);
}

static void every_allocation_of_a_fit_fails_once(void **state) {
    static const struct {
        const char *name;
        int is_tets;
        cell_box_kind kind;
    } rows[] = {{"fit of tetrahedra", 1, BOX_HEXAHEDRA},
                {"fit of hexahedra, wedges and pyramids", 0, BOX_MIXED}};
    (void)state;
    int64_t runs = 0;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        fit_world w;
        block_create(rows[i].is_tets, rows[i].kind, BLOCK_CUBE, 3, 0.8, 0.05,
                     &(uint64_t){effort_seed(3)}, &w.b);
        block_target_create(BLOCK_BALL, 4, 0.5, 0, &w.onto);
        runs += faults_try(rows[i].name, call_fit, &w, 100);
        block_destroy(&w.b);
        block_target_destroy(&w.onto);
    }
    figure("%d runs of fits without some memory", (int)runs);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_allocation_fails_once),
                                       cmocka_unit_test(every_allocation_of_a_fit_fails_once)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
