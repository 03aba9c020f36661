/* inline: loops over many elements become vectors only if their whole body is inlined. And the
 * arithmetic that all formulas stand on. */
#ifndef PL_GEOMETRY_INLINE_H
#define PL_GEOMETRY_INLINE_H

#include <float.h>

#if FLT_EVAL_METHOD != 0
#error "planish needs arithmetic in double itself, not in a wider type: on x86, -msse2 -mfpmath=sse"
#endif

#if defined(__GNUC__)
#define PL_INLINE static inline __attribute__((always_inline))
#else
#define PL_INLINE static inline
#endif

/* Keep rare code out of the way of frequent code. */
#if defined(__GNUC__)
#define PL_NOINLINE static __attribute__((noinline))
#else
#define PL_NOINLINE static
#endif

#endif
