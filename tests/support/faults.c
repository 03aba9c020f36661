#include "support/faults.h"

#include "support/allocations.h"
#include "support/effort.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MARK = 0xa5 };

int faults_refused(faults *f, int status, const planish_error *error) {
    if (!status)
        return 0;
    if (status != PLANISH_ERROR_MEMORY || error->code != PLANISH_ERROR_MEMORY)
        fail_msg("status %d, error %d: %s", status, error->code, error->text);
    assert_non_null(strstr(error->text, "out of memory"));
    assert_null(strchr(error->text, '\n'));
    assert_true(error->element == -1 && error->node == -1);
    allocations_fail_some(0, 0);
    f->refused++;
    return 1;
}

void faults_add(faults *f, const void *data, size_t n) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < n; i++) /* FNV-1a */
        f->digest = (f->digest ^ bytes[i]) * 0x100000001b3u;
}

void faults_mark(void *data, size_t n) {
    memset(data, MARK, n);
}

int faults_is_marked(const void *data, size_t n) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < n; i++)
        if (bytes[i] != MARK)
            return 0;
    return 1;
}

/* ---- the caller's allocator: the one whose allocations fail ---------------------------------- */

static void *allocate(size_t bytes, void *user) {
    faults *f = user;
    void *block = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (block)
        __atomic_fetch_add(&f->live, 1, __ATOMIC_RELAXED);
    return block;
}

static void release(void *block, void *user) {
    faults *f = user;
    __atomic_fetch_sub(&f->live, 1, __ATOMIC_RELAXED);
    free(block);
}

/* ---- runs ------------------------------------------------------------------------------------ */

/** The digest of a run in which n allocations from first on fail. */
static uint64_t run(fault_scenario *scenario, const void *world, faults *f, int64_t first,
                    int64_t n) {
    f->digest = 0xcbf29ce484222325u;
    allocations_fail_some(first, n);
    scenario(world, f);
    allocations_fail_some(0, 0);
    assert_int_equal(f->live, 0);
    return f->digest;
}

int64_t faults_try(const char *name, fault_scenario *scenario, const void *world, int64_t some) {
    static const int64_t in_a_row[] = {1, 2, INT64_MAX};
    enum { N_KINDS = sizeof in_a_row / sizeof *in_a_row };
    faults f = {.allocator = {allocate, release, &f}};
    uint64_t random = effort_seed(41);
    run(scenario, world, &f, 0, 0); /* libraries begin to work */
    allocations_fail_some(0, 0);
    f.digest = 0xcbf29ce484222325u;
    scenario(world, &f);
    const int64_t n = allocations_counted(), wanted = effort(some, n);
    const uint64_t expected = f.digest;
    assert_int_equal(f.refused, 0);
    int64_t runs = 0;
    for (int64_t i = 0; i < n; i++) {
        if (random_below(&random, n - i) >= wanted - runs / N_KINDS)
            continue;
        for (int kind = 0; kind < N_KINDS; kind++, runs++)
            if (run(scenario, world, &f, i, in_a_row[kind]) != expected)
                fail_msg("%s: without allocation %d of %d (kind %d) the results are others", name,
                         (int)i, (int)n, kind);
    }
    if (n > 0 && f.refused == 0)
        fail_msg("%s: no call was refused", name);
    return runs;
}
