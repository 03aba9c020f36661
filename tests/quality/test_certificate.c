/* Tests of src/quality/certificate.c and exact.c against two other exact evaluations: integers of
 * 128 bits, and a fixed-point sum of all products of coordinates, wide enough for any doubles. */
#include "quality/certificate.h"

#include "support/meshes.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

typedef double points[4][3];

static int sign_of(int dim, const points x) {
    const double *vertex[4] = {x[0], x[1], x[2], x[3]};
    return pl_measure_sign(dim, vertex);
}

/* ---- References ----------------------------------------------------------------------------- */

__extension__ typedef __int128 int128;
__extension__ typedef unsigned __int128 uint128;

/** For integer coordinates below 2^36. */
static int integer_sign(int dim, const points x) {
    int128 e[3][3] = {{0}};
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = (int128)x[j + 1][d] - (int128)x[0][d];
    if (dim == 2)
        e[2][2] = 1;
    int128 det = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                 e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                 e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    return (det > 0) - (det < 0);
}

enum { FIXED_LIMBS = 212, FIXED_POINT = 3 * 1130 }; /* 2^-3390 up to 2^3394 */

/** limb += value * 2^bit. */
static void fixed_add(uint32_t limb[FIXED_LIMBS], uint128 value, int bit) {
    int i = bit / 32;
    uint64_t carry = 0;
    uint128 rest = value >> (32 - bit % 32); /* after the lowest limb */
    carry = (uint64_t)limb[i] + (uint32_t)((uint64_t)value << bit % 32);
    limb[i++] = (uint32_t)carry;
    for (carry >>= 32; carry || rest; rest >>= 32) {
        carry += (uint64_t)limb[i] + (uint32_t)rest;
        limb[i++] = (uint32_t)carry;
        carry >>= 32;
    }
}

/** |a b c| into limb. */
static void fixed_add_product(uint32_t limb[FIXED_LIMBS], double a, double b, double c) {
    const double factor[3] = {a, b, c};
    uint64_t half[3][2]; /* mantissas as 26 + 27 bits */
    int bit = FIXED_POINT;
    for (int i = 0; i < 3; i++) {
        int exponent;
        uint64_t mantissa = (uint64_t)ldexp(frexp(fabs(factor[i]), &exponent), 53);
        half[i][0] = mantissa & ((1u << 27) - 1);
        half[i][1] = mantissa >> 27;
        bit += exponent - 53;
    }
    for (int i = 0; i < 8; i++) {
        uint128 product = (uint128)(half[0][i & 1] * half[1][i >> 1 & 1]) * half[2][i >> 2];
        fixed_add(limb, product, bit + 27 * ((i & 1) + (i >> 1 & 1) + (i >> 2)));
    }
}

/** By the determinant of the rows (1, x_j), all (dim + 1)! products of it. */
static int fixed_point_sign(int dim, const points x) {
    static uint32_t sum[2][FIXED_LIMBS]; /* of the positive and of the negative products */
    memset(sum, 0, sizeof sum);
    const int n = dim + 1;
    for (int code = 0; code < n * n * n * n; code++) {
        int p[4] = {code % n, code / n % n, code / (n * n) % n, code / (n * n * n)};
        if (dim == 2 && p[3] != 0)
            continue;
        int odd = 0, repeats = 0;
        for (int i = 0; i < n; i++)
            for (int j = i + 1; j < n; j++) {
                odd ^= p[i] > p[j];
                repeats |= p[i] == p[j];
            }
        double a = x[p[1]][0], b = x[p[2]][1], c = dim == 3 ? x[p[3]][2] : 1;
        if (repeats || a == 0 || b == 0 || c == 0)
            continue;
        odd ^= (a < 0) ^ (b < 0) ^ (c < 0);
        fixed_add_product(sum[odd], a, b, c);
    }
    for (int i = FIXED_LIMBS - 1; i >= 0; i--)
        if (sum[0][i] != sum[1][i])
            return sum[0][i] > sum[1][i] ? 1 : -1;
    return 0;
}

/* ---- Elements ------------------------------------------------------------------------------- */

/** An integer of magnitude below bound. */
static double random_integer(unsigned *seed, double bound) {
    return rint((2 * test_random(seed) - 1) * (bound - 1));
}

/** Vertices of a degenerate element with integer coordinates below 2^36; the last is then moved by
 *  at most 1. */
static void nearly_degenerate(int dim, unsigned *seed, points x) {
    memset(x, 0, sizeof(points));
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            x[j][d] = random_integer(seed, 0x1p30);
    double s = random_integer(seed, 16), t = dim == 3 ? random_integer(seed, 16) : 0;
    for (int d = 0; d < dim; d++) {
        double b = x[1][d] - x[0][d], c = dim == 3 ? x[2][d] - x[0][d] : 0;
        x[dim][d] = x[0][d] + s * b + t * c + random_integer(seed, 2.6);
    }
}

/** A double of any sign with an exponent from low to high, a few bits or all of them. */
static double random_double(unsigned *seed, int low, int high) {
    double mantissa = 2 * test_random(seed) - 1;
    if (test_random(seed) < 0.5)
        mantissa = rint(mantissa * 8) / 8;
    return ldexp(mantissa, low + (int)(test_random(seed) * (high - low + 1)));
}

/** A repeated coordinate or vertex makes exact zeros and cancellation common. */
static void random_points(int dim, unsigned *seed, int low, int high, points x) {
    memset(x, 0, sizeof(points));
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++) {
            int repeat = j > 0 && test_random(seed) < 0.3;
            x[j][d] = repeat ? x[j - 1][d] : random_double(seed, low, high);
        }
}

/* ---- Tests ---------------------------------------------------------------------------------- */

static void agrees_with_integers(void **state) {
    (void)state;
    unsigned seed = 1;
    int count[3] = {0};
    for (int dim = 2; dim <= 3; dim++)
        for (int repeat = 0; repeat < 20000; repeat++) {
            points x;
            nearly_degenerate(dim, &seed, x);
            int expected = integer_sign(dim, x);
            count[expected + 1]++;
            assert_int_equal(fixed_point_sign(dim, x), expected);
            assert_int_equal(sign_of(dim, x), expected);
        }
    for (int i = 0; i < 3; i++)
        assert_true(count[i] > 1000);
}

/** Points on the plane x + y + z = 1/2 (line x + y = 1/2) but for the last bits: around 40 bits of
 * D cancel, and no difference is exact. */
static void agrees_where_rounding_decides(void **state) {
    (void)state;
    unsigned seed = 2;
    for (int dim = 2; dim <= 3; dim++)
        for (int repeat = 0; repeat < 20000; repeat++) {
            points x;
            memset(x, 0, sizeof x);
            for (int j = 0; j <= dim; j++) {
                double rest = 0.5;
                for (int d = 0; d < dim - 1; d++) {
                    x[j][d] = test_random(&seed) / 3 + 1e-9 * test_random(&seed);
                    rest -= x[j][d];
                }
                x[j][dim - 1] = rest;
            }
            assert_int_equal(sign_of(dim, x), fixed_point_sign(dim, x));
        }
}

static void agrees_over_all_exponents(void **state) {
    (void)state;
    static const int range[][2] = {{-3, 3},       {-60, 60},      {-400, 400},  {-1074, 1023},
                                   {-1074, -960}, {-1074, -1050}, {1000, 1023}, {-1074, 0}};
    unsigned seed = 3;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 8; k++)
            for (int repeat = 0; repeat < 2000; repeat++) {
                points x;
                random_points(dim, &seed, range[k][0], range[k][1], x);
                assert_int_equal(sign_of(dim, x), fixed_point_sign(dim, x));
            }
}

/** A needle 1e300 long whose orientation is in coordinates of 1e-300; and the like. */
static void knows_extreme_elements(void **state) {
    (void)state;
    points needle = {{0, 0, 0}, {1e300, 0, 0}, {1e300, 1e-300, 0}, {-1e300, 1e-300, 1e-300}};
    assert_int_equal(sign_of(3, needle), 1);
    needle[3][2] = -5e-324;
    assert_int_equal(sign_of(3, needle), -1);
    needle[3][2] = 0;
    assert_int_equal(sign_of(3, needle), 0);
    points tiny = {{0}, {5e-324}, {0, 5e-324}, {0, 0, 5e-324}};
    assert_int_equal(sign_of(3, tiny), 1);
    assert_int_equal(sign_of(2, tiny), 1);
    points huge = {{-DBL_MAX, -DBL_MAX, -DBL_MAX},
                   {DBL_MAX, -DBL_MAX, -DBL_MAX},
                   {-DBL_MAX, DBL_MAX, -DBL_MAX},
                   {-DBL_MAX, -DBL_MAX, DBL_MAX}};
    assert_int_equal(sign_of(3, huge), 1);
    assert_int_equal(sign_of(2, huge), 1);
    /* In units of 2^-1074, D is 0.4 + 0.4 - 0.6, which underflow makes 0 + 0 - 1. */
    points underflow = {
        {0, 0, 0}, {1, 1, 1}, {1.5 * 0x1p-537, 0, 0x1p-537}, {0.4 * 0x1p-537, -0.4 * 0x1p-537, 0}};
    assert_int_equal(sign_of(3, underflow), 1);
    /* Far from the origin, flat but for one unit in the last place of one coordinate. */
    points far = {{1e6, 1e6, 1e6}, {1e6 + 1, 1e6, 1e6}, {1e6, 1e6 + 1, 1e6}, {1e6, 1e6, 1e6}};
    assert_int_equal(sign_of(3, far), 0);
    far[3][2] = nextafter(1e6, 2e6);
    assert_int_equal(sign_of(3, far), 1);
    far[3][2] = nextafter(1e6, 0);
    assert_int_equal(sign_of(3, far), -1);
}

static void not_finite_is_not_positive(void **state) {
    (void)state;
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    for (int k = 0; k < 3; k++)
        for (int dim = 2; dim <= 3; dim++)
            for (int i = 0; i < dim * (dim + 1); i++) {
                points x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
                x[i / dim][i % dim] = bad[k];
                assert_int_equal(sign_of(dim, x), 0);
            }
}

/** Every exchange of two vertices turns the sign, whatever the element. */
static void exchanges_turn_the_sign(void **state) {
    (void)state;
    unsigned seed = 5;
    for (int dim = 2; dim <= 3; dim++)
        for (int repeat = 0; repeat < 2000; repeat++) {
            points x;
            if (repeat % 2)
                nearly_degenerate(dim, &seed, x);
            else
                random_points(dim, &seed, -300, 300, x);
            int sign = sign_of(dim, x);
            for (int step = 0; step < 12; step++) {
                int i = step % dim, j = i + 1 + step / 3 % (dim - i);
                double kept[3];
                memcpy(kept, x[i], sizeof kept);
                memcpy(x[i], x[j], sizeof kept);
                memcpy(x[j], kept, sizeof kept);
                sign = -sign;
                assert_int_equal(sign_of(dim, x), sign);
            }
        }
}

/** Where the plain formula is lost in rounding, the determinant still has all its digits. */
static void small_determinants_are_accurate(void **state) {
    (void)state;
    unsigned seed = 6;
    for (int repeat = 0; repeat < 1000; repeat++) {
        double height = ldexp(1 + test_random(&seed), -60 - (int)(test_random(&seed) * 1000));
        points x = {{0, 0, 0}, {1, 3, 7}, {3, 7, 11}, {4, 10, 18}};
        x[0][0] = -height; /* v1 + v2 = v3, so D is height times det[(1, y_j, z_j)] = 16 */
        const double *vertex[4] = {x[0], x[1], x[2], x[3]};
        int exponent;
        double m = pl_certified_determinant(3, vertex, &exponent);
        double expected = 16 * height;
        assert_true(fabs(ldexp(m, exponent) - expected) <= 2 * DBL_EPSILON * expected);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_integers),
        cmocka_unit_test(agrees_where_rounding_decides),
        cmocka_unit_test(agrees_over_all_exponents),
        cmocka_unit_test(knows_extreme_elements),
        cmocka_unit_test(not_finite_is_not_positive),
        cmocka_unit_test(exchanges_turn_the_sign),
        cmocka_unit_test(small_determinants_are_accurate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
