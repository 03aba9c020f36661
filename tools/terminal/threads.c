/* threads: how many threads the program can have. */
#include "terminal/threads.h"

#include "base/parallel.h"

#include <pthread.h>
#include <stdlib.h>

static void *wait_for_gate(void *gate) {
    pthread_mutex_lock(gate);
    pthread_mutex_unlock(gate);
    return NULL;
}

static void do_nothing(void *context, int64_t begin, int64_t end, int thread) {
    (void)context;
    (void)begin;
    (void)end;
    (void)thread;
}

int pl_threads_to_use(int wanted) {
    /* The library would take OpenMP's variable as a bound beside the number of cores; here it is as
     * good as -j. Of "4,2" the outermost level counts. */
    const char *told = getenv("OMP_NUM_THREADS");
    const long n = told && wanted == 0 ? strtol(told, NULL, 10) : 0;
    if (n > 0 && n <= PL_MAX_THREADS)
        wanted = (int)n;
    /* Start as many beside this one, all alive at the same time, and end them again. */
    pthread_t started[PL_MAX_THREADS];
    pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER;
    const int threads = pl_thread_count(wanted);
    int n_started = 0;
    pthread_mutex_lock(&gate);
    while (n_started < threads - 1 &&
           pthread_create(&started[n_started], NULL, wait_for_gate, &gate) == 0)
        n_started++;
    pthread_mutex_unlock(&gate);
    for (int i = 0; i < n_started; i++)
        pthread_join(started[i], NULL);
    if (n_started + 1 < threads)
        wanted = n_started + 1;
    pl_on_each_thread(pl_thread_count(wanted), do_nothing,
                      NULL); /* OpenMP keeps them from now on */
    return wanted;
}
