/* Any bytes as numbers, read and written: what is read is what the C library reads, the shortest
 * text reads as the value, and that of a field as what it was said to round to.
 */
#include "fuzz_require.h"

#include "io/core/number.h"
#include "io/core/text.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

enum { LONGEST = 2000 };

static int same(double a, double b) {
    return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

/** What strtod makes of a number of length characters; it knows no Fortran exponents. */
static double expected(const char *text, size_t length) {
    char copy[LONGEST + 1];
    memcpy(copy, text, length);
    copy[length] = '\0';
    for (char *c = copy; *c; c++)
        if (*c == 'd' || *c == 'D')
            *c = 'e';
    return strtod(copy, NULL);
}

static void check_real(const char *text, const char *end) {
    const char *at = text;
    double value = 3.5;
    if (io_parse_real(&at, end, &value)) {
        fuzz_require(at == text && value == 3.5, "without a number nothing changes");
        return;
    }
    fuzz_require(at > text && at <= end, "a number has a length");
    const double wanted = expected(text, (size_t)(at - text));
    fuzz_require(same(value, wanted) || isinf(value) || (isnan(value) && isnan(wanted)) ||
                     (value == 0 && wanted == 0),
                 "a number is read as the C library does");
    fuzz_require(!isinf(value) || isinf(wanted), "what is finite is read as that");
}

static void check_integer(const char *text, const char *end) {
    const char *at = text;
    int64_t value = 7;
    if (io_parse_integer(&at, end, &value)) {
        fuzz_require(at == text && value == 7, "without a number nothing changes");
        return;
    }
    char copy[LONGEST + 1];
    memcpy(copy, text, (size_t)(at - text));
    copy[at - text] = '\0';
    errno = 0;
    fuzz_require(strtoll(copy, NULL, 10) == value && errno == 0,
                 "an integer is read as the C library does");
}

static void check_packed(const char *text, const char *end) {
    double packed, plain;
    const char *at = text;
    if (io_slice_real((io_slice){text, end}, 1, &packed))
        return;
    if (io_parse_real(&at, end, &plain) == 0 && at == end)
        fuzz_require(same(packed, plain), "an exponent that has an e is the same packed");
}

static void check_shortest(double value, int is_float) {
    char text[IO_REAL_SIZE];
    const char *at = text;
    double again;
    const double stored = is_float ? (double)(float)value : value;
    if (!isfinite(stored))
        return;
    const int length = io_format_real(text, stored, is_float);
    fuzz_require(length > 0 && length <= IO_REAL_SIZE, "the text of a number has room");
    fuzz_require(io_parse_real(&at, text + length, &again) == 0 && at == text + length,
                 "the text of a number is one");
    fuzz_require(same(is_float ? (double)(float)again : again, stored),
                 "the shortest text restores the value");
}

static void check_field(double value, int width, io_exponent kind) {
    char text[IO_REAL_SIZE];
    double read;
    const int length = io_format_field(text, value, width, kind);
    const double rounded = io_round_to_field(value, width, kind);
    if (!isfinite(value)) {
        fuzz_require(length == 0 && same(rounded, value), "what is not finite has no field");
        return;
    }
    fuzz_require(length > 0 && length <= width, "a field is as wide as it is");
    fuzz_require(memchr(text, '.', (size_t)length) != NULL, "a field has a point");
    fuzz_require(io_slice_real((io_slice){text, text + length}, 1, &read) == 0 && read == rounded,
                 "a field reads as what its value rounds to");
    fuzz_require(io_round_to_field(rounded, width, kind) == rounded, "rounding is done once");
}

static void check_order(double a, double b, int width, io_exponent kind) {
    if (a <= b && isfinite(a) && isfinite(b))
        fuzz_require(io_round_to_field(a, width, kind) <= io_round_to_field(b, width, kind),
                     "rounding keeps the order");
}

/** The bits of the numbers that the input begins with. */
static void check_values(const uint8_t *data, size_t size) {
    double value[2] = {0};
    memcpy(value, data, size < sizeof value ? size : sizeof value);
    const int width = 8 + (int)(size % (IO_REAL_SIZE - 8));
    const io_exponent kind = (io_exponent)(size % (IO_EXPONENT_ALWAYS + 1));
    check_shortest(value[0], 0);
    check_shortest(value[0], 1);
    check_field(value[0], width, kind);
    check_order(value[0], value[1], width, kind);
    check_order(value[0], nextafter(value[0], INFINITY), width, kind);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const size_t n = size < LONGEST ? size : LONGEST;
    const char *text = (const char *)data;
    double value;
    const char *at = text;
    if (n == 0 || memchr(data, '\0', n) == NULL) {
        check_real(text, text + n);
        check_integer(text, text + n);
        check_packed(text, text + n);
    }
    if (n > 0 && io_parse_real(&at, text + n, &value) == 0)
        check_field(value, 8 + (int)(n % 8), 1);
    check_values(data, size);
    return 0;
}
