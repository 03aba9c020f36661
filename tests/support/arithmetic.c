#define _GNU_SOURCE /* feenableexcept */
#include "support/arithmetic.h"

#include <fenv.h>
#include <string.h>
#ifdef __SSE2_MATH__
#include <xmmintrin.h>
#endif

void test_arithmetic_reset(void) {
    fesetenv(FE_DFL_ENV);
}

static void round_upwards(void) {
    fesetround(FE_UPWARD);
}

static void round_downwards(void) {
    fesetround(FE_DOWNWARD);
}

static void round_to_zero(void) {
    fesetround(FE_TOWARDZERO);
}

/** Some flags are up, and none is to be raised or lowered. */
static void have_raised(void) {
    feraiseexcept(FE_OVERFLOW);
}

#ifdef __SSE2_MATH__
#define FLUSHES
static void flush_subnormals(void) { /* as programs linked with -ffast-math do at their start */
    _mm_setcsr(_mm_getcsr() | 0x8040);
}
static void flush_results(void) {
    _mm_setcsr(_mm_getcsr() | 0x8000);
}
#elif defined(__aarch64__)
#define FLUSHES
static void flush_subnormals(void) {
    __asm__ volatile("msr fpcr, %0" ::"r"(1ul << 24));
}
#define flush_results flush_subnormals
#endif

#ifdef __GLIBC__
static void trap(void) {
    feenableexcept(FE_ALL_EXCEPT);
}
static void trap_upwards(void) {
    round_upwards();
    feenableexcept(FE_INEXACT | FE_UNDERFLOW);
}
#endif

int test_arithmetic_can_trap(void) {
#ifdef __GLIBC__
    const int can = feenableexcept(FE_DIVBYZERO) != -1;
    test_arithmetic_reset();
    return can;
#else
    return 0;
#endif
}

const test_arithmetic test_arithmetics[] = {
    {"upwards", round_upwards},
    {"downwards", round_downwards},
    {"to zero", round_to_zero},
    {"a flag", have_raised},
#ifdef FLUSHES
    {"flushing subnormals", flush_subnormals},
    {"flushing results", flush_results},
#endif
#ifdef __GLIBC__
    {"traps", trap},
    {"upwards with traps", trap_upwards},
#endif
    {0},
};

/** Exceptions of doubles that trap. On x86-64 <fenv.h> tells those of the old registers. */
static int trapping(void) {
#ifdef __SSE2_MATH__
    return (int)(~_mm_getcsr() >> 7 & 0x3f);
#elif defined(__GLIBC__)
    return fegetexcept();
#else
    return 0;
#endif
}

int test_arithmetic_is_usual(void) {
    const test_arithmetic_state now = test_arithmetic_now();
    return now.is_near && !now.traps && !now.flushes_results && !now.flushes_operands;
}

test_arithmetic_state test_arithmetic_now(void) {
    test_arithmetic_state state;
    fenv_t environment;
    /* volatile, all of it: compilers take no notice of environments, and would compute in another
     * one what need not be computed here */
    volatile double one = 1, small = 0x1p-1022, tiny = 0x1p-1074;
    volatile double above, below, half, large;
    memset(&state, 0, sizeof state); /* padding, too */
    fegetenv(&environment);
    state.rounding = fegetround();
    state.flags = fetestexcept(FE_ALL_EXCEPT);
    state.traps = trapping();
#ifdef __GLIBC__
    fedisableexcept(FE_ALL_EXCEPT);
#endif
    above = one + 0x1p-60;
    below = one - 0x1p-60;
    half = small * 0.5;
    large = tiny * 0x1p100;
    fesetenv(&environment);
    state.is_near = above == one && below == one;
    state.flushes_results = half == 0;
    state.flushes_operands = large == 0;
    return state;
}
