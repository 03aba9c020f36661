/* Tests of src/geometry/cube_root.h against the C library's root in long double. */
#include "geometry/cube_root.h"

#include "support/meshes.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>

/** Error of the root of x, in units of the last place of the root. */
static double error_of(double x) {
    const long double root = cbrtl((long double)x);
    const double rounded = (double)root;
    const double unit = nextafter(rounded, INFINITY) - rounded;
    return (double)fabsl(((long double)pl_cube_root(x) - root) / (long double)unit);
}

static void is_within_two_units(void **state) {
    (void)state;
    unsigned seed = 5;
    double worst = 0;
    for (int exponent = -1074; exponent <= 1023; exponent++)
        for (int repeat = 0; repeat < 500; repeat++)
            worst = fmax(worst, error_of(ldexp(1 + test_random(&seed), exponent)));
    assert_true(worst > 0.5 && worst <= 1.2);
}

/** Where the guess is worst and where the exponent's third turns over. */
static void holds_at_the_ends_of_binades(void **state) {
    (void)state;
    for (int exponent = -1074; exponent <= 1023; exponent++) {
        const double x = ldexp(1, exponent);
        assert_true(error_of(x) <= 1.2);
        assert_true(error_of(nextafter(x, INFINITY)) <= 1.2);
        assert_true(exponent == -1074 || error_of(nextafter(x, 0)) <= 1.2);
    }
    assert_true(error_of(DBL_MAX) <= 1.2 && error_of(DBL_TRUE_MIN) <= 1.2);
}

static void knows_zero_and_cubes(void **state) {
    (void)state;
    assert_true(pl_cube_root(0) == 0);
    for (int i = 1; i <= 100; i++)
        assert_true(pl_cube_root((double)i * i * i) == i);
}

/** A scale of 2^3k makes one of 2^k. */
static void scales_exactly(void **state) {
    (void)state;
    unsigned seed = 6;
    for (int k = -300; k <= 300; k += 7) {
        const double x = 1 + 7 * test_random(&seed);
        assert_true(pl_cube_root(ldexp(x, 3 * k)) == ldexp(pl_cube_root(x), k));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(is_within_two_units),
        cmocka_unit_test(holds_at_the_ends_of_binades),
        cmocka_unit_test(knows_zero_and_cubes),
        cmocka_unit_test(scales_exactly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
