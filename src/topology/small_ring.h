/* small_ring: number the nodes and the edges of one small link after the other. Internal to
 * topology.
 *
 * Nearly all stars of a mesh of tetrahedra are small: bytes number their nodes and edges. A node is
 * looked up at the place that it hashes to, an edge in a table of pairs of nodes; both stay in the
 * first-level cache. In one link of fifty, two nodes hash to the same place. The function notices
 * this at the end, and numbers the link again by another hash. A link that collides in both is left
 * to others.
 *
 * Whether something is new, nothing could predict, so no branch asks: what has no number yet has
 * PL_SMALL_NONE, above all numbers, so that its number is the lesser of that and the next one.
 *
 *   pl_small_ring_init, _begin_nodes, _begin_edges     empty a table
 *   pl_small_ring_node, _edge                          number a node, an edge
 *   pl_small_ring_factor, _place, _edges_of            places in a table
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
    PL_SMALL_HASH_BITS = 12,               /* so sparse that nodes hardly ever collide */
    PL_SMALL_HASHES = 2
};

/** Table of one thread. */
typedef struct pl_small_ring {
    uint8_t at[1 << PL_SMALL_HASH_BITS];         /* position of the node that hashes there */
    uint8_t edge[PL_SMALL_RING * PL_SMALL_RING]; /* [p][q] number of the edge from p to q */
    int32_t node[3 * PL_SMALL_LINK + 1];         /* the ring; the last one may be no part of it */
    uint32_t n_nodes, n_edges;
    uint32_t factor;     /* of the hash by which the nodes are at their places */
    uint32_t collision;  /* not 0: two nodes have the same position */
    uint32_t unrepeated; /* PL_SMALL_NONE: no edge has been there twice in the same direction */
    char padding[64];    /* tables of different threads share no line */
} pl_small_ring;

/** Make a table of no link yet. */
static inline void pl_small_ring_init(pl_small_ring *t) {
    memset(t, 0, sizeof *t);
    memset(t->at, PL_SMALL_NONE, sizeof t->at);
}

/** Factor of the i-th hash: odd, with bits all over (the golden ratio after Knuth, and one of
 *  MurmurHash3's). */
static inline uint32_t pl_small_ring_factor(int i) {
    return i == 0 ? UINT32_C(0x9E3779B1) : UINT32_C(0x85EBCA6B);
}

/** Place of a node in the hash table. */
static inline uint32_t pl_small_ring_place(int32_t node, uint32_t factor) {
    return (uint32_t)node * factor >> (32 - PL_SMALL_HASH_BITS);
}

/** Begin to number nodes by the i-th hash. */
static inline void pl_small_ring_begin_nodes(pl_small_ring *t, int i) {
    for (uint32_t k = 0; k < t->n_nodes; k++) /* of the link before */
        t->at[pl_small_ring_place(t->node[k], t->factor)] = PL_SMALL_NONE;
    t->factor = pl_small_ring_factor(i);
    t->n_nodes = 0;
    t->collision = 0;
}

/** Position of node: 0, 1, 2, ... in order of first appearance. The table's counts are the caller's
 *  to keep, in registers: factor as it says, next and collision 0 at first. */
static inline uint8_t pl_small_ring_node(pl_small_ring *t, uint32_t factor, int32_t node,
                                         uint32_t *next, uint32_t *collision) {
    uint8_t *place = t->at + pl_small_ring_place(node, factor);
    const uint32_t known = *place, number = known < *next ? known : *next;
    t->node[*next] = node; /* overwritten by the next one if it was known */
    *next += known >= *next;
    *place = (uint8_t)number;
    *collision |= (uint32_t)(t->node[number] ^ node);
    return (uint8_t)number;
}

/** Begin to number edges: there are at most PL_SMALL_RING nodes. */
static inline void pl_small_ring_begin_edges(pl_small_ring *t) {
    for (uint32_t p = 0, n = t->n_nodes; p < n; p++)
        memset(t->edge + p * PL_SMALL_RING, PL_SMALL_NONE, PL_SMALL_RING);
}

/** The numbers of the edges from the node at position p. */
static inline uint8_t *pl_small_ring_edges_of(pl_small_ring *t, size_t p) {
    return t->edge + PL_SMALL_RING * p;
}

/** Number of an edge, the same in both directions: 0, 1, 2, ... in order of first appearance.
 *  forth and back: where the table has the edge in this direction and the other. Around a closed
 *  link each edge is there once in each direction: then there are half as many as calls, and none
 *  is repeated. */
static inline uint8_t pl_small_ring_edge(uint8_t *forth, const uint8_t *back, uint32_t *next,
                                         uint32_t *unrepeated) {
    const uint32_t twin = *back, number = twin < *next ? twin : *next;
    *next += twin >= *next;
    *unrepeated &= *forth;
    *forth = (uint8_t)number;
    return (uint8_t)number;
}

#endif
