/* small_ring: number the nodes and the edges of one small link after the other. Internal to
 * topology.
 *
 * Nearly all stars of a mesh of tetrahedra are small. Their nodes are found in a hash table of
 * numbers of 32 bits, their edges in a table of pairs of nodes; both stay in the first-level cache.
 * Nothing is emptied between links: a number counts only if it is above those of the link before.
 */
#ifndef PL_TOPOLOGY_SMALL_RING_H
#define PL_TOPOLOGY_SMALL_RING_H

#include <stdint.h>
#include <string.h>

enum {
    PL_SMALL_RING = 64,  /* nodes of a small link, at most */
    PL_SMALL_LINK = 124, /* facets of a small link, at most: those of a sphere with so many nodes */
    PL_SMALL_HASH_BITS = 9,
    PL_SMALL_HASH = 1 << PL_SMALL_HASH_BITS /* so sparse that nodes hardly ever collide */
};

typedef struct pl_small_ring {
    uint64_t node[PL_SMALL_HASH];                /* a node << 32 | its number */
    uint32_t edge[PL_SMALL_RING][PL_SMALL_RING]; /* [p][q] number of the edge from p to q */
    uint32_t last;                               /* number given last */
    char padding[60];                            /* tables of different threads share no line */
} pl_small_ring;

/** The numbers of one link: apart from the tables, so that they stay in registers. */
typedef struct pl_small_numbers {
    uint32_t before;       /* numbers up to it are of former links */
    uint32_t node, edge;   /* given last */
    uint32_t has_repeated; /* 1: an edge has been there twice in the same direction */
} pl_small_numbers;

/** Begin another link. The table is {0} at first. */
static inline pl_small_numbers pl_small_ring_begin(pl_small_ring *t) {
    if (t->last > UINT32_MAX - 3 * PL_SMALL_LINK)
        memset(t, 0, sizeof *t);
    return (pl_small_numbers){t->last, t->last, t->last, 0};
}

/** End it, wherever. */
static inline void pl_small_ring_end(pl_small_ring *t, const pl_small_numbers *given) {
    t->last = given->node > given->edge ? given->node : given->edge;
}

/** Position of node: 0, 1, 2, ... in order of first appearance. Whether it is new nothing could
 *  predict: no branch asks. */
static inline int32_t pl_small_ring_node(pl_small_ring *t, int32_t node, pl_small_numbers *given) {
    uint32_t i = (uint32_t)node * UINT32_C(0x9E3779B1) >> (32 - PL_SMALL_HASH_BITS);
    uint64_t entry = t->node[i];
    while (((uint32_t)entry > given->before) > ((uint32_t)(entry >> 32) == (uint32_t)node)) {
        i = (i + 1) % PL_SMALL_HASH;
        entry = t->node[i];
    }
    const uint32_t is_new = (uint32_t)entry <= given->before;
    given->node += is_new;
    const uint32_t number = is_new ? given->node : (uint32_t)entry;
    t->node[i] = (uint64_t)(uint32_t)node << 32 | number;
    return (int32_t)(number - given->before - 1);
}

/** Position of the edge from the node at p to the one at q, the same as from q to p: 0, 1, 2, ...
 * in order of first appearance. Around a closed link each edge is there once in each direction:
 * then there are half as many as calls, and none is repeated. */
static inline int32_t pl_small_ring_edge(pl_small_ring *t, int32_t p, int32_t q,
                                         pl_small_numbers *given) {
    const uint32_t twin = t->edge[q][p], is_new = twin <= given->before;
    given->edge += is_new;
    given->has_repeated |= t->edge[p][q] > given->before;
    const uint32_t number = is_new ? given->edge : twin;
    t->edge[p][q] = number;
    return (int32_t)(number - given->before - 1);
}

#endif
