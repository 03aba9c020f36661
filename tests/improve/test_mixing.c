/* Tests of src/improve/mixing.c. */
#include "improve/mixing.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { N = 20000 };

/** g: a contraction by rates of up to 0.99, towards 1, 2, 3 ... */
static void step(const double *x, double *end) {
    for (int i = 0; i < N; i++)
        end[i] = (i % 9 + 1) + (0.99 - 0.3 * (i % 5)) * (x[i] - (i % 9 + 1));
}

static double farthest(const double *x) {
    double most = 0;
    for (int i = 0; i < N; i++)
        most = fmax(most, fabs(x[i] - (i % 9 + 1)));
    return most;
}

/** Go n steps from 0; x [N]. */
static void go(int n, int is_mixed, int threads, double *x) {
    pl_mixing m;
    double *end = malloc(N * sizeof *end);
    assert_non_null(end);
    assert_int_equal(pl_mixing_create(N, threads, &m), 1);
    for (int k = 0; k < n; k++) {
        step(x, end);
        if (is_mixed)
            pl_mixing_mix(&m, x, end);
        memcpy(x, end, N * sizeof *x);
    }
    pl_mixing_destroy(&m);
    free(end);
}

/** Of an affine map with five rates six mixed steps, and one for rounding, lead to the end; plain ones
 *  do not. */
static void affine_steps_lead_to_the_end(void **state) {
    (void)state;
    double *plain = calloc(N, sizeof *plain), *mixed = calloc(N, sizeof *mixed);
    assert_true(plain && mixed);
    go(12, 0, 1, plain);
    go(12, 1, 1, mixed);
    assert_true(farthest(plain) > 1);
    assert_true(farthest(mixed) < 1e-6);
    free(plain);
    free(mixed);
}

static void bits_are_the_same(void **state) {
    (void)state;
    double *one = calloc(N, sizeof *one), *three = calloc(N, sizeof *three);
    assert_true(one && three);
    go(5, 1, 1, one);
    go(5, 1, 3, three);
    assert_memory_equal(one, three, N * sizeof *one);
    free(one);
    free(three);
}

/** A first step, and one that does not move, are left as they are. */
static void nothing_is_told_by_one_step(void **state) {
    (void)state;
    pl_mixing m;
    double *x = calloc(N, sizeof *x), *end = calloc(N, sizeof *end),
           *copy = calloc(N, sizeof *copy);
    assert_true(x && end && copy);
    assert_int_equal(pl_mixing_create(N, 1, &m), 1);
    step(x, end);
    memcpy(copy, end, N * sizeof *end);
    assert_int_equal(pl_mixing_mix(&m, x, end), 0);
    assert_memory_equal(end, copy, N * sizeof *end);
    assert_int_equal(pl_mixing_mix(&m, x, end), 0); /* the same again */
    assert_memory_equal(end, copy, N * sizeof *end);
    pl_mixing_forget(&m);
    assert_int_equal(pl_mixing_mix(&m, x, end), 0);
    pl_mixing_destroy(&m);
    free(x);
    free(end);
    free(copy);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(affine_steps_lead_to_the_end),
        cmocka_unit_test(bits_are_the_same),
        cmocka_unit_test(nothing_is_told_by_one_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
