/* Tests of src/geometry/arc_cosine.h against the C library's angle in long double. */
#include "geometry/arc_cosine.h"

#include "support/meshes.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>

static double error_of(double cosine) {
    const long double angle = acosl((long double)cosine);
    return (double)fabsl(((long double)pl_arc_cosine(cosine) - angle) / angle);
}

static void is_within_1e_15(void **state) {
    (void)state;
    unsigned seed = 2;
    double worst = 0;
    for (int repeat = 0; repeat < 200000; repeat++) {
        const double tiny = exp2(-52 * test_random(&seed));
        worst = fmax(worst, error_of(2 * test_random(&seed) - 1));
        worst = fmax(worst, fmax(error_of(1 - tiny), error_of(tiny - 1)));
        worst = fmax(worst, fmax(error_of(tiny), error_of(-tiny)));
    }
    assert_true(worst > 1e-16 && worst < 1e-15);
}

static void knows_its_ends(void **state) {
    (void)state;
    const double pi = 3.14159265358979323846;
    assert_true(pl_arc_cosine(1) == 0 && pl_arc_cosine(-1) == pi);
    assert_true(pl_arc_cosine(0) == pi / 2);
    assert_true(pl_arc_cosine(1 + 1e-15) == 0 && pl_arc_cosine(-1 - 1e-15) == pi);
    assert_true(error_of(0.5) < 1e-15 && error_of(nextafter(0.5, 1)) < 1e-15);
    assert_true(error_of(-0.5) < 1e-15 && error_of(nextafter(-0.5, -1)) < 1e-15);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(is_within_1e_15),
        cmocka_unit_test(knows_its_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
