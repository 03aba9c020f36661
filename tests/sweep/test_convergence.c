/* When sweeps end: three calm ones in a row, and little to come. */
#include "sweep/sweep.h"

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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(three_calm_sweeps_are_needed),
        cmocka_unit_test(one_busy_sweep_begins_anew),
        cmocka_unit_test(slow_falls_are_not_convergence),
        cmocka_unit_test(nothing_left_is_convergence),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
