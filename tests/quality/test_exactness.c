/* What is decided exactly, against integers of any length (GMP), on elements that are flat or
 * nearly so: signs, what planish_measure counts and calls the minimum volume, which elements have
 * no radius ratio, are below their minimum volume, or cannot be positive.
 *
 * An element counts as undecided if |D| is below Shewchuk's bound of the plain formula's rounding
 * error: at about so many the certificate needs its integers. */
#include "quality/certificate.h"

#include "support/degenerate.h"
#include "support/effort.h"

#include <planish/planish.h>

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

enum { BATCH = 2048 }; /* elements that make a mesh */

/* The plain formula's error by its permanent, in space: (7 + 56 u) u; and a few units in the last
 * place. */
static const long double ROUNDING = 7.00001L * 0x1p-53L, UNITS = 4 * 0x1p-53L;
/* The same by the product of the edges' sums of components, and a little more, as the library
 * bounds it where it cares for speed. */
static const long double COARSE_ROUNDING = 9 * 0x1p-53L;

/* ---- exact determinants --------------------------------------------------------------------- */

/** Numbers that keep their memory from element to element. */
static mpz_t vertex_numbers[4][3], edge_numbers[3][3], first, second, exact;

static void numbers_create(void) {
    for (int i = 0; i < 12; i++)
        mpz_init(vertex_numbers[i / 3][i % 3]);
    for (int i = 0; i < 9; i++)
        mpz_init(edge_numbers[i / 3][i % 3]);
    mpz_inits(first, second, exact, NULL);
}

static void numbers_clear(void) {
    for (int i = 0; i < 12; i++)
        mpz_clear(vertex_numbers[i / 3][i % 3]);
    for (int i = 0; i < 9; i++)
        mpz_clear(edge_numbers[i / 3][i % 3]);
    mpz_clears(first, second, exact, NULL);
}

/** first = a d - b c. */
static void find_minor(mpz_t a, mpz_t b, mpz_t c, mpz_t d) {
    mpz_mul(first, a, d);
    mpz_submul(first, b, c);
}

/** exact = D of the edges. */
static void find_determinant(int dim) {
    mpz_t(*e)[3] = edge_numbers;
    if (dim == 2) {
        find_minor(e[0][0], e[0][1], e[1][0], e[1][1]);
        mpz_set(exact, first);
        return;
    }
    mpz_set_ui(exact, 0);
    for (int d = 0; d < 3; d++) {
        const int next = (d + 1) % 3, last = (d + 2) % 3;
        find_minor(e[1][next], e[1][last], e[2][next], e[2][last]);
        mpz_addmul(exact, e[0][d], first);
    }
}

/** The coordinates as whole numbers of 2^(what is returned). */
static int find_numbers(int dim, double x[4][3]) {
    int unit = DBL_MAX_EXP, exponent;
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++) {
            frexp(x[j][d], &exponent);
            if (x[j][d] != 0)
                unit = exponent - DBL_MANT_DIG < unit ? exponent - DBL_MANT_DIG : unit;
        }
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++) {
            mpz_set_d(vertex_numbers[j][d], ldexp(frexp(x[j][d], &exponent), DBL_MANT_DIG));
            if (x[j][d] != 0)
                mpz_mul_2exp(vertex_numbers[j][d], vertex_numbers[j][d],
                             (mp_bitcnt_t)(exponent - DBL_MANT_DIG - unit));
        }
    return unit;
}

/** What is known of an element; long double has the range. */
typedef struct truth {
    int sign;
    long double determinant; /* D to a unit in the last place of a double */
    long double permanent;   /* sum of the absolute products in D */
    long double coarse;      /* product of the edges' sums of absolute components */
    long double lost;        /* what underflow may take from a determinant in the element's scale */
} truth;

/** Of the edges, in units. */
static long double permanent_of(int dim, long double e[3][3]) {
    if (dim == 2)
        return e[0][0] * e[1][1] + e[0][1] * e[1][0];
    long double sum = 0;
    for (int d = 0; d < 3; d++) {
        const int next = (d + 1) % 3, last = (d + 2) % 3;
        sum += e[0][d] * (e[1][next] * e[2][last] + e[1][last] * e[2][next]);
    }
    return sum;
}

static truth truth_of(int dim, double x[4][3]) {
    const int unit = find_numbers(dim, x);
    truth t = {.coarse = 1};
    long double e[3][3], largest = 0;
    long exponent;
    for (int j = 0; j < dim; j++) {
        long double norm = 0;
        for (int d = 0; d < dim; d++) {
            mpz_sub(edge_numbers[j][d], vertex_numbers[j + 1][d], vertex_numbers[0][d]);
            e[j][d] = fabsl((long double)x[j + 1][d] - (long double)x[0][d]);
            norm += e[j][d];
            largest = fmaxl(largest, e[j][d]);
        }
        t.coarse *= norm;
    }
    find_determinant(dim);
    t.sign = mpz_sgn(exact);
    const double mantissa = mpz_get_d_2exp(&exponent, exact);
    t.determinant = ldexpl(mantissa, (int)exponent + dim * unit);
    t.permanent = permanent_of(dim, e);
    t.lost = 0x1p-960L * powl(largest, dim);
    return t;
}

/* ---- one element ---------------------------------------------------------------------------- */

static void expect(int holds, const char *what, int dim, double x[4][3]) {
    if (holds)
        return;
    print_error("%s:\n", what);
    for (int j = 0; j <= dim; j++)
        print_error("    {%a, %a, %a},\n", x[j][0], x[j][1], x[j][2]);
    fail();
}

/** Sign and value of the certificate. What it says below the plain formula's error bound is not
 * from there, and has all its digits. */
static void check_certificate(int dim, double x[4][3], const truth *t) {
    const double *vertex[4] = {x[0], x[1], x[2], x[3]};
    int exponent;
    const double m = pl_certified_determinant(dim, vertex, &exponent);
    const int sign = pl_measure_sign(dim, vertex);
    expect(sign <= 0 || t->sign > 0, "called valid, and is not", dim, x);
    expect(sign == t->sign && (m > 0) - (m < 0) == t->sign, "the sign is wrong", dim, x);
    const long double value = ldexpl(m, exponent), bound = ROUNDING * t->permanent;
    const long double error = fabsl(value - t->determinant);
    const long double few = UNITS * fabsl(t->determinant);
    expect(error <= bound + few + t->lost, "the determinant is wrong", dim, x);
    if (dim == 3 && fabsl(value) < (1 - 1e-4L) * bound)
        expect(error <= few, "the determinant of integers is not exact", dim, x);
}

/* ---- a mesh of them ------------------------------------------------------------------------- */

/** Elements without common nodes. */
typedef struct batch {
    int dim;
    double x[BATCH][4][3], coordinates[BATCH * 12], reference[BATCH * 12], least[BATCH];
    int32_t elements[BATCH * 4];
    truth of[BATCH];
    planish_plan *plan;
} batch;

/** The same elements, all positive: by these the plan learns their orientation. */
static void set_reference(batch *b) {
    const int dim = b->dim, n = dim + 1;
    for (int i = 0; i < BATCH * n; i++) {
        b->elements[i] = i;
        for (int d = 0; d < dim; d++)
            b->reference[i * dim + d] = 2 * (i / n) + (i % n == d + 1);
    }
}

static void draw(batch *b, degenerate_kind kind, uint64_t *random) {
    const int dim = b->dim;
    for (int i = 0; i < BATCH; i++) {
        degenerate_draw(kind, dim, random, b->x[i]);
        b->of[i] = truth_of(dim, b->x[i]);
        check_certificate(dim, b->x[i], &b->of[i]);
        for (int j = 0; j <= dim; j++)
            memcpy(b->coordinates + (i * (dim + 1) + j) * dim, b->x[i][j],
                   (size_t)dim * sizeof(double));
        /* around the element's own volume, where that is a double */
        const double own = (double)fabsl(b->of[i].determinant) / (dim == 3 ? 6 : 2);
        b->least[i] = fmin(DBL_MAX, fmax(5e-324, own * random_between(random, 0.5, 1.5)));
    }
    const planish_mesh mesh = {.dim = dim,
                               .n_nodes = BATCH * (dim + 1),
                               .n_elements = BATCH,
                               .coordinates = b->reference,
                               .elements = b->elements,
                               .min_volume = b->least};
    planish_options options;
    planish_options_init(&options);
    options.threads = 1;
    assert_int_equal(planish_plan_create(&mesh, &options, &b->plan, NULL), PLANISH_OK);
}

static long double volume(const batch *b, int i) {
    return b->of[i].determinant / (b->dim == 3 ? 6 : 2);
}

/** How far off it may be in a double where the plain formula decides. */
static long double tolerance(const batch *b, int i) {
    return COARSE_ROUNDING * b->of[i].coarse + UNITS * fabsl(volume(b, i)) + 0x1p-1074L;
}

static long double clamped(long double a) {
    return a < -DBL_MAX ? -INFINITY : a > DBL_MAX ? INFINITY : a;
}

/** The number of inverted elements, and the minimum volume. */
static void check_measure(const batch *b) {
    planish_quality quality;
    long double least = INFINITY, most = INFINITY;
    int64_t inverted = 0;
    assert_int_equal(planish_measure(b->plan, b->coordinates, &quality, NULL), PLANISH_OK);
    for (int i = 0; i < BATCH; i++) {
        inverted += b->of[i].sign <= 0;
        least = fminl(least, volume(b, i) - tolerance(b, i));
        most = fminl(most, volume(b, i) + tolerance(b, i));
    }
    assert_int_equal(quality.n_inverted, inverted);
    assert_true(quality.min_volume >= clamped(least) && quality.min_volume <= clamped(most));
    assert_true(inverted == 0 || !(quality.min_volume > 0));
}

/** A radius ratio is 1 or more, and 0 says that there is none. */
static void check_ratios(batch *b) {
    static double ratio[BATCH];
    assert_int_equal(planish_measure_elements(b->plan, b->coordinates, ratio, NULL), PLANISH_OK);
    for (int i = 0; i < BATCH; i++)
        expect(b->of[i].sign > 0 ? ratio[i] >= 1 : ratio[i] == 0, "the radius ratio is wrong",
               b->dim, b->x[i]);
}

/** Elements that are not positive are below any minimum volume; others as their volumes say, but
 * for rounding. */
static void check_volumes(batch *b) {
    static uint8_t state[BATCH];
    int64_t n_below, n = 0;
    assert_int_equal(
        planish_check_volumes(b->plan, b->coordinates, NULL, state, &n_below, NULL, NULL),
        PLANISH_OK);
    for (int i = 0; i < BATCH; i++) {
        const long double doubt = tolerance(b, i), least = b->least[i];
        n += state[i] != PLANISH_VOLUME_MET;
        if (b->of[i].sign <= 0 || volume(b, i) + doubt < 0.996L * least)
            expect(state[i] != PLANISH_VOLUME_MET, "not below its minimum volume", b->dim, b->x[i]);
        else if (volume(b, i) - doubt > 0.998L * least)
            expect(state[i] == PLANISH_VOLUME_MET, "below its minimum volume", b->dim, b->x[i]);
    }
    assert_int_equal(n, n_below);
}

/** No node of theirs is free. */
static void check_unfixable(batch *b) {
    static uint8_t unfixable[BATCH];
    int64_t n;
    assert_int_equal(
        planish_find_infeasible(b->plan, b->coordinates, NULL, unfixable, &n, NULL, NULL),
        PLANISH_OK);
    for (int i = 0; i < BATCH; i++)
        expect(unfixable[i] == (b->of[i].sign <= 0), "what cannot be positive is wrong", b->dim,
               b->x[i]);
}

/** Elements of a kind by what is true of them. */
typedef struct tally {
    int64_t n, positive, flat, undecided;
} tally;

static void count(const batch *b, tally *t) {
    for (int i = 0; i < BATCH; i++) {
        t->n++;
        t->positive += b->of[i].sign > 0;
        t->flat += b->of[i].sign == 0;
        t->undecided += fabsl(b->of[i].determinant) <= ROUNDING * b->of[i].permanent;
    }
}

static double percent(int64_t part, int64_t whole) {
    return 100 * (double)part / (double)whole;
}

static void everything_exact_is(void **state) {
    static batch b;
    const int dim = *(int *)*state;
    const int64_t meshes = effort(2, 500);
    tally all = {0};
    numbers_create();
    b = (batch){.dim = dim};
    set_reference(&b);
    for (degenerate_kind kind = 0; kind < DEGENERATE_KINDS; kind++) {
        uint64_t random = effort_seed((uint64_t)(10 * dim + (int)kind));
        tally t = {0};
        for (int64_t i = 0; i < meshes; i++) {
            draw(&b, kind, &random);
            check_measure(&b);
            check_ratios(&b);
            check_volumes(&b);
            check_unfixable(&b);
            count(&b, &t);
            planish_plan_destroy(b.plan);
        }
        assert_true(t.positive > t.n / 100 || kind == DEGENERATE_FLAT);
        figure("%d-D %-20s %8lld elements, %4.1f %% positive, %5.1f %% flat, %5.1f %% undecided by "
               "the plain formula",
               dim, degenerate_name[kind], (long long)t.n, percent(t.positive, t.n),
               percent(t.flat, t.n), percent(t.undecided, t.n));
        all.n += t.n;
        all.undecided += t.undecided;
    }
    figure("%d-D: %lld elements, 0 wrong", dim, (long long)all.n);
    assert_true(all.undecided > all.n / 10);
    numbers_clear();
}

#else

static void everything_exact_is(void **state) {
    (void)state;
    print_message("built without GMP\n");
    skip();
}

#endif

int main(void) {
    static int two = 2, three = 3;
    const struct CMUnitTest tests[] = {
        {"exact 2-D", everything_exact_is, NULL, NULL, &two},
        {"exact 3-D", everything_exact_is, NULL, NULL, &three},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
