/* colouring: independent nodes.
 *
 * The serial greedy algorithm gives each node, in order of priority, the smallest colour that no
 * neighbour has. A node's colour depends on its neighbours of higher priority only, so that a node
 * can be coloured as soon as all of them are, on any thread and in any order (Jones and Plassmann,
 * A parallel graph coloring heuristic, SIAM J. Sci. Comput. 14, 1993). Here a thread that wants to
 * colour a node first colours those of its neighbours that are still missing, and what they need.
 * Nobody waits and nothing is counted: where two threads need the same node, both find the same
 * colour for it.
 *
 * With other processes there are rounds: nodes wait for ghosts of higher priority, too, and when
 * nothing can be done without more of them, their colours are fetched.
 */
#include "topology/topology.h"

#include "geometry/fetch.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"

#include <string.h>

enum {
    CHUNK_NODES = 16384, /* mesh nodes that one thread takes at a time */
    CHUNK_RINGS = 512,   /* rings that one thread takes at a time */
    MIN_COLOURED = 512,  /* rings that it colours at a time, at least */
    MAX_COLOURED = 4096, /* and at most */
    AHEAD = 8,           /* rings whose neighbours are asked for before they are needed */
    UNCOLOURED = -1,
    MOST_WANTED = 64, /* rings that a thread remembers of its way to one that can be coloured */
    MASK_COLOURS = 64 /* colours in a mask */
};

/** The graph of the free nodes, numbered by their rings (ghosts: from n_rings on), and the state of
 *  its colouring. */
typedef struct graph {
    const pl_rings *rings;
    const planish_part *part;  /* or NULL */
    int64_t n_nodes, n_all;    /* n_rings and the ghosts that take part */
    int64_t *of_nodes;         /* [n_nodes] what ghosts are asked; NULL: there are none */
    const int32_t *node;       /* [n_rings] of the mesh, -1: none */
    const int32_t *number;     /* [n_nodes] of each node, or NULL: itself */
    const int32_t *moves_with; /* [n_nodes] or NULL */
    int32_t *ring_of;          /* [n_nodes] ring of each node, -1: not free */
    int32_t *neighbour; /* [offset[n_rings]] rings of the free neighbours, packed to the front of
                           each ring's room */
    uint64_t *priority; /* [n_all] larger: earlier; distinct, and below 2^63 as numbers of
                           neighbours are below 2^31 */
    int32_t *colour;    /* [n_all] negative: none */
    int32_t blocked;    /* the colour of those that wait for ghosts: another one in each round */
    int32_t *ghost;     /* [n_all - n_rings] their nodes */
    int32_t *held;      /* [n_rings] those that wait for ghosts, or for others that do */
    int64_t max_colour;
} graph;

/** The finaliser of MurmurHash3 (A. Appleby, public domain): a bijection, so that hashes of
 *  distinct numbers are distinct. */
static uint32_t hash_of(uint32_t number) {
    number ^= number >> 16;
    number *= UINT32_C(0x85ebca6b);
    number ^= number >> 13;
    number *= UINT32_C(0xc2b2ae35);
    return number ^ number >> 16;
}

static int32_t degree(const graph *g, int64_t r) {
    return (int32_t)(g->priority[r] >> 32);
}

/* ---- the graph ---------------------------------------------------------------------------- */

static void clear_ring_of(void *context, int64_t begin, int64_t end, int thread) {
    graph *g = context;
    (void)thread;
    memset(g->ring_of + begin, -1, (size_t)(end - begin) * sizeof *g->ring_of);
}

static void set_ring_of(void *context, int64_t begin, int64_t end, int thread) {
    graph *g = context;
    (void)thread;
    for (int64_t r = begin; r < end; r++)
        if (g->node[r] >= 0)
            g->ring_of[g->node[r]] = (int32_t)r;
}

/** Free neighbours and priorities. */
static void make_graph(void *context, int64_t begin, int64_t end, int thread) {
    graph *g = context;
    const pl_rings *rings = g->rings;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        int32_t *neighbour = g->neighbour + rings->offset[r];
        int32_t n = 0;
        g->colour[r] = UNCOLOURED;
        const int32_t node = g->node[r];
        if (node < 0)
            continue;
        for (int64_t i = rings->offset[r]; i < rings->offset[r + 1] && !g->moves_with; i++) {
            neighbour[n] = g->ring_of[rings->neighbour[i]];
            n += neighbour[n] >= 0;
        }
        for (int64_t i = rings->offset[r]; i < rings->offset[r + 1] && g->moves_with; i++) {
            const int32_t other = g->ring_of[g->moves_with[rings->neighbour[i]]];
            int is_new = other >= 0 && other != r; /* and each once */
            for (int32_t k = 0; k < n && is_new; k++)
                is_new = neighbour[k] != other;
            if (is_new)
                neighbour[n++] = other;
        }
        const int64_t number = g->part     ? g->part->node_number[node]
                               : g->number ? g->number[node]
                                           : node;
        g->priority[r] = (uint64_t)n << 32 | hash_of((uint32_t)number);
    }
}

/* ---- colours ------------------------------------------------------------------------------ */

/* Threads read colours while others write them, which changes nothing (above). */
static int32_t colour_of(const graph *g, int64_t r) {
    return __atomic_load_n(g->colour + r, __ATOMIC_RELAXED);
}

/** A ring to be coloured, on the way to one that can be: the colours, of the first MASK_COLOURS,
 * that those of its neighbours have which have been looked at. */
typedef struct wanted {
    uint64_t taken;
    int32_t ring, n_seen;
    int64_t depth; /* rings before it on the way */
} wanted;

/** Look at the next neighbours, until one of higher priority has no colour yet: that one; -1: all
 *  have theirs. One of lower priority may have a colour, too, if another thread has been here: not
 *  the ring's own, so that it makes no difference. */
static int32_t find_missing(const graph *g, wanted *self) {
    const int32_t *neighbour = g->neighbour + g->rings->offset[self->ring];
    const uint64_t priority = g->priority[self->ring];
    const int32_t n = degree(g, self->ring);
    uint64_t taken = self->taken;
    for (int32_t i = self->n_seen; i < n; i++) {
        const uint32_t colour = (uint32_t)colour_of(g, neighbour[i]); /* none: a large number */
        /* The top bit of the difference tells: nothing could predict a branch. */
        const uint64_t is_higher = (priority - g->priority[neighbour[i]]) >> 63;
        if (is_higher & colour >> 31) {
            self->taken = taken;
            self->n_seen = i;
            return neighbour[i];
        }
        taken |= (uint64_t)(colour < MASK_COLOURS) << colour % MASK_COLOURS;
    }
    self->taken = taken;
    return -1;
}

/** The smallest colour from first on that no neighbour has. */
static int32_t smallest_colour(const graph *g, int64_t r, int32_t first) {
    const int32_t *neighbour = g->neighbour + g->rings->offset[r];
    const int32_t n = degree(g, r);
    for (;; first += MASK_COLOURS) {
        uint64_t taken = 0;
        for (int32_t i = 0; i < n; i++) {
            const uint32_t place = (uint32_t)(colour_of(g, neighbour[i]) - first);
            taken |= (uint64_t)(place < MASK_COLOURS) << place % MASK_COLOURS;
        }
        if (~taken)
            return first + __builtin_ctzll(~taken);
    }
}

/** Forget one of the way, not its first nor its last, so that what is left lies the denser the
 * nearer it is to the end: then a way of any length n is gone at most about n log n times. */
static void forget_one(wanted *way) {
    const int64_t end = way[MOST_WANTED - 1].depth;
    int least = 1;
    for (int k = 2; k < MOST_WANTED - 1; k++) {
        const int64_t gap = way[k + 1].depth - way[k - 1].depth;
        const int64_t least_gap = way[least + 1].depth - way[least - 1].depth;
        if (gap * (end - way[least].depth) < least_gap * (end - way[k].depth))
            least = k;
    }
    memmove(way + least, way + least + 1, (size_t)(MOST_WANTED - 1 - least) * sizeof *way);
}

/** Colour r and what it needs for that, or find that it waits for ghosts. */
static void colour_from(graph *g, int32_t r, int64_t *max_colour) {
    wanted way[MOST_WANTED];
    int n = 1;
    way[0] = (wanted){.ring = r};
    while (n > 0) {
        wanted *last = &way[n - 1];
        const int32_t missing = find_missing(g, last);
        int32_t colour = g->blocked;
        if (missing >= 0 && colour_of(g, missing) != g->blocked) {
            const wanted next = {.ring = missing, .depth = last->depth + 1};
            if (n == MOST_WANTED) {
                forget_one(way);
                n--;
            }
            way[n++] = next;
            continue;
        }
        if (missing < 0)
            colour = ~last->taken ? __builtin_ctzll(~last->taken)
                                  : smallest_colour(g, last->ring, MASK_COLOURS);
        *max_colour = colour > *max_colour ? colour : *max_colour;
        __atomic_store_n(g->colour + last->ring, colour, __ATOMIC_RELAXED);
        n--;
    }
}

static int is_done(const graph *g, int64_t r) {
    const int32_t colour = colour_of(g, r);
    return g->node[r] < 0 || colour >= 0 || colour == g->blocked;
}

/** Ask for the neighbours of r, of which there are seldom more than two lines. */
PL_AT_ONCE void fetch_neighbours(const graph *g, int64_t r) {
    __builtin_prefetch(g->neighbour + g->rings->offset[r]);
    __builtin_prefetch(g->neighbour + g->rings->offset[r + 1]);
}

enum { DEGREES = 64, HASH_BITS = 4, ROUGH_PLACES = DEGREES << HASH_BITS };

/** About the place of ring r when all are in order of priority. */
static int rough_place(const graph *g, int64_t r) {
    if (g->node[r] < 0)
        return 0;
    const int n = degree(g, r) < DEGREES ? degree(g, r) : DEGREES - 1;
    const uint32_t hash = (uint32_t)g->priority[r];
    return (DEGREES - 1 - n) << HASH_BITS | (int)(~hash >> (32 - HASH_BITS));
}

static void colour_chunk(void *context, int64_t begin, int64_t end, int thread) {
    graph *g = context;
    uint16_t order[MAX_COLOURED]; /* of the rings, counted from begin */
    int32_t next[ROUGH_PLACES + 1] = {0};
    int64_t max_colour = UNCOLOURED;
    const int64_t n = end - begin;
    (void)thread;
    /* About in order of priority most rings have all they need when their turn comes. */
    for (int64_t r = begin; r < end; r++)
        next[rough_place(g, r) + 1]++;
    for (int k = 0; k < ROUGH_PLACES; k++)
        next[k + 1] += next[k];
    for (int64_t r = begin; r < end; r++)
        order[next[rough_place(g, r)]++] = (uint16_t)(r - begin);
    for (int64_t i = 0; i < n; i++) {
        if (i + AHEAD < n)
            fetch_neighbours(g, begin + order[i + AHEAD]);
        if (!is_done(g, begin + order[i]))
            colour_from(g, (int32_t)begin + order[i], &max_colour);
    }
    pl_raise_to(&g->max_colour, max_colour);
}

/* ---- ghosts ------------------------------------------------------------------------------- */

/** Keep the blocked ones of the n rings in held; returns how many there are. */
static int64_t hold_blocked(const graph *g, int64_t n) {
    int64_t n_held = 0;
    for (int64_t k = 0; k < n; k++)
        if (g->colour[g->held[k]] == g->blocked)
            g->held[n_held++] = g->held[k];
    return n_held;
}

/** Colour what is left, in rounds. Nodes next to ghosts without a colour still wait. */
static void colour_with_ghosts(graph *g) {
    const int64_t n_rings = g->rings->n_rings;
    int64_t n_held = n_rings;
    for (int64_t r = 0; r < n_rings; r++)
        g->held[r] = (int32_t)r;
    n_held = hold_blocked(g, n_held);
    while (pl_parts_any(n_held > 0)) {
        for (int64_t i = 0; i < g->n_nodes; i++)
            g->of_nodes[i] = g->ring_of[i] >= 0 ? g->colour[g->ring_of[i]] : UNCOLOURED;
        pl_parts_update(NULL, g->of_nodes, sizeof *g->of_nodes);
        g->blocked--;
        for (int64_t r = n_rings; r < g->n_all; r++) {
            const int32_t colour = (int32_t)g->of_nodes[g->ghost[r - n_rings]];
            g->colour[r] = colour < 0 ? g->blocked : colour;
        }
        for (int64_t k = 0; k < n_held; k++)
            if (!is_done(g, g->held[k]))
                colour_from(g, g->held[k], &g->max_colour);
        n_held = hold_blocked(g, n_held);
    }
}

/* ---- the colouring ------------------------------------------------------------------------ */

static void colour_graph(graph *g, int threads) {
    const int64_t n_rings = g->rings->n_rings;
    pl_parallel_for(threads, g->n_nodes, CHUNK_NODES, clear_ring_of, g);
    pl_parallel_for(pl_paying_threads(threads, n_rings), n_rings, CHUNK_RINGS, set_ring_of, g);
    for (int64_t i = 0; g->of_nodes && i < g->n_nodes; i++)
        g->of_nodes[i] = g->ring_of[i] >= 0;
    if (g->of_nodes)
        pl_parts_update(NULL, g->of_nodes, sizeof *g->of_nodes);
    for (int64_t i = 0; g->of_nodes && i < g->n_nodes; i++) { /* rings for ghosts that take part */
        if (g->part->node_role[i] != PLANISH_ROLE_GHOST || !g->of_nodes[i])
            continue;
        g->ring_of[i] = (int32_t)g->n_all;
        g->ghost[g->n_all++ - n_rings] = (int32_t)i;
    }
    pl_parallel_for(threads, n_rings, CHUNK_RINGS, make_graph, g);
    if (g->of_nodes) { /* priorities of ghosts */
        for (int64_t i = 0; i < g->n_nodes; i++)
            g->of_nodes[i] = g->ring_of[i] >= 0 && g->ring_of[i] < n_rings
                                 ? (int64_t)g->priority[g->ring_of[i]]
                                 : 0;
        pl_parts_update(NULL, g->of_nodes, sizeof *g->of_nodes);
        for (int64_t r = n_rings; r < g->n_all; r++) {
            g->priority[r] = (uint64_t)g->of_nodes[g->ghost[r - n_rings]];
            g->colour[r] = g->blocked;
        }
    }
    int64_t chunk = n_rings / threads / 4;
    chunk = chunk < MIN_COLOURED ? MIN_COLOURED : chunk > MAX_COLOURED ? MAX_COLOURED : chunk;
    pl_parallel_for(threads, n_rings, chunk, colour_chunk, g);
    if (g->of_nodes)
        colour_with_ghosts(g);
}

int pl_colouring_create(const pl_rings *rings, const int32_t *node, const int32_t *number,
                        int64_t n_nodes, const int32_t *moves_with, int threads, int32_t *colour,
                        int *n_colours, planish_error *error) {
    const planish_part *part = pl_part_here();
    const int64_t n = rings->n_rings, n_ghosts = pl_parts_ghosts(n_nodes);
    graph g = {.rings = rings,
               .part = part,
               .n_nodes = n_nodes,
               .n_all = n,
               .of_nodes = part ? pl_alloc(n_nodes, sizeof *g.of_nodes) : NULL,
               .node = node,
               .number = number,
               .moves_with = moves_with,
               .ring_of = pl_alloc(n_nodes, sizeof *g.ring_of),
               .neighbour = pl_alloc(rings->offset[n], sizeof *g.neighbour),
               .priority = pl_alloc(n + n_ghosts, sizeof *g.priority),
               .colour = colour,
               .blocked = UNCOLOURED - 1,
               .ghost = part ? pl_alloc(n_ghosts, sizeof *g.ghost) : NULL,
               .held = part ? pl_alloc(n, sizeof *g.held) : NULL,
               .max_colour = -1};
    const int done =
        g.ring_of && g.neighbour && g.priority && (!part || (g.of_nodes && g.ghost && g.held));
    if (done)
        colour_graph(&g, threads);
    pl_free(g.ring_of);
    pl_free(g.neighbour);
    pl_free(g.priority);
    pl_free(g.of_nodes);
    pl_free(g.ghost);
    pl_free(g.held);
    if (!done)
        return pl_fail_memory(error, "the colours of the nodes");
    double most = (double)g.max_colour;
    pl_parts_largest(&most, 1);
    *n_colours = (int)most + 1;
    return pl_parts_check(error);
}
