/* The parallel loop, scans and checked allocation. */
#include "base/memory.h"
#include "base/parallel.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { N = 100003 };

static void touch(void *context, int64_t begin, int64_t end, int thread) {
    int *count = context;
    assert_true(thread >= 0 && thread < 8);
    for (int64_t i = begin; i < end; i++)
        count[i]++;
}

static void every_index_once(void **state) {
    (void)state;
    static const int64_t sizes[] = {0, 1, 7, 64, 65, N};
    for (int threads = 1; threads <= 8; threads++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
            int *count = calloc(N + 1, sizeof *count);
            pl_parallel_for(threads, sizes[s], 64, touch, count);
            for (int64_t i = 0; i < sizes[s]; i++)
                assert_int_equal(count[i], 1);
            assert_int_equal(count[sizes[s]], 0);
            free(count);
        }
}

static void prefix_sums_are_exclusive(void **state) {
    (void)state;
    int64_t *values = malloc(sizeof *values * (N + 1));
    for (int threads = 1; threads <= 4; threads++)
        for (int64_t n = 0; n <= N; n = n * 3 + 1) {
            for (int64_t i = 0; i < n; i++)
                values[i] = i % 7;
            int64_t total = pl_prefix_sum(threads, n, values), expected = 0;
            for (int64_t i = 0; i < n; i++) {
                assert_int_equal(values[i], expected);
                expected += i % 7;
            }
            assert_int_equal(total, expected);
            assert_int_equal(values[n], expected);
        }
    free(values);
}

/** Key by key, and chunk by chunk in each, whatever lies between the rows. */
static void counts_become_places(void **state) {
    (void)state;
    static const struct {
        int64_t keys, chunks;
    } sizes[] = {{0, 3}, {1, 0}, {1, 1}, {7, 5}, {8, 1}, {513, 3}, {2048, 40}, {1000, 100}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int threads = 1; threads <= 3; threads++) {
            const int64_t keys = sizes[s].keys, chunks = sizes[s].chunks;
            const int64_t row = pl_counts_row(keys);
            int64_t *counts = malloc(sizeof *counts * (size_t)(row * chunks + 1));
            int64_t *begin = malloc(sizeof *begin * (size_t)(keys + 1));
            assert_true(counts && begin && row >= keys && row % 8 == 0);
            for (int64_t i = 0; i < row * chunks; i++)
                counts[i] = i % row < keys ? (i * 5 + i / 3) % 11 : -1;
            pl_counts_to_places(threads, keys, chunks, counts, begin);
            int64_t expected = 0;
            for (int64_t key = 0; key < keys; key++) {
                assert_int_equal(begin[key], expected);
                for (int64_t k = 0; k < chunks; k++) {
                    const int64_t i = k * row + key;
                    assert_int_equal(counts[i], expected);
                    expected += (i * 5 + i / 3) % 11;
                }
            }
            assert_int_equal(begin[keys], expected);
            for (int64_t i = 0; i < row * chunks; i++)
                assert_true(i % row < keys || counts[i] == -1);
            free(counts);
            free(begin);
        }
}

static void impossible_sizes_are_refused(void **state) {
    (void)state;
    assert_null(pl_alloc(-1, 8));
    assert_null(pl_alloc(INT64_MAX, 8));
    assert_null(pl_alloc(INT64_MAX / 4, 16));
    void *empty = pl_alloc(0, 8);
    assert_non_null(empty);
    pl_free(empty);
}

static void growing_keeps_the_content(void **state) {
    (void)state;
    int64_t capacity = 0;
    int *array = NULL;
    for (int i = 0; i < 1000; i++) {
        array = pl_grow(array, i, i + 1, &capacity, sizeof *array);
        assert_non_null(array);
        array[i] = i;
    }
    for (int i = 0; i < 1000; i++)
        assert_int_equal(array[i], i);
    assert_null(pl_grow(array, 1000, INT64_MAX / 2, &capacity, sizeof *array));
    assert_int_equal(array[999], 999);
    pl_free(array);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_index_once),          cmocka_unit_test(prefix_sums_are_exclusive),
        cmocka_unit_test(counts_become_places),      cmocka_unit_test(impossible_sizes_are_refused),
        cmocka_unit_test(growing_keeps_the_content),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
