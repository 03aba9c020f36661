/* pairs: which pairs of levels of any two factors have occurred together. */
#ifndef TEST_SUPPORT_PAIRS_H
#define TEST_SUPPORT_PAIRS_H

#include <stdint.h>

enum { PAIRS_MAX_FACTORS = 48, PAIRS_MAX_LEVELS = 8 };

/** What can be chosen: one of its levels, each with a weight; those behind the last have 0. */
typedef struct pairs_factor {
    const char *name;
    int weight[PAIRS_MAX_LEVELS];
} pairs_factor;

/** factor [n_factors], the caller's. */
typedef struct pairs {
    int n_factors;
    const pairs_factor *factor;
    uint8_t seen[PAIRS_MAX_FACTORS][PAIRS_MAX_FACTORS][PAIRS_MAX_LEVELS][PAIRS_MAX_LEVELS];
} pairs;

/** Whether levels of two factors, a below b, can go together. */
typedef int pairs_allowed_fn(int a, int level_a, int b, int level_b);

/** Draw a level of each factor by its weights. */
void pairs_draw(const pairs *p, uint64_t *state, int *level);

/** Take note of levels that have gone together. */
void pairs_note(pairs *p, const int *level);

/** How many pairs are allowed, and *missing of them have not been noted; those are printed as lines
 *  if say is not 0. */
int64_t pairs_count(const pairs *p, pairs_allowed_fn *allowed, int say, int64_t *missing);

#endif
