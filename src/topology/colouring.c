/* colouring: independent nodes.
 *
 * The serial greedy algorithm gives each node, in order of priority, the smallest colour that no
 * neighbour has. A node's colour depends on its neighbours of higher priority only, so that a node
 * can be coloured as soon as all of them are, on any thread and in any order (Jones and Plassmann,
 * A parallel graph coloring heuristic, SIAM J. Sci. Comput. 14, 1993). Here every node counts those
 * it waits for; the thread that colours the last of them colours the node as well. There are no
 * rounds and no barriers, and what becomes ready lies close to what has just been coloured.
 */
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <string.h>

enum {
    CHUNK_NODES = 16384, /* mesh nodes that one thread takes at a time */
    CHUNK_RINGS = 512,   /* rings, likewise */
    UNCOLOURED = -1,
    MASK_COLOURS = 64 /* colours in a mask */
};

/** The graph of the free nodes, numbered by their rings, and the state of its colouring. */
typedef struct work {
    const pl_rings *rings;
    const int32_t *node;       /* [n_rings] the caller's number, -1: none */
    const int32_t *number;     /* [n_nodes] of each node, or NULL: itself */
    const int32_t *moves_with; /* [n_nodes] or NULL */
    int32_t *ring_of;          /* [n_nodes] ring of each node, -1: not free */
    int32_t *neighbour; /* [offset[n_rings]] rings of the free neighbours, packed to the front of
                           each ring's room */
    uint64_t *priority; /* [n_rings] larger: earlier; distinct */
    int32_t *higher;    /* [n_rings] neighbours of higher priority, which come first */
    int32_t *waiting;   /* [n_rings] uncoloured neighbours of higher priority, and 1 until the
                           loop over all nodes has come past */
    int32_t *next;      /* [n_rings] below it on a thread's stack, -1: none */
    int32_t *colour;    /* [n_rings] */
    int max_colour;
} work;

/** The finaliser of MurmurHash3 (A. Appleby, public domain): a bijection, so that hashes of
 *  distinct numbers are distinct. */
static uint32_t hash_of(uint32_t number) {
    number ^= number >> 16;
    number *= UINT32_C(0x85ebca6b);
    number ^= number >> 13;
    number *= UINT32_C(0xc2b2ae35);
    return number ^ number >> 16;
}

static uint32_t number_of(const work *w, int32_t node) {
    return (uint32_t)(w->number ? w->number[node] : node);
}

static int32_t degree(const work *w, int64_t r) {
    return (int32_t)(w->priority[r] >> 32);
}

/* ---- the graph ---------------------------------------------------------------------------- */

static void clear_ring_of(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    memset(w->ring_of + begin, -1, (size_t)(end - begin) * sizeof *w->ring_of);
}

static void set_ring_of(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    for (int64_t r = begin; r < end; r++)
        if (w->node[r] >= 0)
            w->ring_of[w->node[r]] = (int32_t)r;
}

/** Rings of what the neighbours of ring r move with, each once; how many. */
static int32_t list_movers(const work *w, int64_t r, int32_t *neighbour) {
    int32_t n = 0;
    for (int64_t i = w->rings->offset[r]; i < w->rings->offset[r + 1]; i++) {
        const int32_t other = w->ring_of[w->moves_with[w->rings->neighbour[i]]];
        int is_new = other >= 0 && other != r;
        for (int32_t k = 0; k < n && is_new; k++)
            is_new = neighbour[k] != other;
        if (is_new)
            neighbour[n++] = other;
    }
    return n;
}

/** Free neighbours and priorities. */
static void make_graph(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    const pl_rings *rings = w->rings;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        int32_t *neighbour = w->neighbour + rings->offset[r];
        int32_t n = 0;
        w->colour[r] = UNCOLOURED;
        if (w->node[r] < 0)
            continue;
        for (int64_t i = rings->offset[r]; i < rings->offset[r + 1]; i++) {
            neighbour[n] = w->ring_of[rings->neighbour[i]];
            n += neighbour[n] >= 0;
        }
        if (w->moves_with)
            n = list_movers(w, r, neighbour);
        w->priority[r] = (uint64_t)n << 32 | hash_of(number_of(w, w->node[r]));
    }
}

/** Put those of higher priority first among the neighbours, and count them. No branch: nothing
 * could predict it. */
static void count_waiting(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        if (w->node[r] < 0)
            continue;
        int32_t *neighbour = w->neighbour + w->rings->offset[r];
        const int32_t n = degree(w, r);
        int32_t higher = 0;
        for (int32_t i = 0; i < n; i++) {
            const int32_t other = neighbour[i];
            neighbour[i] = neighbour[higher];
            neighbour[higher] = other;
            higher += w->priority[other] > w->priority[r];
        }
        w->higher[r] = higher;
        w->waiting[r] = higher + 1;
    }
}

/* ---- colours ------------------------------------------------------------------------------ */

/** The smallest colour that no neighbour of r has. Those coloured by now are those of higher
 *  priority, as the others wait for r. */
static int32_t smallest_colour(const work *w, int64_t r) {
    const int32_t *neighbour = w->neighbour + w->rings->offset[r];
    const int32_t n = w->higher[r];
    for (int32_t first = 0;; first += MASK_COLOURS) {
        uint64_t taken = 0;
        for (int32_t i = 0; i < n; i++) {
            uint32_t colour = (uint32_t)(w->colour[neighbour[i]] - first);
            taken |= (uint64_t)(colour < MASK_COLOURS) << (colour % MASK_COLOURS);
        }
        if (~taken)
            return first + __builtin_ctzll(~taken);
    }
}

/** Colour r and all nodes that wait for nobody then. They go on a stack that is linked through
 *  next: a node is on one stack at most. */
static int colour_from(work *w, int32_t r) {
    int32_t top = r;
    int max_colour = 0;
    w->next[r] = -1;
    while (top >= 0) {
        int32_t current = top;
        top = w->next[current];
        int32_t colour = smallest_colour(w, current);
        max_colour = colour > max_colour ? colour : max_colour;
        const int32_t *neighbour = w->neighbour + w->rings->offset[current];
        int32_t n = degree(w, current);
        w->colour[current] = colour;
        for (int32_t i = w->higher[current]; i < n; i++) {
            int32_t other = neighbour[i];
            if (__atomic_sub_fetch(w->waiting + other, 1, __ATOMIC_ACQ_REL) == 0) {
                w->next[other] = top;
                top = other;
            }
        }
    }
    return max_colour;
}

/** Come past all nodes; those that wait for nobody else are coloured at once, the others by whoever
 *  colours the last that they wait for. */
static void colour_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    int max_colour = UNCOLOURED;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        if (w->node[r] < 0 || __atomic_sub_fetch(w->waiting + r, 1, __ATOMIC_ACQ_REL) != 0)
            continue;
        int colour = colour_from(w, (int32_t)r);
        max_colour = colour > max_colour ? colour : max_colour;
    }
    int seen = __atomic_load_n(&w->max_colour, __ATOMIC_RELAXED);
    while (max_colour > seen && !__atomic_compare_exchange_n(&w->max_colour, &seen, max_colour, 1,
                                                             __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
}

/* ---- the colouring ------------------------------------------------------------------------ */

static void run(work *w, int64_t n_nodes, int threads) {
    int64_t n_rings = w->rings->n_rings;
    pl_parallel_for(threads, n_nodes, CHUNK_NODES, clear_ring_of, w);
    pl_parallel_for(threads, n_rings, CHUNK_RINGS, set_ring_of, w);
    pl_parallel_for(threads, n_rings, CHUNK_RINGS, make_graph, w);
    pl_parallel_for(threads, n_rings, CHUNK_RINGS, count_waiting, w);
    pl_parallel_for(threads, n_rings, CHUNK_RINGS, colour_chunk, w);
}

int pl_colouring_create(const pl_rings *rings, const int32_t *node, const int32_t *number,
                        int64_t n_nodes, const int32_t *moves_with, int threads, int32_t *colour,
                        int *n_colours, planish_error *error) {
    int64_t n = rings->n_rings;
    work w = {.rings = rings,
              .node = node,
              .number = number,
              .moves_with = moves_with,
              .colour = colour,
              .max_colour = -1};
    w.ring_of = pl_alloc(n_nodes, sizeof *w.ring_of);
    w.neighbour = pl_alloc(rings->offset[n], sizeof *w.neighbour);
    w.priority = pl_alloc(n, sizeof *w.priority);
    w.higher = pl_alloc(n, sizeof *w.higher);
    w.waiting = pl_alloc(n, sizeof *w.waiting);
    w.next = pl_alloc(n, sizeof *w.next);
    int done = w.ring_of && w.neighbour && w.priority && w.higher && w.waiting && w.next;
    if (done)
        run(&w, n_nodes, threads);
    pl_free(w.ring_of);
    pl_free(w.neighbour);
    pl_free(w.priority);
    pl_free(w.higher);
    pl_free(w.waiting);
    pl_free(w.next);
    if (!done)
        return pl_fail_memory(error, "the colours of the nodes");
    *n_colours = w.max_colour + 1;
    return PLANISH_OK;
}
