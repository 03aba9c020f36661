/* arithmetic: the floating-point environment that the library computes in: round to nearest,
 * subnormals kept, no traps.
 *
 * A caller may have another one: interval arithmetic rounds upwards, programs linked with
 * -ffast-math flush subnormals to zero, others unmask exceptions; and a thread has what the thread
 * had that made it. All of it is as before, flags included, when the caller sees it again.
 */
#ifndef PL_BASE_ARITHMETIC_H
#define PL_BASE_ARITHMETIC_H

/* Where doubles are computed in SSE's registers their control register says it all, and is some
 * twenty times as fast to set as what <fenv.h> does about it. */
#ifdef __SSE2_MATH__
typedef struct pl_arithmetic {
    unsigned control;
} pl_arithmetic;
#else
#include <fenv.h>
typedef struct pl_arithmetic {
    fenv_t environment;
} pl_arithmetic;
#endif

/** Compute as usual on this thread from now on; the arithmetic before, to be set again. */
pl_arithmetic pl_arithmetic_usual(void);

/** Set the arithmetic that pl_arithmetic_usual returned. */
void pl_arithmetic_set(const pl_arithmetic *arithmetic);

#endif
