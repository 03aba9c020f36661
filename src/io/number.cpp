// number: numbers from text and back by <charconv>: exact, in any locale, without exceptions.
#include "io/number.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

namespace {

constexpr long farthest = 1L << 40; // decimal exponents beyond it are as good as it
constexpr int longest_token = 512;  // of numbers with a Fortran exponent

bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

// The magnitude that from_chars gave up on is infinite or zero: the decimal exponent of its first
// digit that is not zero says which.
double beyond_range(const char *begin, const char *end) {
    bool negative = *begin == '-';
    long exponent = 0, shift = 0; // shift: places from that digit to the point, if positive
    bool seen_point = false, seen_digit = false;
    for (const char *c = begin; c < end; c++) {
        if (*c == 'e' || *c == 'E') {
            const char *from = c + 1 < end && c[1] == '+' ? c + 2 : c + 1;
            auto result = std::from_chars(from, end, exponent);
            if (result.ec != std::errc())
                exponent = *from == '-' ? -farthest : farthest;
            exponent = std::clamp(exponent, -farthest, farthest);
            break;
        }
        seen_point |= *c == '.';
        seen_digit |= *c >= '1' && *c <= '9';
        if (*c >= '0' && *c <= '9' && seen_digit != seen_point)
            shift += seen_digit ? 1 : -1;
    }
    double magnitude =
        seen_digit && shift + exponent > 0 ? std::numeric_limits<double>::infinity() : 0.0;
    return negative ? -magnitude : magnitude;
}

// 0, or -1; *at behind the number.
int parse_plain(const char **at, const char *end, double *value) {
    auto result = std::from_chars(*at, end, *value);
    if (result.ec == std::errc::invalid_argument)
        return -1;
    if (result.ec == std::errc::result_out_of_range)
        *value = beyond_range(*at, result.ptr);
    *at = result.ptr;
    return 0;
}

// The same for a number with a Fortran exponent (1.5D-3): a copy with an e in its place.
int parse_fortran(const char **at, const char *end, const char *mark, double *value) {
    char copy[longest_token];
    const char *stop = mark;
    while (stop < end && !is_space(*stop))
        stop++;
    if (stop - *at >= longest_token)
        return -1;
    size_t length = static_cast<size_t>(stop - *at);
    std::memcpy(copy, *at, length);
    copy[mark - *at] = 'e';
    const char *from = copy;
    if (parse_plain(&from, copy + length, value))
        return -1;
    *at += from - copy;
    return 0;
}

} // namespace

extern "C" int io_parse_real(const char **at, const char *end, double *value) {
    const char *from = *at;
    if (from < end && *from == '+') {
        from++;
        if (from < end && (*from == '-' || *from == '+'))
            return -1;
    }
    const char *next = from;
    if (parse_plain(&next, end, value))
        return -1;
    if (next < end && (*next == 'd' || *next == 'D') && parse_fortran(&from, end, next, value) == 0)
        next = from;
    *at = next;
    return 0;
}

extern "C" int io_parse_integer(const char **at, const char *end, int64_t *value) {
    const char *from = *at;
    if (from < end && *from == '+') {
        from++;
        if (from < end && *from == '-')
            return -1;
    }
    auto result = std::from_chars(from, end, *value);
    if (result.ec != std::errc())
        return -1;
    *at = result.ptr;
    return 0;
}

extern "C" int io_format_real(char *text, double value, int is_float) {
    auto result = is_float ? std::to_chars(text, text + IO_REAL_SIZE, static_cast<float>(value))
                           : std::to_chars(text, text + IO_REAL_SIZE, value);
    return static_cast<int>(result.ptr - text);
}

namespace {

// Text of a number in the shape that fields of few characters want: no zero before the point, a
// point wherever it is, short exponents. Returns its length.
int compact(const char *text, const char *end, bool implied_exponent, char *out) {
    char *to = out;
    if (text < end && *text == '-')
        *to++ = *text++;
    const char *mark = std::find(text, end, 'e');
    const char *point = std::find(text, mark, '.');
    const char *digits = text;
    if (point < mark && point - text == 1 && *text == '0' && point + 1 < mark)
        digits++;
    const char *last = mark; // zeros at the end of the decimals say nothing
    while (point < mark && last[-1] == '0')
        last--;
    to = std::copy(digits, last, to);
    if (point == mark)
        *to++ = '.';
    if (mark == end)
        return static_cast<int>(to - out);
    if (!implied_exponent)
        *to++ = 'e';
    const char *exponent = mark + 1;
    if (*exponent == '-' || implied_exponent)
        *to++ = *exponent;
    exponent++;
    while (exponent + 1 < end && *exponent == '0')
        exponent++;
    to = std::copy(exponent, end, to);
    return static_cast<int>(to - out);
}

constexpr int text_size = 400; // of any double in fixed notation with a few decimals

// The text of value with as many decimals as fit into width; 0 if none does.
int fit(char *out, double value, int width, std::chars_format format, bool implied_exponent) {
    char text[text_size], candidate[text_size];
    for (int decimals = width; decimals >= 0; decimals--) {
        auto result = std::to_chars(text, text + text_size, value, format, decimals);
        if (result.ec != std::errc())
            return 0;
        int length = compact(text, result.ptr, implied_exponent, candidate);
        if (length > width)
            continue;
        std::copy(candidate, candidate + length, out);
        return length;
    }
    return 0;
}

// What text of compact's reads as.
double read_compact(const char *text, int length) {
    char copy[IO_REAL_SIZE + 1];
    int n = 0;
    for (int i = 0; i < length; i++) {
        bool implied = i > 0 && (text[i] == '+' || text[i] == '-') && text[i - 1] != 'e';
        if (implied)
            copy[n++] = 'e';
        if (text[i] != '+')
            copy[n++] = text[i];
    }
    double value = 0;
    std::from_chars(copy, copy + n, value);
    return value;
}

} // namespace

extern "C" int io_format_field(char *text, double value, int width, int implied_exponent) {
    char shortest[IO_REAL_SIZE], fixed[IO_REAL_SIZE], scientific[IO_REAL_SIZE];
    auto result = std::to_chars(shortest, shortest + IO_REAL_SIZE, value);
    char whole[IO_REAL_SIZE + 2];
    int length = compact(shortest, result.ptr, implied_exponent != 0, whole);
    if (length <= width) {
        std::copy(whole, whole + length, text);
        return length;
    }
    int n_fixed = fit(fixed, value, width, std::chars_format::fixed, implied_exponent != 0);
    int n_scientific =
        fit(scientific, value, width, std::chars_format::scientific, implied_exponent != 0);
    double of_fixed = std::fabs(read_compact(fixed, n_fixed) - value);
    double of_scientific = std::fabs(read_compact(scientific, n_scientific) - value);
    bool is_fixed = n_fixed > 0 && (n_scientific == 0 || of_fixed <= of_scientific);
    std::copy(is_fixed ? fixed : scientific,
              (is_fixed ? fixed : scientific) + (is_fixed ? n_fixed : n_scientific), text);
    return is_fixed ? n_fixed : n_scientific;
}

extern "C" double io_round_to_field(double value, int width, int implied_exponent) {
    char text[IO_REAL_SIZE];
    int length = io_format_field(text, value, width, implied_exponent);
    return length > 0 ? read_compact(text, length) : value;
}
