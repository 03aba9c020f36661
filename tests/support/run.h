/* run: a mesh smoothed with a plan of its own, measured before and after.
 *
 *   test_options, test_bytes_of, test_copy_of, test_has_isa    what a call needs
 *   test_smooth, test_smooth_in_place                          the call
 *   test_expect_refusal                                        a plan that cannot be made
 */
#ifndef TEST_SUPPORT_RUN_H
#define TEST_SUPPORT_RUN_H

#include <planish/planish.h>

/** Result of smoothing a mesh, and its quality before and after. */
typedef struct test_run {
    double *coordinates; /* [n][dim], to be freed */
    planish_plan_info info;
    planish_result result;
    planish_quality before, after;
} test_run;

/** The default options, with so many threads. */
planish_options test_options(int threads);

/** Size of the coordinates of mesh in bytes. */
size_t test_bytes_of(const planish_mesh *mesh);

/** A copy of the coordinates of mesh, to be freed. */
double *test_copy_of(const planish_mesh *mesh);

/** Whether this CPU, and the library, have the instructions of a planish_isa. */
int test_has_isa(int isa);

/** The test fails if a call does; mesh keeps its coordinates. */
test_run test_smooth(const planish_mesh *mesh, const planish_options *options);

/** Smooth x [n_nodes][dim] of mesh; the test fails if a call does. */
planish_result test_smooth_in_place(const planish_mesh *mesh, double *x,
                                    const planish_options *options);

/** Check that a plan is refused with code, in words that have text. */
void test_expect_refusal(const planish_mesh *mesh, const planish_options *options, int code,
                         const char *text);

#endif
