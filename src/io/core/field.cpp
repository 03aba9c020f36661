// field: real numbers in fields of few characters, as Nastran and Abaqus have them: the text that
// is nearest to a number, and what that text reads as.
//
// How many digits fit depends on the decade of the number alone. So to round to a field is to round
// to that many digits, which for the common numbers a multiplication and a division do exactly.
#include "io/core/number.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace {

constexpr int most_digits = 17;  // that any double needs
constexpr int exact_digits = 15; // so many restore a decimal number from its double
constexpr int widest = IO_REAL_SIZE - 1;
constexpr int last_exact_power = 22; // of ten in a double

// A decimal number: 0.DIGITS * 10^(decade + 1), without zeros at either end.
struct decimal {
    char digits[widest + 1];
    int n;
    int decade;
};

// ---- how many digits fit ------------------------------------------------------------------------

// Characters of an exponent: -5, +12, or e-5, e12.
constexpr int exponent_length(int exponent, io_exponent kind) {
    const int size = exponent < 0 ? -exponent : exponent;
    return 2 + (size > 9) + (size > 99) + (kind != IO_EXPONENT_IMPLIED && exponent < 0);
}

// Digits that fit into room characters (a sign not among them) without an exponent; 0: none.
constexpr int fixed_digits(int room, int decade) {
    if (decade >= 0)
        return decade + 1 <= room - 1 ? room - 1 : 0;
    return room + decade > 0 ? room + decade : 0;
}

// The same with an exponent and point digits before the point.
constexpr int scientific_digits(int room, int decade, int point, io_exponent kind) {
    const int digits = room - 1 - exponent_length(decade + 1 - point, kind);
    return digits >= point && digits > 0 ? digits : 0;
}

constexpr int digits_that_fit(int room, int decade, io_exponent kind) {
    int most = kind == IO_EXPONENT_ALWAYS ? 0 : fixed_digits(room, decade);
    for (int point = 0; point < room; point++) {
        const int digits = scientific_digits(room, decade, point, kind);
        most = digits > most ? digits : most;
    }
    return most;
}

// ---- decimal numbers ----------------------------------------------------------------------------

// Of text d.ddde-xx.
decimal decimal_of(const char *text, const char *end) {
    decimal d{};
    const char *mark = std::find(text, end, 'e');
    for (const char *c = text; c < mark; c++)
        if (*c != '.')
            d.digits[d.n++] = *c;
    const char *exponent = mark + 1 + (mark[1] == '+');
    std::from_chars(exponent, end, d.decade);
    return d;
}

double value_of(const decimal &d) {
    char text[widest + 16];
    std::memcpy(text, d.digits, static_cast<size_t>(d.n));
    text[d.n] = 'e';
    auto result = std::to_chars(text + d.n + 1, text + sizeof text, d.decade + 1 - d.n);
    double value = 0;
    auto read = std::from_chars(text, result.ptr, value);
    // Out of range: too large only, as digits come from a number.
    return read.ec == std::errc() ? value : HUGE_VAL;
}

// The decimal number in reach of a field that is nearest to size > 0; the shortest that restores it
// if that fits.
decimal nearest(double size, int room, io_exponent kind) {
    char text[widest + 16];
    char *end = text + sizeof text;
    auto shortest = std::to_chars(text, end, size, std::chars_format::scientific);
    decimal d = decimal_of(text, shortest.ptr);
    const int digits = digits_that_fit(room, d.decade, kind);
    if (d.n <= digits)
        return d;
    auto rounded = std::to_chars(text, end, size, std::chars_format::scientific, digits - 1);
    d = decimal_of(text, rounded.ptr);
    if (std::isinf(value_of(d))) { // the number before it, of as many digits
        int i = d.n - 1;
        for (; i > 0 && d.digits[i] == '0'; i--)
            d.digits[i] = '9';
        d.digits[i]--;
    }
    while (d.n > 1 && d.digits[d.n - 1] == '0')
        d.n--;
    return d;
}

// ---- text ---------------------------------------------------------------------------------------

// The digits with point of them before the point (0 or less: zeros behind it).
char *put_mantissa(char *to, const decimal &d, int point) {
    const int before = std::clamp(point, 0, d.n);
    to = std::copy(d.digits, d.digits + before, to);
    to = std::fill_n(to, std::max(point - before, 0), '0');
    *to++ = '.';
    to = std::fill_n(to, std::max(-point, 0), '0');
    return std::copy(d.digits + before, d.digits + d.n, to);
}

int fixed_length(const decimal &d) {
    return d.decade >= 0 ? std::max(d.n, d.decade + 1) + 1 : d.n - d.decade;
}

int scientific_length(const decimal &d, int point, io_exponent kind) {
    return std::max(d.n, point) + 1 + exponent_length(d.decade + 1 - point, kind);
}

// Without an exponent if that fits and may be, else with one digit before the point, else as it fits.
char *put(char *to, const decimal &d, int room, io_exponent kind) {
    if (kind != IO_EXPONENT_ALWAYS && fixed_length(d) <= room)
        return put_mantissa(to, d, d.decade + 1);
    int point = 1;
    if (scientific_length(d, point, kind) > room)
        for (point = 0; point < room && scientific_length(d, point, kind) > room; point++)
            ;
    const int exponent = d.decade + 1 - point;
    to = put_mantissa(to, d, point);
    if (kind != IO_EXPONENT_IMPLIED)
        *to++ = 'e';
    else if (exponent > 0)
        *to++ = '+';
    return std::to_chars(to, to + 5, exponent).ptr;
}

// ---- fast rounding ------------------------------------------------------------------------------

constexpr int first_decade = -9, last_decade = 15;
constexpr int n_kinds = IO_EXPONENT_ALWAYS + 1;

constexpr double powers[] = {1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1e0,  1e1,
                             1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11, 1e12,
                             1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

constexpr double power_of_ten(int exponent) {
    return powers[exponent - first_decade];
}

using digit_table =
    std::array<std::array<std::array<signed char, last_decade - first_decade + 1>, widest + 1>,
               n_kinds>;

constexpr digit_table make_digit_table() {
    digit_table table{};
    for (int kind = 0; kind < n_kinds; kind++)
        for (int room = 1; room <= widest; room++)
            for (int decade = first_decade; decade <= last_decade; decade++)
                table[static_cast<size_t>(kind)][static_cast<size_t>(room)]
                     [static_cast<size_t>(decade - first_decade)] = static_cast<signed char>(
                         digits_that_fit(room, decade, static_cast<io_exponent>(kind)));
    return table;
}

constexpr digit_table table = make_digit_table();

// The decade of a number that the table has.
int decade_of(double size) {
    uint64_t bits;
    std::memcpy(&bits, &size, sizeof bits);
    const int exponent = static_cast<int>(bits >> 52) - 1023;
    const int low = exponent * 1233 >> 12; // 1233 / 4096 is log10(2), nearly
    return low + (size >= power_of_ten(low + 1));
}

// value to so many decimals, both of which are exact: the product has 53 bits at most. Only where
// it seems to be halfway between two whole numbers can what was rounded off it matter.
double round_to_decimals(double value, int decimals) {
    const double power = power_of_ten(decimals);
    const double product = value * power;
    double whole = std::nearbyint(product);
    if (std::fabs(product - whole) == 0.5) {
        const double rest = std::fma(value, power, -product);
        if (rest != 0)
            whole = rest > 0 ? std::ceil(product) : std::floor(product);
    }
    return whole / power;
}

} // namespace

extern "C" int io_format_field(char *text, double value, int width, io_exponent kind) {
    if (!std::isfinite(value))
        return 0;
    char *to = text;
    if (value == 0) {
        *to++ = '0';
        *to++ = '.';
        if (kind == IO_EXPONENT_ALWAYS)
            to = std::copy_n("e0", 2, to);
        return static_cast<int>(to - text);
    }
    const int room = width - (value < 0);
    if (value < 0)
        *to++ = '-';
    const decimal d = nearest(std::fabs(value), room, kind);
    return static_cast<int>(put(to, d, room, kind) - text);
}

extern "C" double io_round_to_field(double value, int width, io_exponent kind) {
    const double size = std::fabs(value);
    const int room = width - (value < 0);
    if (size >= power_of_ten(first_decade) && size < power_of_ten(last_decade + 1)) {
        const int decade = decade_of(size);
        const int digits =
            table[kind][static_cast<size_t>(room)][static_cast<size_t>(decade - first_decade)];
        const int decimals = digits - 1 - decade;
        if (digits >= most_digits)
            return value;
        if (digits <= exact_digits && decimals >= 0 && decimals <= last_exact_power)
            return round_to_decimals(value, decimals);
    }
    if (size == 0)
        return 0;
    if (!std::isfinite(value))
        return value;
    const double rounded = value_of(nearest(size, room, kind));
    return value < 0 ? -rounded : rounded;
}
