/* sum: exact sums of doubles.
 *
 * Every term is added to a number wide enough for all doubles, as in R. M. Neal, Fast exact
 * summation using small and large superaccumulators (2015). The number is rounded once, at the
 * end. The sum therefore has the same bits in any order of the terms, and for any number of
 * threads or processes.
 *
 *   pl_sum_add, pl_sum_add_special, pl_sum_carry    add a term
 *   pl_sum_merge                                    add another sum
 *   pl_sum_value                                    the rounded sum
 */
#ifndef PL_BASE_SUM_H
#define PL_BASE_SUM_H

#include <stdint.h>
#include <string.h>

enum {
    PL_SUM_DIGITS = 68, /* doubles have 2098 bits in all, and their sums 63 more */
    PL_SUM_BITS = 32,   /* of a digit that is carried */
    PL_SUM_ROOM = 1024  /* terms, of up to 2^52 in a digit, until they must be */
};

/** Digit i counts 2^(32 i - 1075). {0} is 0. All are integers, so that sums can be added by adding
 *  their integers: 2^30 of them, if pl_sum_carry was called for each. */
typedef struct pl_sum {
    int64_t digit[PL_SUM_DIGITS];
    int64_t n_positive, n_negative, n_nan; /* terms that are infinite, or no numbers */
    int64_t n_added;                       /* since the digits were carried */
} pl_sum;

/** Make the digits, of either sign, smaller than 2^32. */
void pl_sum_carry(pl_sum *sum);

/** Count a term that is not finite. */
void pl_sum_add_special(pl_sum *sum, double term);

/** Add a term to the sum, exactly. */
static inline void pl_sum_add(pl_sum *sum, double term) {
    uint64_t bits;
    memcpy(&bits, &term, sizeof bits);
    const unsigned exponent = (unsigned)(bits >> 52) & 0x7ff;
    const uint64_t fraction = bits & (((uint64_t)1 << 52) - 1);
    if (exponent == 0x7ff) {
        pl_sum_add_special(sum, term);
        return;
    }
    const uint64_t mantissa = fraction | (uint64_t)(exponent > 0) << 52;
    const unsigned place = exponent > 0 ? exponent : 1; /* subnormals: as the least exponent */
    const unsigned shift = place % PL_SUM_BITS;
    const int64_t low = (int64_t)(mantissa << shift & 0xffffffff);
    const int64_t high = (int64_t)(mantissa >> (PL_SUM_BITS - shift));
    const int64_t sign = bits >> 63 ? -1 : 1;
    int64_t *digit = sum->digit + place / PL_SUM_BITS;
    digit[0] += sign * low;
    digit[1] += sign * high;
    if (++sum->n_added >= PL_SUM_ROOM)
        pl_sum_carry(sum);
}

/** Add part, which is carried for it, to shared; several threads may do so at the same time.
 * Nothing else is to be added to shared. */
void pl_sum_merge(pl_sum *shared, pl_sum *part);

/** The double next to the sum, ties to even: infinite where it is too large, NaN where terms were
 *  NaN, or infinite with both signs. */
double pl_sum_value(const pl_sum *sum);

#endif
