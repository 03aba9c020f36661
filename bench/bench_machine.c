/* bench_machine: limits of this machine, to compare with the speed of the kernels, as JSON.
 *
 *   bench_machine [THREADS]
 *
 * One core: its clock, as dependent shifts and exclusive ors count it; then additions,
 * multiplications, both in turn, divisions and square roots of packs of four doubles, independent
 * of one another, per cycle. Memory: the sum of two arrays of 128 MB into a third, by 1 and by
 * THREADS threads (all CPUs), in GB/s of bytes read and written. Between two cores: time of a cache
 * line to the other core and back, about four times as long without a common cache. Each figure is
 * the best of several.
 */
#include "base/memory.h"
#include "base/parallel.h"
#include "common.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#if defined(__x86_64__)
#define WIDE __attribute__((target("avx2")))
#else
#define WIDE
#endif

typedef double pack __attribute__((vector_size(32)));

enum {
    REPEATS = 40, /* of a millisecond or so: on a shared machine some of them are undisturbed */
    MEMORY_REPEATS = 7,
    STEPS = 500000,
    CHAINS =
        12, /* independent of one another: more than any latency needs, and they fit registers */
    ROOT_CHAINS = 8,
    ARRAY = 16 << 20, /* doubles */
    HANDOVERS = 2000, /* of a line, there and back */
    CHUNK = 1 << 16
};

static volatile double sink; /* what is computed must be */

/** Cycles per second: each step is two dependent operations of one cycle. */
static double clock_rate(void) {
    double best = 0;
    for (int i = 0; i < REPEATS; i++) {
        uint64_t x = (uint64_t)i + 88172645463325252u;
        double begin = bench_seconds(CLOCK_MONOTONIC);
        for (int step = 0; step < STEPS; step++)
            x ^= x >> 1;
        double rate = 2.0 * STEPS / (bench_seconds(CLOCK_MONOTONIC) - begin);
        sink = (double)x;
        best = rate > best ? rate : best;
    }
    return best;
}

/** Time STEPS rounds of body over independent chains x[c], operations per chain and round; packs of
 *  four per second. */
#define DEFINE_RATE(name, chains, operations, body)                                                \
    WIDE static double name(void) {                                                                \
        double best = 0;                                                                           \
        for (int i = 0; i < REPEATS; i++) {                                                        \
            pack x[chains];                                                                        \
            const pack a = {1.25, 1.5, 1.75, 1.125}, b = a * 0.75 - 0.25, inverse = 1 / b;         \
            for (int c = 0; c < (chains); c++)                                                     \
                x[c] = a + c;                                                                      \
            double begin = bench_seconds(CLOCK_MONOTONIC);                                         \
            for (int step = 0; step < STEPS; step++)                                               \
                for (int c = 0; c < (chains); c++)                                                 \
                    body;                                                                          \
            double rate = (double)STEPS * (chains) * (operations) /                                \
                          (bench_seconds(CLOCK_MONOTONIC) - begin);                                \
            for (int c = 0; c < (chains); c++)                                                     \
                sink = x[c][0] + x[c][3] + b[1] + inverse[1];                                      \
            best = rate > best ? rate : best;                                                      \
        }                                                                                          \
        return best;                                                                               \
    }

DEFINE_RATE(addition_rate, CHAINS, 1, x[c] = x[c] + a)
/* Up and down again: subnormal numbers would take many times as long on some processors. */
DEFINE_RATE(multiplication_rate, CHAINS, 1, x[c] = x[c] * (step & 1 ? b : inverse))
DEFINE_RATE(mixed_rate, CHAINS, 2, x[c] = x[c] * b + a)
DEFINE_RATE(division_rate, ROOT_CHAINS, 1, x[c] = a / x[c])
DEFINE_RATE(root_rate, ROOT_CHAINS, 1,
            x[c] = ((pack){sqrt(x[c][0]), sqrt(x[c][1]), sqrt(x[c][2]), sqrt(x[c][3])}))

typedef struct arrays {
    double *a, *b, *c;
} arrays;

static void fill(void *context, int64_t begin, int64_t end, int thread) {
    arrays *x = context;
    for (int64_t i = begin; i < end; i++) {
        x->a[i] = (double)thread;
        x->b[i] = (double)i;
        x->c[i] = 1;
    }
}

static void add(void *context, int64_t begin, int64_t end, int thread) {
    arrays *x = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        x->a[i] = x->b[i] + x->c[i];
}

/** Bytes per second of the sum of two arrays; 0 without memory. */
static double bandwidth(int threads) {
    double best = 0;
    arrays x = {pl_alloc(ARRAY, sizeof(double)), pl_alloc(ARRAY, sizeof(double)),
                pl_alloc(ARRAY, sizeof(double))};
    if (x.a && x.b && x.c) {
        pl_parallel_for(threads, ARRAY, CHUNK, fill, &x);
        for (int i = 0; i < MEMORY_REPEATS; i++) {
            double begin = bench_seconds(CLOCK_MONOTONIC);
            pl_parallel_for(threads, ARRAY, CHUNK, add, &x);
            double rate = 3.0 * ARRAY * sizeof(double) / (bench_seconds(CLOCK_MONOTONIC) - begin);
            best = rate > best ? rate : best;
        }
    }
    pl_free(x.a);
    pl_free(x.b);
    pl_free(x.c);
    return best;
}

/** A line of the cache, and whose turn it is: 0, 1. */
typedef struct line {
    _Alignas(128) int turn;
} line;

static void hand_over(void *context, int64_t begin, int64_t end, int thread) {
    line *l = context;
    (void)begin;
    (void)end;
    for (int i = 0; thread < 2 && i < HANDOVERS; i++) {
        while (__atomic_load_n(&l->turn, __ATOMIC_ACQUIRE) != thread)
            ;
        __atomic_store_n(&l->turn, !thread, __ATOMIC_RELEASE);
    }
}

/** Seconds that a line takes from one core to another and back. */
static double round_trip(void) {
    double best = INFINITY;
    for (int i = 0; i < REPEATS; i++) {
        line l = {0};
        double begin = bench_seconds(CLOCK_MONOTONIC);
        pl_on_each_thread(2, hand_over, &l);
        double seconds = (bench_seconds(CLOCK_MONOTONIC) - begin) / HANDOVERS;
        best = seconds < best ? seconds : best;
    }
    return best;
}

int main(int argc, char **argv) {
    int threads = pl_thread_count(argc > 1 ? atoi(argv[1]) : 0);
    double clock = clock_rate();
    printf(
        "{ \"ghz\": %.3f,\n  \"packs_per_cycle\": { \"addition\": %.3f, \"multiplication\": %.3f, "
        "\"both\": %.3f, \"division\": %.4f, \"root\": %.4f },\n",
        clock * 1e-9, addition_rate() / clock, multiplication_rate() / clock, mixed_rate() / clock,
        division_rate() / clock, root_rate() / clock);
    printf("  \"threads\": %d, \"memory_gb_per_s\": [%.2f", threads, bandwidth(1) * 1e-9);
    if (threads > 1)
        printf(", %.2f", bandwidth(threads) * 1e-9);
    printf("]");
    if (threads > 1 && pl_thread_count(0) > 1) /* on one CPU they would take turns of its clock */
        printf(",\n  \"line_round_trip_ns\": %.0f", round_trip() * 1e9);
    printf(" }\n");
    return fflush(stdout) ? 2 : 0;
}
