/* colouring: independent nodes.
 *
 * The serial greedy algorithm gives each node, in order of priority, the smallest colour that no
 * neighbour has. A node's colour depends on its neighbours of higher priority only, so that a node
 * can be coloured as soon as all of them are, on any thread and in any order (Jones and Plassmann,
 * A parallel graph coloring heuristic, SIAM J. Sci. Comput. 14, 1993). Here every node counts those
 * it waits for; the thread that colours the last of them colours the node as well. There are no
 * rounds and no barriers, and what becomes ready lies close to what has just been coloured.
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
    CHUNK_RINGS = 512,   /* rings, likewise */
    AHEAD = 8,           /* rings whose neighbours are asked for before they are needed */
    UNCOLOURED = -1,
    MASK_COLOURS = 64 /* colours in a mask */
};

/** The graph of the free nodes, numbered by their rings (ghosts: from n_rings on), and the state of
 *  its colouring. */
typedef struct work {
    const pl_rings *rings;
    const planish_part *part;  /* or NULL */
    int64_t n_nodes, n_all;    /* n_rings and the ghosts that take part */
    int64_t *of_nodes;         /* [n_nodes] what ghosts are asked; NULL: there are none */
    const int32_t *node;       /* [n_rings] the caller's number, -1: none */
    const int32_t *number;     /* [n_nodes] of each node, or NULL: itself */
    const int32_t *moves_with; /* [n_nodes] or NULL */
    int32_t *ring_of;          /* [n_nodes] ring of each node, -1: not free */
    int32_t *neighbour; /* [offset[n_rings]] rings of the free neighbours, packed to the front of
                           each ring's room */
    uint64_t *priority; /* [n_all] larger: earlier; distinct */
    int32_t *higher;    /* [n_rings] neighbours of higher priority, which come first */
    int32_t *waiting;   /* [n_all] uncoloured neighbours of higher priority, and 1 until the
                           loop over all nodes has come past */
    int32_t *next;      /* [n_rings] below it on a thread's stack, -1: none */
    int32_t *colour;    /* [n_all] */
    int32_t *ghost;     /* [n_all - n_rings] their nodes, */
    uint8_t *is_new;    /* and whether their colours have just come */
    int32_t *held;      /* [n_rings] those that wait for ghosts */
    int max_colour;
    int is_shared; /* by several threads */
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

/** How many nodes r waits for when so many more have been coloured. */
static inline int32_t wait_for_fewer(const work *w, int64_t r, int32_t n) {
    if (w->is_shared)
        return __atomic_sub_fetch(w->waiting + r, n, __ATOMIC_ACQ_REL);
    return w->waiting[r] -= n;
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
            if (wait_for_fewer(w, other, 1) == 0) {
                w->next[other] = top;
                top = other;
            }
        }
    }
    return max_colour;
}

/** Ask for the neighbours of r, of which there are seldom more than two lines. */
PL_AT_ONCE void fetch_neighbours(const work *w, int64_t r) {
    __builtin_prefetch(w->neighbour + w->rings->offset[r]);
    __builtin_prefetch(w->neighbour + w->rings->offset[r + 1]);
}

/** Come past all nodes; those that wait for nobody else are coloured at once, the others by whoever
 *  colours the last that they wait for. */
static void colour_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    int max_colour = UNCOLOURED;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        if (r + AHEAD < end)
            fetch_neighbours(w, r + AHEAD);
        if (w->node[r] < 0 || wait_for_fewer(w, r, 1) != 0)
            continue;
        int colour = colour_from(w, (int32_t)r);
        max_colour = colour > max_colour ? colour : max_colour;
    }
    int seen = __atomic_load_n(&w->max_colour, __ATOMIC_RELAXED);
    while (max_colour > seen && !__atomic_compare_exchange_n(&w->max_colour, &seen, max_colour, 1,
                                                             __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
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
        w->of_nodes[i] = w->ring_of[i] >= 0 ? (int64_t)w->priority[w->ring_of[i]] : 0;
    pl_parts_update(NULL, w->of_nodes, sizeof *w->of_nodes);
    for (int64_t g = n; g < w->n_all; g++) {
        w->priority[g] = (uint64_t)w->of_nodes[w->ghost[g - n]];
        w->colour[g] = UNCOLOURED;
        w->waiting[g] = INT32_MAX; /* for another process */
    }
}

static void fetch_colours(const work *w) {
    const int64_t n = w->rings->n_rings;
    for (int64_t i = 0; i < w->n_nodes; i++)
        w->of_nodes[i] = w->ring_of[i] >= 0 ? w->colour[w->ring_of[i]] : UNCOLOURED;
    pl_parts_update(NULL, w->of_nodes, sizeof *w->of_nodes);
    for (int64_t g = n; g < w->n_all; g++) {
        const int32_t colour = (int32_t)w->of_nodes[w->ghost[g - n]];
        w->is_new[g - n] = w->colour[g] != colour;
        w->colour[g] = colour;
    }
}

/** Of the nodes that r waits for the ghosts; or only those whose colours are new. */
static int32_t count_ghosts(const work *w, int64_t r, int new_only) {
    const int32_t *neighbour = w->neighbour + w->rings->offset[r];
    const int64_t first = w->rings->n_rings;
    int32_t n = 0;
    for (int32_t i = 0; i < w->higher[r]; i++)
        n += neighbour[i] >= first && (!new_only || w->is_new[neighbour[i] - first]);
    return n;
}

/** Colour r, for which so many ghosts have got theirs, and what waits for it, if it can be done. */
static void colour_after(work *w, int32_t r, int32_t n_new) {
    if (n_new == 0 || wait_for_fewer(w, r, n_new) != 0)
        return;
    const int colour = colour_from(w, r);
    w->max_colour = colour > w->max_colour ? colour : w->max_colour;
}

/** Colour what is left, in rounds. */
static void colour_with_ghosts(work *w) {
    int64_t n_held = 0;
    for (int64_t r = 0; r < w->rings->n_rings; r++)
        if (w->node[r] >= 0 && w->colour[r] == UNCOLOURED && count_ghosts(w, r, 0) > 0)
            w->held[n_held++] = (int32_t)r;
    while (pl_parts_any(n_held > 0)) {
        int64_t n_left = 0;
        fetch_colours(w);
        for (int64_t k = 0; k < n_held; k++)
            colour_after(w, w->held[k], count_ghosts(w, w->held[k], 1));
        for (int64_t k = 0; k < n_held; k++)
            if (w->colour[w->held[k]] == UNCOLOURED)
                w->held[n_left++] = w->held[k];
        n_held = n_left;
    }
}

/* ---- the colouring ------------------------------------------------------------------------ */

static void run(work *w, int threads) {
    const int64_t n_rings = w->rings->n_rings;
    pl_parallel_for(threads, w->n_nodes, CHUNK_NODES, clear_ring_of, w);
    pl_parallel_for(threads, n_rings, CHUNK_RINGS, set_ring_of, w);
    if (w->of_nodes)
        find_ghosts(w);
    pl_parallel_for(threads, n_rings, CHUNK_RINGS, make_graph, w);
    if (w->of_nodes)
        find_priorities_of_ghosts(w);
    pl_parallel_for(threads, n_rings, CHUNK_RINGS, count_waiting, w);
    pl_parallel_for(threads, n_rings, CHUNK_RINGS, colour_chunk, w);
    if (w->of_nodes)
        colour_with_ghosts(w);
}

/** Room for what ghosts take; 0 without memory. */
static int allocate_for_ghosts(work *w, int64_t n_ghosts) {
    if (!w->part)
        return 1;
    w->of_nodes = pl_alloc(w->n_nodes, sizeof *w->of_nodes);
    w->ghost = pl_alloc(n_ghosts, sizeof *w->ghost);
    w->is_new = pl_alloc(n_ghosts, sizeof *w->is_new);
    w->held = pl_alloc(w->rings->n_rings, sizeof *w->held);
    return w->of_nodes && w->ghost && w->is_new && w->held;
}

static int allocate(work *w, int64_t n_ghosts) {
    const int64_t n = w->rings->n_rings;
    w->ring_of = pl_alloc(w->n_nodes, sizeof *w->ring_of);
    w->neighbour = pl_alloc(w->rings->offset[n], sizeof *w->neighbour);
    w->priority = pl_alloc(n + n_ghosts, sizeof *w->priority);
    w->higher = pl_alloc(n, sizeof *w->higher);
    w->waiting = pl_alloc(n + n_ghosts, sizeof *w->waiting);
    w->next = pl_alloc(n, sizeof *w->next);
    return w->ring_of && w->neighbour && w->priority && w->higher && w->waiting && w->next &&
           allocate_for_ghosts(w, n_ghosts);
}

static void release(work *w) {
    pl_free(w->ring_of);
    pl_free(w->neighbour);
    pl_free(w->priority);
    pl_free(w->higher);
    pl_free(w->waiting);
    pl_free(w->next);
    pl_free(w->of_nodes);
    pl_free(w->ghost);
    pl_free(w->is_new);
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
              .max_colour = -1,
              .is_shared = threads > 1};
    const int done = allocate(&w, pl_parts_ghosts(n_nodes));
    if (done)
        run(&w, threads);
    release(&w);
    if (!done)
        return pl_fail_memory(error, "the colours of the nodes");
    double most = w.max_colour;
    pl_parts_largest(&most, 1);
    *n_colours = (int)most + 1;
    return pl_parts_check(error);
}
