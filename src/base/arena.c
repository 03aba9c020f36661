/* arena: a stretch of memory that many arrays share. */
#include "base/arena.h"

#include "base/system.h"

#include <stdint.h>

enum { ALIGNMENT = 64 };

/** Head of every array that is taken, in a cache line of its own. */
typedef struct pl_span {
    char *end;
    struct pl_span *next;
} pl_span;

_Static_assert(sizeof(pl_span) <= ALIGNMENT, "a span's head stands in one cache line");

void pl_arena_begin(pl_arena *arena, size_t bytes, size_t huge) {
    *arena = (pl_arena){.begin = pl_system_reserve(bytes)};
    if (!arena->begin)
        return;
    arena->bytes = bytes;
    arena->huge = huge < bytes ? huge : bytes;
    pl_system_want_huge_pages(arena->begin, arena->huge);
}

void pl_arena_end(pl_arena *arena) {
    if (arena->begin)
        pl_system_unreserve(arena->begin, arena->bytes);
    *arena = (pl_arena){0};
}

/** Make a span of the first gap of so many bytes; NULL: there is none. */
static pl_span *take_gap(pl_arena *arena, size_t bytes) {
    pl_span **at = &arena->first;
    char *begin = arena->begin;
    while (*at && (size_t)((char *)*at - begin) < bytes) {
        begin = (*at)->end;
        at = &(*at)->next;
    }
    if (!*at && (size_t)(arena->begin + arena->bytes - begin) < bytes)
        return NULL;
    pl_span *span = (pl_span *)(void *)begin;
    *span = (pl_span){.end = begin + bytes, .next = *at};
    *at = span;
    return span;
}

void *pl_arena_take(pl_arena *arena, size_t bytes) {
    if (bytes > arena->bytes)
        return NULL;
    bytes = (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT + ALIGNMENT;
    pl_spin_lock(&arena->lock);
    pl_span *span = take_gap(arena, bytes);
    pl_spin_unlock(&arena->lock);
    if (!span)
        return NULL;
    char *const small = arena->begin + arena->huge, *const end = (char *)span + bytes;
    char *const first = (char *)span < small ? small : (char *)span;
    if (first < end) /* small pages */
        pl_system_populate(first, (size_t)(end - first));
    return (char *)span + ALIGNMENT;
}

/** Give whole huge pages of a gap back to the system: arrays that are not in the arena want them.
 *  Behind end nothing has changed. */
static void give_back(char *gap, char *end, char *gap_end) {
    const size_t before = (PL_HUGE_PAGE - (uintptr_t)gap % PL_HUGE_PAGE) % PL_HUGE_PAGE;
    const size_t behind = (PL_HUGE_PAGE - (uintptr_t)end % PL_HUGE_PAGE) % PL_HUGE_PAGE;
    end = behind <= (size_t)(gap_end - end) ? end + behind : end - (PL_HUGE_PAGE - behind);
    if (end - gap > (ptrdiff_t)before)
        pl_system_discard(gap + before, (size_t)(end - gap) - before);
}

void pl_arena_give(pl_arena *arena, void *taken) {
    const pl_span *span = (const pl_span *)(const void *)((char *)taken - ALIGNMENT);
    pl_spin_lock(&arena->lock);
    pl_span **at = &arena->first;
    char *gap = arena->begin;
    while (*at != span) {
        gap = (*at)->end;
        at = &(*at)->next;
    }
    char *const end = span->end;
    *at = span->next;
    if (!arena->holds)
        give_back(gap, end, *at ? (char *)*at : arena->begin + arena->bytes);
    pl_spin_unlock(&arena->lock);
}

void pl_arena_stop_holding(pl_arena *arena) {
    if (!arena->holds)
        return;
    pl_spin_lock(&arena->lock);
    char *gap = arena->begin, *const end = arena->begin + arena->bytes;
    for (pl_span *span = arena->first; span; span = span->next) {
        give_back(gap, (char *)span, (char *)span);
        gap = span->end;
    }
    give_back(gap, end, end);
    arena->holds = 0;
    pl_spin_unlock(&arena->lock);
}
