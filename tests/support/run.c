/* run: a mesh smoothed with a plan of its own, measured before and after. */
#include "support/run.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void expect(int status, const planish_error *error) {
    if (status)
        fail_msg("%s", error->text);
}

planish_options test_options(int threads) {
    planish_options options;
    planish_options_init(&options);
    options.threads = threads;
    return options;
}

size_t test_bytes_of(const planish_mesh *mesh) {
    return (size_t)(mesh->n_nodes * mesh->dim) * sizeof(double);
}

double *test_copy_of(const planish_mesh *mesh) {
    double *copy = malloc(test_bytes_of(mesh));
    assert_non_null(copy);
    return memcpy(copy, mesh->coordinates, test_bytes_of(mesh));
}

int test_has_isa(int isa) {
    static const double x[] = {0, 0, 1, 0, 0, 1};
    static const int32_t nodes[] = {0, 1, 2};
    const planish_mesh mesh = {
        .dim = 2, .n_nodes = 3, .n_elements = 1, .coordinates = x, .elements = nodes};
    planish_options options = test_options(1);
    planish_plan *plan;
    options.isa = (planish_isa)isa;
    if (planish_plan_create(&mesh, &options, &plan, NULL))
        return 0;
    planish_plan_destroy(plan);
    return 1;
}

test_run test_smooth(const planish_mesh *mesh, const planish_options *options) {
    test_run r;
    planish_plan *plan;
    planish_error error = {.text = ""};
    r.coordinates = test_copy_of(mesh);
    expect(planish_plan_create(mesh, options, &plan, &error), &error);
    planish_plan_get_info(plan, &r.info);
    expect(planish_measure(plan, r.coordinates, &r.before, &error), &error);
    expect(planish_smooth(plan, r.coordinates, options, &r.result, &error), &error);
    expect(planish_measure(plan, r.coordinates, &r.after, &error), &error);
    assert_int_equal(r.result.n_inverted, r.after.n_inverted);
    r.info.isa = r.info.binding = NULL; /* text of the plan */
    planish_plan_destroy(plan);
    return r;
}

planish_result test_smooth_in_place(const planish_mesh *mesh, double *x,
                                    const planish_options *options) {
    planish_plan *plan;
    planish_result result;
    planish_error error = {.text = ""};
    expect(planish_plan_create(mesh, options, &plan, &error), &error);
    expect(planish_smooth(plan, x, options, &result, &error), &error);
    planish_plan_destroy(plan);
    return result;
}

void test_expect_refusal(const planish_mesh *mesh, const planish_options *options, int code,
                         const char *text) {
    planish_plan *plan = NULL;
    planish_error error = {.text = ""};
    assert_int_equal(planish_plan_create(mesh, options, &plan, &error), code);
    if (!strstr(error.text, text))
        fail_msg("\"%s\" does not say \"%s\"", error.text, text);
    assert_null(plan);
}
