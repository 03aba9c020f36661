/* target_ratio: ratios of elements against targets, by plain loops in long double. */
#ifndef TEST_SUPPORT_TARGET_RATIO_H
#define TEST_SUPPORT_TARGET_RATIO_H

#include <stdint.h>

/** Return the square of what counts of an element of a planish_cell_type, whose nodes are node, at x
 *  against what it is at reference, both [.][dim]: AR^2, and with a weight of sizes these, too. */
long double target_square_of(int type, const int32_t *node, const double *x,
                             const double *reference, double weight);

#endif
