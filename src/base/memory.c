/* memory: arrays whose size cannot overflow. */
#include "base/memory.h"

#include "base/context.h"
#include "base/system.h"

#include <limits.h>
#include <string.h>

enum {
    ALIGNMENT = 64,     /* a cache line, and the widest vector */
    OWN_PAGES = 1 << 19 /* bytes of an array whose pages cost less if they come at once */
};

static size_t round_up(size_t bytes, size_t unit) {
    return (bytes + unit - 1) / unit * unit;
}

/* ---- blocks -------------------------------------------------------------------------------- */

/** Whom a block has its memory from. */
typedef enum source { SYSTEM, CALLER, ARENA, PAGES } source;

/** Head of every array, in a cache line of its own. */
typedef struct pl_memory_block {
    pl_context *owner; /* NULL: nobody */
    void *start;       /* what the source has given */
    size_t bytes;      /* room for the array */
    source source;
    int call;                     /* of the context that wanted it last */
    struct pl_memory_block *next; /* in the list of those that are kept */
} pl_memory_block;

_Static_assert(sizeof(pl_memory_block) <= ALIGNMENT, "a block's head stands in one cache line");

static pl_memory_block *block_of(void *array) {
    return (pl_memory_block *)(void *)((char *)array - ALIGNMENT);
}

/** Return bytes of fresh memory, and its source in *from; NULL without memory. Large arrays
 *  outside of the arena have pages of their own, which go back to the system at once. The first touch
 *  of huge ones is cheap; others are populated, as it is dear one by one. */
static void *fresh_memory(pl_context *owner, size_t bytes, source *from) {
    void *start = NULL;
    if (owner && owner->allocator.allocate) {
        *from = CALLER;
        pl_context *before = pl_context_enter(NULL);
        start = owner->allocator.allocate(bytes + ALIGNMENT, owner->allocator.user);
        pl_context_enter(before);
        return start;
    }
    if (owner && bytes <= owner->largest_shared) {
        *from = ARENA;
        start = pl_arena_take(&owner->arena, bytes);
    }
    if (!start && PL_SHARES_PAGES && bytes >= OWN_PAGES) {
        const size_t last = bytes % PL_HUGE_PAGE;
        *from = PAGES;
        start = pl_system_reserve(bytes);
        if (start) { /* huge pages, if the system has any, but for the last bytes */
            pl_system_want_huge_pages(start, bytes);
            pl_system_populate((char *)start + (bytes - last), last);
        }
    }
    if (start)
        return start;
    *from = SYSTEM;
    return pl_system_allocate(ALIGNMENT, bytes);
}

/** Return a fresh block for an array of bytes, a multiple of ALIGNMENT, with its head; NULL
 *  without memory. */
static pl_memory_block *fresh_block(pl_context *owner, size_t bytes) {
    source from;
    void *start = fresh_memory(owner, bytes + ALIGNMENT, &from);
    if (!start)
        return NULL;
    pl_memory_block *block = start;
    if (from == CALLER)
        block =
            (pl_memory_block *)(void *)((char *)start + (ALIGNMENT - (uintptr_t)start % ALIGNMENT));
    *block = (pl_memory_block){.owner = owner, .start = start, .bytes = bytes, .source = from};
    if (owner)
        __atomic_fetch_add(&owner->bytes, (int64_t)bytes, __ATOMIC_RELAXED);
    return block;
}

static void release_block(pl_memory_block *block) {
    pl_context *owner = block->owner, *before;
    if (owner)
        __atomic_fetch_sub(&owner->bytes, (int64_t)block->bytes, __ATOMIC_RELAXED);
    switch (block->source) {
    case SYSTEM:
        pl_system_release(block->start);
        break;
    case CALLER:
        before = pl_context_enter(NULL);
        owner->allocator.release(block->start, owner->allocator.user);
        pl_context_enter(before);
        break;
    case ARENA:
        pl_arena_give(&owner->arena, block->start);
        break;
    case PAGES:
        pl_system_unreserve(block->start, block->bytes + ALIGNMENT);
        break;
    }
}

/* ---- blocks that are kept for the next call --------------------------------------------------
 *
 * Kept blocks change no time that was measured (below 1 %). They stay because docs/embedding.md
 * promises that a repeated call allocates nothing. */

/** Take a kept block of so many bytes; NULL: there is none. */
static pl_memory_block *take_kept(pl_context *context, size_t bytes) {
    pl_spin_lock(&context->lock);
    pl_memory_block **at = &context->kept;
    while (*at && (*at)->bytes != bytes)
        at = &(*at)->next;
    pl_memory_block *block = *at;
    if (block)
        *at = block->next;
    pl_spin_unlock(&context->lock);
    return block;
}

void pl_forget_kept(pl_context *context) {
    context->keeps = 0;
    while (context->kept) {
        pl_memory_block *block = context->kept;
        context->kept = block->next;
        release_block(block);
    }
}

void pl_forget_unwanted(pl_context *context, int call) {
    pl_memory_block *unwanted = NULL;
    pl_spin_lock(&context->lock);
    for (pl_memory_block **at = &context->kept; *at;) {
        pl_memory_block *block = *at;
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
        pl_memory_block *block = unwanted;
        unwanted = block->next;
        release_block(block);
    }
}

void pl_own_block(void *array, pl_context *context) {
    block_of(array)->owner = context;
}

/* ---- arrays -------------------------------------------------------------------------------- */

void *pl_alloc(int64_t count, size_t size) {
    pl_context *context = pl_context_current();
    if (count < 0 || (size && (uint64_t)count > (SIZE_MAX / 2) / size))
        return NULL;
    size_t bytes = (size_t)count * size;
    bytes = bytes ? round_up(bytes, ALIGNMENT) : ALIGNMENT;
    pl_memory_block *block = NULL;
    if (context && context->keeps) {
        /* One of a few sizes, an eighth apart at most. Only blocks of the very size are taken
         * again: so a call that wants what the one before wanted finds it all. */
        size_t unit = ALIGNMENT;
        while (bytes / unit >= 16)
            unit *= 2;
        bytes = round_up(bytes, unit);
        block = take_kept(context, bytes);
    }
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
    block->call = context ? context->call : 0;
    return (char *)block + ALIGNMENT;
}

void *pl_alloc_zero(int64_t count, size_t size) {
    void *array = pl_alloc(count, size);
    if (array)
        memset(array, 0, (size_t)count * size);
    return array;
}

char *pl_copy_text(const char *text) {
    const size_t size = strlen(text) + 1;
    char *copy = pl_alloc((int64_t)size, 1);
    return copy ? memcpy(copy, text, size) : NULL;
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

void *pl_append(void *array, int64_t *count, int64_t *capacity, const void *item, size_t size) {
    void *old;
    memcpy(&old, array, sizeof old);
    char *grown = pl_grow(old, *count, *count + 1, capacity, size);
    if (!grown)
        return NULL;
    memcpy(array, &grown, sizeof grown);
    return memcpy(grown + (size_t)(*count)++ * size, item, size);
}

void pl_free(void *array) {
    if (!array)
        return;
    pl_memory_block *block = block_of(array);
    pl_context *owner = block->owner;
    if (!owner || !owner->keeps) {
        release_block(block);
        return;
    }
    pl_spin_lock(&owner->lock);
    block->next = owner->kept;
    owner->kept = block;
    pl_spin_unlock(&owner->lock);
}
