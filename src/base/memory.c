/* memory: arrays whose size cannot overflow. */
#include "base/memory.h"

#include "base/context.h"
#include "base/spin.h"
#include "base/system.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum {
    ALIGNMENT = 64, /* a cache line, and the widest vector */
    LARGE = 4 << 20 /* bytes: such arrays stand by themselves; with so much for each of the places
                       where they are written at a time they have huge pages of their own */
};

static size_t round_up(size_t bytes, size_t unit) {
    return (bytes + unit - 1) / unit * unit;
}

/* ---- blocks -------------------------------------------------------------------------------- */

/** What stands before every array, in a cache line of its own. */
typedef struct pl_block {
    pl_context *owner;     /* NULL: the system */
    void *start;           /* what the owner's allocator has given */
    size_t bytes;          /* room for the array */
    int call;              /* of the context that wanted it last */
    struct pl_block *next; /* in the list of those that are kept */
} pl_block;

_Static_assert(sizeof(pl_block) <= ALIGNMENT, "a block's head stands in one cache line");

static pl_block *block_of(void *array) {
    return (pl_block *)(void *)((char *)array - ALIGNMENT);
}

/** What the caller's allocator has. */
static void *ask(pl_context *owner, size_t bytes) {
    pl_context *before = pl_context_enter(NULL);
    void *start = owner->allocator.allocate(bytes, owner->allocator.user);
    pl_context_enter(before);
    return start;
}

/** Fresh memory for bytes, a multiple of ALIGNMENT, and what stands before them. */
static pl_block *fresh_block(pl_context *owner, size_t bytes) {
    pl_block *block;
    void *start = owner && bytes < LARGE ? pl_arena_take(&owner->arena, bytes + ALIGNMENT) : NULL;
    if (!start && owner && owner->allocator.allocate) {
        start = ask(owner, bytes + 2 * ALIGNMENT);
        if (!start)
            return NULL;
        block = (pl_block *)(void *)((char *)start + (ALIGNMENT - (uintptr_t)start % ALIGNMENT));
    } else {
        if (!start)
            start = pl_system_allocate(ALIGNMENT, bytes + ALIGNMENT);
        block = start;
    }
    if (!start)
        return NULL;
    *block = (pl_block){.owner = owner, .start = start, .bytes = bytes};
    if (owner)
        __atomic_fetch_add(&owner->bytes, (int64_t)bytes, __ATOMIC_RELAXED);
    return block;
}

static void release_block(pl_block *block) {
    pl_context *owner = block->owner;
    if (owner)
        __atomic_fetch_sub(&owner->bytes, (int64_t)block->bytes, __ATOMIC_RELAXED);
    if (owner && pl_arena_has(&owner->arena, block)) {
        pl_arena_give(&owner->arena, block->start);
    } else if (owner && owner->allocator.allocate) {
        pl_context *before = pl_context_enter(NULL);
        owner->allocator.release(block->start, owner->allocator.user);
        pl_context_enter(before);
    } else {
        pl_system_release(block->start);
    }
}

/* ---- blocks that are kept: the next call wants the same again -------------------------------- */

/** bytes rounded up to one of a few sizes, an eighth apart at most. Only blocks of the very size
 *  are taken again: so a call that wants what the one before wanted finds it all. */
static size_t kept_size(size_t bytes) {
    size_t unit = ALIGNMENT;
    while (bytes / unit >= 16)
        unit *= 2;
    return round_up(bytes, unit);
}

/** A kept block of so many bytes, or NULL. */
static pl_block *take_kept(pl_context *context, size_t bytes) {
    pl_spin_lock(&context->lock);
    pl_block **at = &context->kept;
    while (*at && (*at)->bytes != bytes)
        at = &(*at)->next;
    pl_block *block = *at;
    if (block)
        *at = block->next;
    pl_spin_unlock(&context->lock);
    return block;
}

static void keep(pl_context *context, pl_block *block) {
    pl_spin_lock(&context->lock);
    block->next = context->kept;
    context->kept = block;
    pl_spin_unlock(&context->lock);
}

void pl_forget_kept(pl_context *context) {
    context->keeps = 0;
    while (context->kept) {
        pl_block *block = context->kept;
        context->kept = block->next;
        release_block(block);
    }
}

void pl_forget_unwanted(pl_context *context, int call) {
    pl_block *unwanted = NULL;
    pl_spin_lock(&context->lock);
    for (pl_block **at = &context->kept; *at;) {
        pl_block *block = *at;
        if (block->call < call) {
            *at = block->next;
            block->next = unwanted;
            unwanted = block;
        } else {
            at = &block->next;
        }
    }
    pl_spin_unlock(&context->lock);
    while (unwanted) {
        pl_block *block = unwanted;
        unwanted = block->next;
        release_block(block);
    }
}

void pl_own_block(void *array, pl_context *context) {
    block_of(array)->owner = context;
}

/* ---- arrays -------------------------------------------------------------------------------- */

void *pl_alloc_scattered(int64_t count, size_t size, int64_t places) {
    pl_context *context = pl_context_current();
    if (count < 0 || (size && (uint64_t)count > (SIZE_MAX / 2) / size))
        return NULL;
    size_t bytes = (size_t)count * size;
    bytes = bytes ? round_up(bytes, ALIGNMENT) : ALIGNMENT;
    pl_block *block = NULL;
    if (context && context->keeps) {
        bytes = kept_size(bytes);
        block = take_kept(context, bytes);
    }
    const int is_fresh = !block;
    if (!block)
        block = fresh_block(context, bytes);
    if (!block && context && context->keeps) { /* what is kept for later may help now */
        pl_forget_unwanted(context, INT_MAX);
        block = fresh_block(context, bytes);
    }
    if (!block) {
        if (context)
            __atomic_store_n(&context->failed, 1, __ATOMIC_RELAXED);
        return NULL;
    }
    void *array = (char *)block + ALIGNMENT;
    block->call = context ? context->call : 0;
    if (is_fresh && (int64_t)(bytes / LARGE) >= places)
        pl_system_want_huge_pages(array, bytes);
    return array;
}

void *pl_alloc(int64_t count, size_t size) {
    return pl_alloc_scattered(count, size, 1);
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
    if (!array)
        return;
    pl_block *block = block_of(array);
    if (block->owner && block->owner->keeps)
        keep(block->owner, block);
    else
        release_block(block);
}

void pl_discard(void *begin, int64_t bytes) {
    const pl_context *context = pl_context_current();
    if (!context || !pl_arena_has(&context->arena, begin)) /* there others want the pages */
        pl_system_discard(begin, (size_t)bytes);
}
