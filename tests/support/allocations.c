/* allocations: permit the library a number of allocations, and no more. */
#include "support/allocations.h"

#include <stdatomic.h>
#include <stdlib.h>

static _Atomic int64_t left = INT64_MAX;
static _Atomic int64_t before_failure = INT64_MAX; /* negative: it has failed */

void allocations_permit(int64_t permitted) {
    atomic_store(&left, permitted < 0 ? INT64_MAX : permitted);
}

void allocations_fail_one(int64_t permitted) {
    atomic_store(&before_failure, permitted);
}

int allocations_failed(void) {
    return atomic_exchange(&before_failure, INT64_MAX) < 0;
}

void *aligned_alloc(size_t alignment, size_t size) {
    void *memory = NULL;
    if (atomic_fetch_sub(&before_failure, 1) == 0)
        return NULL;
    if (atomic_fetch_sub(&left, 1) <= 0 || posix_memalign(&memory, alignment, size) != 0)
        return NULL;
    return memory;
}
