#include "support/effort.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

int64_t effort(int64_t little, int64_t much) {
    return getenv("PLANISH_LONG") ? much : little;
}

int effort_step(int n) {
    return getenv("PLANISH_BRIEF") || getenv("PLANISH_QUICK") ? n : 1;
}

/* The finaliser of SplitMix64, so that neighbouring seeds have nothing in common. */
static uint64_t mix(uint64_t z) {
    z += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

uint64_t effort_seed(uint64_t number) {
    const char *seed = getenv("PLANISH_SEED");
    return mix(mix(number) + (seed ? strtoull(seed, NULL, 10) : 0)) | 1;
}

uint64_t random_bits(uint64_t *state) {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 0x2545f4914f6cdd1du;
}

int64_t random_below(uint64_t *state, int64_t n) {
    return (int64_t)(random_bits(state) % (uint64_t)n);
}

double random_unit(uint64_t *state) {
    return (double)(random_bits(state) >> 11) * 0x1p-53;
}

double random_between(uint64_t *state, double low, double high) {
    return low + (high - low) * random_unit(state);
}

void figure(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    printf("figure: ");
    vprintf(format, arguments);
    printf("\n");
    fflush(stdout);
    va_end(arguments);
}
