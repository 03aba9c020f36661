/* arena: a stretch of memory that many arrays share.
 *
 * The first touch of a page of 4 kB takes as long as the rings of several nodes, and an array of a
 * megabyte is too small for a huge page of its own. In an arena arrays lie side by side and share
 * huge pages; an array finds the resident pages that an earlier array has given back.
 *
 * Without the arena the set-up of a million tetrahedra takes 17 % longer, of 100 000 40 % (two
 * cores; planish smooth --json, best of 7 in turns).
 *
 *   pl_arena_begin, _end      reserve the memory, release it
 *   pl_arena_take, _give      take memory for an array, give it back
 *   pl_arena_settle           hold given-back pages no longer
 *   pl_arena_has              whether a place is in the arena
 */
#ifndef PL_BASE_ARENA_H
#define PL_BASE_ARENA_H

#include <stddef.h>

typedef struct pl_arena {
    char *begin;           /* NULL: there is none, */
    size_t bytes;          /* and 0 */
    size_t huge;           /* of them, in huge pages */
    int holds;             /* what is given back stays resident */
    struct pl_span *first; /* those that are taken, by their places */
    int lock;              /* see spin.h */
} pl_arena;

/** Reserve bytes of address space, the first huge of them in huge pages if the system has any.
 *  No byte is resident before it is taken. If the system refuses, the arena is empty. */
void pl_arena_begin(pl_arena *arena, size_t bytes, size_t huge);

/** The end of all that was taken, too. */
void pl_arena_end(pl_arena *arena);

/** bytes, uninitialised and aligned to 64, at the first place where they have room; NULL: nowhere.
 *  What of them is in small pages becomes resident. By several threads at once. */
void *pl_arena_take(pl_arena *arena, size_t bytes);

/** Give back what was taken: whole huge pages in which nothing is any more go back to the system,
 * if the arena does not hold them for what will be taken next. */
void pl_arena_give(pl_arena *arena, void *taken);

/** Hold no longer: what was held goes back. */
void pl_arena_settle(pl_arena *arena);

/** Whether place is in the arena. */
int pl_arena_has(const pl_arena *arena, const void *place);

#endif
