/* ordering: the nodes along a Hilbert curve.
 *
 * Keys from coordinates by the state machine of the curve (after C. Hamilton, Compact Hilbert
 * Indices, 2006), two levels at a time. Then a stable radix sort by the leading digits, which tell
 * nearly all nodes apart; the few that they do not are sorted by insertion, or where there are many
 * together, everything by all digits.
 */
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/frame.h"

enum {
    LEVELS_3D = 21,  /* 63 bits of key */
    LEVELS_2D = 31,  /* 62 bits */
    MAX_STATES = 24, /* entry corners times directions */
    DIGIT_BITS = 11, /* a table of counts fits the first-level cache */
    DIGITS = 1 << DIGIT_BITS,
    CHUNK_KEYS = 1024, /* nodes whose keys one thread makes at a time */
    MIN_CHUNK = 4096,  /* nodes that it sorts at a time, at least, */
    MAX_CHUNKS = 256,  /* and such chunks, at most: bounds the table of counts */
    SPARE_BITS = 3,    /* of leading digits, beyond those that number the nodes */
    MAX_RUN = 32       /* nodes with the same leading digits that are sorted by insertion */
};

/* ---- the curve ---------------------------------------------------------------------------- */

/** The curve as a state machine: cell is the octant (quadrant) of a point, bit d for axis d. A
 *  state is an entry corner e and a direction d, numbered e * dim + d. */
typedef struct curve {
    uint8_t digit[MAX_STATES][8]; /* of the key */
    uint8_t next[MAX_STATES][8];  /* state inside the cell */
    struct {
        uint8_t digits, next;
    } twice[MAX_STATES][64]; /* the same for two levels: cell << dim | cell inside that */
} curve;

static unsigned rotate_right(unsigned bits, unsigned by, unsigned dim) {
    by %= dim;
    return (bits >> by | bits << (dim - by)) & ((1u << dim) - 1);
}

static void make_curve(unsigned dim, curve *c) {
    const unsigned cells = 1u << dim;
    for (unsigned entry = 0; entry < cells; entry++)
        for (unsigned direction = 0; direction < dim; direction++)
            for (unsigned cell = 0; cell < cells; cell++) {
                const unsigned state = entry * dim + direction, turn = direction + 1;
                /* The cell is the i-th on the way: by the inverse of Gray's code. */
                const unsigned code = rotate_right(cell ^ entry, turn, dim);
                const unsigned i = code ^ code >> 1 ^ code >> 2;
                /* The curve enters it at a corner (Gray's code of the even number before i), and
                 * runs inside along an axis that the number of trailing ones decides. */
                const unsigned even = i == 0 ? 0 : (i - 1) / 2 * 2;
                const unsigned ones = i % 2 == 0 && i > 0 ? i - 1 : i;
                const unsigned corner = rotate_right(even ^ even >> 1, 2 * dim - turn, dim);
                const unsigned axis = i == 0 ? 0 : (unsigned)__builtin_ctz(~ones) % dim;
                const unsigned along = (direction + axis + 1) % dim;
                c->digit[state][cell] = (uint8_t)i;
                c->next[state][cell] = (uint8_t)((entry ^ corner) * dim + along);
            }
    for (unsigned state = 0; state < cells * dim; state++)
        for (unsigned two = 0; two < cells * cells; two++) {
            const unsigned outer = two >> dim, inner = two & (cells - 1);
            const unsigned inside = c->next[state][outer];
            c->twice[state][two].digits =
                (uint8_t)(c->digit[state][outer] << dim | c->digit[inside][inner]);
            c->twice[state][two].next = c->next[inside][inner];
        }
}

/** Bits of place, dim apart from one another. */
static inline uint64_t spread(unsigned dim, uint32_t place) {
    uint64_t bits = place;
    if (dim == 3) {
        bits = (bits | bits << 32) & UINT64_C(0x001F00000000FFFF);
        bits = (bits | bits << 16) & UINT64_C(0x001F0000FF0000FF);
        bits = (bits | bits << 8) & UINT64_C(0x100F00F00F00F00F);
        bits = (bits | bits << 4) & UINT64_C(0x10C30C30C30C30C3);
        return (bits | bits << 2) & UINT64_C(0x1249249249249249);
    }
    bits = (bits | bits << 16) & UINT64_C(0x0000FFFF0000FFFF);
    bits = (bits | bits << 8) & UINT64_C(0x00FF00FF00FF00FF);
    bits = (bits | bits << 4) & UINT64_C(0x0F0F0F0F0F0F0F0F);
    bits = (bits | bits << 2) & UINT64_C(0x3333333333333333);
    return (bits | bits << 1) & UINT64_C(0x5555555555555555);
}

_Static_assert(DIGITS % 8 == 0, "a row of counts is as long as pl_counts_row says");
_Static_assert(LEVELS_3D % 2 && LEVELS_2D % 2, "one level is left for the first step");

/* ---- keys --------------------------------------------------------------------------------- */

/** A node and its place on the curve. */
typedef struct item {
    uint64_t key;
    int32_t node;
} item;

/** The sort of the nodes. */
typedef struct sort {
    const planish_mesh *mesh;
    pl_frame frame;
    curve curve;
    uint64_t first_key, differing; /* bits in which a key differs from the first one */
    int first_bit;                 /* of the leading digits */
    int has_long_run;              /* they leave too many nodes together */
    item *from, *to;               /* [n] a pass sorts from -> to */
    int shift;                     /* of the pass's digit */
    int64_t chunk, n_chunks;
    int64_t *place; /* [n_chunks][DIGITS] where each digit of each chunk goes; counts at first */
    int32_t *order; /* [n] result */
} sort;

/** Key of a node: of its cell, of 2^levels along each axis. */
static inline uint64_t key_of(const sort *s, int dim, int levels, int64_t node) {
    const double *x = s->mesh->coordinates + node * dim;
    const curve *c = &s->curve;
    const double end = (double)((int64_t)1 << levels);
    uint64_t cells = 0;
    for (int d = 0; d < dim; d++) { /* differences are below 1 */
        const double place = pl_frame_difference(&s->frame, x[d], s->frame.low[d]) * end;
        cells |= spread((unsigned)dim, (uint32_t)(place < end - 1 ? place : end - 1)) << d;
    }
    int shift = (levels - 1) * dim;
    uint64_t key = c->digit[0][cells >> shift];
    unsigned state = c->next[0][cells >> shift];
    while (shift > 0) {
        shift -= 2 * dim;
        const unsigned two = (unsigned)(cells >> shift) & ((1u << 2 * dim) - 1);
        key = key << 2 * dim | c->twice[state][two].digits;
        state = c->twice[state][two].next;
    }
    return key;
}

static void make_keys(void *context, int64_t begin, int64_t end, int thread) {
    sort *s = context;
    uint64_t differing = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        uint64_t key = s->mesh->dim == 3 ? key_of(s, 3, LEVELS_3D, i) : key_of(s, 2, LEVELS_2D, i);
        differing |= key ^ s->first_key;
        s->from[i] = (item){key, (int32_t)i};
    }
    __atomic_fetch_or(&s->differing, differing, __ATOMIC_RELAXED);
}

/* ---- sorting ------------------------------------------------------------------------------ */

static inline unsigned digit_of(const sort *s, const item *it) {
    return (unsigned)(it->key >> s->shift) & (DIGITS - 1);
}

static void count_digits(void *context, int64_t begin, int64_t end, int thread) {
    sort *s = context;
    int32_t count[DIGITS] = {0};
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        count[digit_of(s, s->from + i)]++;
    for (int64_t d = 0; d < DIGITS; d++)
        s->place[begin / s->chunk * DIGITS + d] = count[d];
}

static void move_items(void *context, int64_t begin, int64_t end, int thread) {
    sort *s = context;
    int64_t *restrict place = s->place + begin / s->chunk * DIGITS; /* no key is there */
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        s->to[place[digit_of(s, s->from + i)]++] = s->from[i];
}

/** Sort by the digits of the keys from bit first_bit on. */
static void sort_digits(sort *s, int first_bit, int threads) {
    const int64_t n = s->mesh->n_nodes;
    int64_t begin[DIGITS + 1];
    for (s->shift = first_bit; s->shift < 64; s->shift += DIGIT_BITS) {
        if ((s->differing >> s->shift & (DIGITS - 1)) == 0)
            continue;
        pl_parallel_for(threads, n, s->chunk, count_digits, s);
        pl_counts_to_places(threads, DIGITS, s->n_chunks, s->place, begin);
        pl_parallel_for(pl_paying_threads(threads, n), n, s->chunk, move_items, s);
        item *sorted = s->to;
        s->to = s->from;
        s->from = sorted;
    }
}

/** Write the runs of items with the same leading digits that begin here, each sorted by insertion.
 */
static void write_order(void *context, int64_t begin, int64_t end, int thread) {
    sort *s = context;
    const item *from = s->from;
    const int64_t n = s->mesh->n_nodes;
    const int shift = s->first_bit;
    int64_t i = begin;
    (void)thread;
    while (i > 0 && i < end && from[i].key >> shift == from[i - 1].key >> shift)
        i++;
    for (int64_t next; i < end; i = next) {
        int32_t *order = s->order + i;
        uint64_t key[MAX_RUN];
        for (next = i + 1; next < n && from[next].key >> shift == from[i].key >> shift;)
            next++;
        if (next - i == 1) {
            order[0] = from[i].node;
            continue;
        }
        if (next - i > MAX_RUN) {
            __atomic_store_n(&s->has_long_run, 1, __ATOMIC_RELAXED);
            continue;
        }
        for (int64_t k = 0; k < next - i; k++) {
            int64_t place = k;
            for (; place > 0 && key[place - 1] > from[i + k].key; place--) {
                key[place] = key[place - 1];
                order[place] = order[place - 1];
            }
            key[place] = from[i + k].key;
            order[place] = from[i + k].node;
        }
    }
}

static void write_sorted(void *context, int64_t begin, int64_t end, int thread) {
    sort *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        s->order[i] = s->from[i].node;
}

static void sort_nodes(sort *s, int threads) {
    const int64_t n = s->mesh->n_nodes;
    make_curve((unsigned)s->mesh->dim, &s->curve);
    s->first_key = s->mesh->dim == 3 ? key_of(s, 3, LEVELS_3D, 0) : key_of(s, 2, LEVELS_2D, 0);
    pl_parallel_for(threads, n, CHUNK_KEYS, make_keys, s);
    /* So many leading digits of those bits that differ as number all nodes, and some more bits. */
    const int top = s->differing ? 64 - __builtin_clzll(s->differing) : 0;
    int wanted = SPARE_BITS, bits = DIGIT_BITS;
    while (n >> (wanted - SPARE_BITS) > 0)
        wanted++;
    while (bits < wanted)
        bits += DIGIT_BITS;
    s->first_bit = top > bits ? top - bits : 0;
    sort_digits(s, s->first_bit, threads);
    pl_parallel_for(threads, n, s->chunk, write_order, s);
    if (!s->has_long_run)
        return;
    sort_digits(s, 0, threads); /* nodes with the same key keep their order */
    pl_parallel_for(threads, n, s->chunk, write_sorted, s);
}

int pl_curve_order(const planish_mesh *mesh, int threads, int32_t *order, planish_error *error) {
    const int64_t n = mesh->n_nodes;
    sort s = {.mesh = mesh, .order = order};
    const int status = pl_frame_create(mesh, NULL, threads, &s.frame, error);
    if (status || n == 0)
        return status;
    s.chunk = n / MAX_CHUNKS + 1 > MIN_CHUNK ? n / MAX_CHUNKS + 1 : MIN_CHUNK;
    s.n_chunks = (n - 1) / s.chunk + 1;
    s.place = pl_alloc(DIGITS * s.n_chunks, sizeof *s.place);
    s.from = pl_alloc(n, sizeof *s.from);
    s.to = pl_alloc(n, sizeof *s.to);
    const int done = s.place && s.from && s.to;
    if (done)
        sort_nodes(&s, threads);
    pl_free(s.from);
    pl_free(s.to);
    pl_free(s.place);
    return done ? PLANISH_OK : pl_fail_memory(error, "the order of the nodes");
}
