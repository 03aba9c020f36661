/* small_ring: number the nodes and the edges of one small link after the other. Internal to
 * topology.
 *
 * Nearly all stars of a mesh of tetrahedra are small: bytes number their nodes and edges. A node is
 * looked up at the place that it hashes to, an edge in a table of pairs of nodes; both stay in the
 * first-level cache. Where two nodes of a link hash to the same place, which is rare, that is
 * noticed at the end, and the link is left to others.
 *
 * Whether something is new, nothing could predict, so no branch asks: what has no number yet has
 * PL_SMALL_NONE, above all numbers, so that its number is the lesser of that and the next one.
 */
#ifndef PL_TOPOLOGY_SMALL_RING_H
#define PL_TOPOLOGY_SMALL_RING_H

#include <stdint.h>
#include <string.h>

enum {
    PL_SMALL_NONE = UINT8_MAX,
    PL_SMALL_LINK = PL_SMALL_NONE / 3 - 1, /* facets of a small link, at most: three nodes and edges
                                              each have numbers below PL_SMALL_NONE */
    PL_SMALL_RING = 64,                    /* nodes of which the edges are numbered, at most */
    PL_SMALL_HASH_BITS = 12                /* so sparse that nodes hardly ever collide */
};

typedef struct pl_small_ring {
    uint8_t at[1 << PL_SMALL_HASH_BITS];         /* position of the node that hashes there */
    uint8_t edge[PL_SMALL_RING * PL_SMALL_RING]; /* [p][q] number of the edge from p to q */
    int32_t corner[3 * PL_SMALL_LINK];           /* of the facets: nodes, */
    uint8_t position[3 * PL_SMALL_LINK];         /* and their positions in the ring */
    uint8_t turned[PL_SMALL_LINK];               /* 1: a facet's last two are exchanged */
    int32_t node[3 * PL_SMALL_LINK + 1];         /* the ring; the last one may be no part of it */
    uint32_t n_nodes, n_edges;
    uint8_t unrepeated; /* PL_SMALL_NONE: no edge has been there twice in the same direction */
    char padding[64];   /* tables of different threads share no line */
} pl_small_ring;

/** Make a table of no link yet. */
static inline void pl_small_ring_init(pl_small_ring *t) {
    memset(t, 0, sizeof *t);
    memset(t->at, PL_SMALL_NONE, sizeof t->at);
}

static inline uint8_t *pl_small_ring_place(pl_small_ring *t, int32_t node) {
    return &t->at[(uint32_t)node * UINT32_C(0x9E3779B1) >> (32 - PL_SMALL_HASH_BITS)];
}

/** Number n nodes 0, 1, 2, ... in order of first appearance: corner, into position. */
static inline void pl_small_ring_number_nodes(pl_small_ring *t, int64_t n) {
    uint32_t next = 0;
    for (uint32_t i = 0; i < t->n_nodes; i++) /* of the link before */
        *pl_small_ring_place(t, t->node[i]) = PL_SMALL_NONE;
#pragma GCC unroll 3
    for (int64_t i = 0; i < n; i++) {
        uint8_t *place = pl_small_ring_place(t, t->corner[i]);
        const uint32_t known = *place, number = known < next ? known : next;
        t->node[next] = t->corner[i]; /* overwritten by the next one if it was known */
        next += known >= next;
        t->position[i] = *place = (uint8_t)number;
    }
    t->n_nodes = next;
}

/** Begin to number edges: there are at most PL_SMALL_RING nodes. */
static inline void pl_small_ring_begin_edges(pl_small_ring *t) {
    for (uint32_t p = 0, n = t->n_nodes; p < n; p++)
        memset(t->edge + p * PL_SMALL_RING, PL_SMALL_NONE, PL_SMALL_RING);
}

/** Number of the edge from the node at p to the one at q, the same as from q to p: 0, 1, 2, ... in
 *  order of first appearance. Around a closed link each edge is there once in each direction: then
 *  there are half as many as calls, and none is repeated. */
static inline uint8_t pl_small_ring_edge(pl_small_ring *t, uint32_t p, uint32_t q, uint32_t *next,
                                         uint8_t *unrepeated) {
    uint8_t *edge = t->edge + p * PL_SMALL_RING + q;
    const uint32_t twin = t->edge[q * PL_SMALL_RING + p], number = twin < *next ? twin : *next;
    *next += twin >= *next;
    *unrepeated &= *edge;
    *edge = (uint8_t)number;
    return (uint8_t)number;
}

#endif
