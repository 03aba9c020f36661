/* Threads that call planish or run its tasks have enough with less stack than docs/embedding.md tells. */
#include <planish/planish.h>

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#ifndef STACK
#define STACK (128 << 10)
#endif

enum { TASKS = 2, N = 8, ROW = N + 1, NODES = ROW * ROW * ROW, MOST_ELEMENTS = 6 * N * N * N };

/* ---- threads --------------------------------------------------------------------------------- */

typedef struct part {
    planish_task_fn *task;
    void *data;
    int index;
} part;

static int start(void *(*function)(void *), void *data, pthread_t *thread) {
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, STACK);
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
        if (start(run_part, &parts[i], &thread[i]))
            abort();
    }
    for (int i = 0; i < n_tasks; i++)
        pthread_join(thread[i], NULL);
}

/* ---- meshes ---------------------------------------------------------------------------------- */

/** Elements of a cell: corners as x + 2 y + 4 z, and the edges that have a node in the middle. */
typedef struct kind {
    planish_cell_type type;
    int order, n_of_cell, n_corners, corner[6][8], n_edges, edge[12][2];
} kind;

/* clang-format off */
#define TETRAHEDRA .n_of_cell = 6, .n_corners = 4, .corner = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, \
                                                              {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}
#define HEXAHEDRON .n_of_cell = 1, .n_corners = 8, .corner = {{0, 1, 3, 2, 4, 5, 7, 6}}
#define WEDGES .n_of_cell = 2, .n_corners = 6, .corner = {{0, 1, 3, 4, 5, 7}, {0, 3, 2, 4, 7, 6}}

static const kind kinds[] = {
    {PLANISH_CELL_TETRAHEDRON, 1, TETRAHEDRA},
    {PLANISH_CELL_HEXAHEDRON, 1, HEXAHEDRON},
    {PLANISH_CELL_WEDGE, 1, WEDGES},
    {PLANISH_CELL_TETRAHEDRON10, 2, TETRAHEDRA, .n_edges = 6,
     .edge = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}},
    {PLANISH_CELL_HEXAHEDRON20, 2, HEXAHEDRON, .n_edges = 12,
     .edge = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}},
    {PLANISH_CELL_WEDGE15, 2, WEDGES, .n_edges = 9,
     .edge = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}},
};
/* clang-format on */

typedef struct box {
    double xyz[NODES][3];
    uint8_t type[MOST_ELEMENTS];
    int64_t offset[MOST_ELEMENTS + 1];
    int32_t node[MOST_ELEMENTS * 8];
} box;

/** Throw the inner nodes of a grid about: some elements will be inverted. */
static void throw_about(double xyz[][3], double most) {
    unsigned random = 1;
    for (int i = 0; i < NODES; i++) {
        const int at[3] = {i % ROW, i / ROW % ROW, i / ROW / ROW};
        int inside = 1;
        for (int d = 0; d < 3; d++)
            inside &= at[d] > 0 && at[d] < N;
        for (int d = 0; d < 3; d++) {
            random = random * 1664525u + 1013904223u;
            xyz[i][d] = at[d] + (inside ? most * ((random >> 8) / 16777216.0 - 0.5) : 0);
        }
    }
}

static int32_t *add_nodes(const kind *k, const int corner[], int32_t first, int32_t *to) {
    int32_t place[8];
    for (int j = 0; j < k->n_corners; j++) {
        const int32_t step =
            (corner[j] & 1) + ROW * ((corner[j] >> 1 & 1) + ROW * (corner[j] >> 2));
        *to++ = place[j] = first + k->order * step;
    }
    for (int j = 0; j < k->n_edges; j++)
        *to++ = (place[k->edge[j][0]] + place[k->edge[j][1]]) / 2;
    return to;
}

static int64_t make(const kind *k, box *b) {
    const int cells = N / k->order;
    int64_t n = 0;
    int32_t *to = b->node;
    throw_about(b->xyz, k->order == 1 ? 1.4 : 0.5);
    for (int i = 0; i < cells * cells * cells; i++) {
        const int32_t first =
            k->order * (i % cells + ROW * (i / cells % cells + ROW * (i / cells / cells)));
        for (int e = 0; e < k->n_of_cell; e++) {
            b->type[n] = (uint8_t)k->type;
            b->offset[n++] = to - b->node;
            to = add_nodes(k, k->corner[e], first, to);
        }
    }
    b->offset[n] = to - b->node;
    return n;
}

/* ---- calls ----------------------------------------------------------------------------------- */

/** Smooth elements of a kind. way: with threads of the caller, for the best worst element. */
static int smooth(const kind *k, int way, box *b) {
    planish_options options;
    planish_plan *plan = NULL;
    planish_result result = {.n_inverted = -1};
    planish_error error = {.text = ""};
    const planish_cells cells = {
        .n = make(k, b), .type = b->type, .offset = b->offset, .node = b->node};
    const planish_mesh mesh = {
        .dim = 3, .n_nodes = NODES, .n_elements = cells.n, .coordinates = *b->xyz, .cells = &cells};
    planish_options_init(&options);
    options.threads = TASKS;
    options.parallel = way & 1 ? run_tasks : NULL;
    options.min_volume_fraction = way & 2 ? 1e-3 : 0;
    options.worst = !(way & 2)          ? PLANISH_WORST_NONE
                    : k->n_corners == 4 ? PLANISH_WORST_ANGLE
                                        : PLANISH_WORST_ASPECT_RATIO;
    if (planish_plan_create(&mesh, &options, &plan, &error) ||
        planish_smooth(plan, *b->xyz, &options, &result, &error))
        fprintf(stderr, "type %d, way %d: %s\n", (int)k->type, way, error.text);
    planish_plan_destroy(plan);
    if (result.n_inverted != 0)
        fprintf(stderr, "type %d, way %d: %d inverted\n", (int)k->type, way,
                (int)result.n_inverted);
    return result.n_inverted != 0;
}

static void *call(void *data) {
    int *failed = data;
    box *b = malloc(sizeof *b);
    for (size_t k = 0; b && k < sizeof kinds / sizeof *kinds; k++)
        for (int way = 0; way < 4; way++)
            *failed += smooth(&kinds[k], way, b);
    free(b);
    return NULL;
}

int main(void) {
    pthread_t thread;
    int failed = 0;
    if (start(call, &failed, &thread) || pthread_join(thread, NULL))
        return 2;
    return failed != 0;
}
