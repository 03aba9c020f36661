/* A thread that calls planish has enough with 128 kB of stack, one that runs its tasks with 64 kB
 * (docs/embedding.md). */
#include <planish/planish.h>

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

enum { CALLER = 128 << 10, TASK = 64 << 10, TASKS = 2, N = 12 };

typedef struct part {
    planish_task_fn *task;
    void *data;
    int index;
} part;

static int start(size_t stack, void *(*function)(void *), void *data, pthread_t *thread) {
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, stack);
    const int failed = pthread_create(thread, &attributes, function, data);
    pthread_attr_destroy(&attributes);
    return failed;
}

static void *run_part(void *data) {
    const part *p = data;
    p->task(p->data, p->index);
    return NULL;
}

static void run_tasks(int n_tasks, planish_task_fn *task, void *data, void *user) {
    pthread_t thread[TASKS];
    part parts[TASKS];
    (void)user;
    for (int i = 0; i < n_tasks; i++) {
        parts[i] = (part){task, data, i};
        if (start(TASK, run_part, &parts[i], &thread[i]))
            abort();
    }
    for (int i = 0; i < n_tasks; i++)
        pthread_join(thread[i], NULL);
}

/** A cube of N^3 cells of six tetrahedra whose inner nodes are thrown about: some are inverted. */
static void make(double *xyz, int32_t *elements) {
    static const int paths[6][2] = {{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}};
    const int row = N + 1;
    unsigned random = 1;
    int32_t *e = elements;
    for (int i = 0; i < row * row * row; i++) {
        const int at[3] = {i % row, i / row % row, i / row / row};
        int inside = 1;
        for (int d = 0; d < 3; d++)
            inside &= at[d] > 0 && at[d] < N;
        for (int d = 0; d < 3; d++) {
            random = random * 1664525u + 1013904223u;
            xyz[3 * i + d] = at[d] + (inside ? 1.4 * ((random >> 8) / 16777216.0 - 0.5) : 0);
        }
    }
    for (int i = 0; i < N * N * N; i++) {
        const int first = i % N + row * (i / N % N + row * (i / N / N));
        for (int k = 0; k < 6; k++) {
            const int corner[4] = {0, paths[k][0], paths[k][1], 7};
            for (int j = 0; j < 4; j++)
                *e++ =
                    first + (corner[j] & 1) + row * ((corner[j] >> 1 & 1) + row * (corner[j] >> 2));
        }
    }
}

static void *call(void *data) {
    enum { NODES = (N + 1) * (N + 1) * (N + 1), ELEMENTS = 6 * N * N * N };
    double *xyz = malloc(3 * NODES * sizeof *xyz);
    int32_t *elements = malloc(4 * ELEMENTS * sizeof *elements);
    int *failed = data;
    if (!xyz || !elements)
        return NULL;
    for (int way = 0; way < 4; way++) {
        planish_options options;
        planish_plan *plan = NULL;
        planish_result result = {.n_inverted = -1};
        planish_error error = {.text = ""};
        make(xyz, elements);
        const planish_mesh mesh = {.dim = 3,
                                   .n_nodes = NODES,
                                   .n_elements = ELEMENTS,
                                   .coordinates = xyz,
                                   .elements = elements};
        planish_options_init(&options);
        options.threads = TASKS;
        options.parallel = way & 1 ? run_tasks : NULL;
        options.min_volume_fraction = way & 2 ? 1e-3 : 0;
        options.worst = way & 2 ? PLANISH_WORST_ANGLE : PLANISH_WORST_NONE;
        if (planish_plan_create(&mesh, &options, &plan, &error) ||
            planish_smooth(plan, xyz, &options, &result, &error))
            fprintf(stderr, "%s\n", error.text);
        planish_plan_destroy(plan);
        *failed += result.n_inverted != 0;
    }
    free(xyz);
    free(elements);
    return NULL;
}

int main(void) {
    pthread_t thread;
    int failed = 0;
    if (start(CALLER, call, &failed, &thread) || pthread_join(thread, NULL))
        return 2;
    return failed != 0;
}
