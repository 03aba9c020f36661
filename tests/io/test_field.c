/* Numbers in fields of few characters: nothing that fits is nearer, and rounding is what is
 * written.
 */
#include "io/core/number.h"
#include "io/core/text.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { RANDOM_NUMBERS = 200000, SEARCHED_NUMBERS = 4000, TEXT_SIZE = 64 };

static const int widths[] = {8, 16, 20};
enum { N_WIDTHS = sizeof widths / sizeof *widths };

static uint64_t random_bits(uint64_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static double random_unit(uint64_t *state) {
    return (double)(random_bits(state) >> 11) / 9007199254740992.0;
}

/** Of all magnitudes, of common ones, of few digits, and beside powers of ten. */
static double random_number(uint64_t *state) {
    const uint64_t bits = random_bits(state);
    const double sign = bits & 1 ? -1 : 1;
    double value;
    switch (bits >> 1 & 7) {
    case 0:
        memcpy(&value, &bits, sizeof value);
        return isfinite(value) ? value : DBL_MAX;
    case 1:
        return sign * pow(10, -330 + 638 * random_unit(state)) * (1 + 0.7 * random_unit(state));
    case 2:
        return sign * round(1e5 * random_unit(state)) / 1e3;
    case 3:
        value = pow(10, floor(-20 + 40 * random_unit(state)));
        return sign * value * (1 + (double)((int)(bits >> 8 & 7) - 3) * DBL_EPSILON);
    case 4: /* halfway between two numbers of few digits */
        return sign * (floor(1e6 * random_unit(state)) + 0.5) / pow(2, (double)(bits >> 8 & 15));
    case 5: /* 9.99... */
        value = pow(10, floor(-12 + 30 * random_unit(state)));
        return sign * value * (1 - pow(10, -1 - 12 * random_unit(state)));
    default:
        return sign * pow(10, -12 + 30 * random_unit(state));
    }
}

/** What a reader makes of a text that has no e before its exponent, by the C library. */
static double read_text(const char *text, int length) {
    char copy[TEXT_SIZE];
    int n = 0;
    for (int i = 0; i < length; i++) {
        if (i > 0 && (text[i] == '+' || text[i] == '-') && text[i - 1] != 'e')
            copy[n++] = 'e';
        copy[n++] = text[i];
    }
    copy[n] = '\0';
    char *end;
    const double value = strtod(copy, &end);
    assert_true(*end == '\0' && n > 0);
    return value;
}

static void check_number(double value, int width, int kind) {
    char text[IO_REAL_SIZE + 1];
    const int length = io_format_field(text, value, width, kind);
    const double rounded = io_round_to_field(value, width, kind);
    double packed = 0;
    assert_in_range(length, 2, width);
    text[length] = '\0';
    assert_non_null(strchr(text, '.'));
    if (!(read_text(text, length) == rounded))
        print_error("%.17g becomes '%s', not %.17g\n", value, text, rounded);
    assert_true(read_text(text, length) == rounded && isfinite(rounded));
    assert_int_equal(io_slice_real((io_slice){text, text + length}, 1, &packed), 0);
    assert_true(packed == rounded);
    assert_true(io_round_to_field(rounded, width, kind) == rounded);
    char again[IO_REAL_SIZE];
    assert_int_equal(io_format_field(again, rounded, width, kind), length);
    assert_memory_equal(text, again, (size_t)length);
}

static void what_is_written_is_what_rounding_says(void **state) {
    (void)state;
    uint64_t seed = 88172645463325252u;
    for (int i = 0; i < RANDOM_NUMBERS; i++) {
        const double value = random_number(&seed);
        for (int w = 0; w < N_WIDTHS; w++)
            for (int kind = 0; kind <= IO_EXPONENT_ALWAYS; kind++)
                check_number(value, widths[w], kind);
    }
}

/** A text of the whole number mantissa with decimals of its digits behind the point and an exponent
 *  (none if it is 0 and need not be); -1 if it is longer than width. */
static int candidate(char *text, int negative, long long mantissa, int decimals, int exponent,
                     int kind, int width) {
    char digits[TEXT_SIZE];
    int n = snprintf(digits, sizeof digits, "%lld", mantissa), length = 0;
    if (decimals > 2 * width || n > 19)
        return -1;
    if (negative)
        text[length++] = '-';
    for (int i = 0; i < n - decimals; i++)
        text[length++] = digits[i];
    text[length++] = '.';
    for (int i = n; i < decimals; i++)
        text[length++] = '0';
    for (int i = n > decimals ? n - decimals : 0; i < n; i++)
        text[length++] = digits[i];
    if (exponent || kind == IO_EXPONENT_ALWAYS)
        length += sprintf(text + length, kind == IO_EXPONENT_IMPLIED ? "%+d" : "e%d", exponent);
    return length <= width ? length : -1;
}

/** The least error of all texts of width characters, found by trying them. */
static double least_error(double value, int width, int kind) {
    const int decade = value == 0 ? 0 : (int)floor(log10(fabs(value)));
    double least = INFINITY;
    for (int exponent = decade - width; exponent <= decade + width; exponent++) {
        const int tried = exponent == decade + width ? 0 : exponent;
        for (int decimals = 0; decimals <= width; decimals++) {
            const long double scaled = fabsl((long double)value) * powl(10, decimals - tried);
            if (!(scaled < 1e18L))
                break;
            for (int step = -1; step <= 2; step++) {
                char text[TEXT_SIZE];
                const long long mantissa = (long long)floorl(scaled) + step;
                const int length = mantissa < 0 ? -1
                                                : candidate(text, value < 0, mantissa, decimals,
                                                            tried, kind, width);
                if (length > 0) {
                    const double error = fabs(read_text(text, length) - value);
                    least = error < least ? error : least;
                }
            }
        }
    }
    return least;
}

static void no_text_is_nearer(void **state) {
    (void)state;
    uint64_t seed = 4101842887655102017u;
    for (int i = 0; i < SEARCHED_NUMBERS; i++) {
        const double value = random_number(&seed);
        const int width = widths[i % N_WIDTHS], kind = i / N_WIDTHS % (IO_EXPONENT_ALWAYS + 1);
        const double error = fabs(io_round_to_field(value, width, kind) - value);
        if (!(error <= least_error(value, width, kind)))
            print_error("%.17g in %d characters: error %g, not %g\n", value, width, error,
                        least_error(value, width, kind));
        assert_true(error <= least_error(value, width, kind));
    }
}

static int compare(const void *a, const void *b) {
    const double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

static void rounding_keeps_the_order(void **state) {
    (void)state;
    enum { N = 100000 };
    uint64_t seed = 1181783497276652981u;
    double *value = malloc(N * sizeof *value);
    for (int i = 0; i < N; i++) {
        value[i] = random_number(&seed);
        if (i % 2) /* close to the one before */
            value[i] = value[i - 1] * (1 + 1e-7 * (random_unit(&seed) - 0.5));
        if (!isfinite(value[i]))
            value[i] = 1;
    }
    qsort(value, N, sizeof *value, compare);
    for (int w = 0; w < N_WIDTHS; w++)
        for (int kind = 0; kind <= IO_EXPONENT_ALWAYS; kind++)
            for (int i = 1; i < N; i++)
                assert_true(io_round_to_field(value[i - 1], widths[w], kind) <=
                            io_round_to_field(value[i], widths[w], kind));
    free(value);
}

static void known_numbers(void **state) {
    (void)state;
    static const struct {
        double value;
        int width;
        io_exponent kind;
        const char *text;
    } cases[] = {
        {0, 8, IO_EXPONENT_IMPLIED, "0."},
        {-0.0, 8, IO_EXPONENT_IMPLIED, "0."},
        {1, 8, IO_EXPONENT_IMPLIED, "1."},
        {-1, 8, IO_EXPONENT_IMPLIED, "-1."},
        {0.5, 8, IO_EXPONENT_IMPLIED, ".5"},
        {0.1, 20, IO_EXPONENT_NEEDED, ".1"},
        {123.456, 8, IO_EXPONENT_IMPLIED, "123.456"},
        {-1234567, 8, IO_EXPONENT_IMPLIED, "-1.235+6"},
        {1234567, 8, IO_EXPONENT_IMPLIED, "1234567."},
        {12345678, 8, IO_EXPONENT_IMPLIED, "1.2346+7"},
        {9.9999999, 8, IO_EXPONENT_IMPLIED, "10."},
        {0.99999999, 8, IO_EXPONENT_IMPLIED, "1."},
        {-0.9999999, 8, IO_EXPONENT_IMPLIED, "-1."},
        {9999999.6, 8, IO_EXPONENT_IMPLIED, "1.+7"},
        {99999999.6, 8, IO_EXPONENT_IMPLIED, "1.+8"},
        {1.0 / 3, 8, IO_EXPONENT_IMPLIED, ".3333333"},
        {-1.0 / 3, 8, IO_EXPONENT_IMPLIED, "-.333333"},
        {1.0 / 3, 16, IO_EXPONENT_IMPLIED, ".333333333333333"},
        {1.0 / 3, 20, IO_EXPONENT_NEEDED, ".3333333333333333"},
        {1.2345678e-5, 8, IO_EXPONENT_IMPLIED, "1.2346-5"},
        {1.2345678e-5, 8, IO_EXPONENT_NEEDED, "1.235e-5"},
        {1.2345678e-10, 8, IO_EXPONENT_IMPLIED, ".12346-9"},
        {1.2345678e-10, 8, IO_EXPONENT_NEEDED, ".1235e-9"},
        {1.2345678e10, 8, IO_EXPONENT_IMPLIED, "12.346+9"},
        {1.2345678e10, 8, IO_EXPONENT_NEEDED, "12.346e9"},
        {1e10, 8, IO_EXPONENT_NEEDED, "1.e10"},
        {0.001, 8, IO_EXPONENT_IMPLIED, ".001"},
        {5e-324, 8, IO_EXPONENT_IMPLIED, "5.-324"},
        {-5e-324, 8, IO_EXPONENT_NEEDED, "-5.e-324"},
        {DBL_MAX, 8, IO_EXPONENT_IMPLIED, "1.79+308"},
        {-DBL_MAX, 8, IO_EXPONENT_IMPLIED, "-1.7+308"},
        {-DBL_MAX, 8, IO_EXPONENT_NEEDED, "-1.7e308"},
        {DBL_MAX, 20, IO_EXPONENT_NEEDED, "1.79769313486231e308"},
        {0, 12, IO_EXPONENT_ALWAYS, "0.e0"},
        {1, 12, IO_EXPONENT_ALWAYS, "1.e0"},
        {-1.0 / 3, 12, IO_EXPONENT_ALWAYS, "-.33333333e0"},
        {1.0 / 3, 24, IO_EXPONENT_ALWAYS, "3.333333333333333e-1"},
        {-DBL_MAX, 24, IO_EXPONENT_ALWAYS, "-1.7976931348623157e308"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[IO_REAL_SIZE + 1];
        const int length = io_format_field(text, cases[i].value, cases[i].width, cases[i].kind);
        text[length] = '\0';
        assert_string_equal(text, cases[i].text);
        check_number(cases[i].value, cases[i].width, cases[i].kind);
    }
    char text[IO_REAL_SIZE];
    assert_int_equal(io_format_field(text, NAN, 8, IO_EXPONENT_IMPLIED), 0);
    assert_int_equal(io_format_field(text, INFINITY, 8, IO_EXPONENT_IMPLIED), 0);
    assert_true(isnan(io_round_to_field(NAN, 8, IO_EXPONENT_IMPLIED)));
    assert_true(io_round_to_field(-INFINITY, 8, IO_EXPONENT_IMPLIED) == -INFINITY);
}

/** Numbers halfway between two of a field, and those beside them: what decides is the number
 * itself, not its product with a power of ten. */
static void halves_are_told_apart(void **state) {
    (void)state;
    uint64_t seed = 2685821657736338717u;
    for (int i = 0; i < RANDOM_NUMBERS; i++) {
        const double below = floor(1e6 + 8.9e6 * random_unit(&seed));
        const double half = (below + 0.5) / 1e7;
        for (int step = -2; step <= 2; step++)
            check_number(half * (1 + step * DBL_EPSILON / 2), 8, 1);
    }
}

static void packed_numbers_are_read(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double value;
    } good[] = {{"1.5-3", 1.5e-3},  {"1.5+3", 1.5e3},   {"-1.5-3", -1.5e-3}, {"+.5+2", 50},
                {"1.5D-3", 1.5e-3}, {"1.5E-3", 1.5e-3}, {"1.5d+3", 1.5e3},   {".5", .5},
                {"1.", 1},          {"7", 7},           {"-7.", -7},         {"7-1", 0.7},
                {"1.+0", 1}};
    static const char *const bad[] = {"",     "-",   ".",    "1.5-",    "1.5-3-4", "1.5E-3-1",
                                      "1 5",  "x",   "1.5x", "1.5-3x",  "--1",     "1.5+-3",
                                      "-.-3", "1,5", "1.5e", "1.5e-3.5"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        double value = -1;
        const char *text = good[i].text;
        assert_int_equal(io_slice_real((io_slice){text, text + strlen(text)}, 1, &value), 0);
        assert_true(value == good[i].value);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        double value;
        if (io_slice_real((io_slice){bad[i], bad[i] + strlen(bad[i])}, 1, &value) == 0)
            print_error("'%s' is no number\n", bad[i]);
        assert_int_equal(io_slice_real((io_slice){bad[i], bad[i] + strlen(bad[i])}, 1, &value), -1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_numbers),
        cmocka_unit_test(what_is_written_is_what_rounding_says),
        cmocka_unit_test(no_text_is_nearer),
        cmocka_unit_test(rounding_keeps_the_order),
        cmocka_unit_test(halves_are_told_apart),
        cmocka_unit_test(packed_numbers_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
