/* context: the services that a call of the library uses: memory, threads, log and the part
 * of the mesh that this process has.
 *
 * Each plan owns a context, and each call on the plan enters it. The context is then *current*: a
 * thread-local variable (context.c) names it, on the calling thread and on the threads that work
 * for the call. Functions need not be handed the context. The current context decides
 *
 *   the allocator        pl_alloc and pl_free       memory.h, arena.h
 *   the threads          pl_parallel_for            parallel.h
 *   the log              pl_log                     below
 *   the process' part    pl_parts_*                 parts.h
 *
 * Without a current context, as in the file formats, memory is the system's, threads are OpenMP's,
 * nobody listens, and the whole mesh is in this process. While the caller's functions run there is
 * no current context.
 *
 * Two fields of the context are hidden state that decides the result of a call:
 *
 *   failed        an allocation has failed on the way: phases skip work that lacks memory, and
 *                 planish_smooth then fails rather than return another mesh
 *   unreached     another process was not reached: nobody is asked any more, and every call that
 *                 asks others fails (pl_parts_check); it is never reset
 *
 * The library has no other hidden state that a result could depend on. One more variable is not
 * constant: hwloc's description of the machine (plan/placement.c), which is loaded once and then
 * only read; it decides on which cores threads run.
 *
 *   pl_context_create, _destroy              make and free a context
 *   pl_context_pool_pages, _keep_blocks      how its arrays share pages, and until when
 *   pl_context_enter, pl_context_current     set and read the current context
 *   pl_call_enter, _leave                    a thread works for a call
 *   pl_context_begin, _end                   a call works on the plan
 *   pl_log                                   tell the caller
 */
#ifndef PL_BASE_CONTEXT_H
#define PL_BASE_CONTEXT_H

#include "base/printf.h"

#include <planish/planish.h>

#include "base/arena.h"

/* The library computes in one floating-point environment: round to nearest, subnormals kept, no
 * traps. A caller may have another one: interval arithmetic rounds upwards, programs linked with
 * -ffast-math flush subnormals to zero, others unmask exceptions; and a thread has what the thread
 * had that made it. All of it is as before, flags included, when the caller sees it again.
 *
 * Where doubles are computed in SSE's registers, their control register is enough. It is some
 * twenty times as fast to set as the environment of <fenv.h>. */
#ifdef __SSE2_MATH__
typedef unsigned pl_arithmetic;
#else
#include <fenv.h>
typedef fenv_t pl_arithmetic;
#endif

typedef struct pl_context {
    planish_allocator allocator;   /* allocate NULL: the system's */
    planish_parallel_fn *parallel; /* NULL: OpenMP's */
    void *parallel_user;
    planish_log_fn *log; /* or NULL */
    void *log_user;
    const planish_part *part; /* see parts.h; NULL: the whole mesh is in this process */
    int unreached;            /* another process was not reached, ever */
    int32_t *shared;          /* [n_shared] the part's SHARED nodes, and */
    void *shared_values;      /* [n_shared] room for a value of each */
    int64_t n_shared;
    int keeps;      /* blocks that are released are kept for the next that want some */
    int64_t bytes;  /* of all blocks, those that are kept among them */
    int failed;     /* an allocation has failed since pl_context_begin */
    int call;       /* number of the call that is under way, or the last: see pl_context_begin */
    pl_arena arena; /* where its arrays are, as far as they have room */
    size_t largest_shared;        /* bytes of the largest that may be: see memory.c */
    struct pl_memory_block *kept; /* see memory.c */
    int lock;                     /* of kept */
} pl_context;

/** Make a context as options say, which holds its own memory, or NULL without memory. */
pl_context *pl_context_create(const planish_options *options);

/* 0: no array has pages of the library's own, as the address sanitizer is to see it by itself. */
#define PL_SHARES_PAGES 1
#ifdef __SANITIZE_ADDRESS__
#undef PL_SHARES_PAGES
#define PL_SHARES_PAGES 0
#elif defined __has_feature
#if __has_feature(address_sanitizer)
#undef PL_SHARES_PAGES
#define PL_SHARES_PAGES 0
#endif
#endif

/** Let the arrays of context, which works on so many elements, share their pages: the smaller ones,
 *  or with all each of them, and then what is given back is held until pl_context_keep_blocks. Not
 *  those of few elements, and not where memory is the caller's. */
void pl_context_pool_pages(pl_context *context, int64_t n_elements, int all);

/** Keep, from now on, released arrays for later ones of their size, and hold nothing else.
 *  Call it when the arrays that stay have been made. */
void pl_context_keep_blocks(pl_context *context);

/** Free context, once all arrays allocated in it have been released. context may be NULL. */
void pl_context_destroy(pl_context *context);

/** Enter context (NULL: none) on this thread. Return the context before, to be entered again at the
 *  end. Callbacks run without a context. */
pl_context *pl_context_enter(pl_context *context);

/** State of a thread before it worked for a call. */
typedef struct pl_outside {
    pl_context *context;
    pl_arithmetic arithmetic;
} pl_outside;

/** Begin the work of this thread for a call: enter context (may be NULL), and set the library's
 *  floating-point environment, with or without a context. Callbacks run in that environment, too.
 */
pl_outside pl_call_enter(pl_context *context);

/** End the work for a call: the thread's state is again as it was outside. */
void pl_call_leave(const pl_outside *outside);

/** Begin a call on the plan. */
void pl_context_begin(pl_context *context);

/** End the call on the plan. Kept blocks that neither this call nor the one before wanted are
 *  released. */
void pl_context_end(pl_context *context);

/** Return the context that this thread is in, or NULL. */
pl_context *pl_context_current(void);

/** Tell the caller, if it listens; on the thread that called the library. */
void pl_log(planish_log_level level, const char *format, ...) PL_PRINTF(2, 3);

#endif
