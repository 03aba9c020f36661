/* lanes: a pack of PL_PACK doubles that the kernels compute with.
 *
 * PL_PACK 4 or 2: a vector of the compiler's vector extension, mapped to what the target has.
 * PL_PACK 1: a double, plain C. A sum over facets always has PL_LANES accumulators (PL_PACKS
 * packs), so all give the same bits.
 */
#ifndef PL_STAR_LANES_H
#define PL_STAR_LANES_H

#include "star/star.h"

#include <math.h>

enum { PL_PACKS = PL_LANES / PL_PACK };

#if PL_PACK == 1

typedef double lanes;
typedef int64_t lanes_mask;

static inline lanes lanes_of(double x) {
    return x;
}
static inline lanes lanes_sqrt(lanes a) {
    return sqrt(a);
}
static inline lanes lanes_max(lanes a, lanes b) {
    return a > b ? a : b;
}
static inline lanes lanes_abs(lanes a) {
    return fabs(a);
}
static inline lanes_mask lanes_greater(lanes a, lanes b) {
    return a > b;
}
static inline double lanes_get(lanes a, int lane) {
    (void)lane;
    return a;
}
static inline int lanes_all_set(lanes_mask mask) {
    return mask != 0;
}

#else

typedef double lanes __attribute__((vector_size(PL_PACK * sizeof(double))));
typedef int64_t lanes_mask __attribute__((vector_size(PL_PACK * sizeof(double))));

static inline lanes lanes_of(double x) {
    lanes a;
    for (int i = 0; i < PL_PACK; i++)
        a[i] = x;
    return a;
}
static inline lanes lanes_sqrt(lanes a) {
#if PL_PACK == 4
    return (lanes){sqrt(a[0]), sqrt(a[1]), sqrt(a[2]), sqrt(a[3])};
#else
    return (lanes){sqrt(a[0]), sqrt(a[1])};
#endif
}
static inline lanes lanes_max(lanes a, lanes b) {
    lanes_mask greater = a > b;
    return (lanes)(((lanes_mask)a & greater) | ((lanes_mask)b & ~greater));
}
static inline lanes lanes_abs(lanes a) {
    return (lanes)((lanes_mask)a & INT64_MAX);
}
static inline lanes_mask lanes_greater(lanes a, lanes b) {
    return a > b;
}
static inline double lanes_get(lanes a, int lane) {
    return a[lane];
}
static inline int lanes_all_set(lanes_mask mask) {
    int64_t all = mask[0];
    for (int i = 1; i < PL_PACK; i++)
        all &= mask[i];
    return all != 0;
}

#endif

/** Pack at array, which is aligned to its size. */
static inline lanes lanes_load(const double *array) {
    return *(const lanes *)(const void *)array;
}
static inline void lanes_store(double *array, lanes a) {
    *(lanes *)(void *)array = a;
}

/** Value of one of all PL_LANES lanes. */
static inline double lanes_lane(const lanes packs[PL_PACKS], int lane) {
    return lanes_get(packs[lane / PL_PACK], lane % PL_PACK);
}

/** Sum and largest of all lanes, in a fixed order. */
static inline double lanes_sum(const lanes packs[PL_PACKS]) {
    return (lanes_lane(packs, 0) + lanes_lane(packs, 1)) +
           (lanes_lane(packs, 2) + lanes_lane(packs, 3));
}
static inline double lanes_largest(const lanes packs[PL_PACKS]) {
    double a = lanes_lane(packs, 0), b = lanes_lane(packs, 1);
    double c = lanes_lane(packs, 2), d = lanes_lane(packs, 3);
    double ab = a > b ? a : b, cd = c > d ? c : d;
    return ab > cd ? ab : cd;
}

#endif
