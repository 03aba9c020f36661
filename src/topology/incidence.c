/* incidence: the elements of every node, and any items of some nodes.
 *
 * Elements: a stable counting sort of the pairs (node, element) by node, in two steps that both stay in cache
 * and need neither atomics nor an array per thread: chunks of elements deal their pairs out to
 * buckets of neighbouring node numbers, then each bucket is sorted by itself. Both steps keep the
 * order of the elements, so that every list comes out ascending.
 */
#include "topology/topology.h"

#include "topology/cell_star.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <string.h>

enum {
    MAX_BUCKETS = 1024,  /* as many write streams as caches and page tables follow */
    MIN_BUCKET_BITS = 9, /* a bucket of 512 nodes: 4 kB of offsets */
    MIN_CHUNK = 8192,    /* elements that one thread deals out at a time, at least, */
    MAX_CHUNKS = 1024    /* and such chunks, at most: bounds the table of counts */
};

typedef struct pair {
    int32_t node, element;
} pair;

/** The sort. Bucket b holds the nodes b << bits .. */
typedef struct sort {
    const planish_mesh *mesh;
    const uint8_t *unasked;            /* [n] or NULL */
    const uint8_t *corner;             /* [m] for the incidence of cells, or NULL */
    pl_cell_kind kinds[PL_CELL_KINDS]; /* for it */
    pl_incidence *incidence;
    int bits;
    int64_t n_buckets, chunk;
    int64_t *place; /* [n_chunks][row] where each chunk puts its next pair of each bucket; counts at
                       first */
    int64_t row;
    int64_t *begin; /* [n_buckets + 1] first pair of each bucket */
    pair *pairs;    /* bucket by bucket */
} sort;

/** List the nodes of the cell that begins with an element. Returns how many; 0: none begins there. */
static inline int nodes_of_cell(const sort *s, int64_t element, int32_t node[PL_CELL_CORNERS]) {
    if (pl_corner_index(s->corner[element]) != 0)
        return 0;
    const pl_cell_kind *kind = pl_cell_kind_of(s->kinds, s->corner, element);
    pl_cell_nodes(kind, s->mesh->elements + element * (s->mesh->dim + 1), node);
    return kind->n_nodes;
}

static void count_chunk(void *context, int64_t begin, int64_t end, int thread) {
    sort *s = context;
    int64_t nodes_per_element = s->mesh->dim + 1;
    int64_t count[MAX_BUCKETS] = {0};
    (void)thread;
    for (int64_t i = begin; s->corner && i < end; i++) {
        int32_t node[PL_CELL_CORNERS];
        for (int v = nodes_of_cell(s, i, node); v-- > 0;)
            count[node[v] >> s->bits]++;
    }
    for (int64_t i = begin * nodes_per_element; !s->corner && i < end * nodes_per_element; i++) {
        const int32_t node = s->mesh->elements[i];
        count[node >> s->bits] += !(s->unasked && s->unasked[node]);
    }
    for (int64_t b = 0; b < s->n_buckets; b++)
        s->place[begin / s->chunk * s->row + b] = count[b];
}

static inline void deal(const sort *s, int dim, int64_t begin, int64_t end, int64_t *place) {
    for (int64_t i = begin; i < end; i++)
        for (int j = 0; j <= dim; j++) {
            const int32_t node = s->mesh->elements[i * (dim + 1) + j];
            s->pairs[place[node >> s->bits]++] = (pair){node, (int32_t)i};
        }
}

static void deal_cells(const sort *s, int64_t begin, int64_t end, int64_t *place) {
    int32_t node[PL_CELL_CORNERS];
    for (int64_t i = begin; i < end; i++)
        for (int v = nodes_of_cell(s, i, node); v-- > 0;)
            s->pairs[place[node[v] >> s->bits]++] = (pair){node[v], (int32_t)i};
}

static void deal_chunk(void *context, int64_t begin, int64_t end, int thread) {
    enum { AT_ONCE = 64 }; /* elements */
    const sort *s = context;
    const int dim = s->mesh->dim;
    int64_t *place = s->place + begin / s->chunk * s->row;
    (void)thread;
    if (s->corner)
        deal_cells(s, begin, end, place);
    else if (!s->unasked && dim == 3)
        deal(s, 3, begin, end, place);
    else if (!s->unasked)
        deal(s, 2, begin, end, place);
    /* Only the pairs of nodes that are asked for: collected first, without a branch that would be
     * guessed wrongly half of the time. */
    for (int64_t first = begin; s->unasked && first < end; first += AT_ONCE) {
        pair asked[AT_ONCE * 4];
        int n = 0;
        for (int64_t i = first; i < first + AT_ONCE && i < end; i++)
            for (int j = 0; j <= dim; j++) {
                const int32_t node = s->mesh->elements[i * (dim + 1) + j];
                asked[n] = (pair){node, (int32_t)i};
                n += !s->unasked[node];
            }
        for (int k = 0; k < n; k++)
            s->pairs[place[asked[k].node >> s->bits]++] = asked[k];
    }
}

/** Sort the pairs of one bucket: the offsets become the ends of the lists, and move to their
 *  beginnings while the lists are filled from behind. */
static void sort_bucket(void *context, int64_t bucket, int64_t unused, int thread) {
    sort *s = context;
    int64_t *offset = s->incidence->offset;
    int64_t first_node = bucket << s->bits, end_node = (bucket + 1) << s->bits;
    int64_t begin = s->begin[bucket], end = s->begin[bucket + 1];
    (void)unused;
    (void)thread;
    if (end_node > s->mesh->n_nodes)
        end_node = s->mesh->n_nodes;
    memset(offset + first_node, 0, (size_t)(end_node - first_node) * sizeof *offset);
    for (int64_t i = begin; i < end; i++)
        offset[s->pairs[i].node]++;
    int64_t list_end = begin;
    for (int64_t node = first_node; node < end_node; node++)
        offset[node] = list_end += offset[node];
    for (int64_t i = end; i-- > begin;)
        s->incidence->element[--offset[s->pairs[i].node]] = s->pairs[i].element;
}

static int create(const planish_mesh *mesh, const uint8_t *unasked, const uint8_t *corner,
                  int threads, pl_incidence *incidence, planish_error *error) {
    const int64_t n = mesh->n_nodes, m = mesh->n_elements;
    int64_t n_pairs = -1;
    sort s = {.mesh = mesh,
              .unasked = unasked,
              .corner = corner,
              .incidence = incidence,
              .bits = MIN_BUCKET_BITS};
    if (corner)
        pl_cell_kinds_make(mesh->dim, s.kinds);
    *incidence = (pl_incidence){0};
    while ((n - 1) >> s.bits >= MAX_BUCKETS)
        s.bits++;
    s.n_buckets = ((n - 1) >> s.bits) + 1;
    s.chunk = m / MAX_CHUNKS + 1 > MIN_CHUNK ? m / MAX_CHUNKS + 1 : MIN_CHUNK;
    s.row = pl_counts_row(s.n_buckets);
    const int64_t n_chunks = (m + s.chunk - 1) / s.chunk;
    s.place = pl_alloc(n_chunks * s.row, sizeof *s.place);
    s.begin = pl_alloc(s.n_buckets + 1, sizeof *s.begin);
    incidence->offset = pl_alloc(n + 1, sizeof *incidence->offset);
    if (s.place && s.begin && incidence->offset) {
        pl_parallel_for(threads, m, s.chunk, count_chunk, &s);
        pl_counts_to_places(threads, s.n_buckets, n_chunks, s.place, s.begin);
        n_pairs = s.begin[s.n_buckets];
    }
    s.pairs = pl_alloc(n_pairs, sizeof *s.pairs); /* NULL if that failed */
    incidence->element = pl_alloc(n_pairs, sizeof *incidence->element);
    const int done = s.pairs && incidence->element;
    if (done) {
        pl_parallel_for(threads, m, s.chunk, deal_chunk, &s);
        pl_parallel_for(threads, s.n_buckets, 1, sort_bucket, &s);
        incidence->offset[n] = n_pairs;
    }
    pl_free(s.pairs);
    pl_free(s.place);
    pl_free(s.begin);
    if (done)
        return PLANISH_OK;
    pl_incidence_destroy(incidence);
    return pl_fail_memory(error, "the elements of the nodes");
}

int pl_incidence_create(const planish_mesh *mesh, const uint8_t *unasked, int threads,
                        pl_incidence *incidence, planish_error *error) {
    return create(mesh, unasked, NULL, threads, incidence, error);
}

int pl_cell_incidence_create(const planish_mesh *mesh, const uint8_t *corner, int threads,
                             pl_incidence *incidence, planish_error *error) {
    return create(mesh, NULL, corner, threads, incidence, error);
}

/* ---- items ---------------------------------------------------------------------------------- */

/** Items that are counted, or listed, at their nodes. */
typedef struct listing {
    pl_nodes_of_fn *nodes_of;
    const void *context;
    pl_incidence *incidence;
    int fills;
} listing;

static void list_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const listing *l = context;
    int32_t node[PL_CELL_NODES];
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int n = l->nodes_of(l->context, i, node);
        for (int j = 0; j < n; j++) {
            int is_first = node[j] >= 0;
            for (int k = 0; k < j; k++)
                is_first &= node[k] != node[j];
            if (!is_first)
                continue;
            const int64_t place =
                __atomic_fetch_add(&l->incidence->offset[node[j] + 1], 1, __ATOMIC_RELAXED);
            if (l->fills)
                l->incidence->element[place] = (int32_t)i;
        }
    }
}

/** Sort the items of each node, in whatever order threads have listed them. */
static void sort_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const pl_incidence *of = context;
    (void)thread;
    for (int64_t node = begin; node < end; node++)
        for (int64_t k = of->offset[node] + 1; k < of->offset[node + 1]; k++) {
            const int32_t item = of->element[k];
            int64_t at = k;
            for (; at > of->offset[node] && of->element[at - 1] > item; at--)
                of->element[at] = of->element[at - 1];
            of->element[at] = item;
        }
}

int pl_items_of_nodes(int64_t n_nodes, int64_t n_items, pl_nodes_of_fn *nodes_of,
                      const void *context, int threads, pl_incidence *incidence) {
    enum { CHUNK = 256, CHUNK_NODES = 4096 };
    listing l = {.nodes_of = nodes_of, .context = context, .incidence = incidence};
    int64_t total = 0;
    *incidence = (pl_incidence){.offset = pl_alloc_zero(n_nodes + 1, sizeof *incidence->offset)};
    if (!incidence->offset)
        return 0;
    pl_parallel_for(threads, n_items, CHUNK, list_chunk, &l);
    for (int64_t i = 1; i <= n_nodes; i++) { /* offset[i + 1]: where those of node i begin */
        const int64_t of_node = incidence->offset[i];
        incidence->offset[i] = total;
        total += of_node;
    }
    incidence->element = pl_alloc(total, sizeof *incidence->element);
    if (!incidence->element) {
        pl_incidence_destroy(incidence);
        return 0;
    }
    l.fills = 1;
    pl_parallel_for(threads, n_items, CHUNK, list_chunk, &l);
    if (threads > 1)
        pl_parallel_for(threads, n_nodes, CHUNK_NODES, sort_chunk, incidence);
    return 1;
}

void pl_incidence_destroy(pl_incidence *incidence) {
    pl_free(incidence->offset);
    pl_free(incidence->element);
    *incidence = (pl_incidence){0};
}
