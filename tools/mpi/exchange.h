/* exchange: messages by MPI between the processes that share a mesh: the four functions of
 * planish_part, and values that the first process collects.
 *
 *     pl_exchange_*             values of ghosts
 *     pl_gathering_*            how many values of each process the first one gets
 *     pl_gather, pl_scatter     these values, there and back
 */
#ifndef PL_TOOLS_MPI_EXCHANGE_H
#define PL_TOOLS_MPI_EXCHANGE_H

#include "job/job.h"

#include <mpi.h>

/** A ghost: this process's node, and where its value comes from. */
typedef struct pl_ghost {
    int32_t node;
    int owner;       /* rank */
    int32_t of_node; /* the owner's number of it */
} pl_ghost;

/** Destination of the value of one of our nodes. */
typedef struct pl_goal {
    int32_t neighbour; /* index in to */
    int32_t position;  /* in the list of ghosts that it has from here */
} pl_goal;

/** Ready to exchange. Everything is owned but comm. */
typedef struct pl_exchange {
    MPI_Comm comm;
    int n_to, n_from;     /* neighbours */
    int *to, *from;       /* ranks, ascending */
    int64_t *to_begin;    /* [n_to + 1] of the most that goes to each */
    int64_t *from_begin;  /* [n_from + 1] of the ghosts of each */
    int32_t *ghost;       /* [from_begin[n_from]] by neighbour and position */
    int64_t *goal_begin;  /* [n_nodes + 1] */
    pl_goal *goal;        /* of each node of ours */
    MPI_Request *request; /* [n_from + n_to] receives, then sends */
    char *in, *out;       /* messages, of entries: a position and a value */
    int64_t *n_out;       /* [n_to] entries */
    int64_t capacity;     /* bytes of an entry at most */
    int64_t entry;        /* bytes, of the messages under way */
    pl_traffic traffic;   /* of this process */
} pl_exchange;

/** Find out who wants what: ghosts [n] of this process, of n_nodes nodes. Collective. Returns 0, or
 * a negative planish_status with *error filled in; to be destroyed in any case. */
int pl_exchange_create(pl_exchange *e, MPI_Comm comm, const pl_ghost *ghosts, int64_t n,
                       int64_t n_nodes, planish_error *error);
void pl_exchange_destroy(pl_exchange *exchange);

/** The functions of part, whose user becomes exchange. */
void pl_exchange_serve(pl_exchange *exchange, planish_part *part);

/** How many records of each process the first one gets, and where they are there. */
typedef struct pl_gathering {
    MPI_Comm comm;
    int n;              /* of this process */
    int *count, *begin; /* [ranks] in the first process; owned */
    int64_t n_all;      /* in the first process; 0 in the others */
} pl_gathering;

/** Create it for n records of this process. Collective. Returns 0, or a negative planish_status with
 *  *error filled in (PLANISH_ERROR_PARTS: more than MPI counts); to be destroyed in any case. */
int pl_gathering_create(pl_gathering *gathering, MPI_Comm comm, int64_t n, planish_error *error);
void pl_gathering_destroy(pl_gathering *gathering);

/** Gather records [n][size] of each process as all [n_all][size] of the first one. Collective. */
void pl_gather(const pl_gathering *gathering, const void *mine, int size, void *all);

/** Scatter all of the first process, as they were gathered. Collective. */
void pl_scatter(const pl_gathering *gathering, const void *all, int size, void *mine);

#endif
