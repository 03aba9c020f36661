/* arithmetic: the floating-point environment that the library computes in. */
#include "base/arithmetic.h"

#ifdef __SSE2_MATH__

#include <xmmintrin.h>

/* MXCSR at the start of every process: all exceptions masked, and all other bits 0. */
#define USUAL 0x1f80u

pl_arithmetic pl_arithmetic_usual(void) {
    const pl_arithmetic before = {_mm_getcsr()};
    _mm_setcsr(USUAL);
    return before;
}

void pl_arithmetic_set(const pl_arithmetic *arithmetic) {
    _mm_setcsr(arithmetic->control);
}

#else

pl_arithmetic pl_arithmetic_usual(void) {
    pl_arithmetic before;
    fegetenv(&before.environment);
    fesetenv(FE_DFL_ENV);
    return before;
}

void pl_arithmetic_set(const pl_arithmetic *arithmetic) {
    fesetenv(&arithmetic->environment);
}

#endif
