/* Numbers from text and back, against the C library in the C locale. */
#include "io/core/number.h"

#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { RANDOM_NUMBERS = 300000 };

static uint64_t random_bits(uint64_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static int parse(const char *text, double *value) {
    const char *at = text, *end = text + strlen(text);
    int status = io_parse_real(&at, end, value);
    return status ? -1 : (int)(at - text);
}

static void written_numbers_are_restored(void **state) {
    (void)state;
    uint64_t seed = 88172645463325252u;
    for (int i = 0; i < RANDOM_NUMBERS; i++) {
        uint64_t bits = random_bits(&seed);
        double value, again;
        char text[IO_REAL_SIZE + 1];
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value))
            continue;
        int length = io_format_real(text, value, 0);
        assert_true(length > 0 && length <= IO_REAL_SIZE);
        text[length] = '\0';
        assert_int_equal(parse(text, &again), length);
        assert_memory_equal(&value, &again, sizeof value);
        assert_true(strtod(text, NULL) == value);
        volatile float single = (float)value;
        if (isfinite(single)) {
            length = io_format_real(text, single, 1);
            text[length] = '\0';
            assert_true(length <= 16 && strtof(text, NULL) == single);
        }
    }
}

static void known_texts_are_read(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double value;
        int length; /* read of it, -1: no number */
    } cases[] = {
        {"1", 1, 1},
        {"-0.5", -0.5, 4},
        {"+2.25", 2.25, 5},
        {".5", 0.5, 2},
        {"5.", 5, 2},
        {"1e3", 1000, 3},
        {"1E+03", 1000, 5},
        {"1d3", 1000, 3},
        {"-1.5D-02", -0.015, 8},
        {"0.1 2", 0.1, 3},
        {"12x", 12, 2},
        {"3d", 3, 1},
        {"1e400", INFINITY, 5},
        {"-1e400", -INFINITY, 6},
        {"1e-400", 0, 6},
        {"123456789012345678901234567890e300", INFINITY, 34},
        {"0.000000000000000000001e-320", 0, 28},
        {"4.9e-324", 4.9e-324, 8},
        {"2.2250738585072011e-308", 2.2250738585072011e-308, 23},
        {"9007199254740993", 9007199254740992.0, 16},
        {"1.7976931348623157e308", 1.7976931348623157e308, 22},
        {"", 0, -1},
        {"-", 0, -1},
        {"+-1", 0, -1},
        {"++1", 0, -1},
        {"e5", 0, -1},
        {".", 0, -1},
        {"x", 0, -1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double value = -7;
        assert_int_equal(parse(cases[i].text, &value), cases[i].length);
        if (cases[i].length >= 0)
            assert_true(value == cases[i].value);
    }
    double value;
    assert_int_equal(parse("nan", &value), 3);
    assert_true(isnan(value));
    assert_int_equal(parse("-inf", &value), 4);
    assert_true(value == -INFINITY);
}

/** Numbers whose digits, not their exponent, decide whether they are too large or too small. */
static void long_texts_are_read(void **state) {
    (void)state;
    char text[2100];
    double value;
    snprintf(text, sizeof text, "0.%0*d1e100", 600, 0);
    assert_int_equal(parse(text, &value), (int)strlen(text));
    assert_true(value == 0);
    snprintf(text, sizeof text, "0.%0*d1e601", 600, 0);
    assert_int_equal(parse(text, &value), (int)strlen(text));
    assert_true(value == 1);
    memset(text, '9', 2000);
    strcpy(text + 2000, "e-1000");
    assert_int_equal(parse(text, &value), 2006);
    assert_true(isinf(value));
    strcpy(text + 2000, "e-2400");
    assert_int_equal(parse(text, &value), 2006);
    assert_true(value == 0);
    assert_int_equal(parse("0.000e99999999999999999999", &value), 26);
    assert_true(value == 0);
    assert_int_equal(parse("0.01e-9223372036854775808", &value), 25);
    assert_true(value == 0);
}

static void the_end_is_never_passed(void **state) {
    (void)state;
    static const char text[] = "-123.456d+78";
    for (size_t size = 0; size < sizeof text; size++) {
        char *exact = malloc(size + 1); /* a reader beyond the end is caught by the sanitizer */
        memcpy(exact, text, size);
        char *copy = realloc(exact, size ? size : 1);
        const char *at = copy;
        double value;
        if (io_parse_real(&at, copy + size, &value) == 0)
            assert_true(at <= copy + size);
        free(copy);
    }
}

static void integers_are_checked(void **state) {
    (void)state;
    static const struct {
        const char *text;
        int64_t value;
        int length;
    } cases[] = {
        {"0", 0, 1},
        {"-17 ", -17, 3},
        {"+8", 8, 2},
        {"9223372036854775807", INT64_MAX, 19},
        {"9223372036854775808", 0, -1},
        {"-9223372036854775808", INT64_MIN, 20},
        {"99999999999999999999999", 0, -1},
        {"", 0, -1},
        {"+-3", 0, -1},
        {"x", 0, -1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *at = cases[i].text;
        int64_t value = 0;
        int status = io_parse_integer(&at, at + strlen(at), &value);
        assert_int_equal(status ? -1 : (int)(at - cases[i].text), cases[i].length);
        if (!status)
            assert_int_equal(value, cases[i].value);
    }
}

static void the_locale_does_not_matter(void **state) {
    (void)state;
    static const char *const names[] = {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8", "C.UTF-8"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (setlocale(LC_ALL, names[i]))
            break;
    double value;
    assert_int_equal(parse("1.5", &value), 3);
    assert_true(value == 1.5);
    char text[IO_REAL_SIZE];
    assert_int_equal(io_format_real(text, 1.5, 0), 3);
    assert_memory_equal(text, "1.5", 3);
    setlocale(LC_ALL, "C");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(written_numbers_are_restored),
        cmocka_unit_test(known_texts_are_read),
        cmocka_unit_test(long_texts_are_read),
        cmocka_unit_test(the_end_is_never_passed),
        cmocka_unit_test(integers_are_checked),
        cmocka_unit_test(the_locale_does_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
