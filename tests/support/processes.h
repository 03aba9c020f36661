/* processes: a mesh in parts, and threads that have them, as processes would. */
#ifndef TEST_SUPPORT_PROCESSES_H
#define TEST_SUPPORT_PROCESSES_H

#include <planish/planish.h>

#include <pthread.h>

typedef struct processes processes;

/** The part of one process; everything is owned but of. */
typedef struct process {
    planish_mesh mesh; /* with part */
    planish_part part;
    double *coordinates;
    int32_t *elements;
    int64_t *node_number, *element_number;
    uint8_t *node_role, *is_counted, *constraint;
    double *direction, *min_volume;
    processes *of; /* all of them */
    int rank;
    const int32_t *sent_node; /* what it has sent, until the others have it */
    int64_t n_sent, sent_size;
    const void *sent;
    int64_t n_messages, n_values; /* all that it has sent */
} process;

struct processes {
    int n;
    process *parts;        /* [n] */
    pthread_mutex_t mutex; /* of what follows */
    pthread_cond_t all_are_there;
    int n_waiting, n_meetings; /* processes that wait for the others; times that all have met */
    int is_broken;             /* a process has ended its body: all calls of others fail */
    int64_t **offered;         /* [n] values to be added up or compared */
    int fails_at; /* call of a function that fails in every process, counted down; -1: none */
};

/** Ways to share out the nodes: in slabs, at random, all to the last process. */
enum { SLABS, SCATTERED, ONE_HAS_ALL, N_OWNINGS };

/** Fill owner [n_nodes] < n: which process owns a node, by one of these ways. */
void processes_own(const planish_mesh *mesh, int owning, int n, uint64_t seed, int *owner);

/** Split mesh into n parts; owner [n_nodes] < n says which process owns a node. */
void processes_create(processes *w, const planish_mesh *mesh, int n, const int *owner);
void processes_destroy(processes *w);

/** Call body(part, user) for each part in a thread of its own, all at the same time. A body that ends
 *  does not keep the others waiting: their calls fail from then on. */
void processes_run(processes *w, void (*body)(process *part, void *user), void *user);

/** Put the coordinates of all parts together: each node as its owner has it. */
void processes_gather(const processes *w, int dim, double *coordinates);

#endif
