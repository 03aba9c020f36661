/* Exact sums: against integers of any length (GMP), and in any order. */
#include "base/sum.h"

#include "base/parallel.h"
#include "support/effort.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#ifdef PLANISH_HAVE_GMP
#include <gmp.h>
#endif

enum { MOST = 64, N = 20000 };

static double sum_of(const double *x, int64_t n) {
    pl_sum sum = {{0}, 0, 0, 0, 0};
    for (int64_t i = 0; i < n; i++)
        pl_sum_add(&sum, x[i]);
    return pl_sum_value(&sum);
}

static void assert_same(double a, double b) {
    assert_memory_equal(&a, &b, sizeof a);
}

/* ---- terms --------------------------------------------------------------------------------- */

enum { ALIKE, ANY_SIZE, CANCELLING, SUBNORMAL, POWERS, LARGE, N_KINDS };

static double draw(int kind, uint64_t *state) {
    const double unit = random_between(state, -1, 1);
    switch (kind) {
    case ANY_SIZE:
        return ldexp(unit, (int)random_below(state, 2040) - 1060);
    case CANCELLING:
        return ldexp(unit, (int)random_below(state, 120) - 60);
    case SUBNORMAL:
        return ldexp(floor(8 * unit), -1074 + (int)random_below(state, 60));
    case POWERS:
        return ldexp(unit < 0 ? -1 : 1, (int)random_below(state, 110));
    case LARGE:
        return unit * DBL_MAX;
    default:
        return unit;
    }
}

/* ---- the nearest double -------------------------------------------------------------------- */

#ifdef PLANISH_HAVE_GMP

/** n terms, at most MOST; CANCELLING: but for some, each comes with its opposite. */
static int64_t draw_terms(int kind, uint64_t *state, double *x) {
    const int64_t n = random_below(state, MOST + 1);
    for (int64_t i = 0; i < n; i++)
        x[i] = kind == CANCELLING && i % 2 == 1 && i % 9 != 0 ? -x[i - 1] : draw(kind, state);
    return n;
}

/** x as a multiple of 2^-1074. */
static void set_units(mpz_t units, double x) {
    int exponent;
    const double mantissa = frexp(x, &exponent); /* x = integer * 2^(exponent - 53) */
    mpz_set_d(units, ldexp(mantissa, 53));
    if (exponent - 53 + 1074 >= 0)
        mpz_mul_2exp(units, units, (mp_bitcnt_t)(exponent - 53 + 1074));
    else
        mpz_tdiv_q_2exp(units, units, (mp_bitcnt_t)(53 - 1074 - exponent)); /* exact */
}

static int last_bit(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (int)(bits & 1);
}

/** No neighbour of value is nearer to sum, nor as near with an even mantissa; both sums in units.
 */
static void assert_nearest(const mpz_t sum, double value) {
    mpz_t here, there;
    mpz_inits(here, there, NULL);
    for (int side = -1; side <= 1; side += 2) {
        const double other = nextafter(value, side < 0 ? -INFINITY : INFINITY);
        if (isinf(other))
            continue;
        set_units(here, value);
        set_units(there, other);
        mpz_sub(here, here, sum);
        mpz_sub(there, there, sum);
        const int order = mpz_cmpabs(here, there);
        assert_true(order < 0 || (order == 0 && !last_bit(value)));
    }
    mpz_clears(here, there, NULL);
}

static void sums_are_rounded_once(void **state) {
    (void)state;
    uint64_t random = effort_seed(1);
    int64_t n_finite = 0;
    mpz_t sum, term;
    mpz_inits(sum, term, NULL);
    for (int64_t i = 0; i < effort(N, 100 * N); i++) {
        double x[MOST];
        const int64_t n = draw_terms((int)(i % N_KINDS), &random, x);
        const double value = sum_of(x, n);
        mpz_set_ui(sum, 0);
        for (int64_t k = 0; k < n; k++) {
            set_units(term, x[k]);
            mpz_add(sum, sum, term);
        }
        if (isinf(value)) { /* half of a unit in the last place more than the largest double */
            set_units(term, DBL_MAX);
            assert_true(mpz_cmpabs(sum, term) > 0 && (mpz_sgn(sum) > 0) == (value > 0));
            continue;
        }
        assert_nearest(sum, value);
        n_finite++;
    }
    mpz_clears(sum, term, NULL);
    assert_true(n_finite > N / 2);
}

#else

static void sums_are_rounded_once(void **state) {
    (void)state;
    skip(); /* GMP is missing */
}

#endif

static void ties_go_to_even(void **state) {
    (void)state;
    const double even = 1, odd = 1 + DBL_EPSILON, half = DBL_EPSILON / 2, little = 0x1p-1074;
    assert_true(sum_of((double[]){even, half}, 2) == even);
    assert_true(sum_of((double[]){odd, half}, 2) == 1 + 2 * DBL_EPSILON);
    assert_true(sum_of((double[]){even, half, little}, 3) == odd);
    assert_true(sum_of((double[]){odd, half, -little}, 3) == odd);
    assert_true(sum_of((double[]){-even, -half, -little}, 3) == -odd);
}

/* ---- in any order -------------------------------------------------------------------------- */

static void shuffle(double *x, int64_t n, uint64_t *random) {
    for (int64_t i = n - 1; i > 0; i--) {
        const int64_t k = random_below(random, i + 1);
        const double kept = x[i];
        x[i] = x[k];
        x[k] = kept;
    }
}

typedef struct shared_sum {
    const double *x;
    pl_sum sum;
} shared_sum;

static void add_chunk(void *context, int64_t begin, int64_t end, int thread) {
    shared_sum *s = context;
    pl_sum part = {{0}, 0, 0, 0, 0};
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        pl_sum_add(&part, s->x[i]);
    pl_sum_merge(&s->sum, &part);
}

/** Also where digits have to be carried now and then. */
static void order_and_threads_change_no_bit(void **state) {
    (void)state;
    static double x[N];
    uint64_t random = effort_seed(2);
    for (int kind = 0; kind < LARGE; kind++) {
        for (int64_t i = 0; i < N; i++)
            x[i] = kind == ALIKE ? 2 - DBL_EPSILON : draw(kind, &random);
        const double sum = sum_of(x, N);
        for (int threads = 1; threads <= 8; threads++) {
            shared_sum s = {.x = x};
            shuffle(x, N, &random);
            assert_same(sum_of(x, N), sum);
            pl_parallel_for(threads, N, 7, add_chunk, &s);
            assert_same(pl_sum_value(&s.sum), sum);
        }
    }
}

/* ---- not finite ---------------------------------------------------------------------------- */

static void what_is_not_finite_shows(void **state) {
    (void)state;
    assert_same(sum_of(NULL, 0), 0);
    assert_same(sum_of((double[]){1, -1}, 2), 0);
    assert_true(sum_of((double[]){1, INFINITY, 2}, 3) == INFINITY);
    assert_true(sum_of((double[]){1, -INFINITY, 2}, 3) == -INFINITY);
    assert_true(isnan(sum_of((double[]){INFINITY, 1, -INFINITY}, 3)));
    assert_true(isnan(sum_of((double[]){NAN, 1, INFINITY}, 3)));
    assert_true(sum_of((double[]){DBL_MAX, DBL_MAX}, 2) == INFINITY);
    assert_true(sum_of((double[]){-DBL_MAX, -DBL_MAX}, 2) == -INFINITY);
    assert_true(sum_of((double[]){DBL_MAX, DBL_MAX, -DBL_MAX}, 3) == DBL_MAX); /* on the way only */
    shared_sum s = {.x = (double[]){-INFINITY}};
    add_chunk(&s, 0, 1, 0);
    assert_true(pl_sum_value(&s.sum) == -INFINITY);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_are_rounded_once),
        cmocka_unit_test(ties_go_to_even),
        cmocka_unit_test(order_and_threads_change_no_bit),
        cmocka_unit_test(what_is_not_finite_shows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
