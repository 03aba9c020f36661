/* memory: arrays whose size cannot overflow.
 *
 *   pl_alloc, pl_alloc_zero, pl_grow, pl_append, pl_copy_text, pl_free    arrays
 *   pl_own_block                                     give an array to a context
 *   pl_forget_kept, pl_forget_unwanted               release blocks kept for the next call
 */
#ifndef PL_BASE_MEMORY_H
#define PL_BASE_MEMORY_H

#include <stddef.h>
#include <stdint.h>

/* Memory comes from the context that the thread is in (context.h), if any, and goes back to the one
 * that it came from. */
struct pl_context;

/** Bytes with room for a huge page or two: an array of so many can have pages of its own. */
enum { PL_LARGE_ARRAY = 4 << 20 };

/** Allocate count elements of size bytes, uninitialised and aligned to 64 bytes, to be released by
 * pl_free. NULL if count is negative, the product overflows or there is no memory. A count of 0
 * gives a valid pointer. Huge pages are not touched: those of large arrays are placed by the thread
 * that writes first; the part that fills no huge page may be resident at once. */
void *pl_alloc(int64_t count, size_t size);

/** Allocate as pl_alloc does, zeroed. */
void *pl_alloc_zero(int64_t count, size_t size);

/** Grow array (from pl_alloc, or NULL with count 0) to at least needed elements, by half at least.
 *  Updates *capacity; returns the new array, or NULL (the old one stays valid). */
void *pl_grow(void *array, int64_t count, int64_t needed, int64_t *capacity, size_t size);

/** Append *item, of size bytes, to the array that array points to (a T **), of *count elements with
 *  room for *capacity. Return where it is, or NULL without memory. item is none of the array. */
void *pl_append(void *array, int64_t *count, int64_t *capacity, const void *item, size_t size);

/** Copy text to an array from pl_alloc; NULL without memory. */
char *pl_copy_text(const char *text);

/** Release array, from any function above; NULL: do nothing. */
void pl_free(void *array);

/** Say that array is context's. */
void pl_own_block(void *array, struct pl_context *context);

/** Release the blocks that context keeps, and keep no further ones. */
void pl_forget_kept(struct pl_context *context);

/** Release the kept blocks that no call since call has wanted. */
void pl_forget_unwanted(struct pl_context *context, int call);

#endif
