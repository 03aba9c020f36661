/* context: who serves a call of the library. */
#include "base/context.h"

#include "base/memory.h"
#include "base/system.h"

#include <stdarg.h>
#include <stdio.h>
#ifdef __SSE2_MATH__
#include <xmmintrin.h>
#endif

static _Thread_local pl_context *current;

pl_context *pl_context_enter(pl_context *context) {
    pl_context *before = current;
    current = context;
    return before;
}

pl_outside pl_call_enter(pl_context *context) {
    pl_outside outside = {.context = pl_context_enter(context)};
#ifdef __SSE2_MATH__
    enum { USUAL = 0x1f80 }; /* as every process starts: all exceptions masked, other bits 0 */
    outside.arithmetic = _mm_getcsr();
    _mm_setcsr(USUAL);
#else
    fegetenv(&outside.arithmetic);
    fesetenv(FE_DFL_ENV);
#endif
    return outside;
}

void pl_call_leave(const pl_outside *outside) {
    pl_context_enter(outside->context);
#ifdef __SSE2_MATH__
    _mm_setcsr(outside->arithmetic);
#else
    fesetenv(&outside->arithmetic);
#endif
}

void pl_context_begin(pl_context *context) {
    context->call++;
    context->failed = 0;
}

void pl_context_end(pl_context *context) {
    pl_forget_unwanted(context, context->call - 1);
}

pl_context *pl_context_current(void) {
    return current;
}

pl_context *pl_context_create(const planish_options *options) {
    const planish_allocator *allocator = options->allocator;
    pl_context first = {.parallel = options->parallel,
                        .parallel_user = options->parallel_user,
                        .log = options->log,
                        .log_user = options->log_user};
    if (allocator)
        first.allocator = *allocator;
    pl_context *before = pl_context_enter(&first);
    pl_context *context = pl_alloc(1, sizeof *context);
    pl_context_enter(before);
    if (!context)
        return NULL;
    *context = first;
    pl_own_block(context, context);
    return context;
}

void pl_context_pool_pages(pl_context *context, int64_t n_elements, int all) {
    enum {
        /* Addresses: more than the arrays of a plan take at once. */
        BYTES_PER_ELEMENT = 128,
        /* Resident if they are touched: little more than these arrays take. */
        HUGE_PER_ELEMENT = 95,
        MAX_BYTES = 32 << 20 /* of a larger mesh most arrays are large */
    };
    const int has_addresses = SIZE_MAX > UINT32_MAX;
    int64_t bytes = n_elements * BYTES_PER_ELEMENT;
    const int is_large = bytes > MAX_BYTES;
    if (is_large && !(all && has_addresses))
        bytes = MAX_BYTES;
    int64_t huge = bytes * HUGE_PER_ELEMENT / BYTES_PER_ELEMENT / PL_HUGE_PAGE * PL_HUGE_PAGE;
    if (is_large && all) /* what the last page has too much does not count */
        huge = bytes;
    if (!PL_SHARES_PAGES || huge == 0 || context->allocator.allocate)
        return;
    pl_arena_begin(&context->arena, (size_t)bytes, (size_t)huge);
    context->arena.holds = all && context->arena.begin;
    context->largest_shared = all ? (size_t)bytes : PL_LARGE_ARRAY - 1;
}

void pl_context_keep_blocks(pl_context *context) {
    context->keeps = 1;
    pl_arena_stop_holding(&context->arena);
}

void pl_context_destroy(pl_context *context) {
    if (!context)
        return;
    pl_forget_kept(context);
    pl_context last = *context;
    pl_own_block(context, &last);
    pl_free(context);
    pl_arena_end(&last.arena);
}

void pl_log(planish_log_level level, const char *format, ...) {
    pl_context *context = current;
    char text[512];
    if (!context || !context->log)
        return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    pl_context_enter(NULL);
    context->log(level, text, context->log_user);
    pl_context_enter(context);
}
