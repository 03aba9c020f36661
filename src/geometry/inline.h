/* inline: loops over many elements become vectors only if their whole body is inlined. */
#ifndef PL_GEOMETRY_INLINE_H
#define PL_GEOMETRY_INLINE_H

#if defined(__GNUC__)
#define PL_INLINE static inline __attribute__((always_inline))
#else
#define PL_INLINE static inline
#endif

#endif
