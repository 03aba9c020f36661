/* allocations: permit the library a number of allocations, and no more.
 *
 * A program that links this file gets its aligned_alloc, the one that pl_alloc calls for arrays
 * that have no pages of their own (memory.c): those of small meshes.
 */
#ifndef TEST_SUPPORT_ALLOCATIONS_H
#define TEST_SUPPORT_ALLOCATIONS_H

#include <stdint.h>

/** Let the next permitted allocations succeed and all others fail; negative: let all succeed. */
void allocations_permit(int64_t permitted);

/** Let the next permitted allocations succeed, the one after them fail, and all others succeed. */
void allocations_fail_one(int64_t permitted);

/** Whether that one has failed; ends the wait for it. */
int allocations_failed(void);

/** Begin to count; the first allocations succeed, the n after them fail, and all others succeed. */
void allocations_fail_some(int64_t first, int64_t n);

/** Allocations asked for since then. */
int64_t allocations_counted(void);

#endif
