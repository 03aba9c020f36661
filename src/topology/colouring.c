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

#include "base/fetch.h"
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
typedef struct work {
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
    if (w->part)
        return (uint32_t)w->part->node_number[node];
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
        if (w->moves_with)
            n = list_movers(w, r, neighbour);
        for (int64_t i = rings->offset[r]; i < rings->offset[r + 1] && !w->moves_with; i++) {
            neighbour[n] = w->ring_of[rings->neighbour[i]];
            n += neighbour[n] >= 0;
        }
        w->priority[r] = (uint64_t)n << 32 | hash_of(number_of(w, w->node[r]));
    }
}

/* ---- colours ------------------------------------------------------------------------------ */

/* Threads read colours while others write them, which changes nothing (above). */
static int32_t colour_of(const work *w, int64_t r) {
    return __atomic_load_n(w->colour + r, __ATOMIC_RELAXED);
}

static void set_colour(work *w, int64_t r, int32_t colour) {
    __atomic_store_n(w->colour + r, colour, __ATOMIC_RELAXED);
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
static int32_t find_missing(const work *w, wanted *self) {
    const int32_t *neighbour = w->neighbour + w->rings->offset[self->ring];
    const uint64_t priority = w->priority[self->ring];
    const int32_t n = degree(w, self->ring);
    uint64_t taken = self->taken;
    for (int32_t i = self->n_seen; i < n; i++) {
        const uint32_t colour = (uint32_t)colour_of(w, neighbour[i]); /* none: a large number */
        /* The top bit of the difference tells: nothing could predict a branch. */
        const uint64_t is_higher = (priority - w->priority[neighbour[i]]) >> 63;
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
static int32_t smallest_colour(const work *w, int64_t r, int32_t first) {
    const int32_t *neighbour = w->neighbour + w->rings->offset[r];
    const int32_t n = degree(w, r);
    for (;; first += MASK_COLOURS) {
        uint64_t taken = 0;
        for (int32_t i = 0; i < n; i++) {
            const uint32_t place = (uint32_t)(colour_of(w, neighbour[i]) - first);
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
static void colour_from(work *w, int32_t r, int64_t *max_colour) {
    wanted way[MOST_WANTED];
    int n = 1;
    way[0] = (wanted){.ring = r};
    while (n > 0) {
        wanted *last = &way[n - 1];
        const int32_t missing = find_missing(w, last);
        int32_t colour = w->blocked;
        if (missing >= 0 && colour_of(w, missing) != w->blocked) {
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
                                  : smallest_colour(w, last->ring, MASK_COLOURS);
        *max_colour = colour > *max_colour ? colour : *max_colour;
        set_colour(w, last->ring, colour);
        n--;
    }
}

static int is_done(const work *w, int64_t r) {
    const int32_t colour = colour_of(w, r);
    return w->node[r] < 0 || colour >= 0 || colour == w->blocked;
}

/** Ask for the neighbours of r, of which there are seldom more than two lines. */
PL_AT_ONCE void fetch_neighbours(const work *w, int64_t r) {
    __builtin_prefetch(w->neighbour + w->rings->offset[r]);
    __builtin_prefetch(w->neighbour + w->rings->offset[r + 1]);
}

enum { DEGREES = 64, HASH_BITS = 4, ROUGH_PLACES = DEGREES << HASH_BITS };

/** About the place of ring r when all are in order of priority. */
static int rough_place(const work *w, int64_t r) {
    if (w->node[r] < 0)
        return 0;
    const int n = degree(w, r) < DEGREES ? degree(w, r) : DEGREES - 1;
    const uint32_t hash = (uint32_t)w->priority[r];
    return (DEGREES - 1 - n) << HASH_BITS | (int)(~hash >> (32 - HASH_BITS));
}

/** order [end - begin] becomes the rings begin .. end-1, counted from begin, about in order of
 *  priority: so most of them have all they need when their turn comes. */
static void sort_roughly(const work *w, int64_t begin, int64_t end, uint16_t *order) {
    int32_t next[ROUGH_PLACES + 1] = {0};
    for (int64_t r = begin; r < end; r++)
        next[rough_place(w, r) + 1]++;
    for (int k = 0; k < ROUGH_PLACES; k++)
        next[k + 1] += next[k];
    for (int64_t r = begin; r < end; r++)
        order[next[rough_place(w, r)]++] = (uint16_t)(r - begin);
}

static void colour_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    uint16_t order[MAX_COLOURED];
    int64_t max_colour = UNCOLOURED;
    const int64_t n = end - begin;
    (void)thread;
    sort_roughly(w, begin, end, order);
    for (int64_t i = 0; i < n; i++) {
        if (i + AHEAD < n)
            fetch_neighbours(w, begin + order[i + AHEAD]);
        if (!is_done(w, begin + order[i]))
            colour_from(w, (int32_t)begin + order[i], &max_colour);
    }
    pl_raise_to(&w->max_colour, max_colour);
}

/* ---- ghosts ------------------------------------------------------------------------------- */

/** Ask of what ghosts there are which take part. */
static void find_ghosts(work *w) {
    for (int64_t i = 0; i < w->n_nodes; i++)
        w->of_nodes[i] = w->ring_of[i] >= 0;
    pl_parts_update(NULL, w->of_nodes, sizeof *w->of_nodes);
    for (int64_t i = 0; i < w->n_nodes; i++) {
        if (w->part->node_role[i] != PLANISH_GHOST || !w->of_nodes[i])
            continue;
        w->ring_of[i] = (int32_t)w->n_all;
        w->ghost[w->n_all++ - w->rings->n_rings] = (int32_t)i;
    }
}

static void find_priorities_of_ghosts(work *w) {
    const int64_t n = w->rings->n_rings;
    for (int64_t i = 0; i < w->n_nodes; i++)
        w->of_nodes[i] =
            w->ring_of[i] >= 0 && w->ring_of[i] < n ? (int64_t)w->priority[w->ring_of[i]] : 0;
    pl_parts_update(NULL, w->of_nodes, sizeof *w->of_nodes);
    for (int64_t g = n; g < w->n_all; g++) {
        w->priority[g] = (uint64_t)w->of_nodes[w->ghost[g - n]];
        w->colour[g] = w->blocked;
    }
}

/** Fetch the colours of ghosts. Nodes next to ghosts without a colour still wait. */
static void fetch_colours(work *w) {
    for (int64_t i = 0; i < w->n_nodes; i++)
        w->of_nodes[i] = w->ring_of[i] >= 0 ? w->colour[w->ring_of[i]] : UNCOLOURED;
    pl_parts_update(NULL, w->of_nodes, sizeof *w->of_nodes);
    w->blocked--;
    for (int64_t g = w->rings->n_rings; g < w->n_all; g++) {
        const int32_t colour = (int32_t)w->of_nodes[w->ghost[g - w->rings->n_rings]];
        w->colour[g] = colour < 0 ? w->blocked : colour;
    }
}

/** Keep the blocked ones of the n rings in held; returns how many there are. */
static int64_t hold_blocked(const work *w, int64_t n) {
    int64_t n_held = 0;
    for (int64_t k = 0; k < n; k++)
        if (w->colour[w->held[k]] == w->blocked)
            w->held[n_held++] = w->held[k];
    return n_held;
}

/** Colour what is left, in rounds. */
static void colour_with_ghosts(work *w) {
    int64_t n_held = w->rings->n_rings;
    for (int64_t r = 0; r < n_held; r++)
        w->held[r] = (int32_t)r;
    n_held = hold_blocked(w, n_held);
    while (pl_parts_any(n_held > 0)) {
        fetch_colours(w);
        for (int64_t k = 0; k < n_held; k++)
            if (!is_done(w, w->held[k]))
                colour_from(w, w->held[k], &w->max_colour);
        n_held = hold_blocked(w, n_held);
    }
}

/* ---- the colouring ------------------------------------------------------------------------ */

static void run(work *w, int threads) {
    const int64_t n_rings = w->rings->n_rings;
    pl_parallel_for(threads, w->n_nodes, CHUNK_NODES, clear_ring_of, w);
    pl_parallel_for(pl_paying_threads(threads, n_rings), n_rings, CHUNK_RINGS, set_ring_of, w);
    if (w->of_nodes)
        find_ghosts(w);
    pl_parallel_for(threads, n_rings, CHUNK_RINGS, make_graph, w);
    if (w->of_nodes)
        find_priorities_of_ghosts(w);
    int64_t chunk = n_rings / threads / 4;
    chunk = chunk < MIN_COLOURED ? MIN_COLOURED : chunk > MAX_COLOURED ? MAX_COLOURED : chunk;
    pl_parallel_for(threads, n_rings, chunk, colour_chunk, w);
    if (w->of_nodes)
        colour_with_ghosts(w);
}

/** Room for what ghosts take; 0 without memory. */
static int allocate_for_ghosts(work *w, int64_t n_ghosts) {
    if (!w->part)
        return 1;
    w->of_nodes = pl_alloc(w->n_nodes, sizeof *w->of_nodes);
    w->ghost = pl_alloc(n_ghosts, sizeof *w->ghost);
    w->held = pl_alloc(w->rings->n_rings, sizeof *w->held);
    return w->of_nodes && w->ghost && w->held;
}

static int allocate(work *w, int64_t n_ghosts) {
    const int64_t n = w->rings->n_rings;
    w->ring_of = pl_alloc(w->n_nodes, sizeof *w->ring_of);
    w->neighbour = pl_alloc(w->rings->offset[n], sizeof *w->neighbour);
    w->priority = pl_alloc(n + n_ghosts, sizeof *w->priority);
    return w->ring_of && w->neighbour && w->priority && allocate_for_ghosts(w, n_ghosts);
}

static void release(work *w) {
    pl_free(w->ring_of);
    pl_free(w->neighbour);
    pl_free(w->priority);
    pl_free(w->of_nodes);
    pl_free(w->ghost);
    pl_free(w->held);
}

int pl_colouring_create(const pl_rings *rings, const int32_t *node, const int32_t *number,
                        int64_t n_nodes, const int32_t *moves_with, int threads, int32_t *colour,
                        int *n_colours, planish_error *error) {
    work w = {.rings = rings,
              .part = pl_part_here(),
              .n_nodes = n_nodes,
              .n_all = rings->n_rings,
              .node = node,
              .number = number,
              .moves_with = moves_with,
              .colour = colour,
              .blocked = UNCOLOURED - 1,
              .max_colour = -1};
    const int done = allocate(&w, pl_parts_ghosts(n_nodes));
    if (done)
        run(&w, threads);
    release(&w);
    if (!done)
        return pl_fail_memory(error, "the colours of the nodes");
    double most = (double)w.max_colour;
    pl_parts_largest(&most, 1);
    *n_colours = (int)most + 1;
    return pl_parts_check(error);
}
