/* exact: integers as long as determinants of coordinates need.
 *
 * A double is an integer times a power of two. So differences, products and sums of integers give
 * the sign of a determinant exactly, whatever the exponents. Used where the rounding error bound
 * cannot decide; numbers keep only the limbs they need, so common cases stay short.
 *
 *   pl_exact_unit, _difference               integers of doubles
 *   pl_exact_add, _multiply, _round          arithmetic
 *   pl_exact_turn                            the turn of three points in the plane
 */
#ifndef PL_BASE_EXACT_H
#define PL_BASE_EXACT_H

#include <stdint.h>

/** Doubles are 2^-1074 times integers below 2^2098. A difference of two has at most 2099 bits, a
 * sum of six products of three at most 6300; those of order 2 (quality/validity.c) have weights of
 * 280 bits more, and a product may leave a limb at 0. */
enum { PL_EXACT_LIMBS = 208 };

/** Integer: sign * sum of limb[i] 2^(32 i), i < n; limb[n - 1] is not 0, and n is 0 for 0. */
typedef struct pl_exact {
    int sign; /* +1 or -1 */
    int n;
    uint32_t limb[PL_EXACT_LIMBS]; /* lowest first */
} pl_exact;

/** Largest k with a = integer * 2^k that keeps the integer below 2^53; at least -1074. a is finite
 *  and not 0. */
int pl_exact_unit(double a);

/** Compute (a - b) / 2^unit; unit is at most the pl_exact_unit of both (of those that are not 0).
 */
void pl_exact_difference(double a, double b, int unit, pl_exact *difference);

/** Compute sum = a + b_sign * b; b_sign is +1 or -1. sum is neither a nor b. */
void pl_exact_add(const pl_exact *a, const pl_exact *b, int b_sign, pl_exact *sum);

/** Compute product = a * b, neither of which it is. */
void pl_exact_multiply(const pl_exact *a, const pl_exact *b, pl_exact *product);

/** Return m with a = m 2^exponent up to the last bits of m, 1 <= |m| < 2^97 with the sign of a; 0
 * for 0.
 */
double pl_exact_round(const pl_exact *a, int *exponent);

/** The sign of the turn at b on the way from a to b to c, exactly: +1 to the left, 0 straight. */
int pl_exact_turn(const double a[2], const double b[2], const double c[2]);

#endif
