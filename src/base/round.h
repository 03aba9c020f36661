/* round: round coordinates to the format that the caller stores.
 *
 *   pl_round_to_float, pl_store, pl_storage_of, pl_is_same
 */
#ifndef PL_BASE_ROUND_H
#define PL_BASE_ROUND_H

#include <planish/planish.h>

#include <math.h>

/** Format in which coordinates are stored. */
typedef struct pl_storage {
    planish_precision precision;
    planish_round_fn *round; /* with PLANISH_PRECISION_ROUNDED */
    void *user;
} pl_storage;

/** The float nearest to value. Through volatile, because GCC 12 drops (double)(float)value where it
 *  vectorises neighbouring statements (seen with -O3; tests/star/test_kernel.c catches it). */
static inline double pl_round_to_float(double value) {
    volatile float rounded = (float)value;
    return (double)rounded;
}

/** Whether two numbers are the same, signs of zeros too. */
static inline int pl_is_same(double a, double b) {
    return a == b && !signbit(a) == !signbit(b);
}

/** The value that will be stored in the place of value. */
static inline double pl_store(const pl_storage *storage, double value) {
    if (storage->precision == PLANISH_PRECISION_FLOAT)
        return pl_round_to_float(value);
    return storage->precision == PLANISH_PRECISION_ROUNDED ? storage->round(value, storage->user)
                                                           : value;
}

/** Storage that options ask for. */
static inline pl_storage pl_storage_of(const planish_options *options) {
    return (pl_storage){options->precision, options->round, options->round_user};
}

#endif
