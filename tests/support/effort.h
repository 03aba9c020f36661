/* effort: how much randomised tests do, and their random numbers.
 *
 * Tests that draw their cases do a few of them in tools/check and many in tools/check --long, which
 * sets PLANISH_LONG. PLANISH_SEED, a number, draws other cases. Figures are printed for
 * docs/reliability.md.
 */
#ifndef TEST_SUPPORT_EFFORT_H
#define TEST_SUPPORT_EFFORT_H

#include "base/printf.h"

#include <stdint.h>

/** much if PLANISH_LONG is set, else little. */
int64_t effort(int64_t little, int64_t much);

/** The step through a list of cases: 1, or n if PLANISH_BRIEF or PLANISH_QUICK is set. The one is where a
 *  sanitizer makes a test seven times as slow: it has to see what the test does, but not with every
 *  case. The other is tools/check without --full. */
int effort_step(int n);

/** The state that a sequence of random numbers begins with: one for each number, and others with
 *  each PLANISH_SEED. Never 0. */
uint64_t effort_seed(uint64_t number);

/** The next 64 random bits; draw twice in one list of arguments, and the order is the compiler's choice
 *  (xorshift64*, Marsaglia 2003, Vigna 2016). */
uint64_t random_bits(uint64_t *state);

/** In [0, n), n > 0. */
int64_t random_below(uint64_t *state, int64_t n);

/** In [0, 1). */
double random_unit(uint64_t *state);

/** In [low, high). */
double random_between(uint64_t *state, double low, double high);

/** A line "figure: text" on standard output. */
void figure(const char *format, ...) PL_PRINTF(1, 2);

#endif
