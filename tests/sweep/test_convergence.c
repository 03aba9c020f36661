/* When sweeps end: three calm ones in a row, and little to come. */
#include "sweep/sweep.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

/** Sweeps until convergence when each brings ratio times the fall of the one before. */
static int sweeps_until(double first_fall, double ratio, double tolerance) {
    pl_convergence convergence = {{0}, 0};
    double rms = 1, fall = first_fall;
    for (int sweep = 1; sweep < 10000; sweep++) {
        double after = rms * (1 - fall);
        if (pl_converged(&convergence, rms, after, tolerance))
            return sweep;
        rms = after;
        fall *= ratio;
    }
    return 10000;
}

static void three_calm_sweeps_are_needed(void **state) {
    (void)state;
    assert_int_equal(sweeps_until(0, 1, 1e-5), 3);
    /* falls 0.1, 0.01, ...: below 1e-5 from the sixth on */
    assert_int_equal(sweeps_until(0.1, 0.1, 2e-6), 8);
}

static void one_busy_sweep_begins_anew(void **state) {
    (void)state;
    pl_convergence convergence = {{0}, 0};
    static const double falls[] = {0, 0, 0.1, 0, 0, 0};
    for (int i = 0; i < 6; i++)
        assert_int_equal(pl_converged(&convergence, 1, 1 - falls[i], 1e-5), i == 5);
}

/** Small falls that hardly shrink are a slow mode, not convergence. */
static void slow_falls_are_not_convergence(void **state) {
    (void)state;
    pl_convergence convergence = {{0}, 0};
    for (int i = 0; i < 100; i++)
        assert_int_equal(pl_converged(&convergence, 1, 1 - 0.9e-5, 1e-5), 0);
    assert_true(sweeps_until(0.9e-5, 0.9995, 1e-5) > 500);
}

static void nothing_left_is_convergence(void **state) {
    (void)state;
    pl_convergence convergence = {{0}, 0};
    for (int i = 0; i < 3; i++)
        assert_int_equal(pl_converged(&convergence, 0, 0, 0), i == 2);
}

/** Falls k^-p of n sweeps. */
static pl_convergence falls_of_power(double p, int n) {
    pl_convergence convergence = {{0}, 0};
    for (int k = 1; k <= n; k++)
        pl_converged(&convergence, 1, 1 - 0.1 * pow(k, -p), 0);
    return convergence;
}

/** The forecast agrees with the sum of falls that go on as a power of the sweeps. */
static void falls_of_a_power_are_forecast(void **state) {
    (void)state;
    for (int n = 5; n <= 40; n += 5)
        for (double p = 1.5; p <= 3; p += 0.5) {
            const pl_convergence convergence = falls_of_power(p, n);
            double sum = 0;
            for (int k = 100000; k > n + 24; k--)
                sum += 0.1 * pow(k, -p);
            sum += 0.1 * pow(100000, 1 - p) / (p - 1);
            assert_true(fabs(pl_left_after(&convergence, 24) / sum - 1) < 0.2);
        }
}

static void falls_without_end_are_forecast(void **state) {
    (void)state;
    const pl_convergence slow = falls_of_power(0.9, 10);
    const pl_convergence constant = {{1e-5, 1e-5, 1e-5}, 10}, none = {{1e-5, 1e-5, 0}, 10};
    assert_true(isinf(pl_left_after(&slow, 24)));
    assert_true(isinf(pl_left_after(&constant, 24)));
    assert_true(pl_left_after(&none, 24) == 0);
}

/** Falls that were measured: errors of single nodes spread out soon, those of a whole mesh do not. */
static void rough_meshes_are_told_from_slow_ones(void **state) {
    (void)state;
    static const pl_convergence rough[] = {
        {{2.9e-3, 1.19e-3, 5.15e-4}, 5},   /* a million tetrahedra */
        {{1.19e-3, 4.32e-4, 1.96e-4}, 6},  /* 100,000 tetrahedra */
        {{9.86e-5, 6.95e-5, 4.95e-5}, 7}}; /* 20,000 triangles */
    static const pl_convergence slow[] = {
        {{9.38e-3, 6.96e-3, 5.51e-3}, 6},   /* 100,000 tetrahedra, twisted */
        {{7.76e-3, 5.03e-3, 3.43e-3}, 6},   /* with nodes that slide */
        {{1.79e-5, 1.56e-5, 1.44e-5}, 11}}; /* 250,000 quadrilaterals of a curved box */
    for (int i = 0; i < 3; i++) {
        assert_true(pl_left_after(&rough[i], 24) < 1e-4);
        assert_true(pl_left_after(&slow[i], 24) > 1e-3);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(three_calm_sweeps_are_needed),
        cmocka_unit_test(one_busy_sweep_begins_anew),
        cmocka_unit_test(slow_falls_are_not_convergence),
        cmocka_unit_test(nothing_left_is_convergence),
        cmocka_unit_test(falls_of_a_power_are_forecast),
        cmocka_unit_test(falls_without_end_are_forecast),
        cmocka_unit_test(rough_meshes_are_told_from_slow_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
