/* parallel: the only loop that runs on several threads, and the scans built on it. */
#include "base/parallel.h"

#include "base/context.h"

#ifdef _OPENMP
#include <omp.h>
#endif

int pl_thread_count(int threads) {
    const pl_context *context = pl_context_current();
#ifdef _OPENMP
    if (threads <= 0 || !context || !context->parallel) {
        threads = threads <= 0 ? omp_get_max_threads() : threads;
        threads = threads > omp_get_thread_limit() ? omp_get_thread_limit() : threads;
    }
#else
    if (threads <= 0 || !context || !context->parallel)
        return 1;
#endif
    threads = threads > PL_MAX_THREADS ? PL_MAX_THREADS : threads;
    return threads < 1 ? 1 : threads;
}

static void run_chunk(int64_t index, int64_t n, int64_t chunk, pl_chunk_fn *body, void *context,
                      int thread) {
    int64_t begin = index * chunk;
    int64_t end = n - begin < chunk ? n : begin + chunk;
    body(context, begin, end, thread);
}

/** Most stretches; more threads share them: the stack of a caller's thread may be small. */
enum { MOST_STRETCHES = 64 };

/** Stretch of chunks: next is the first that nobody has taken. */
typedef struct stretch {
    int64_t next, end;
    char padding[48]; /* stretches of different threads share no cache line */
} stretch;

/** Loop under way. */
typedef struct loop {
    stretch stretches[MOST_STRETCHES];
    int n_stretches;
    int64_t n, chunk;
    pl_chunk_fn *body;
    void *body_context;
    pl_context *context; /* of the calling thread */
} loop;

/** Run the stretch of one thread, and then the chunks of the others' that nobody else does. */
static void run_thread(void *a_loop, int thread) {
    loop *l = a_loop;
    const pl_outside outside = pl_call_enter(l->context);
    for (int i = 0; i < l->n_stretches; i++) {
        stretch *s = &l->stretches[(thread + i) % l->n_stretches];
        while (__atomic_load_n(&s->next, __ATOMIC_RELAXED) < s->end) {
            int64_t index = __atomic_fetch_add(&s->next, 1, __ATOMIC_RELAXED);
            if (index < s->end)
                run_chunk(index, l->n, l->chunk, l->body, l->body_context, thread);
        }
    }
    pl_call_leave(&outside);
}

/** Call work(data, t) for all threads t, by the caller's means or by OpenMP's. */
static void run_threads(const pl_context *context, int threads, planish_task_fn *work, void *data) {
    if (context && context->parallel) {
        pl_context *before = pl_context_enter(NULL);
        context->parallel(threads, work, data, context->parallel_user);
        pl_context_enter(before);
        return;
    }
#ifdef _OPENMP
#pragma omp parallel num_threads(threads)
    work(data, omp_get_thread_num());
#else
    for (int t = 0; t < threads; t++)
        work(data, t);
#endif
}

void pl_parallel_for(int threads, int64_t n, int64_t chunk, pl_chunk_fn *body, void *context) {
    int64_t chunks = n > 0 ? (n - 1) / chunk + 1 : 0;
    /* Always the whole team, also for few chunks: libgomp ends the threads that a smaller team
     * leaves over, and those it makes later have lost their places. */
    if (threads > 1 && chunks > 1) {
        loop l = {.n_stretches = threads < MOST_STRETCHES ? threads : MOST_STRETCHES,
                  .n = n,
                  .chunk = chunk,
                  .body = body,
                  .body_context = context,
                  .context = pl_context_current()};
        for (int s = 0; s < l.n_stretches; s++) {
            l.stretches[s].next = chunks * s / l.n_stretches;
            l.stretches[s].end = chunks * (s + 1) / l.n_stretches;
        }
        run_threads(l.context, threads, run_thread, &l);
        return;
    }
    for (int64_t i = 0; i < chunks; i++)
        run_chunk(i, n, chunk, body, context, 0);
}

/** The work of pl_on_each_thread. */
typedef struct each {
    pl_chunk_fn *body;
    void *body_context;
} each;

static void run_each(void *an_each, int thread) {
    const each *e = an_each;
    e->body(e->body_context, thread, thread + 1, thread);
}

void pl_on_each_thread(int threads, pl_chunk_fn *body, void *context) {
    each e = {body, context};
    if (threads > 1)
        run_threads(pl_context_current(), threads, run_each, &e);
    else
        run_each(&e, 0);
}

enum { SCAN_BLOCKS = 64 }; /* of a parallel scan: more than threads that pay for one */

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
    threads = pl_paying_threads(threads, n);
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

/** The work of pl_counts_to_places. */
typedef struct tallies {
    int64_t row, n_chunks;
    int64_t *counts, *begin;
} tallies;

static void add_chunks(void *context, int64_t first, int64_t end, int thread) {
    const tallies *t = context;
    (void)thread;
    for (int64_t key = first; key < end; key++)
        t->begin[key] = 0;
    for (int64_t k = 0; k < t->n_chunks; k++)
        for (int64_t key = first; key < end; key++)
            t->begin[key] += t->counts[k * t->row + key];
}

static void place_chunks(void *context, int64_t first, int64_t end, int thread) {
    enum { AT_ONCE = 256 }; /* keys */
    const tallies *t = context;
    int64_t place[AT_ONCE];
    (void)thread;
    for (int64_t some = first; some < end; some += AT_ONCE) {
        const int64_t n = end - some < AT_ONCE ? end - some : AT_ONCE;
        for (int64_t i = 0; i < n; i++)
            place[i] = t->begin[some + i];
        for (int64_t k = 0; k < t->n_chunks; k++) {
            int64_t *counts = t->counts + k * t->row + some;
            for (int64_t i = 0; i < n; i++) {
                const int64_t count = counts[i];
                counts[i] = place[i];
                place[i] += count;
            }
        }
    }
}

void pl_counts_to_places(int threads, int64_t n_keys, int64_t n_chunks, int64_t *counts,
                         int64_t *begin) {
    enum { CHUNK_KEYS = 512 };
    tallies t = {pl_counts_row(n_keys), n_chunks, counts, begin};
    threads = pl_paying_threads(threads, n_keys * n_chunks);
    pl_parallel_for(threads, n_keys, CHUNK_KEYS, add_chunks, &t);
    pl_prefix_sum(1, n_keys, begin);
    pl_parallel_for(threads, n_keys, CHUNK_KEYS, place_chunks, &t);
}

void pl_raise_to(int64_t *largest, int64_t value) {
    int64_t seen = __atomic_load_n(largest, __ATOMIC_RELAXED);
    while (value > seen && !__atomic_compare_exchange_n(largest, &seen, value, 1, __ATOMIC_RELAXED,
                                                        __ATOMIC_RELAXED)) {
    }
}

void pl_raise_double(double *largest, double value) {
    double known;
    __atomic_load(largest, &known, __ATOMIC_RELAXED);
    while (value > known && !__atomic_compare_exchange(largest, &known, &value, 1, __ATOMIC_RELAXED,
                                                       __ATOMIC_RELAXED))
        ;
}

void pl_lower_to(int64_t *lowest, int64_t value) {
    int64_t seen = __atomic_load_n(lowest, __ATOMIC_RELAXED);
    while (value < seen && !__atomic_compare_exchange_n(lowest, &seen, value, 1, __ATOMIC_RELAXED,
                                                        __ATOMIC_RELAXED)) {
    }
}
