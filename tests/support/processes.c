/* processes: a mesh in parts, and threads that have them. */
#define _GNU_SOURCE /* pthread_attr_setaffinity_np */
#include "support/processes.h"
#include "support/effort.h"

#include <sched.h>
#include <stdlib.h>
#include <string.h>

static void *checked(void *memory) {
    if (!memory)
        abort();
    return memory;
}

static void *room(int64_t n, size_t size) {
    return checked(calloc((size_t)(n > 0 ? n : 1), size));
}

/* ---- what processes do together ------------------------------------------------------------- */

/* Each of these has two times at which all wait for each other: before the first they say what they
 * have, before the second they look at what the others have said. */

/** Whether this is the one that fails: asked before the first, */
static int fails_now(const process *p) {
    return p->of->fails_at == 0;
}

/** and counted before the second. */
static void count_down(const process *p) {
    if (p->rank == 0 && p->of->fails_at >= 0)
        p->of->fails_at--;
}

/** Wait until all processes are here; return 0 if one will not come. */
static int meet(processes *w) {
    pthread_mutex_lock(&w->mutex);
    const int meeting = w->n_meetings;
    if (++w->n_waiting == w->n) {
        w->n_waiting = 0;
        w->n_meetings++;
        pthread_cond_broadcast(&w->all_are_there);
    }
    while (meeting == w->n_meetings && !w->is_broken)
        pthread_cond_wait(&w->all_are_there, &w->mutex);
    const int have_met = meeting != w->n_meetings;
    pthread_mutex_unlock(&w->mutex);
    return have_met;
}

/** Come to no meeting any more. */
static void leave(processes *w) {
    pthread_mutex_lock(&w->mutex);
    w->is_broken = 1;
    pthread_cond_broadcast(&w->all_are_there);
    pthread_mutex_unlock(&w->mutex);
}

/** values become those of all processes: their sums, or the largest. */
static int combine(process *p, int64_t *values, int n, int largest) {
    processes *w = p->of;
    const int fails = fails_now(p);
    int64_t *result = room(n, sizeof *result);
    w->offered[p->rank] = values;
    if (!meet(w)) {
        free(result);
        return 1;
    }
    count_down(p);
    for (int i = 0; i < n; i++) {
        result[i] = w->offered[0][i];
        for (int k = 1; k < w->n; k++) {
            const int64_t other = w->offered[k][i];
            if (largest)
                result[i] = other > result[i] ? other : result[i];
            else
                result[i] += other;
        }
    }
    meet(w);
    memcpy(values, result, (size_t)n * sizeof *values);
    free(result);
    return fails;
}

static int add(int64_t *values, int n, void *user) {
    return combine(user, values, n, 0);
}

static int largest(int64_t *values, int n, void *user) {
    return combine(user, values, n, 1);
}

static int send_values(const int32_t *node, int64_t n, const void *values, int64_t size,
                       void *user) {
    process *p = user;
    for (int64_t i = 0; i < n; i++)
        if (p->node_role[node[i]] != PLANISH_ROLE_SHARED)
            abort();
    p->sent_node = node;
    p->n_sent = n;
    p->sent = values;
    p->sent_size = size;
    p->n_messages++;
    p->n_values += n;
    return 0;
}

/** The node of that number, or -1. */
static int64_t find(const process *p, int64_t number) {
    int64_t low = 0, high = p->mesh.n_nodes;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        if (p->node_number[middle] < number)
            low = middle + 1;
        else
            high = middle;
    }
    return low < p->mesh.n_nodes && p->node_number[low] == number ? low : -1;
}

static int receive_values(planish_take_fn *take, void *taker, void *user) {
    process *p = user;
    processes *w = p->of;
    const int fails = fails_now(p);
    if (!meet(w))
        return 1;
    count_down(p);
    for (int k = 0; k < w->n; k++) {
        const process *q = &w->parts[k];
        for (int64_t i = 0; k != p->rank && i < q->n_sent; i++) {
            const int64_t ghost = find(p, q->node_number[q->sent_node[i]]);
            if (ghost >= 0)
                take((int32_t)ghost, (const char *)q->sent + i * q->sent_size, taker);
        }
    }
    meet(w);
    return fails;
}

/* ---- parts ---------------------------------------------------------------------------------- */

/** Which nodes a process has: 1 its own, 2 ghosts. */
static uint8_t *find_nodes(const planish_mesh *mesh, const int *owner, int rank) {
    uint8_t *has = room(mesh->n_nodes, 1);
    const int corners = mesh->dim + 1;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        has[i] = owner[i] == rank;
    for (int64_t e = 0; e < mesh->n_elements; e++) {
        const int32_t *node = mesh->elements + e * corners;
        int mine = 0;
        for (int j = 0; j < corners; j++)
            mine |= owner[node[j]] == rank;
        for (int j = 0; mine && j < corners; j++)
            has[node[j]] |= owner[node[j]] == rank ? 1 : 2;
    }
    return has;
}

/** Whether a node is another process's ghost: somebody else owns a node of one of its elements. */
static uint8_t *find_shared(const planish_mesh *mesh, const int *owner) {
    uint8_t *shared = room(mesh->n_nodes, 1);
    const int corners = mesh->dim + 1;
    for (int64_t e = 0; e < mesh->n_elements; e++)
        for (int j = 0; j < corners; j++)
            for (int k = 0; k < corners; k++)
                shared[mesh->elements[e * corners + j]] |= owner[mesh->elements[e * corners + j]] !=
                                                           owner[mesh->elements[e * corners + k]];
    return shared;
}

static void take_nodes(process *p, const planish_mesh *mesh, const int *owner, const uint8_t *has,
                       const uint8_t *shared, int32_t *local) {
    const int dim = mesh->dim;
    int64_t n = 0;
    p->node_number = room(mesh->n_nodes, sizeof *p->node_number);
    p->node_role = room(mesh->n_nodes, 1);
    p->constraint = room(mesh->n_nodes, 1);
    p->coordinates = room(mesh->n_nodes * dim, sizeof *p->coordinates);
    p->direction = room(mesh->n_nodes * dim, sizeof *p->direction);
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        local[i] = -1;
        if (!has[i])
            continue;
        p->node_number[n] = i;
        p->node_role[n] = (uint8_t)(owner[i] != p->rank ? PLANISH_ROLE_GHOST
                                    : shared[i]         ? PLANISH_ROLE_SHARED
                                                        : PLANISH_ROLE_OWN);
        p->constraint[n] = mesh->constraint ? mesh->constraint[i] : 0;
        memcpy(p->coordinates + n * dim, mesh->coordinates + i * dim,
               (size_t)dim * sizeof *p->coordinates);
        if (mesh->direction)
            memcpy(p->direction + n * dim, mesh->direction + i * dim,
                   (size_t)dim * sizeof *p->direction);
        local[i] = (int32_t)n++;
    }
    p->mesh.n_nodes = n;
}

static void take_elements(process *p, const planish_mesh *mesh, const int *owner,
                          const int32_t *local) {
    const int corners = mesh->dim + 1;
    int64_t n = 0;
    p->elements = room(mesh->n_elements * corners, sizeof *p->elements);
    p->element_number = room(mesh->n_elements, sizeof *p->element_number);
    p->is_counted = room(mesh->n_elements, 1);
    p->min_volume = room(mesh->n_elements, sizeof *p->min_volume);
    for (int64_t e = 0; e < mesh->n_elements; e++) {
        const int32_t *node = mesh->elements + e * corners;
        int mine = 0;
        for (int j = 0; j < corners; j++)
            mine |= owner[node[j]] == p->rank;
        if (!mine)
            continue;
        for (int j = 0; j < corners; j++)
            p->elements[n * corners + j] = local[node[j]];
        p->element_number[n] = e;
        p->is_counted[n] = owner[node[e % corners]] == p->rank;
        p->min_volume[n++] = mesh->min_volume ? mesh->min_volume[e] : 0;
    }
    p->mesh.n_elements = n;
}

static void part_create(process *p, processes *w, int rank, const planish_mesh *mesh,
                        const int *owner, const uint8_t *shared) {
    uint8_t *has = find_nodes(mesh, owner, rank);
    int32_t *local = room(mesh->n_nodes, sizeof *local);
    *p = (process){.of = w, .rank = rank, .mesh = {.dim = mesh->dim}};
    take_nodes(p, mesh, owner, has, shared, local);
    take_elements(p, mesh, owner, local);
    p->part = (planish_part){.node_number = p->node_number,
                             .node_role = p->node_role,
                             .is_counted = p->is_counted,
                             .add = add,
                             .largest = largest,
                             .send = send_values,
                             .receive = receive_values,
                             .user = p};
    p->mesh.coordinates = p->coordinates;
    p->mesh.elements = p->elements;
    p->mesh.constraint = mesh->constraint ? p->constraint : NULL;
    p->mesh.direction = mesh->direction ? p->direction : NULL;
    p->mesh.min_volume = mesh->min_volume ? p->min_volume : NULL;
    p->mesh.part = &p->part;
    free(has);
    free(local);
}

void processes_create(processes *w, const planish_mesh *mesh, int n, const int *owner) {
    uint8_t *shared = find_shared(mesh, owner);
    *w = (processes){.n = n, .fails_at = -1};
    w->parts = room(n, sizeof *w->parts);
    w->offered = room(n, sizeof *w->offered);
    pthread_mutex_init(&w->mutex, NULL);
    pthread_cond_init(&w->all_are_there, NULL);
    for (int k = 0; k < n; k++)
        part_create(&w->parts[k], w, k, mesh, owner, shared);
    free(shared);
}

void processes_destroy(processes *w) {
    for (int k = 0; k < w->n; k++) {
        process *p = &w->parts[k];
        free(p->coordinates);
        free(p->elements);
        free(p->node_number);
        free(p->element_number);
        free(p->node_role);
        free(p->is_counted);
        free(p->constraint);
        free(p->direction);
        free(p->min_volume);
    }
    pthread_mutex_destroy(&w->mutex);
    pthread_cond_destroy(&w->all_are_there);
    free(w->parts);
    free(w->offered);
}

/* ---- threads --------------------------------------------------------------------------------- */

typedef struct task {
    process *part;
    void (*body)(process *part, void *user);
    void *user;
} task;

static void *run(void *a_task) {
    const task *t = a_task;
    t->body(t->part, t->user);
    leave(t->part->of);
    return NULL;
}

/** All threads on this CPU: parts this small wait for one another all the time, and waking a thread
 *  on an idle CPU takes longer than its turn (five times as long in all, on a virtual machine). */
static void stay_here(pthread_attr_t *attributes) {
#ifdef __linux__
    const int here = sched_getcpu();
    cpu_set_t set;
    CPU_ZERO(&set);
    if (here < 0 || here >= CPU_SETSIZE)
        return;
    CPU_SET((size_t)here, &set);
    pthread_attr_setaffinity_np(attributes, sizeof set, &set);
#else
    (void)attributes;
#endif
}

void processes_run(processes *w, void (*body)(process *part, void *user), void *user) {
    w->n_waiting = w->is_broken = 0;
    pthread_t *thread = room(w->n, sizeof *thread);
    task *tasks = room(w->n, sizeof *tasks);
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes) != 0)
        abort();
    stay_here(&attributes);
    for (int k = 0; k < w->n; k++) {
        tasks[k] = (task){&w->parts[k], body, user};
        if (pthread_create(&thread[k], &attributes, run, &tasks[k]) != 0)
            abort();
    }
    for (int k = 0; k < w->n; k++)
        pthread_join(thread[k], NULL);
    pthread_attr_destroy(&attributes);
    free(thread);
    free(tasks);
}

void processes_gather(const processes *w, int dim, double *coordinates) {
    for (int k = 0; k < w->n; k++) {
        const process *p = &w->parts[k];
        for (int64_t i = 0; i < p->mesh.n_nodes; i++)
            if (p->node_role[i] != PLANISH_ROLE_GHOST)
                memcpy(coordinates + p->node_number[i] * dim, p->coordinates + i * dim,
                       (size_t)dim * sizeof *coordinates);
    }
}

void processes_own(const planish_mesh *mesh, int owning, int n, uint64_t seed, int *owner) {
    uint64_t random = effort_seed(seed);
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        if (owning == SLABS)
            owner[i] = (int)(i * n / mesh->n_nodes);
        else if (owning == SCATTERED)
            owner[i] = (int)random_below(&random, n);
        else
            owner[i] = n - 1;
    }
}
