/* jets: numbers of 113 bits with their first and second derivatives by a point in space.
 *
 * Sums, products and functions of jets have the derivatives that calculus says; nothing else is
 * known here. Besides, each has the sizes of its value, gradient and Hessian with all terms taken
 * absolutely: what cancels in them does so in any formula, and errors are judged by them. A jet
 * that is a length, an area, a measure is as large as it is, however it was computed: jet_part.
 */
#ifndef TEST_SUPPORT_JETS_H
#define TEST_SUPPORT_JETS_H

#include <math.h>
#include <quadmath.h>

__extension__ typedef __float128 quad;

/** Of the Hessian xx xy xz yy yz zz. */
typedef struct jet {
    quad value, gradient[3], hessian[6];
    long double size[3]; /* of value, gradient, Hessian */
} jet;

static const int jet_row[6] = {0, 0, 0, 1, 1, 2}, jet_column[6] = {0, 1, 2, 1, 2, 2};

static inline jet jet_constant(quad a) {
    return (jet){.value = a, .size = {(long double)fabsq(a), 0, 0}};
}

/** Coordinate d of the point, which is a there. */
static inline jet jet_variable(quad a, int d) {
    jet x = jet_constant(a);
    x.gradient[d] = 1;
    x.size[1] = 1;
    return x;
}

/** a + factor b. */
static inline jet jet_sum(jet a, quad factor, jet b) {
    a.value += factor * b.value;
    for (int d = 0; d < 3; d++)
        a.gradient[d] += factor * b.gradient[d];
    for (int k = 0; k < 6; k++)
        a.hessian[k] += factor * b.hessian[k];
    for (int i = 0; i < 3; i++)
        a.size[i] += (long double)fabsq(factor) * b.size[i];
    return a;
}

static inline jet jet_scaled(quad factor, jet a) {
    return jet_sum(jet_constant(0), factor, a);
}

static inline jet jet_product(jet a, jet b) {
    jet c = {.value = a.value * b.value};
    for (int d = 0; d < 3; d++)
        c.gradient[d] = a.value * b.gradient[d] + b.value * a.gradient[d];
    for (int k = 0; k < 6; k++)
        c.hessian[k] = a.value * b.hessian[k] + b.value * a.hessian[k] +
                       a.gradient[jet_row[k]] * b.gradient[jet_column[k]] +
                       a.gradient[jet_column[k]] * b.gradient[jet_row[k]];
    c.size[0] = a.size[0] * b.size[0];
    c.size[1] = a.size[0] * b.size[1] + b.size[0] * a.size[1];
    c.size[2] = a.size[0] * b.size[2] + b.size[0] * a.size[2] + 2 * a.size[1] * b.size[1];
    return c;
}

/** A function of a with this value and these derivatives at it. */
static inline jet jet_function(jet a, quad value, quad slope, quad bend) {
    jet f = {.value = value};
    const long double of_slope = (long double)fabsq(slope), of_bend = (long double)fabsq(bend);
    for (int d = 0; d < 3; d++)
        f.gradient[d] = slope * a.gradient[d];
    for (int k = 0; k < 6; k++)
        f.hessian[k] =
            slope * a.hessian[k] + bend * (a.gradient[jet_row[k]] * a.gradient[jet_column[k]]);
    f.size[0] = (long double)fabsq(value);
    f.size[1] = of_slope * a.size[1];
    f.size[2] = of_slope * a.size[2] + of_bend * a.size[1] * a.size[1];
    return f;
}

/** a^power of a > 0, without the exponential function where it is seldom needed. */
static inline jet jet_power(jet a, double power) {
    const quad value = power == 0.5  ? sqrtq(a.value)
                       : power == -1 ? 1 / a.value
                       : power == -4 ? 1 / (a.value * a.value * a.value * a.value)
                                     : powq(a.value, power);
    const quad slope = power * value / a.value;
    return jet_function(a, value, slope, (power - 1) * slope / a.value);
}

/** a^32. */
static inline jet jet_power_32(jet a) {
    quad value = a.value;
    for (int i = 0; i < 5; i++)
        value *= value;
    const quad slope = 32 * value / a.value;
    return jet_function(a, value, slope, 31 * slope / a.value);
}

/** The same jet, with the sizes that its value and its derivatives have. */
static inline jet jet_part(jet a) {
    quad squares[2] = {0, 0};
    for (int d = 0; d < 3; d++)
        squares[0] += a.gradient[d] * a.gradient[d];
    for (int k = 0; k < 6; k++)
        squares[1] += (jet_row[k] == jet_column[k] ? 1 : 2) * a.hessian[k] * a.hessian[k];
    a.size[0] = (long double)fabsq(a.value);
    a.size[1] = sqrtl((long double)squares[0]);
    a.size[2] = sqrtl((long double)squares[1]);
    return a;
}

#endif
