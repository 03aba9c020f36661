/* The arena: places against a model, what stays and what goes back, several threads; and which
 * arrays are in one. */
#include "base/arena.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/system.h"
#include "support/effort.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

#include <cmocka.h>

enum { HEAD = 64, MEGABYTE = 1 << 20, BYTES = 16 * MEGABYTE };

/** Whether place is in the arena. */
static int is_in(const pl_arena *arena, const void *place) {
    const uintptr_t begin = (uintptr_t)arena->begin, at = (uintptr_t)place;
    return at >= begin && at - begin < arena->bytes;
}

/** An arena of BYTES, or the test is skipped: the system maps no pages. */
static void begin(pl_arena *arena) {
    pl_arena_begin(arena, BYTES, BYTES / 2);
    if (!arena->begin)
        skip();
}

/* ---- places --------------------------------------------------------------------------------- */

/** What is taken, as the model has it: by places. */
typedef struct taken {
    unsigned char *at;
    size_t bytes;
    unsigned char mark; /* that all of it holds */
} taken;

enum { MOST = 200 };

typedef struct model {
    const pl_arena *arena;
    taken list[MOST];
    int n;
} model;

static size_t whole(size_t bytes) {
    return HEAD + (bytes + HEAD - 1) / HEAD * HEAD;
}

/** Where the first gap with room for bytes is in the model's list, and its place; NULL: nowhere. */
static unsigned char *first_gap(const model *m, size_t bytes, int *index) {
    unsigned char *gap = (unsigned char *)m->arena->begin;
    for (*index = 0; *index < m->n; ++*index) {
        const taken *next = m->list + *index;
        if ((size_t)(next->at - HEAD - gap) >= whole(bytes))
            return gap + HEAD;
        gap = next->at + whole(next->bytes) - HEAD;
    }
    const size_t left = (size_t)((unsigned char *)m->arena->begin + m->arena->bytes - gap);
    return left >= whole(bytes) ? gap + HEAD : NULL;
}

static void check_content(const taken *t) {
    for (size_t i = 0; i < t->bytes; i++)
        if (t->at[i] != t->mark)
            fail_msg("byte %zu of %zu has changed", i, t->bytes);
}

static void take(model *m, pl_arena *arena, size_t bytes, unsigned char mark) {
    int index;
    unsigned char *const expected = first_gap(m, bytes, &index);
    unsigned char *const at = pl_arena_take(arena, bytes);
    assert_ptr_equal(at, expected);
    if (!at)
        return;
    assert_int_equal((uintptr_t)at % HEAD, 0);
    assert_true(is_in(arena, at) && is_in(arena, at + bytes - 1));
    memset(at, mark, bytes);
    memmove(m->list + index + 1, m->list + index, (size_t)(m->n - index) * sizeof *m->list);
    m->list[index] = (taken){at, bytes, mark};
    m->n++;
}

static void give(model *m, pl_arena *arena, int index) {
    check_content(m->list + index);
    pl_arena_give(arena, m->list[index].at);
    m->n--;
    memmove(m->list + index, m->list + index + 1, (size_t)(m->n - index) * sizeof *m->list);
}

/** Taken and given at random, from bytes to megabytes, now and then until it is full: always the
 *  first gap, and what is taken keeps what was written there while gaps beside it go back. */
static void as_the_model(void **state) {
    (void)state;
    const int64_t steps = effort(3000, 100000);
    pl_arena arena;
    uint64_t random = effort_seed(1);
    int refused = 0;
    begin(&arena);
    model m = {.arena = &arena};
    for (int64_t step = 0; step < steps; step++) {
        const size_t most = (size_t)1 << (6 + random_below(&random, 18)); /* to 8 MB */
        const size_t bytes = 1 + (size_t)random_below(&random, (int64_t)most);
        const int grows = step / 200 % 2 == 0;
        if (m.n < MOST && random_below(&random, 4) < (grows ? 3 : 1)) {
            const int before = m.n;
            take(&m, &arena, bytes, (unsigned char)random_below(&random, 256));
            refused += m.n == before;
        } else if (m.n > 0) {
            give(&m, &arena, (int)random_below(&random, m.n));
        }
    }
    assert_true(refused > 0);
    while (m.n > 0)
        give(&m, &arena, (int)random_below(&random, m.n));
    take(&m, &arena, BYTES - HEAD, 1); /* there is one gap again */
    assert_int_equal(m.n, 1);
    take(&m, &arena, 1, 1);
    assert_int_equal(m.n, 1);
    pl_arena_end(&arena);
}

/** Of a gap whole huge pages go back, and are zero afterwards, but no byte of what is beside it. */
static void gaps_go_back(void **state) {
    (void)state;
    static const size_t below[] = {HEAD, 2 * MEGABYTE - 2 * HEAD, 3 * MEGABYTE};
    static const size_t gaps[] = {MEGABYTE, 3 * MEGABYTE, 4 * MEGABYTE, 7 * MEGABYTE};
    for (size_t b = 0; b < sizeof below / sizeof *below; b++)
        for (size_t g = 0; g < sizeof gaps / sizeof *gaps; g++) {
            pl_arena arena;
            begin(&arena);
            model m = {.arena = &arena};
            take(&m, &arena, below[b], 1);
            take(&m, &arena, gaps[g], 2);
            take(&m, &arena, MEGABYTE, 3);
            unsigned char *const gap = m.list[1].at;
            give(&m, &arena, 1);
            for (int i = 0; i < 2; i++)
                check_content(m.list + i);
            const uintptr_t page = PL_HUGE_PAGE, end = (uintptr_t)gap + gaps[g];
            for (uintptr_t p = ((uintptr_t)gap + page - 1) / page * page; p + page <= end;
                 p += page)
                for (size_t i = 0; i < page; i++)
                    if (((const unsigned char *)p)[i] != 0)
                        fail_msg("a page that nobody has is still there");
            pl_arena_end(&arena);
        }
}

/** Neighbours that go one after the other, in any order, leave no page: their gaps are one. */
static void neighbours_go_back_together(void **state) {
    (void)state;
    enum { N = 9 };
    for (unsigned seed = 0; seed < 20; seed++) {
        pl_arena arena;
        uint64_t random = effort_seed(seed);
        begin(&arena);
        model m = {.arena = &arena};
        for (int i = 0; i < N; i++)
            take(&m, &arena, MEGABYTE - HEAD, (unsigned char)(i + 1));
        while (m.n > 0)
            give(&m, &arena, (int)random_below(&random, m.n));
        for (size_t i = 0; i < (N - 1) / 2 * (size_t)PL_HUGE_PAGE; i++)
            if (arena.begin[i] != 0)
                fail_msg("byte %zu is still there, seed %u", i, seed);
        pl_arena_end(&arena);
    }
}

/** Whether all of the bytes are value. */
static int is_all(const unsigned char *bytes, size_t n, unsigned char value) {
    size_t i = 0;
    while (i < n && bytes[i] == value)
        i++;
    return i == n;
}

/** An arena that holds keeps what its gaps had, for the next array there, until it settles: then
 *  whole huge pages of all gaps go back, and of later ones at once. */
static void held_until_settled(void **state) {
    (void)state;
    pl_arena arena;
    begin(&arena);
    arena.holds = 1;
    model m = {.arena = &arena};
    for (int i = 0; i < 5; i++) /* of three megabytes each, so that each has a whole huge page */
        take(&m, &arena, 3 * MEGABYTE - HEAD, (unsigned char)(i + 1));
    unsigned char *at[5];
    for (int i = 0; i < 5; i++)
        at[i] = m.list[i].at;
    give(&m, &arena, 0);
    give(&m, &arena, 1); /* the third */
    assert_true(is_all(at[0], MEGABYTE, 1) && is_all(at[2], 3 * MEGABYTE - HEAD, 3));
    unsigned char *const again = pl_arena_take(&arena, MEGABYTE);
    assert_ptr_equal(again, at[0]);
    assert_true(is_all(again, MEGABYTE, 1)); /* as it was found */
    pl_arena_give(&arena, again);
    give(&m, &arena, 2); /* the fifth, the last one */
    assert_true(is_all(at[4], 3 * MEGABYTE - HEAD, 5));
    pl_arena_stop_holding(&arena);
    for (int i = 0; i < m.n; i++)
        check_content(m.list + i);
    const unsigned char *const start = (const unsigned char *)arena.begin;
    assert_true(is_all(start, PL_HUGE_PAGE, 0));
    assert_true(is_all(start + 3 * PL_HUGE_PAGE, PL_HUGE_PAGE, 0));
    assert_true(is_all(start + 6 * PL_HUGE_PAGE, PL_HUGE_PAGE, 0));
    give(&m, &arena, 0); /* the second: now there is a gap before the fourth */
    assert_true(is_all(start, 4 * PL_HUGE_PAGE, 0));
    check_content(m.list);
    pl_arena_stop_holding(&arena);
    check_content(m.list);
    pl_arena_end(&arena);
}

/* ---- what is resident ----------------------------------------------------------------------- */

/** Whether the page at place is resident; -1: the system does not tell. */
static int is_resident(const void *place) {
#ifdef __linux__
    const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE);
    unsigned char resident = 0;
    if (mincore((void *)((uintptr_t)place / page * page), page, &resident) == 0)
        return resident & 1;
#else
    (void)place;
#endif
    return -1;
}

/** Skip the test where pages are not populated, or the system does not tell. */
static void require_populating(void) {
    char *const start = pl_system_reserve(BYTES);
    int does = 0;
    if (start) {
        does = is_resident(start + MEGABYTE) == 0;
        pl_system_populate(start, BYTES);
        does = does && is_resident(start + MEGABYTE) == 1;
        pl_system_unreserve(start, BYTES);
    }
    if (!does)
        skip();
}

/** Around what was written in some of the pages that are populated: that stays, and the rest is 0.
 */
static void populated_pages_keep_content(void **state) {
    (void)state;
    unsigned char *const start = pl_system_reserve(BYTES);
    if (!start)
        skip();
    start[3 * MEGABYTE + 5] = 7;
    pl_system_populate(start + HEAD, BYTES - 2 * HEAD);
    pl_system_populate(start, 1);
    pl_system_populate(start, 0);
    for (size_t i = 0; i < BYTES; i++)
        if (start[i] != (i == 3 * MEGABYTE + 5 ? 7 : 0))
            fail_msg("byte %zu is %d", i, start[i]);
    pl_system_unreserve(start, BYTES);
}

/** Of a large array the last bytes are resident at once, and nothing else that was not written; of
 *  few bytes nothing is populated. */
static void last_bytes_are_resident(void **state) {
    (void)state;
    require_populating();
    char *const few = pl_system_reserve(MEGABYTE);
    pl_system_populate(few, (1 << 16) - 1);
    assert_int_equal(is_resident(few), 0);
    pl_system_unreserve(few, MEGABYTE);
    if (!PL_SHARES_PAGES)
        return;
    char *const array = pl_alloc(7 * MEGABYTE, 1); /* its head is in the first huge page */
    assert_non_null(array);
    assert_int_equal(is_resident(array + 3 * MEGABYTE), 0);
    assert_int_equal(is_resident(array + 5 * MEGABYTE), 0);
    assert_int_equal(is_resident(array + 6 * MEGABYTE + MEGABYTE / 8), 1);
    assert_int_equal(is_resident(array + 7 * MEGABYTE - MEGABYTE / 8), 1);
    pl_free(array);
}

/** Of what is taken from an arena, so is what lies in small pages. */
static void small_pages_are_resident(void **state) {
    (void)state;
    pl_arena arena;
    require_populating();
    begin(&arena); /* half of it in huge pages */
    char *const array = pl_arena_take(&arena, 10 * MEGABYTE);
    assert_non_null(array);
    assert_int_equal(is_resident(arena.begin + 3 * MEGABYTE), 0);
    assert_int_equal(is_resident(arena.begin + 7 * MEGABYTE), 0);
    assert_int_equal(is_resident(arena.begin + 8 * MEGABYTE + MEGABYTE / 8), 1);
    assert_int_equal(is_resident(array + 10 * MEGABYTE - MEGABYTE / 8), 1);
    assert_int_equal(is_resident(array + 11 * MEGABYTE), 0);
    pl_arena_end(&arena);
}

static void none(void **state) {
    (void)state;
    pl_arena arena;
    pl_arena_begin(&arena, SIZE_MAX - 5, SIZE_MAX - 5);
    assert_null(arena.begin);
    assert_null(pl_arena_take(&arena, 1));
    assert_false(is_in(&arena, &arena) || is_in(&arena, NULL));
    pl_arena_end(&arena);
    begin(&arena);
    assert_null(pl_arena_take(&arena, BYTES + 1));
    assert_null(pl_arena_take(&arena, BYTES));
    assert_null(pl_arena_take(&arena, SIZE_MAX));
    assert_false(is_in(&arena, arena.begin + BYTES) || is_in(&arena, arena.begin - 1));
    pl_arena_end(&arena);
    assert_null(pl_arena_take(&arena, 1));
}

/* ---- several threads ------------------------------------------------------------------------ */

/** The work of several threads; what cmocka asserts, it asserts on the first alone. */
typedef struct common {
    pl_arena *arena;
    int failures;
} common;

static void work_alone(void *context, int64_t begin, int64_t end, int thread) {
    enum { AT_ONCE = 8, STEPS = 4000 };
    common *c = context;
    pl_arena *arena = c->arena;
    int failures = 0;
    taken list[AT_ONCE] = {{NULL, 0, 0}};
    uint64_t random = effort_seed((uint64_t)thread);
    (void)begin;
    (void)end;
    for (int step = 0; step < STEPS; step++) {
        taken *t = list + random_below(&random, AT_ONCE);
        if (t->at) {
            for (size_t i = 0; i < t->bytes; i++)
                failures += t->at[i] != t->mark;
            pl_arena_give(arena, t->at);
            t->at = NULL;
        } else {
            t->bytes = 1 + (size_t)random_below(&random, 40000);
            t->mark = (unsigned char)(thread + 1);
            t->at = pl_arena_take(arena, t->bytes);
            failures += !t->at;
            if (t->at)
                memset(t->at, t->mark, t->bytes);
        }
    }
    for (int i = 0; i < AT_ONCE; i++)
        if (list[i].at)
            pl_arena_give(arena, list[i].at);
    __atomic_fetch_add(&c->failures, failures, __ATOMIC_RELAXED);
}

static void threads_at_once(void **state) {
    (void)state;
    pl_arena arena;
    begin(&arena);
    common c = {&arena, 0};
    pl_on_each_thread(8, work_alone, &c);
    assert_int_equal(c.failures, 0);
    assert_null(arena.first);
    pl_arena_end(&arena);
}

/* ---- whose arrays are in one ---------------------------------------------------------------- */

static void *ask(size_t bytes, void *user) {
    (void)user;
    return malloc(bytes);
}

static void release(void *memory, void *user) {
    (void)user;
    free(memory);
}

/** Whether an array of bytes is in the arena of a plan for so many elements, of which all arrays
 *  may be there, or the smaller ones; it can be used. */
static int shares(int64_t n_elements, int all, int64_t bytes, const planish_allocator *allocator) {
    planish_options options;
    planish_options_init(&options);
    options.allocator = allocator;
    pl_context *context = pl_context_create(&options);
    assert_non_null(context);
    pl_context_pool_pages(context, n_elements, all);
    pl_context *before = pl_context_enter(context);
    char *array = pl_alloc(bytes, 1);
    assert_non_null(array);
    memset(array, 1, (size_t)bytes);
    const int found = is_in(&context->arena, array);
    assert_true(context->bytes >= bytes);
    pl_free(array);
    pl_context_enter(before);
    pl_context_destroy(context);
    return found;
}

static void arrays_share(void **state) {
    (void)state;
    const planish_allocator allocator = {.allocate = ask, .release = release};
    pl_arena arena;
    begin(&arena);
    pl_arena_end(&arena);
    for (int all = 0; all < 2; all++) {
        const int large = all && PL_SHARES_PAGES;
        assert_false(shares(1000, all, 1000, NULL));
        assert_false(shares(100000, all, 1000, &allocator));
        assert_false(shares(1000000, all, 200 * MEGABYTE, NULL));
        assert_int_equal(shares(100000, all, 1, NULL), PL_SHARES_PAGES);
        assert_int_equal(shares(100000, all, 3 * MEGABYTE, NULL), PL_SHARES_PAGES);
        assert_int_equal(shares(INT32_MAX / 64, all, 3 * MEGABYTE, NULL), PL_SHARES_PAGES);
        assert_int_equal(shares(100000, all, 5 * MEGABYTE, NULL), large);
        assert_int_equal(shares(1000000, all, 60 * MEGABYTE, NULL), large);
    }
}

/** What has no room in the arena stands elsewhere. */
static void a_full_one_is_no_error(void **state) {
    (void)state;
    enum { N = 20 };
    planish_options options;
    planish_options_init(&options);
    pl_arena arena;
    begin(&arena);
    pl_arena_end(&arena);
    pl_context *context = pl_context_create(&options);
    char *array[N];
    int inside = 0;
    assert_non_null(context);
    pl_context_pool_pages(context, 50000, 1);
    pl_context *before = pl_context_enter(context);
    for (int i = 0; i < N; i++) {
        array[i] = pl_alloc(MEGABYTE, 1);
        assert_non_null(array[i]);
        memset(array[i], i, MEGABYTE);
        inside += is_in(&context->arena, array[i]);
    }
    assert_true(inside < N);
    assert_int_equal(inside > 0, PL_SHARES_PAGES);
    for (int i = 0; i < N; i++) {
        for (int k = 0; k < MEGABYTE; k++)
            if (array[i][k] != i)
                fail_msg("array %d has changed", i);
        pl_free(array[i]);
    }
    pl_context_enter(before);
    pl_context_destroy(context);
}

/** Large arrays outside of any context stand at huge pages of their own, and go back at once. */
static void large_arrays_stand_alone(void **state) {
    (void)state;
    enum { LARGE = 9 * MEGABYTE };
    void *pages = pl_system_reserve(LARGE);
    if (!pages)
        skip();
    assert_int_equal((uintptr_t)pages % PL_HUGE_PAGE, 0);
    memset(pages, 1, LARGE);
    pl_system_unreserve(pages, LARGE);
    for (int i = 0; i < 3; i++) {
        unsigned char *array = pl_alloc(LARGE, 1);
        assert_non_null(array);
        if (PL_SHARES_PAGES)
            for (int k = 0; k < LARGE; k++)
                if (array[k] != 0)
                    fail_msg("byte %d is from before", k);
        memset(array, 1, LARGE);
        pl_free(array);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_the_model),
        cmocka_unit_test(gaps_go_back),
        cmocka_unit_test(neighbours_go_back_together),
        cmocka_unit_test(held_until_settled),
        cmocka_unit_test(populated_pages_keep_content),
        cmocka_unit_test(last_bytes_are_resident),
        cmocka_unit_test(small_pages_are_resident),
        cmocka_unit_test(none),
        cmocka_unit_test(threads_at_once),
        cmocka_unit_test(arrays_share),
        cmocka_unit_test(a_full_one_is_no_error),
        cmocka_unit_test(large_arrays_stand_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
