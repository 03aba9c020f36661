/* fuzz_bytes: the bytes of an input as decisions: each take_... uses up a few; behind the end all
 * are 0, so that short inputs are plain cases.
 */
#ifndef FUZZ_BYTES_H
#define FUZZ_BYTES_H

#include "fuzz_require.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct fuzz_bytes {
    const uint8_t *at, *end;
} fuzz_bytes;

static inline uint8_t take_byte(fuzz_bytes *bytes) {
    return bytes->at < bytes->end ? *bytes->at++ : 0;
}

/** 0 .. n - 1, n at most 256. */
static inline int take_below(fuzz_bytes *bytes, int n) {
    return take_byte(bytes) % n;
}

/** 1 in about one case of n, and never behind the end. */
static inline int take_chance(fuzz_bytes *bytes, int n) {
    return take_byte(bytes) % n == n - 1;
}

/** The next 8 bytes as they are. */
static inline int64_t take_bits(fuzz_bytes *bytes) {
    uint64_t bits = 0;
    for (int i = 0; i < 8; i++)
        bits = bits << 8 | take_byte(bytes);
    return (int64_t)bits;
}

/** A small whole number, rarely any. */
static inline int64_t take_integer(fuzz_bytes *bytes) {
    const uint8_t kind = take_byte(bytes);
    if (kind == 255)
        return take_bits(bytes);
    return kind > 250 ? -(int64_t)(kind - 250) : kind;
}

/** A number of moderate size, rarely one at the edge of what numbers are, or any bits. */
static inline double take_real(fuzz_bytes *bytes) {
    static const double odd[] = {
        NAN,  INFINITY, -INFINITY, DBL_MAX, -DBL_MAX, DBL_MIN, DBL_MIN / 1024,  5e-324,
        -0.0, 1e300,    1e-300,    1e150,   1e-150,   0x1p53,  1 + DBL_EPSILON, 1e30};
    const int kind = take_below(bytes, 64);
    double value = 0;
    if (kind == 63)
        return odd[take_below(bytes, (int)(sizeof odd / sizeof *odd))];
    if (kind == 62) {
        const int64_t bits = take_bits(bytes);
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    return (int8_t)take_byte(bytes) / (kind < 32 ? 16.0 : 1000.0);
}

/** The same, but finite. */
static inline double take_finite(fuzz_bytes *bytes) {
    const double value = take_real(bytes);
    return isfinite(value) ? value : 0;
}

/** Give one of n numbers another value. Not in one expression: compilers differ in what is taken
 *  first. */
static inline void take_change(fuzz_bytes *bytes, double *number, int64_t n) {
    const int64_t high = take_byte(bytes);
    const int64_t at = (high << 8) + take_byte(bytes);
    number[at % n] = take_real(bytes);
}

#endif
