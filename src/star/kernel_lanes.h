/* kernel_lanes: a pack of PL_PACK doubles that the kernels compute with.
 *
 * PL_PACK 4 or 2: a vector of the compiler's vector extension, mapped to what the target has.
 * PL_PACK 1: a double, plain C. A sum over facets always has PL_LANES accumulators (PL_PACKS
 * packs), so all give the same bits.
 *
 * All of these are inlined always: left to itself, gcc calls the smallest of them in functions that
 * have become large, and a guarded visit then takes up to half as long again.
 *
 *   lanes_of, _load, _store, _get                     make a pack, keep it, take one lane
 *   lanes_sqrt, _max, _min, _abs, _inverse_cube_root  arithmetic beside the operators
 *   lanes_greater, _select, _bits, _of_bits           compare, choose, bits
 *   lanes_all_set, _any_set                           ask a mask
 *   lanes_lane, _sum, _largest                        of the PL_PACKS packs of one sum
 */
#ifndef PL_STAR_KERNEL_LANES_H
#define PL_STAR_KERNEL_LANES_H

/* Kernels, of which a file that includes this one is part (PL_KERNEL, before). RADIUS: radius ratios
 * of simplices. MEAN: mean ratios of corners. GUARDED: both, and everything else. */
#define PL_RADIUS  0
#define PL_MEAN    1
#define PL_GUARDED 2
#ifndef PL_KERNEL
#define PL_KERNEL PL_GUARDED
#endif

#include "geometry/inline.h"
#include "star/star.h"

#include <math.h>
#include <string.h>
#if PL_PACK > 1 && defined(__SSE2__)
#include <immintrin.h>
#endif

enum { PL_PACKS = PL_LANES / PL_PACK };

#if PL_PACK == 1

typedef double lanes;
typedef int64_t lanes_mask;

/** Pack with x in every lane. */
PL_INLINE lanes lanes_of(double x) {
    return x;
}

/** Square root of each lane. */
PL_INLINE lanes lanes_sqrt(lanes a) {
    return sqrt(a);
}

/** Maximum of each lane; b if not a > b. */
PL_INLINE lanes lanes_max(lanes a, lanes b) {
    return a > b ? a : b;
}

/** Absolute value of each lane. */
PL_INLINE lanes lanes_abs(lanes a) {
    return fabs(a);
}

/** Mask of the lanes in which a > b: all bits set, or none. */
PL_INLINE lanes_mask lanes_greater(lanes a, lanes b) {
    return -(lanes_mask)(a > b); /* all bits, as of vectors */
}

/** Lanes of a where mask is set, else of b. */
PL_INLINE lanes lanes_select(lanes_mask mask, lanes a, lanes b) {
    return mask ? a : b;
}

/** Bits of the doubles. */
PL_INLINE lanes_mask lanes_bits(lanes a) {
    lanes_mask bits;
    memcpy(&bits, &a, sizeof bits);
    return bits;
}

/** Doubles of these bits. */
PL_INLINE lanes lanes_of_bits(lanes_mask bits) {
    lanes a;
    memcpy(&a, &bits, sizeof a);
    return a;
}

/** Number in one lane. */
PL_INLINE double lanes_get(lanes a, int lane) {
    (void)lane;
    return a;
}

/** Whether mask is set in all lanes. */
PL_INLINE int lanes_all_set(lanes_mask mask) {
    return mask != 0;
}

/** Whether mask is set in any lane. */
PL_INLINE int lanes_any_set(lanes_mask mask) {
    return mask != 0;
}

#else

typedef double lanes __attribute__((vector_size(PL_PACK * sizeof(double))));
typedef int64_t lanes_mask __attribute__((vector_size(PL_PACK * sizeof(double))));

/** Pack with x in every lane. */
PL_INLINE lanes lanes_of(double x) {
    lanes a;
    for (int i = 0; i < PL_PACK; i++)
        a[i] = x;
    return a;
}

/** Square root of each lane. */
PL_INLINE lanes lanes_sqrt(lanes a) {
#if PL_PACK == 4 && defined(__AVX__)
    return _mm256_sqrt_pd(a);
#elif PL_PACK == 2 && defined(__SSE2__)
    return _mm_sqrt_pd(a);
#elif PL_PACK == 4
    return (lanes){sqrt(a[0]), sqrt(a[1]), sqrt(a[2]), sqrt(a[3])};
#else
    return (lanes){sqrt(a[0]), sqrt(a[1])};
#endif
}

/** Lanes of a where mask is set, else of b. */
PL_INLINE lanes lanes_select(lanes_mask mask, lanes a, lanes b) {
    return (lanes)(((lanes_mask)a & mask) | ((lanes_mask)b & ~mask));
}

/** Bits of the doubles. */
PL_INLINE lanes_mask lanes_bits(lanes a) {
    return (lanes_mask)a;
}

/** Doubles of these bits. */
PL_INLINE lanes lanes_of_bits(lanes_mask bits) {
    return (lanes)bits;
}

/** Maximum of each lane; b if not a > b. */
PL_INLINE lanes lanes_max(lanes a, lanes b) {
#if PL_PACK == 4 && defined(__AVX__)
    return _mm256_max_pd(a, b); /* a > b ? a : b, which the compiler does not see */
#elif PL_PACK == 2 && defined(__SSE2__)
    return _mm_max_pd(a, b);
#else
    return lanes_select(a > b, a, b);
#endif
}

/** Absolute value of each lane. */
PL_INLINE lanes lanes_abs(lanes a) {
    return (lanes)((lanes_mask)a & INT64_MAX);
}

/** Mask of the lanes in which a > b: all bits set, or none. */
PL_INLINE lanes_mask lanes_greater(lanes a, lanes b) {
    return a > b;
}

/** Number in one lane. */
PL_INLINE double lanes_get(lanes a, int lane) {
    return a[lane];
}

/** Whether mask is set in all lanes. */
PL_INLINE int lanes_all_set(lanes_mask mask) {
    int64_t all = mask[0];
    for (int i = 1; i < PL_PACK; i++)
        all &= mask[i];
    return all != 0;
}

/** Whether mask is set in any lane. */
PL_INLINE int lanes_any_set(lanes_mask mask) {
    int64_t any = mask[0];
    for (int i = 1; i < PL_PACK; i++)
        any |= mask[i];
    return any != 0;
}

#endif

/** Pack at array, which is aligned to its size. */
PL_INLINE lanes lanes_load(const double *array) {
    return *(const lanes *)(const void *)array;
}

/** Store a pack to array. */
PL_INLINE void lanes_store(double *array, lanes a) {
    *(lanes *)(void *)array = a;
}

/** Minimum of each lane; a if not a > b. */
PL_INLINE lanes lanes_min(lanes a, lanes b) {
    return lanes_select(lanes_greater(a, b), b, a);
}

/** Return a^(-1/3) of a > 0, finite and normal, to some units in the last place: a guess from the
 * exponent (3 % off), then Newton's iteration, which squares the error; + - * only, so that the
 * bits are the same everywhere. */
PL_INLINE lanes lanes_inverse_cube_root(lanes a) {
    enum { GUESS = 0x553ef0ff, THIRD = 0x55555556, NEWTON_STEPS = 4 };
    lanes_mask high = lanes_bits(a) >> 32;
    lanes y = lanes_of_bits((GUESS - (high * THIRD >> 32)) << 32);
    for (int i = 0; i < NEWTON_STEPS; i++)
        y += y * (lanes_of(1) - a * y * y * y) * lanes_of(1.0 / 3);
    return y;
}

/** Value of one of all PL_LANES lanes. */
PL_INLINE double lanes_lane(const lanes packs[PL_PACKS], int lane) {
    return lanes_get(packs[lane / PL_PACK], lane % PL_PACK);
}

/** Sum and largest of all lanes, in a fixed order. */
PL_INLINE double lanes_sum(const lanes packs[PL_PACKS]) {
    return (lanes_lane(packs, 0) + lanes_lane(packs, 1)) +
           (lanes_lane(packs, 2) + lanes_lane(packs, 3));
}

/** Largest of the PL_LANES accumulators. */
PL_INLINE double lanes_largest(const lanes packs[PL_PACKS]) {
    double a = lanes_lane(packs, 0), b = lanes_lane(packs, 1);
    double c = lanes_lane(packs, 2), d = lanes_lane(packs, 3);
    double ab = a > b ? a : b, cd = c > d ? c : d;
    return ab > cd ? ab : cd;
}

#endif
