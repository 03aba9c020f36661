/* exact: integers as long as determinants of coordinates need. Schoolbook methods, sign and
 * magnitude. */
#include "base/exact.h"

#include <float.h>
#include <limits.h>
#include <math.h>

enum { LIMB_BITS = 32, MANTISSA_BITS = 53, LOWEST_UNIT = -1074 };

int pl_exact_unit(double a) {
    int exponent;
    frexp(a, &exponent);
    int unit = exponent - MANTISSA_BITS;
    return unit > LOWEST_UNIT ? unit : LOWEST_UNIT;
}

static void trim(pl_exact *a) {
    while (a->n > 0 && a->limb[a->n - 1] == 0)
        a->n--;
}

/** Compute a / 2^unit. */
static void from_double(double a, int unit, pl_exact *result) {
    result->sign = a < 0 ? -1 : 1;
    result->n = 0;
    if (a == 0)
        return;
    int own = pl_exact_unit(a);
    uint64_t mantissa = (uint64_t)ldexp(fabs(a), -own);
    int zeros = (own - unit) / LIMB_BITS, shift = (own - unit) % LIMB_BITS;
    for (; result->n < zeros; result->n++)
        result->limb[result->n] = 0;
    uint64_t low = (mantissa & UINT32_MAX) << shift;
    uint64_t high = (mantissa >> LIMB_BITS << shift) + (low >> LIMB_BITS);
    result->limb[result->n++] = (uint32_t)low;
    result->limb[result->n++] = (uint32_t)high;
    result->limb[result->n++] = (uint32_t)(high >> LIMB_BITS);
    trim(result);
}

void pl_exact_add(const pl_exact *a, const pl_exact *b, int b_sign, pl_exact *sum) {
    const int sign = b_sign * b->sign;
    int order = (a->n > b->n) - (a->n < b->n); /* sign of |a| - |b| */
    for (int i = a->n - 1; i >= 0 && order == 0; i--)
        order = (a->limb[i] > b->limb[i]) - (a->limb[i] < b->limb[i]);
    const pl_exact *larger = order >= 0 ? a : b, *smaller = order >= 0 ? b : a;
    const int is_sum = a->sign == sign;
    uint64_t carry = 0; /* of a sum, or borrow of a difference */
    sum->sign = order >= 0 ? a->sign : sign;
    sum->n = larger->n;
    for (int i = 0; i < larger->n; i++) {
        const uint64_t from = larger->limb[i], other = i < smaller->n ? smaller->limb[i] : 0;
        const uint64_t value = is_sum ? from + other + carry : from - other - carry;
        sum->limb[i] = (uint32_t)value;
        carry = is_sum ? value >> LIMB_BITS : value >> 63;
    }
    if (is_sum && carry)
        sum->limb[sum->n++] = (uint32_t)carry;
    if (!is_sum)
        trim(sum);
}

void pl_exact_difference(double a, double b, int unit, pl_exact *difference) {
    pl_exact first, second;
    from_double(a, unit, &first);
    from_double(b, unit, &second);
    pl_exact_add(&first, &second, -1, difference);
}

void pl_exact_multiply(const pl_exact *a, const pl_exact *b, pl_exact *product) {
    product->sign = a->sign * b->sign;
    product->n = a->n + b->n;
    for (int i = 0; i < product->n; i++)
        product->limb[i] = 0;
    for (int i = 0; i < a->n; i++) {
        uint64_t carry = 0;
        for (int j = 0; j < b->n; j++) {
            carry += (uint64_t)a->limb[i] * b->limb[j] + product->limb[i + j];
            product->limb[i + j] = (uint32_t)carry;
            carry >>= LIMB_BITS;
        }
        product->limb[i + b->n] = (uint32_t)carry;
    }
    trim(product);
}

double pl_exact_round(const pl_exact *a, int *exponent) {
    enum { KEPT = 3 }; /* limbs with at least 65 bits */
    int lowest = a->n > KEPT ? a->n - KEPT : 0;
    double m = 0;
    for (int i = a->n - 1; i >= lowest; i--)
        m = m * 0x1p32 + a->limb[i];
    *exponent = lowest * LIMB_BITS;
    return a->sign * m;
}

int pl_exact_turn(const double a[2], const double b[2], const double c[2]) {
    /* Shewchuk, Adaptive precision floating-point arithmetic, 1997: 3 eps + 16 eps^2, and more. */
    const double rounding = 4e-16, smallest = 1e-280;
    const double left = (b[0] - a[0]) * (c[1] - a[1]), right = (b[1] - a[1]) * (c[0] - a[0]);
    const double turn = left - right, sum = fabs(left) + fabs(right);
    if (sum > smallest && fabs(turn) > rounding * sum && sum <= DBL_MAX)
        return turn > 0 ? 1 : -1;
    const double all[] = {a[0], a[1], b[0], b[1], c[0], c[1]};
    int unit = INT_MAX;
    for (int i = 0; i < 6; i++) {
        const int own = all[i] == 0 ? INT_MAX : pl_exact_unit(all[i]);
        unit = own < unit ? own : unit;
    }
    if (unit == INT_MAX)
        return 0;
    pl_exact edge[4], one, other, exact;
    pl_exact_difference(b[0], a[0], unit, &edge[0]);
    pl_exact_difference(c[1], a[1], unit, &edge[1]);
    pl_exact_difference(b[1], a[1], unit, &edge[2]);
    pl_exact_difference(c[0], a[0], unit, &edge[3]);
    pl_exact_multiply(&edge[0], &edge[1], &one);
    pl_exact_multiply(&edge[2], &edge[3], &other);
    pl_exact_add(&one, &other, -1, &exact);
    return exact.n == 0 ? 0 : exact.sign;
}
