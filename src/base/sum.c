/* sum: exact sums of doubles. */
#include "base/sum.h"

#include <math.h>

static const int64_t DIGIT = (int64_t)1 << PL_SUM_BITS;

void pl_sum_carry(pl_sum *sum) {
    for (int i = 0; i + 1 < PL_SUM_DIGITS; i++) {
        sum->digit[i + 1] += sum->digit[i] / DIGIT;
        sum->digit[i] %= DIGIT;
    }
    sum->n_added = 0;
}

void pl_sum_add_special(pl_sum *sum, double term) {
    sum->n_nan += isnan(term) != 0;
    sum->n_positive += term > 0;
    sum->n_negative += term < 0;
}

static void add_atomically(int64_t *shared, int64_t part) {
    if (part != 0)
        __atomic_fetch_add(shared, part, __ATOMIC_RELAXED);
}

void pl_sum_merge(pl_sum *shared, pl_sum *part) {
    pl_sum_carry(part);
    for (int i = 0; i < PL_SUM_DIGITS; i++)
        add_atomically(&shared->digit[i], part->digit[i]);
    add_atomically(&shared->n_positive, part->n_positive);
    add_atomically(&shared->n_negative, part->n_negative);
    add_atomically(&shared->n_nan, part->n_nan);
}

/** Carry so that no digit but the last is negative: that has the sum's sign. */
static void borrow(pl_sum *sum) {
    for (int i = 0; i + 1 < PL_SUM_DIGITS; i++) {
        const int64_t rest = sum->digit[i] & (DIGIT - 1);
        sum->digit[i + 1] += (sum->digit[i] - rest) / DIGIT;
        sum->digit[i] = rest;
    }
}

/** Return the value of digits of 32 bits, none negative, rounded to even. */
static double value_of_digits(const int64_t *digit) {
    enum { EXTRA = 11 }; /* of 64 bits: those that a double has no room for */
    int top = PL_SUM_DIGITS - 1, n = 0;
    while (top > 0 && digit[top] == 0)
        top--;
    const uint64_t first = (uint64_t)digit[top], second = top > 0 ? (uint64_t)digit[top - 1] : 0;
    const uint64_t third = top > 1 ? (uint64_t)digit[top - 2] : 0;
    for (uint64_t rest = first; rest > 0; rest >>= 1)
        n++; /* bits of first: at most 32, as sums of so many terms are not made */
    if (n == 0)
        return 0;
    const uint64_t bits = first << (64 - n) | second << (PL_SUM_BITS - n) | third >> n;
    int more = (third & (((uint64_t)1 << n) - 1)) != 0;
    for (int i = 0; i < top - 2; i++)
        more |= digit[i] != 0;
    const uint64_t half = (uint64_t)1 << (EXTRA - 1);
    const uint64_t rest = bits & (((uint64_t)1 << EXTRA) - 1);
    uint64_t mantissa = bits >> EXTRA;
    const int odd = (int)(mantissa & 1);
    mantissa += rest > half || (rest == half && (more || odd));
    /* subnormal sums have no bits to lose */
    return ldexp((double)mantissa, PL_SUM_BITS * (top - 2) + n - 1075 + EXTRA);
}

double pl_sum_value(const pl_sum *sum) {
    pl_sum s = *sum;
    if (s.n_nan > 0 || (s.n_positive > 0 && s.n_negative > 0))
        return NAN;
    if (s.n_positive > 0 || s.n_negative > 0)
        return s.n_positive > 0 ? INFINITY : -INFINITY;
    borrow(&s);
    const int negative = s.digit[PL_SUM_DIGITS - 1] < 0;
    for (int i = 0; negative && i < PL_SUM_DIGITS; i++)
        s.digit[i] = -s.digit[i];
    if (negative)
        borrow(&s);
    const double value = value_of_digits(s.digit);
    return negative ? -value : value;
}
