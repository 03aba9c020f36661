/* checksum: a checksum of coordinates, added one after another (pl_checksum_add).
 */
#ifndef PL_BASE_CHECKSUM_H
#define PL_BASE_CHECKSUM_H

#include <stdint.h>
#include <string.h>

/** Return checksum (0 at first) with one more number, coordinate d of its node; a multiplication
 * spreads it upwards, a shift back down. */
static inline uint64_t pl_checksum_add(uint64_t checksum, double x, int d) {
    uint64_t word;
    memcpy(&word, &x, sizeof word);
    checksum = (checksum ^ (word + (uint64_t)d)) * UINT64_C(0x9E3779B97F4A7C15);
    return checksum ^ checksum >> 32;
}

#endif
