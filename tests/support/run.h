/* run: a mesh smoothed with a plan of its own, measured before and after. */
#ifndef TEST_SUPPORT_RUN_H
#define TEST_SUPPORT_RUN_H

#include <planish/planish.h>

typedef struct test_run {
    double *coordinates; /* [n][dim], to be freed */
    planish_plan_info info;
    planish_result result;
    planish_quality before, after;
} test_run;

/** The test fails if a call does; mesh keeps its coordinates. */
test_run test_smooth(const planish_mesh *mesh, const planish_options *options);

#endif
