/* exchange: values of ghosts, and sums, by MPI. */
#include "mpi/exchange.h"

#include "base/clock.h"
#include "base/status.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TAG_LISTS = 1, TAG_VALUES = 2 };

/* ---- who wants what ------------------------------------------------------------------------- */

/** By owner, and there by its number: what the owner sends in one order is received in it. */
static int compare_ghosts(const void *a, const void *b) {
    const pl_ghost *p = a, *q = b;
    if (p->owner != q->owner)
        return p->owner < q->owner ? -1 : 1;
    return (p->of_node > q->of_node) - (p->of_node < q->of_node);
}

/** to and to_begin: how many nodes each process wants of this one. */
static int list_goals(pl_exchange *e) {
    int n_ranks;
    MPI_Comm_size(e->comm, &n_ranks);
    int *wanted = calloc((size_t)n_ranks, sizeof *wanted);
    int *asked = calloc((size_t)n_ranks, sizeof *asked);
    e->to = calloc((size_t)n_ranks, sizeof *e->to);
    e->to_begin = calloc((size_t)n_ranks + 1, sizeof *e->to_begin);
    const int done = wanted && asked && e->to && e->to_begin;
    if (done) {
        for (int k = 0; k < e->n_from; k++)
            wanted[e->from[k]] = (int)(e->from_begin[k + 1] - e->from_begin[k]);
        MPI_Alltoall(wanted, 1, MPI_INT, asked, 1, MPI_INT, e->comm);
        for (int rank = 0; rank < n_ranks; rank++)
            if (asked[rank] > 0) {
                e->to[e->n_to] = rank;
                e->to_begin[e->n_to + 1] = e->to_begin[e->n_to] + asked[rank];
                e->n_to++;
            }
    }
    free(wanted);
    free(asked);
    return done ? 0 : -1;
}

/** Send the lists of what is wanted, and receive those of the others: goal_begin and goal. */
static int swap_lists(pl_exchange *e, const pl_ghost *ghosts, int64_t n, int64_t n_nodes) {
    const int64_t n_goals = e->to_begin[e->n_to];
    int32_t *wanted = calloc((size_t)n_goals + 1, sizeof *wanted);
    int32_t *mine = malloc(((size_t)n + 1) * sizeof *mine);
    e->goal_begin = calloc((size_t)n_nodes + 2, sizeof *e->goal_begin);
    e->goal = malloc(((size_t)n_goals + 1) * sizeof *e->goal);
    const int status = wanted && mine && e->request && e->goal_begin && e->goal ? 0 : -1;
    if (!status) {
        for (int64_t i = 0; i < n; i++)
            mine[i] = ghosts[i].of_node;
        for (int k = 0; k < e->n_to; k++)
            MPI_Irecv(wanted + e->to_begin[k], (int)(e->to_begin[k + 1] - e->to_begin[k]),
                      MPI_INT32_T, e->to[k], TAG_LISTS, e->comm, &e->request[k]);
        for (int k = 0; k < e->n_from; k++)
            MPI_Isend(mine + e->from_begin[k], (int)(e->from_begin[k + 1] - e->from_begin[k]),
                      MPI_INT32_T, e->from[k], TAG_LISTS, e->comm, &e->request[e->n_to + k]);
        MPI_Waitall(e->n_to + e->n_from, e->request, MPI_STATUSES_IGNORE);
        int64_t *next = e->goal_begin + 1; /* becomes the beginning of the node after */
        for (int64_t i = 0; i < n_goals; i++)
            next[wanted[i] + 1]++;
        for (int64_t i = 0; i < n_nodes; i++)
            next[i + 1] += next[i];
        for (int32_t k = 0; k < e->n_to; k++)
            for (int64_t i = e->to_begin[k]; i < e->to_begin[k + 1]; i++)
                e->goal[next[wanted[i]]++] = (pl_goal){k, (int32_t)(i - e->to_begin[k])};
    }
    free(wanted);
    free(mine);
    return status;
}

int pl_exchange_create(pl_exchange *e, MPI_Comm comm, const pl_ghost *ghosts, int64_t n,
                       int64_t n_nodes, planish_error *error) {
    *e = (pl_exchange){.comm = comm,
                       .from = calloc((size_t)n + 1, sizeof *e->from),
                       .from_begin = calloc((size_t)n + 2, sizeof *e->from_begin),
                       .ghost = calloc((size_t)n + 1, sizeof *e->ghost)};
    pl_ghost *sorted = calloc((size_t)n + 1, sizeof *sorted);
    int status = sorted && e->from && e->from_begin && e->ghost ? 0 : -1;
    if (!status) {
        for (int64_t i = 0; i < n; i++)
            sorted[i] = ghosts[i];
        qsort(sorted, (size_t)n, sizeof *sorted, compare_ghosts);
        for (int64_t i = 0; i < n; i++) {
            if (i == 0 || sorted[i].owner != sorted[i - 1].owner) {
                e->from[e->n_from] = sorted[i].owner;
                e->from_begin[e->n_from++] = i;
            }
            e->ghost[i] = sorted[i].node;
        }
        e->from_begin[e->n_from] = n;
        status = list_goals(e);
    }
    if (!status) {
        e->request = malloc(((size_t)(e->n_to + e->n_from) + 1) * sizeof *e->request);
        e->n_out = calloc((size_t)e->n_to + 1, sizeof *e->n_out);
        status = e->n_out ? swap_lists(e, sorted, n, n_nodes) : -1;
    }
    free(sorted);
    return status ? pl_fail_memory(error, "the ghosts") : PLANISH_OK;
}

void pl_exchange_destroy(pl_exchange *e) {
    free(e->to);
    free(e->from);
    free(e->to_begin);
    free(e->from_begin);
    free(e->ghost);
    free(e->goal_begin);
    free(e->goal);
    free(e->request);
    free(e->in);
    free(e->out);
    free(e->n_out);
    *e = (pl_exchange){0};
}

/* ---- the functions of planish_part ---------------------------------------------------------- */

/** Integers of all processes together, in place. */
static int reduce(pl_exchange *e, int64_t *values, int n, MPI_Op operation) {
    const double begin = pl_seconds();
    const int code = MPI_Allreduce(MPI_IN_PLACE, values, n, MPI_INT64_T, operation, e->comm);
    e->traffic.wait_seconds += pl_seconds() - begin;
    e->traffic.messages++;
    e->traffic.bytes += n * (int64_t)sizeof *values;
    return code;
}

static int add_up(int64_t *values, int n, void *user) {
    return reduce(user, values, n, MPI_SUM);
}

static int largest(int64_t *values, int n, void *user) {
    return reduce(user, values, n, MPI_MAX);
}

/** Room for messages with values of size bytes; 0, or -1. */
static int make_room(pl_exchange *e, int64_t size) {
    e->entry = size + (int64_t)sizeof(int32_t);
    if (e->entry <= e->capacity)
        return 0;
    free(e->in);
    free(e->out);
    e->in = malloc((size_t)(e->from_begin[e->n_from] * e->entry) + 1);
    e->out = malloc((size_t)(e->to_begin[e->n_to] * e->entry) + 1);
    e->capacity = e->in && e->out ? e->entry : 0;
    return e->in && e->out ? 0 : -1;
}

/** One message to each neighbour, though it may be empty: he waits for it. */
static int send_values(const int32_t *node, int64_t n, const void *values, int64_t size,
                       void *user) {
    pl_exchange *e = user;
    int code = MPI_SUCCESS;
    if (make_room(e, size))
        return -1;
    for (int k = 0; k < e->n_from && !code; k++) {
        const int64_t begin = e->from_begin[k] * e->entry, end = e->from_begin[k + 1] * e->entry;
        code = end - begin > INT_MAX ? MPI_ERR_COUNT
                                     : MPI_Irecv(e->in + begin, (int)(end - begin), MPI_BYTE,
                                                 e->from[k], TAG_VALUES, e->comm, &e->request[k]);
    }
    memset(e->n_out, 0, (size_t)e->n_to * sizeof *e->n_out);
    for (int64_t i = 0; i < n; i++)
        for (int64_t k = e->goal_begin[node[i]]; k < e->goal_begin[node[i] + 1]; k++) {
            const pl_goal *goal = &e->goal[k];
            const int64_t entry = e->to_begin[goal->neighbour] + e->n_out[goal->neighbour]++;
            char *to = e->out + entry * e->entry;
            memcpy(to, &goal->position, sizeof goal->position);
            memcpy(to + sizeof goal->position, (const char *)values + i * size, (size_t)size);
        }
    for (int k = 0; k < e->n_to && !code; k++) {
        const int64_t bytes = e->n_out[k] * e->entry;
        code = bytes > INT_MAX
                   ? MPI_ERR_COUNT
                   : MPI_Isend(e->out + e->to_begin[k] * e->entry, (int)bytes, MPI_BYTE, e->to[k],
                               TAG_VALUES, e->comm, &e->request[e->n_from + k]);
        e->traffic.messages++;
        e->traffic.nodes += e->n_out[k];
        e->traffic.bytes += bytes;
    }
    return code;
}

static int receive_values(planish_take_fn *take, void *taker, void *user) {
    pl_exchange *e = user;
    const double begin = pl_seconds();
    double taking = 0;
    int code = MPI_SUCCESS;
    for (int i = 0; i < e->n_from && !code; i++) {
        MPI_Status status;
        int k, bytes;
        code = MPI_Waitany(e->n_from, e->request, &k, &status);
        if (code || MPI_Get_count(&status, MPI_BYTE, &bytes))
            break;
        const double arrived = pl_seconds();
        const char *next = e->in + e->from_begin[k] * e->entry;
        for (const char *end = next + bytes; next < end; next += e->entry) {
            int32_t position;
            memcpy(&position, next, sizeof position);
            take(e->ghost[e->from_begin[k] + position], next + sizeof position, taker);
        }
        taking += pl_seconds() - arrived;
    }
    if (!code)
        code = MPI_Waitall(e->n_to, e->request + e->n_from, MPI_STATUSES_IGNORE);
    e->traffic.wait_seconds += pl_seconds() - begin - taking;
    return code;
}

void pl_exchange_serve(pl_exchange *exchange, planish_part *part) {
    part->add = add_up;
    part->largest = largest;
    part->send = send_values;
    part->receive = receive_values;
    part->user = exchange;
}

/* ---- values of all processes in the first one ----------------------------------------------- */

int pl_gathering_create(pl_gathering *g, MPI_Comm comm, int64_t n, planish_error *error) {
    int rank, n_ranks;
    MPI_Comm_rank(comm, &rank);
    MPI_Comm_size(comm, &n_ranks);
    *g = (pl_gathering){.comm = comm,
                        .n = (int)n,
                        .count = calloc((size_t)n_ranks, sizeof *g->count),
                        .begin = calloc((size_t)n_ranks, sizeof *g->begin)};
    if (!g->count || !g->begin)
        return pl_fail_memory(error, "values of all processes");
    MPI_Gather(&g->n, 1, MPI_INT, g->count, 1, MPI_INT, 0, comm);
    for (int k = 0; rank == 0 && k < n_ranks; k++) {
        g->begin[k] = (int)g->n_all;
        g->n_all += g->count[k];
    }
    return n <= INT_MAX && g->n_all <= INT_MAX
               ? PLANISH_OK
               : pl_fail(error, PLANISH_ERROR_PARTS, "there are more values than MPI counts");
}

void pl_gathering_destroy(pl_gathering *g) {
    free(g->count);
    free(g->begin);
    *g = (pl_gathering){.n = 0};
}

void pl_gather(const pl_gathering *g, const void *mine, int size, void *all) {
    MPI_Datatype row;
    MPI_Type_contiguous(size, MPI_BYTE, &row);
    MPI_Type_commit(&row);
    MPI_Gatherv(mine, g->n, row, all, g->count, g->begin, row, 0, g->comm);
    MPI_Type_free(&row);
}

void pl_scatter(const pl_gathering *g, const void *all, int size, void *mine) {
    MPI_Datatype row;
    MPI_Type_contiguous(size, MPI_BYTE, &row);
    MPI_Type_commit(&row);
    MPI_Scatterv(all, g->count, g->begin, row, mine, g->n, row, 0, g->comm);
    MPI_Type_free(&row);
}
