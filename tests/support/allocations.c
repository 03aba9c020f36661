/* allocations: permit the library a number of allocations, and no more. */
#include "support/allocations.h"

#include <stdatomic.h>
#include <stdlib.h>

static _Atomic int64_t left = INT64_MAX;
static _Atomic int64_t before_failure = INT64_MAX; /* negative: it has failed */

static _Atomic int64_t counted, some_begin, some_end;

void allocations_permit(int64_t permitted) {
    atomic_store(&left, permitted < 0 ? INT64_MAX : permitted);
}

void allocations_fail_one(int64_t permitted) {
    atomic_store(&before_failure, permitted);
}

int allocations_failed(void) {
    return atomic_exchange(&before_failure, INT64_MAX) < 0;
}

void allocations_fail_some(int64_t first, int64_t n) {
    atomic_store(&some_begin, 0); /* none, meanwhile */
    atomic_store(&some_end, 0);
    atomic_store(&counted, 0);
    atomic_store(&some_begin, first);
    atomic_store(&some_end, first < INT64_MAX - n ? first + n : INT64_MAX);
}

int64_t allocations_counted(void) {
    return atomic_load(&counted);
}

void *aligned_alloc(size_t alignment, size_t size) {
    void *memory = NULL;
    const int64_t number = atomic_fetch_add(&counted, 1);
    if (number >= atomic_load(&some_begin) && number < atomic_load(&some_end))
        return NULL;
    if (atomic_fetch_sub(&before_failure, 1) == 0)
        return NULL;
    if (atomic_fetch_sub(&left, 1) <= 0 || posix_memalign(&memory, alignment, size) != 0)
        return NULL;
    return memory;
}
