/* round: to single precision and back. */
#ifndef PL_BASE_ROUND_H
#define PL_BASE_ROUND_H

/** The float nearest to value. Through volatile, because GCC 12 drops (double)(float)value where it
 *  vectorises neighbouring statements (seen with -O3; tests/star/test_kernel.c catches it). */
static inline double pl_round_to_float(double value) {
    volatile float rounded = (float)value;
    return (double)rounded;
}

#endif
