/* rings: the neighbours and the link of every free node.
 *
 * They are made in the order of the nodes along the space-filling curve: what is read, the
 * elements, lies all over memory, what is written does not. The link of an interior node is a
 * sphere (a circle in 2-D), so Euler's formula foretells its number of vertices, and one pass fills
 * all rings. Where a node disproves that, all rings are counted and filled again.
 */
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/elements.h"
#include "topology/local_map.h"

enum { CHUNK = 256 }; /* rings that one thread takes at a time */
/* The edges of links on so many nodes are numbered by a table: less than a byte can say. */
enum { SMALL_RING = 64, SMALL_TABLE = SMALL_RING * SMALL_RING };

/** The work on all rings. */
typedef struct work {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    const int8_t *sign;
    const int32_t *node; /* [n_rings] */
    pl_rings *rings;
    pl_local_map *maps; /* [threads] the ring of one node */
    uint8_t *tables;    /* [threads][SMALL_RING][SMALL_RING] 0 between nodes */
    int counting;       /* lengths are wanted, not nodes */
    int foretold_wrong; /* a ring has another length than its room */
} work;

static int64_t degree(const pl_incidence *incidence, int32_t node) {
    return incidence->offset[node + 1] - incidence->offset[node];
}

/* ---- one ring ----------------------------------------------------------------------------- */

/** Write the link facet of an element of a star. In a positive tetrahedron the facets opposite
 *  nodes 1 and 3 are positive in the element's order, in a positive triangle those opposite nodes
 *  0 and 2; exchanging the last two nodes turns a facet round. */
static inline void write_facet(int dim, const int32_t *position, int place, int negative,
                               const pl_link *link, int64_t facet) {
    int straight = (place + dim) % 2 == 0;
    int turn = straight == negative;
    if (dim == 3)
        pl_link_set(link, facet * dim, position[0]);
    pl_link_set(link, facet * dim + dim - 2, position[turn ? dim - 1 : dim - 2]);
    pl_link_set(link, facet * dim + dim - 1, position[turn ? dim - 2 : dim - 1]);
}

/** Write that half-edge i of a link of n facets, from p to q, is of that edge. */
static inline void write_edge(const pl_link *link, int64_t n, int64_t i, int32_t p, int32_t q,
                              int32_t edge) {
    pl_link_set(link, 3 * n + i, edge);
    if (edge < pl_link_edges(3, n)) { /* they all are around a free node */
        pl_link_set(link, 6 * n + 2 * edge, p);
        pl_link_set(link, 6 * n + 2 * edge + 1, q);
    }
}

/** The nodes of a facet, and the first again. */
static inline void facet_nodes(const pl_link *link, int64_t facet, int32_t v[4]) {
    for (int c = 0; c < 3; c++)
        v[c] = pl_link_get(link, 3 * facet + c);
    v[3] = v[0];
}

/** Number the edges of the n facets of a star's link in order of appearance. map holds its nodes.
 */
static inline void write_edges(pl_local_map *map, const pl_link *link, int64_t n) {
    const int32_t n_nodes = map->count;
    for (int64_t f = 0; f < n; f++) {
        int32_t v[4];
        facet_nodes(link, f, v);
        for (int c = 0; c < 3; c++) {
            const int32_t p = v[c], q = v[c + 1], low = p < q ? p : q, high = p < q ? q : p;
            const uint64_t key = (uint64_t)(high + 1) << 32 | (uint64_t)low; /* that of no node */
            write_edge(link, n, 3 * f + c, p, q, pl_local_map_add(map, key) - n_nodes);
        }
    }
}

/** Where a table says what is known of the edge from p to q. */
static inline uint8_t *entry_of(uint8_t *table, int32_t p, int32_t q) {
    return table + (p < q ? p * SMALL_RING + q : q * SMALL_RING + p);
}

/** The same with a table, where nodes and edges are few; which edge is new no branch asks. */
static inline void write_few_edges(uint8_t *table, const pl_link *link, int64_t n) {
    int32_t count = 0, v[4];
    for (int64_t f = 0; f < n; f++) {
        facet_nodes(link, f, v);
        for (int c = 0; c < 3; c++) {
            uint8_t *entry = entry_of(table, v[c], v[c + 1]);
            const int32_t is_new = *entry == 0;
            count += is_new;
            const int32_t edge = (count & -is_new) | (*entry & (is_new - 1)); /* from 1 */
            *entry = (uint8_t)edge;
            write_edge(link, n, 3 * f + c, v[c], v[c + 1], edge - 1);
        }
    }
    for (int64_t f = 0; f < n; f++) {
        facet_nodes(link, f, v);
        for (int c = 0; c < 3; c++)
            *entry_of(table, v[c], v[c + 1]) = 0;
    }
}

/** Put ring r, or its first room nodes, into ring, and write its link. Returns its length, or -1
 *  without memory. */
static inline int64_t find_ring(const work *w, int dim, int thread, int64_t r, int32_t *ring,
                                int64_t room) {
    pl_local_map *thread_map = w->maps + thread;
    const int32_t node = w->node[r];
    const int64_t begin = w->incidence->offset[node], n = degree(w->incidence, node);
    const pl_link link = pl_link_at(&w->rings->link, dim, w->rings->link_offset[r]);
    if (pl_local_map_empty(thread_map, n * dim * (dim == 3 ? 2 : 1)) != 0)
        return -1;
    pl_local_map map = *thread_map; /* in registers */
    for (int64_t i = 0; i < n; i++) {
        const int32_t index = w->incidence->element[begin + i];
        const int32_t *element = w->mesh->elements + (int64_t)index * (dim + 1);
        int place = pl_place_in_element(dim, element, node);
        int32_t position[3];
        for (int j = 0; j < dim; j++) {
            int32_t other = pl_other_node(element, place, j);
            position[j] = pl_local_map_add(&map, (uint64_t)other);
            if (position[j] < room) /* writes known nodes again: cheaper than to ask */
                ring[position[j]] = other;
        }
        write_facet(dim, position, place, w->sign && w->sign[index] < 0, &link, i);
    }
    const int64_t length = map.count;
    if (dim == 3 && length <= SMALL_RING && pl_link_edges(3, n) < UINT8_MAX)
        write_few_edges(w->tables + (int64_t)thread * SMALL_TABLE, &link, n);
    else if (dim == 3)
        write_edges(&map, &link, n);
    return length;
}

/* ---- all rings ---------------------------------------------------------------------------- */

/** Lengths after Euler: V = F / 2 + 2 on a sphere of triangles, V = F on a circle of edges. */
static void foretell_lengths(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        int64_t facets = degree(w->incidence, w->node[r]);
        w->rings->offset[r] = w->mesh->dim == 3 ? facets / 2 + 2 : facets;
        w->rings->link_offset[r] = facets;
    }
}

/** Count the nodes of rings begin .. end-1 into their offsets, or fill the room that the offsets
 * say and compare. */
static inline void find_rings(work *w, int dim, int64_t begin, int64_t end, int thread) {
    pl_rings *rings = w->rings;
    for (int64_t r = begin; r < end; r++) {
        pl_fetch_ahead(w->mesh, dim, w->incidence, w->node, r, end);
        if (w->counting) {
            rings->offset[r] = find_ring(w, dim, thread, r, NULL, 0);
            continue;
        }
        int64_t room = rings->offset[r + 1] - rings->offset[r];
        int32_t *ring = rings->neighbour + rings->offset[r];
        if (find_ring(w, dim, thread, r, ring, room) != room)
            __atomic_store_n(&w->foretold_wrong, 1, __ATOMIC_RELAXED);
    }
}

static void find_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    if (w->mesh->dim == 3)
        find_rings(w, 3, begin, end, thread);
    else
        find_rings(w, 2, begin, end, thread);
}

/** Make room by the lengths in rings->offset and fill it. */
static int fill(work *w, int threads) {
    pl_rings *rings = w->rings;
    int64_t total = pl_prefix_sum(threads, rings->n_rings, rings->offset);
    pl_free(rings->neighbour);
    rings->neighbour = pl_alloc(total, sizeof *rings->neighbour);
    if (!rings->neighbour)
        return -1;
    w->counting = 0;
    w->foretold_wrong = 0;
    pl_parallel_for(threads, rings->n_rings, CHUNK, find_chunk, w);
    return pl_local_maps_failed(w->maps, threads) ? -1 : 0;
}

/** Take the nodes of links that are too large out of node and is_free. */
static void hold_large(work *w, int32_t *node, uint8_t *is_free) {
    pl_rings *rings = w->rings;
    int64_t kept = 0;
    for (int64_t r = 0; r < rings->n_rings; r++) {
        const int64_t n = degree(w->incidence, node[r]);
        if (n > PL_MAX_LINK) {
            is_free[node[r]] = 0;
            continue;
        }
        rings->max_link = n > rings->max_link ? n : rings->max_link;
        node[kept++] = node[r];
    }
    rings->n_rings = kept;
}

/** Room for the links, by the lengths in rings->link_offset. */
static int make_room_for_links(const work *w, int threads) {
    pl_rings *rings = w->rings;
    const int64_t total = pl_prefix_sum(threads, rings->n_rings, rings->link_offset);
    return pl_link_alloc(&rings->link, w->mesh->dim, total, rings->max_link);
}

/** Foretell, fill, and where that does not hold: count, fill. */
static int make_rings(work *w, int threads) {
    pl_rings *rings = w->rings;
    pl_parallel_for(threads, rings->n_rings, CHUNK, foretell_lengths, w);
    if (make_room_for_links(w, threads) != 0 || fill(w, threads) != 0)
        return -1;
    if (!w->foretold_wrong)
        return 0;
    w->counting = 1;
    pl_parallel_for(threads, rings->n_rings, CHUNK, find_chunk, w);
    return pl_local_maps_failed(w->maps, threads) ? -1 : fill(w, threads);
}

int pl_rings_create(const planish_mesh *mesh, const pl_incidence *incidence, const int8_t *sign,
                    uint8_t *is_free, int32_t *node, int64_t *n_free, int threads, pl_rings *rings,
                    planish_error *error) {
    *rings = (pl_rings){.n_rings = *n_free};
    work w = {.mesh = mesh,
              .incidence = incidence,
              .sign = sign,
              .node = node,
              .rings = rings,
              .maps = pl_local_maps_create(threads),
              .tables = pl_alloc_zero(threads, SMALL_TABLE)};
    hold_large(&w, node, is_free);
    rings->offset = pl_alloc(rings->n_rings + 1, sizeof *rings->offset);
    rings->link_offset = pl_alloc(rings->n_rings + 1, sizeof *rings->link_offset);
    int done =
        w.maps && w.tables && rings->offset && rings->link_offset && make_rings(&w, threads) == 0;
    pl_local_maps_destroy(w.maps, threads);
    pl_free(w.tables);
    if (!done) {
        pl_rings_destroy(rings);
        return pl_fail_memory(error, "the neighbours of the nodes");
    }
    *n_free = rings->n_rings;
    return PLANISH_OK;
}

void pl_rings_destroy(pl_rings *rings) {
    pl_free(rings->offset);
    pl_free(rings->neighbour);
    pl_free(rings->link_offset);
    pl_link_free(&rings->link);
    *rings = (pl_rings){0};
}
