/* arena: a stretch of memory that many arrays share.
 *
 * The first touch of a page of 4 kB takes as long as the rings of several nodes. An array of a
 * megabyte is too small for a huge page of its own. In an arena arrays lie side by side and share
 * huge pages; an array finds the resident pages that an earlier array has given back.
 *
 * Without the arena the set-up of a million tetrahedra takes 17 % longer, of 100 000 40 % (two
 * cores; planish smooth --json, best of 7 in turns).
 *
 *   pl_arena_begin, _end      reserve the memory, release it
 *   pl_arena_take, _give      take memory for an array, give it back
 *   pl_arena_stop_holding     hold given-back pages no longer
 *   pl_spin_lock, _unlock     a lock
 */
#ifndef PL_BASE_ARENA_H
#define PL_BASE_ARENA_H

#include <sched.h>
#include <stddef.h>

typedef struct pl_arena {
    char *begin;           /* NULL: there is none, */
    size_t bytes;          /* and 0 */
    size_t huge;           /* of them, in huge pages */
    int holds;             /* what is given back stays resident */
    struct pl_span *first; /* those that are taken, by their places */
    int lock;              /* see pl_spin_lock */
} pl_arena;

/** Reserve bytes of address space, the first huge of them in huge pages if the system has any.
 *  No byte is resident before it is taken. If the system refuses, the arena is empty. */
void pl_arena_begin(pl_arena *arena, size_t bytes, size_t huge);

/** Release the memory, with all that was taken. */
void pl_arena_end(pl_arena *arena);

/** Take bytes, uninitialised and aligned to 64, at the first place where they have room; NULL:
 *  nowhere. Those in small pages become resident. Several threads may call it at once. */
void *pl_arena_take(pl_arena *arena, size_t bytes);

/** Give back what was taken: empty huge pages go back to the system, unless the arena holds them
 *  for the next arrays. */
void pl_arena_give(pl_arena *arena, void *taken);

/** Hold given-back pages no longer: they go back to the system. */
void pl_arena_stop_holding(pl_arena *arena);

/* ---- a lock that is held for microseconds, and seldom wanted by two threads; 0: nobody has it --
 */

/** Wait until nobody has the lock, and take it. */
static inline void pl_spin_lock(int *lock) {
    while (__atomic_exchange_n(lock, 1, __ATOMIC_ACQUIRE))
        sched_yield();
}

/** Release the lock. */
static inline void pl_spin_unlock(int *lock) {
    __atomic_store_n(lock, 0, __ATOMIC_RELEASE);
}

#endif
