/* binary: numbers from the bytes of a binary file, at any alignment, in either byte order.
 *
 *   io_machine_is_little        the byte order of this machine
 *   io_load_u16, _u32, _i32 ... a number at a place; swapped: its byte order is the other one
 */
#ifndef PL_IO_CORE_BINARY_H
#define PL_IO_CORE_BINARY_H

#include <stdint.h>
#include <string.h>

/** Return whether this machine's numbers begin with their lowest byte. */
static inline int io_machine_is_little(void) {
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

/** Return the number that stands at at, which need not be aligned. */
static inline uint16_t io_load_u16(const char *at, int swapped) {
    uint16_t bits;
    memcpy(&bits, at, sizeof bits);
    if (!swapped)
        return bits;
    return (uint16_t)((bits & 0xffu) << 8 | bits >> 8);
}

static inline uint32_t io_swap_u32(uint32_t bits) {
    bits = (bits & 0x00ff00ffu) << 8 | (bits >> 8 & 0x00ff00ffu);
    return bits << 16 | bits >> 16;
}

static inline uint32_t io_load_u32(const char *at, int swapped) {
    uint32_t bits;
    memcpy(&bits, at, sizeof bits);
    return swapped ? io_swap_u32(bits) : bits;
}

static inline uint64_t io_load_u64(const char *at, int swapped) {
    uint64_t bits;
    memcpy(&bits, at, sizeof bits);
    if (!swapped)
        return bits;
    return (uint64_t)io_swap_u32((uint32_t)bits) << 32 | io_swap_u32((uint32_t)(bits >> 32));
}

static inline int32_t io_load_i32(const char *at, int swapped) {
    return (int32_t)io_load_u32(at, swapped);
}

static inline int64_t io_load_i64(const char *at, int swapped) {
    return (int64_t)io_load_u64(at, swapped);
}

static inline float io_load_f32(const char *at, int swapped) {
    uint32_t bits = io_load_u32(at, swapped);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline double io_load_f64(const char *at, int swapped) {
    uint64_t bits = io_load_u64(at, swapped);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

#endif
