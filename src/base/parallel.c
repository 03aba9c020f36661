/* parallel: the only loop that runs on several threads, and the sums and scans built on it. */
#include "base/parallel.h"

#ifdef _OPENMP
#include <omp.h>
#endif

int pl_thread_count(int threads) {
#ifdef _OPENMP
    if (threads <= 0)
        threads = omp_get_max_threads();
    if (threads > omp_get_thread_limit())
        threads = omp_get_thread_limit();
    if (threads > PL_MAX_THREADS)
        threads = PL_MAX_THREADS;
#else
    threads = 1;
#endif
    return threads < 1 ? 1 : threads;
}

static void run_chunk(int64_t index, int64_t n, int64_t chunk, pl_chunk_fn *body, void *context,
                      int thread) {
    int64_t begin = index * chunk;
    int64_t end = n - begin < chunk ? n : begin + chunk;
    body(context, begin, end, thread);
}

#ifdef _OPENMP

/** More threads than this share stretches: the stack of a caller's thread may be small. */
enum { MOST_SHARES = 64 };

/** A stretch of chunks: next is the first that nobody has taken. */
typedef struct share {
    int64_t next, end;
    char padding[48]; /* shares of different threads share no cache line */
} share;

/** Do the chunks of a share that nobody else does. */
static void run_share(share *s, int64_t n, int64_t chunk, pl_chunk_fn *body, void *context,
                      int thread) {
    while (__atomic_load_n(&s->next, __ATOMIC_RELAXED) < s->end) {
        int64_t index = __atomic_fetch_add(&s->next, 1, __ATOMIC_RELAXED);
        if (index < s->end)
            run_chunk(index, n, chunk, body, context, thread);
    }
}

#endif

void pl_parallel_for(int threads, int64_t n, int64_t chunk, pl_chunk_fn *body, void *context) {
    int64_t chunks = n > 0 ? (n - 1) / chunk + 1 : 0;
#ifdef _OPENMP
    /* Always the whole team, also for few chunks: libgomp ends the threads that a smaller team
     * leaves over, and those it makes later have lost their places. */
    if (threads > 1 && chunks > 1) {
        share shares[MOST_SHARES];
        const int n_shares = threads < MOST_SHARES ? threads : MOST_SHARES;
        for (int s = 0; s < n_shares; s++)
            shares[s] = (share){chunks * s / n_shares, chunks * (s + 1) / n_shares, {0}};
#pragma omp parallel num_threads(threads)
        for (int s = 0, me = omp_get_thread_num(); s < n_shares; s++)
            run_share(&shares[(me + s) % n_shares], n, chunk, body, context, me);
        return;
    }
#else
    (void)threads;
#endif
    for (int64_t i = 0; i < chunks; i++)
        run_chunk(i, n, chunk, body, context, 0);
}

void pl_on_each_thread(int threads, pl_chunk_fn *body, void *context) {
#ifdef _OPENMP
#pragma omp parallel num_threads(threads)
    {
        int thread = omp_get_thread_num();
        body(context, thread, thread + 1, thread);
    }
#else
    (void)threads;
    body(context, 0, 1, 0);
#endif
}

struct sum {
    pl_chunk_sum_fn *body;
    void *context;
    double *partial;
    int64_t chunk;
};

static void sum_chunk(void *context, int64_t begin, int64_t end, int thread) {
    struct sum *sum = context;
    sum->partial[begin / sum->chunk] = sum->body(sum->context, begin, end, thread);
}

double pl_parallel_sum(int threads, int64_t n, int64_t chunk, pl_chunk_sum_fn *body, void *context,
                       double *partial) {
    struct sum sum = {body, context, partial, chunk};
    pl_parallel_for(threads, n, chunk, sum_chunk, &sum);
    int64_t chunks = n > 0 ? (n - 1) / chunk + 1 : 0;
    double total = 0;
    for (int64_t i = 0; i < chunks; i++)
        total += partial[i];
    return total;
}

enum { SCAN_BLOCKS = 64 }; /* blocks of a parallel scan: more than threads that pay for one */

struct scan {
    int64_t *values;
    int64_t block_total[SCAN_BLOCKS];
    int64_t block;
    int add;
};

static void scan_chunk(void *context, int64_t begin, int64_t end, int thread) {
    struct scan *scan = context;
    (void)thread;
    int64_t *total = &scan->block_total[begin / scan->block];
    if (!scan->add) {
        int64_t sum = 0;
        for (int64_t i = begin; i < end; i++)
            sum += scan->values[i];
        *total = sum;
        return;
    }
    int64_t running = *total;
    for (int64_t i = begin; i < end; i++) {
        int64_t value = scan->values[i];
        scan->values[i] = running;
        running += value;
    }
}

int64_t pl_prefix_sum(int threads, int64_t n, int64_t *values) {
    struct scan scan = {.values = values, .block = n / SCAN_BLOCKS + 1};
    pl_parallel_for(threads, n, scan.block, scan_chunk, &scan);
    int64_t total = 0;
    for (int64_t i = 0; i * scan.block < n; i++) {
        int64_t block_total = scan.block_total[i];
        scan.block_total[i] = total;
        total += block_total;
    }
    scan.add = 1;
    pl_parallel_for(threads, n, scan.block, scan_chunk, &scan);
    values[n] = total;
    return total;
}

void pl_raise_to(int64_t *largest, int64_t value) {
    int64_t seen = __atomic_load_n(largest, __ATOMIC_RELAXED);
    while (value > seen && !__atomic_compare_exchange_n(largest, &seen, value, 1, __ATOMIC_RELAXED,
                                                        __ATOMIC_RELAXED)) {
    }
}

void pl_lower_to(int64_t *lowest, int64_t value) {
    int64_t seen = __atomic_load_n(lowest, __ATOMIC_RELAXED);
    while (value < seen && !__atomic_compare_exchange_n(lowest, &seen, value, 1, __ATOMIC_RELAXED,
                                                        __ATOMIC_RELAXED)) {
    }
}
