/* parallel: the only loop that runs on several threads, and the scans built on it.
 *
 * All parallel work of the library and of the file formats goes through pl_parallel_for: one
 * place decides how chunks meet threads. Results never depend on the number of threads: sums of
 * chunks are exact (sum.h).
 *
 *   pl_parallel_for, pl_on_each_thread       run chunks, or a task per thread
 *   pl_thread_count, pl_paying_threads       numbers of threads
 *   pl_prefix_sum, pl_counts_row, pl_counts_to_places    scans and counting sorts
 *   pl_set_flag, pl_raise_to, pl_raise_double, pl_lower_to    results shared by threads
 */
#ifndef PL_BASE_PARALLEL_H
#define PL_BASE_PARALLEL_H

#include <stdint.h>

enum { PL_MAX_THREADS = 1024 }; /* more than any machine has cores for one process */

/** The threads that threads (0: as many as OpenMP would use) can mean: at least 1, at most what
 *  OpenMP's limit and PL_MAX_THREADS allow. */
int pl_thread_count(int threads);

/** Chunk: indices begin .. end-1, on thread (0 .. threads-1). */
typedef void pl_chunk_fn(void *context, int64_t begin, int64_t end, int thread);

/** Call body once for every chunk of 0 .. n-1; chunks are of size chunk but the last. Each thread
 * begins with its own stretch of them, so that from loop to loop it finds in its caches, and in
 * the memory of its NUMA node (but for the last 2 MB of an array: memory.c), what it has touched
 * before; when that is done it helps the others. Returns when all are done. */
void pl_parallel_for(int threads, int64_t n, int64_t chunk, pl_chunk_fn *body, void *context);

/** Number of threads worth using for a cheap loop over n values, or one that writes all over the
 *  memory of n. With few values most cache lines would travel between cores. */
static inline int pl_paying_threads(int threads, int64_t n) {
    enum { FEW = 1 << 16 };
    return n < FEW ? 1 : threads;
}

/** Call body(context, t, t + 1, t) on thread t of each of the threads that pl_parallel_for uses. */
void pl_on_each_thread(int threads, pl_chunk_fn *body, void *context);

/** Replace values[0 .. n-1] by their exclusive prefix sum. values has n + 1 entries; values[n]
 *  becomes the total, which is returned. */
int64_t pl_prefix_sum(int threads, int64_t n, int64_t *values);

/** Length of a row of a counting sort in chunks: chunk k counts its values of key in counts[k *
 *  row + key]. row is at least n_keys, so that chunks share no line of the cache. */
static inline int64_t pl_counts_row(int64_t n_keys) {
    enum { LINE = 64 / sizeof(int64_t) };
    return (n_keys + LINE - 1) / LINE * LINE;
}

/** Turn counts [n_chunks][row] into the places at which each chunk puts its items of each key: key by
 *  key, and chunk by chunk in each. begin [n_keys + 1]: where each key begins, and the end. */
void pl_counts_to_places(int threads, int64_t n_keys, int64_t n_chunks, int64_t *counts,
                         int64_t *begin);

/** Set *flag to value, as other threads may, too: it is written only where it is not that already,
 * so that cores leave one another its line of the cache. */
static inline void pl_set_flag(uint8_t *flag, uint8_t value) {
    if (__atomic_load_n(flag, __ATOMIC_RELAXED) != value)
        __atomic_store_n(flag, value, __ATOMIC_RELAXED);
}

/** Raise *largest to value, or lower *lowest to it, whichever thread comes first. */
void pl_raise_to(int64_t *largest, int64_t value);

/** Raise *largest to value, as pl_raise_to does. */
void pl_raise_double(double *largest, double value);

/** Lower *lowest to value, whichever thread comes first. */
void pl_lower_to(int64_t *lowest, int64_t value);

#endif
