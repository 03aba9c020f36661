/* memory: arrays whose size cannot overflow. */
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

enum {
    ALIGNMENT = 64, /* a cache line, and the widest vector */
    HUGE_PAGE = 1 << 21,
    MANY_PAGES = 2 /* of smaller arrays too much would be resident that nobody uses */
};

static size_t round_up(size_t bytes, size_t unit) {
    return (bytes + unit - 1) / unit * unit;
}

/** Ask for huge pages within an array, if there are many for each of the places where it is written
 *  at a time: fewer page faults, and fewer misses of the page table. A refusal does no harm. */
static void want_huge_pages(void *array, size_t bytes, int64_t places) {
#ifdef MADV_HUGEPAGE
    const uintptr_t begin = round_up((uintptr_t)array, HUGE_PAGE);
    const uintptr_t end = ((uintptr_t)array + bytes) / HUGE_PAGE * HUGE_PAGE;
    if (array && end > begin && (int64_t)((end - begin) / HUGE_PAGE / MANY_PAGES) >= places)
        madvise((void *)begin, end - begin, MADV_HUGEPAGE);
#else
    (void)array;
    (void)bytes;
    (void)places;
#endif
}

void *pl_alloc(int64_t count, size_t size) {
    return pl_alloc_scattered(count, size, 1);
}

void *pl_alloc_scattered(int64_t count, size_t size, int64_t places) {
    if (count < 0 || (size && (uint64_t)count > (SIZE_MAX / 2) / size))
        return NULL;
    size_t bytes = (size_t)count * size;
    bytes = bytes ? round_up(bytes, ALIGNMENT) : ALIGNMENT;
    void *array = aligned_alloc(ALIGNMENT, bytes);
    want_huge_pages(array, bytes, places);
    return array;
}

void *pl_alloc_zero(int64_t count, size_t size) {
    void *array = pl_alloc(count, size);
    if (array)
        memset(array, 0, (size_t)count * size);
    return array;
}

void *pl_grow(void *array, int64_t count, int64_t needed, int64_t *capacity, size_t size) {
    if (needed <= *capacity && array)
        return array;
    int64_t wanted = needed > INT64_MAX / 2 ? needed : needed + needed / 2;
    if (wanted < 16)
        wanted = 16;
    void *grown = pl_alloc(wanted, size);
    if (!grown)
        return NULL;
    if (count > 0)
        memcpy(grown, array, (size_t)count * size);
    pl_free(array);
    *capacity = wanted;
    return grown;
}

void pl_free(void *array) {
    free(array);
}

void pl_discard(void *begin, int64_t bytes) {
#ifdef __linux__
    const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE), from = (uintptr_t)begin;
    const uintptr_t first = (from + page - 1) / page * page;
    const uintptr_t end = (from + (uintptr_t)bytes) / page * page;
    if (end > first)
        madvise((void *)first, end - first, MADV_DONTNEED); /* a refusal does no harm */
#else
    (void)begin;
    (void)bytes;
#endif
}
