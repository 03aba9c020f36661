// number: numbers from text and back by <charconv>: exact, in any locale, without exceptions.
#include "io/core/number.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>

namespace {

constexpr int64_t farthest = int64_t(1) << 40; // decimal exponents beyond it are as good as it
constexpr int longest_token = 512;             // of numbers with a Fortran exponent

bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

// The magnitude that from_chars gave up on is infinite or zero: the decimal exponent of its first
// digit that is not zero says which.
double beyond_range(const char *begin, const char *end) {
    bool negative = *begin == '-';
    int64_t exponent = 0, shift = 0; // shift: places from that digit to the point, if positive
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
