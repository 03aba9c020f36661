/* rings: the neighbours and the link of every free node.
 *
 * They are made in the order of the nodes along the space-filling curve: what is read, the
 * elements, lies all over memory, what is written does not. Whether a node is inside the mesh shows
 * by its link: it is closed then. The link of an interior node is a sphere (a circle in 2-D), so
 * Euler's formula foretells its number of vertices, and one pass fills all rings. Where a node
 * disproves that, all rings are counted and filled again.
 */
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/inline.h"
#include "topology/cell_star.h"
#include "topology/element_walk.h"
#include "topology/local_map.h"
#include "topology/small_ring.h"

#include <string.h>

enum { CHUNK = 256 }; /* rings that one thread takes at a time */

/** The making of all rings. */
typedef struct ring_maker {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    const int8_t *sign;
    const uint8_t *corner; /* [m] or NULL */
    pl_cell_kind kinds[PL_CELL_KINDS];
    int32_t *node;    /* [n_rings] */
    uint8_t *is_free; /* [n_nodes] */
    pl_rings *rings;
    pl_local_map *maps;    /* [threads] the ring of one node */
    pl_small_ring *tables; /* [threads] the same, where it is small */
    int open;              /* links may be */
    int foretells;         /* the lengths of rings: they are those of closed links */
    int wide;              /* positions need high bytes */
    int is_shared;         /* by several threads */
    int counting;          /* lengths are wanted, not nodes */
    int foretold_wrong;    /* a ring has another length than its room */
} ring_maker;

/** Result of the search at one node. */
typedef struct star {
    int64_t length; /* of the ring; -1: not found */
    int is_sound;   /* the link: no facet at the node belongs to more than two elements, and these
                       traverse it in opposite directions */
    int is_closed;  /* and each belongs to two */
} star;

static int64_t degree(const pl_incidence *incidence, int32_t node) {
    return incidence->offset[node + 1] - incidence->offset[node];
}

/** Nodes of a closed link of n triangles that is one sphere, after Euler. */
static int64_t length_of_sphere(int64_t n) {
    return n / 2 + 2;
}

/* Several threads may do this to a node at the same time. */
static inline void set_fixed(const ring_maker *m, int32_t node) {
    pl_set_flag(&m->is_free[node], 0);
}

/* ---- one ring ----------------------------------------------------------------------------- */

/** Number the edges of the n facets of a star's link in order of appearance. map holds its nodes.
 *  Returns how many there are. */
static inline int64_t write_edges(pl_local_map *map, const pl_link *link, int64_t n) {
    const int32_t n_nodes = map->count;
    for (int64_t f = 0; f < n; f++)
        for (int c = 0; c < 3; c++) {
            const int32_t p = pl_link_get(link, 3 * f + c);
            const int32_t q = pl_link_get(link, 3 * f + (c + 1) % 3);
            const int32_t low = p < q ? p : q, high = p < q ? q : p;
            const uint64_t key = (uint64_t)(high + 1) << 32 | (uint64_t)low; /* that of no node */
            pl_link_set(link, 3 * n + 3 * f + c, pl_local_map_add(map, key) - n_nodes);
        }
    return map->count - n_nodes;
}

/** Whether no two facets of a link traverse an edge (in 2-D: leave or reach a node) in the same
 *  direction, and none have the same nodes: their elements would be duplicates. map holds the nodes
 *  and edges. */
static inline int is_link_sound(pl_local_map *map, int dim, const pl_link *link, int64_t n) {
    const uint64_t direction = UINT64_C(1) << 63, nodes = UINT64_C(1) << 62; /* marks of new keys */
    const int32_t known = map->count;
    for (int64_t f = 0; f < n; f++)
        for (int c = 0; c < dim; c++) {
            const uint64_t p = pl_link_get(link, dim * f + c);
            const uint64_t q = dim == 3 ? pl_link_get(link, dim * f + (c + 1) % 3) : (uint64_t)c;
            pl_local_map_add(map, direction | p << 32 | q);
        }
    if (map->count - known != n * dim)
        return 0;
    for (int64_t f = 0; f < n; f++) {
        int32_t v[3] = {0, 0, 0}; /* ascending */
        for (int c = 0; c < dim; c++) {
            int32_t p = pl_link_get(link, dim * f + c);
            for (int i = 0; i < c; i++) {
                const int32_t larger = v[i] > p ? v[i] : p;
                v[i] = v[i] > p ? p : v[i];
                p = larger;
            }
            v[c] = p;
        }
        pl_local_map_add(map, nodes | (uint64_t)v[0] << 32 | (uint64_t)v[1] << 16 | (uint64_t)v[2]);
    }
    return map->count - known == n * (dim + 1);
}

/* Positions of an open link may be cut off when they are stored. It does not pass for closed all
 * the same: of a closed one each position has two corners of facets at least. */
_Static_assert(2 * (UINT8_MAX + 1) > 3 * PL_BYTE_LINK && 2 * (UINT16_MAX + 1) > 3 * PL_MAX_LINK,
               "positions that are cut off could look like those of a closed link");

/** Put the ring of node, or its first room nodes, into ring, and write its link. */
static inline star find_ring(const ring_maker *m, int dim, int thread, int32_t node, pl_link link,
                             int32_t *ring, int64_t room) {
    pl_local_map *thread_map = m->maps + thread;
    const int64_t begin = m->incidence->offset[node], n = degree(m->incidence, node);
    if (pl_local_map_empty(thread_map, 4 * n * dim) != 0)
        return (star){-1, 0, 0};
    pl_local_map map = *thread_map; /* in registers */
    for (int64_t i = 0; i < n; i++) {
        const int32_t index = m->incidence->element[begin + i];
        const int32_t *element = m->mesh->elements + (int64_t)index * (dim + 1);
        int place = 0; /* of node in element; no branch, as nothing could predict it */
        for (int j = 1; j <= dim; j++)
            place += j & -(element[j] == node);
        /* The order of its link facet needs the last two exchanged, or not: in a positive
         * tetrahedron the facets opposite nodes 1 and 3 are positive in the element's order, in a
         * positive triangle those opposite nodes 0 and 2. */
        const int turned = ((place + dim) % 2 != 0) != (m->sign && m->sign[index] < 0);
        for (int j = 0; j < dim; j++) {
            const int32_t other = element[j + (j >= place)];
            const int32_t position = pl_local_map_add(&map, (uint64_t)other);
            if (position < room) /* writes known nodes again: cheaper than to ask */
                ring[position] = other;
            pl_link_set(&link, i * dim + pl_facet_corner(dim, j, turned), position);
        }
    }
    const int64_t length = map.count;
    const int two_each = dim == 3 ? 2 * write_edges(&map, &link, n) == 3 * n : length == n;
    if (!two_each && !m->open)
        return (star){length, 0, 0};
    const int is_sound = is_link_sound(&map, dim, &link, n);
    return (star){length, is_sound, is_sound && two_each};
}

/* ---- one small ring ----------------------------------------------------------------------- */

/** 1 if two nodes are the same, or else 0. No number of a node is negative. Where == gives a number,
 *  compilers may write the low byte of a register alone: then what comes next waits for what that
 *  held before, which can be the end of all that went before. */
static inline uint32_t is_same_node(int32_t a, int32_t b) {
    return ((uint32_t)(a ^ b) - 1) >> 31;
}

/** Number the nodes of node's link by the i-th hash: positions of the corners of its n facets, as
 *  if all elements were positive. No branch: nothing could predict it. */
PL_NOINLINE void find_small_facets(const int32_t *elements, int32_t node, const int32_t *list,
                                   int64_t n, int i, pl_small_ring *table,
                                   uint8_t *restrict corner) {
    pl_small_ring_begin_nodes(table, i);
    const uint32_t factor = table->factor;
    uint32_t n_nodes = 0, collision = 0;
    for (const int32_t *end = list + n; list < end; list++, corner += 3) {
        const int32_t *element = elements + (int64_t)*list * 4;
        const uint32_t is_a = is_same_node(element[0], node), is_b = is_same_node(element[1], node),
                       is_d = is_same_node(element[3], node);
        const int32_t other[3] = {element[is_a], element[1 + is_a + is_b], element[3 - is_d]};
        uint8_t position[3];
#pragma GCC unroll 3
        for (int j = 0; j < 3; j++)
            position[j] = pl_small_ring_node(table, factor, other[j], &n_nodes, &collision);
        /* 1 and 2 are exchanged for the order of the facet, unless node is b or d (find_ring) */
        const uint8_t kept = (position[1] ^ position[2]) & (uint8_t) - (is_b + is_d);
        corner[0] = position[0];
        corner[1] = position[2] ^ kept;
        corner[2] = position[1] ^ kept;
    }
    table->n_nodes = n_nodes;
    table->collision = collision;
}

/** Number the edges of n facets. */
PL_NOINLINE void find_small_edges(pl_small_ring *table, int64_t n, const uint8_t *restrict corner,
                                  uint8_t *restrict edge) {
    uint32_t n_edges = 0, unrepeated = PL_SMALL_NONE;
    pl_small_ring_begin_edges(table);
    for (const uint8_t *end = corner + 3 * n; corner < end; corner += 3, edge += 3) {
        const size_t p = corner[0], q = corner[1], r = corner[2];
        uint8_t *of_p = pl_small_ring_edges_of(table, p), *of_q = pl_small_ring_edges_of(table, q),
                *of_r = pl_small_ring_edges_of(table, r);
        edge[0] = pl_small_ring_edge(of_p + q, of_q + p, &n_edges, &unrepeated);
        edge[1] = pl_small_ring_edge(of_q + r, of_r + q, &n_edges, &unrepeated);
        edge[2] = pl_small_ring_edge(of_r + p, of_p + r, &n_edges, &unrepeated);
    }
    table->n_edges = n_edges;
    table->unrepeated = unrepeated;
}

/** Find a ring as find_ring does, but faster: in 3-D where the ring is small and, if closed, one
 *  sphere. For an open link no ring is written, and the content of link means nothing. */
static star find_small_ring(const ring_maker *m, int thread, int32_t node, pl_link link,
                            int32_t *ring, int64_t room) {
    const int32_t *list = m->incidence->element + m->incidence->offset[node];
    const int64_t n = degree(m->incidence, node);
    pl_small_ring *table = m->tables + thread;
    star found = {-1, 0, 0};
    if (n > PL_SMALL_LINK)
        return found;
    int i = 0;
    do
        find_small_facets(m->mesh->elements, node, list, n, i, table, link.low);
    while (table->collision && ++i < PL_SMALL_HASHES);
    const int64_t length = table->n_nodes;
    if (table->collision || length > PL_SMALL_RING)
        return found;
    for (int64_t f = 0; m->sign && f < n; f++)
        if (m->sign[list[f]] < 0) { /* the other order of the facet's corners */
            const uint8_t last = link.low[3 * f + 2];
            link.low[3 * f + 2] = link.low[3 * f + 1];
            link.low[3 * f + 1] = last;
        }
    find_small_edges(table, n, link.low, link.low + 3 * n);
    const int is_closed = 2 * table->n_edges == 3 * n && table->unrepeated == PL_SMALL_NONE;
    /* Nodes of a facet of one element alone, or that its elements traverse in one direction alone,
     * are not inside: this spares most of them that their links are looked at. */
    for (int64_t f = 0; !is_closed && f < 3 * n; f += 3)
        for (int c = 0; c < 3; c++) {
            const int p = link.low[f + c], q = link.low[f + (c + 1) % 3];
            if (table->edge[q * PL_SMALL_RING + p] != PL_SMALL_NONE)
                continue;
            set_fixed(m, table->node[p]);
            set_fixed(m, table->node[q]);
        }
    /* A sphere of more than two facets has none twice. */
    if (!is_closed || (n > 2 && length == length_of_sphere(n)))
        found = (star){length, is_closed, is_closed};
    if (found.is_closed) {
        if (room > 0)
            memcpy(ring, table->node, (size_t)(length < room ? length : room) * sizeof *ring);
        if (link.high)
            memset(link.high, 0, (size_t)(n * pl_link_positions_kept(3, 0)));
    }
    return found;
}

/* ---- one ring of cells -------------------------------------------------------------------- */

enum { MOST_CELLS = (PL_SMALL_NONE - 2) / (PL_CELL_CORNERS - 1) }; /* of a small ring */

/** Find what the cells of node make of its ring, or its first room nodes, of its link and its forms. map,
 *  or else table by its i-th hash, numbers the nodes. Returns how many nodes there are. */
static inline int64_t find_cells(const ring_maker *m, int dim, int32_t node, pl_local_map *map,
                                 pl_small_ring *table, int i, const pl_link *link, uint8_t *form,
                                 int32_t *ring, int64_t room) {
    const int32_t *list = m->incidence->element + m->incidence->offset[node];
    const int32_t *end = m->incidence->element + m->incidence->offset[node + 1];
    uint32_t n_nodes = 0, collision = 0;
    int64_t n = 0; /* facets */
    if (!map)
        pl_small_ring_begin_nodes(table, i);
    const uint32_t factor = table->factor;
    for (; list < end; list++) {
        const pl_cell_kind *kind = pl_cell_kind_of(m->kinds, m->corner, *list);
        int32_t own[PL_CELL_CORNERS], position[PL_CELL_CORNERS];
        pl_cell_nodes(kind, m->mesh->elements + (int64_t)*list * (dim + 1), own);
        const pl_cell_star *of =
            &kind->star[m->sign && m->sign[*list] < 0][pl_cell_place(kind, own, node)];
        for (int j = 0; j < of->n_others; j++) {
            const int other = of->other[j];
            position[other] =
                map ? pl_local_map_add(map, (uint64_t)own[other])
                    : pl_small_ring_node(table, factor, own[other], &n_nodes, &collision);
            if (map && position[other] < room)
                ring[position[other]] = own[other];
        }
        for (int f = 0; f < of->n_facets; f++, n++) {
            for (int j = 0; j < dim; j++)
                pl_link_set(link, n * dim + j, position[of->facet[f][j]]);
            form[n] = of->form[f];
        }
    }
    if (map)
        return map->count;
    table->n_nodes = n_nodes;
    table->collision = collision;
    return n_nodes;
}

/** Find a ring as find_ring does, of a node of cells. */
static inline star find_cell_ring(const ring_maker *m, int dim, int thread, int32_t node,
                                  pl_link link, uint8_t *form, int32_t *ring, int64_t room) {
    pl_small_ring *table = m->tables + thread;
    const int64_t n = degree(m->incidence, node);
    int64_t length = 0;
    for (int i = 0; i < PL_SMALL_HASHES && n <= MOST_CELLS; i++) {
        length = find_cells(m, dim, node, NULL, table, i, &link, form, NULL, 0);
        if (table->collision)
            continue;
        if (room > 0)
            memcpy(ring, table->node, (size_t)(length < room ? length : room) * sizeof *ring);
        return (star){length, 1, 1};
    }
    pl_local_map *map = m->maps + thread;
    if (pl_local_map_empty(map, n * (PL_CELL_CORNERS - 1)) != 0)
        return (star){-1, 0, 0};
    length = find_cells(m, dim, node, map, table, 0, &link, form, ring, room);
    return (star){length, 1, 1};
}

/* ---- all rings ---------------------------------------------------------------------------- */

/* The positions of an open link are told apart by a byte up to so many facets, and by two up to the
 * other number: three for each, at most. */
enum { BYTE_OPEN_LINK = (UINT8_MAX + 1) / 3, MAX_OPEN_LINK = (UINT16_MAX + 1) / 3 };

/** Whether the link of a node may be closed: so many facets that the kernels take, each of whose
 *  edges belongs to two of the triangles, which are then even in number. A large star is looked at,
 *  and no link is kept: most large stars are on the boundary, and would make all links take two
 *  bytes. */
static int can_be_closed(ring_maker *m, int thread, int32_t node) {
    const int dim = m->mesh->dim;
    const int64_t n = degree(m->incidence, node);
    if (n > PL_MAX_LINK || (dim == 3 && n % 2 != 0))
        return 0;
    if (n <= PL_BYTE_LINK)
        return 1;
    star found = {-1, 0, 0};
    pl_link link = {NULL, NULL};
    if (pl_link_alloc(&link, pl_link_positions_kept(dim, 0), n, 1) == 0)
        found = find_ring(m, dim, thread, node, link, NULL, 0);
    pl_link_free(&link);
    if (found.length < 0)
        m->maps[thread].failed = 1;
    return found.is_closed;
}

/** Foretell the numbers of nodes and facets of a closed link of cells. */
static void foretell_cells(const ring_maker *m, int32_t node, int64_t *length, int64_t *facets) {
    const int dim = m->mesh->dim;
    int64_t twice = dim == 3 ? 4 : 0;
    *facets = 0;
    for (int64_t i = m->incidence->offset[node]; i < m->incidence->offset[node + 1]; i++) {
        const int32_t first = m->incidence->element[i];
        twice += pl_cell_kind_of(m->kinds, m->corner, first)->twice;
        *facets += pl_cell_facets(m->kinds, m->corner, m->mesh->elements, dim, first, node);
    }
    *length = twice / 2;
}

/** Make room for links, and for rings as of spheres, V = F in 2-D, of circles; open links: the rings
 *  are counted. Nodes whose links are too large, or have to be closed but cannot, are free no longer.
 */
static void make_room(void *context, int64_t begin, int64_t end, int thread) {
    ring_maker *m = context;
    int64_t max_link = 0;
    for (int64_t r = begin; r < end; r++) {
        const int32_t node = m->node[r];
        int64_t facets = degree(m->incidence, node), length = facets;
        if (m->corner)
            foretell_cells(m, node, &length, &facets);
        if (m->open ? facets > MAX_OPEN_LINK : !can_be_closed(m, thread, node)) {
            m->is_free[node] = 0;
            facets = length = 0;
        }
        if (!m->corner && m->mesh->dim == 3)
            length = length_of_sphere(facets);
        max_link = facets > max_link ? facets : max_link;
        m->rings->offset[r] = length;
        m->rings->link_offset[r] = facets;
    }
    if (max_link > (m->open ? BYTE_OPEN_LINK : PL_BYTE_LINK))
        __atomic_store_n(&m->wide, 1, __ATOMIC_RELAXED);
}

/** Ask for where the ring and the link of r will be written: another core may have written there
 * what is gone by now. */
PL_AT_ONCE void fetch_room(const pl_rings *rings, int dim, int64_t r) {
    const int64_t k = pl_link_positions_kept(dim, rings->form != NULL);
    pl_fetch_all_to_write(rings->neighbour + rings->offset[r],
                          rings->neighbour + rings->offset[r + 1]);
    pl_fetch_all_to_write(rings->link.low + k * rings->link_offset[r],
                          rings->link.low + k * rings->link_offset[r + 1]);
}

/** Count the nodes of rings begin .. end-1 into their offsets, or fill the room that the offsets
 * say and compare. Nodes whose links are open are free no longer. */
static inline void find_rings(ring_maker *m, int dim, int64_t begin, int64_t end, int thread) {
    pl_rings *rings = m->rings;
    for (int64_t r = begin; r < end; r++) {
        pl_fetch_ahead(m->mesh, dim, m->incidence, m->node, r, rings->n_rings);
        if (m->is_shared && !m->counting && r + PL_AHEAD_ROOM < end)
            fetch_room(rings, dim, r + PL_AHEAD_ROOM);
        const int64_t room = m->counting ? 0 : rings->offset[r + 1] - rings->offset[r];
        int32_t *ring = m->counting ? NULL : rings->neighbour + rings->offset[r];
        const pl_link link = pl_link_at(
            &rings->link, pl_link_positions_kept(dim, rings->form != NULL), rings->link_offset[r]);
        star found = {-1, 0, 0};
        if (!__atomic_load_n(&m->is_free[m->node[r]], __ATOMIC_RELAXED))
            found.length = room;
        else if (dim == 3 && !m->open)
            found = find_small_ring(m, thread, m->node[r], link, ring, room);
        if (found.length < 0 && m->corner)
            found = find_cell_ring(m, dim, thread, m->node[r], link,
                                   rings->form + rings->link_offset[r], ring, room);
        else if (found.length < 0)
            found = find_ring(m, dim, thread, m->node[r], link, ring, room);
        const int keeps = m->open ? found.is_sound : found.is_closed;
        if (!keeps)
            set_fixed(m, m->node[r]);
        if (m->counting)
            rings->offset[r] = keeps ? found.length : 0;
        else if (keeps && found.length != room)
            __atomic_store_n(&m->foretold_wrong, 1, __ATOMIC_RELAXED);
    }
}

static void find_chunk(void *context, int64_t begin, int64_t end, int thread) {
    ring_maker *m = context;
    if (m->mesh->dim == 3)
        find_rings(m, 3, begin, end, thread);
    else
        find_rings(m, 2, begin, end, thread);
}

/** Make room by the lengths in rings->offset, and fill it; counting: these are counted before. -1
 *  without memory. */
static int fill_rings(ring_maker *m, int counting, int threads) {
    pl_rings *rings = m->rings;
    m->counting = 1;
    if (counting)
        pl_parallel_for(threads, rings->n_rings, CHUNK, find_chunk, m);
    if (pl_local_maps_failed(m->maps, threads))
        return -1;
    const int64_t total = pl_prefix_sum(threads, rings->n_rings, rings->offset);
    pl_free(rings->neighbour);
    rings->neighbour = pl_alloc(total, sizeof *rings->neighbour);
    if (!rings->neighbour)
        return -1;
    m->counting = 0;
    m->foretold_wrong = 0;
    pl_parallel_for(threads, rings->n_rings, CHUNK, find_chunk, m);
    return pl_local_maps_failed(m->maps, threads) ? -1 : 0;
}

/** Foretell, fill, and where that does not hold, or links may be open: count, fill. -1 without
 *  memory. */
static int make_rings(ring_maker *m, int threads) {
    pl_rings *rings = m->rings;
    const int64_t n = rings->n_rings;
    pl_parallel_for(threads, n, CHUNK, make_room, m);
    if (pl_local_maps_failed(m->maps, threads))
        return -1;
    const int64_t total = pl_prefix_sum(threads, n, rings->link_offset);
    rings->form = m->corner ? pl_alloc(total, sizeof *rings->form) : NULL;
    if (pl_link_alloc(&rings->link, pl_link_positions_kept(m->mesh->dim, rings->form != NULL),
                      total, m->wide) != 0 ||
        (m->corner && !rings->form) || fill_rings(m, !m->foretells, threads) != 0)
        return -1;
    return m->foretold_wrong ? fill_rings(m, 1, threads) : 0;
}

/** Drop the nodes that are not free; only the room of their rings remains. */
static void drop_open(void *context, int64_t begin, int64_t end, int thread) {
    ring_maker *m = context;
    int64_t n_free = 0;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        if (m->is_free[m->node[r]])
            n_free++;
        else
            m->node[r] = -1;
    }
    __atomic_fetch_add(&m->rings->n_free, n_free, __ATOMIC_RELAXED);
}

int pl_rings_create(const planish_mesh *mesh, const pl_incidence *incidence, const int8_t *sign,
                    const uint8_t *corner, uint8_t *is_free, int32_t *node, int64_t n, int open,
                    int threads, pl_rings *rings, planish_error *error) {
    *rings = (pl_rings){.n_rings = n};
    ring_maker m = {.mesh = mesh,
                    .incidence = incidence,
                    .sign = sign,
                    .corner = corner,
                    .node = node,
                    .is_free = is_free,
                    .rings = rings,
                    .open = open || corner,
                    .foretells = !open,
                    .is_shared = threads > 1,
                    .maps = pl_local_maps_create(threads),
                    .tables = pl_alloc(threads, sizeof *m.tables)};
    if (corner)
        pl_cell_kinds_make(mesh->dim, m.kinds);
    rings->offset = pl_alloc(n + 1, sizeof *rings->offset);
    rings->link_offset = pl_alloc(n + 1, sizeof *rings->link_offset);
    for (int t = 0; m.tables && t < threads; t++)
        pl_small_ring_init(m.tables + t);
    int done =
        m.maps && m.tables && rings->offset && rings->link_offset && make_rings(&m, threads) == 0;
    if (done)
        pl_parallel_for(threads, n, CHUNK, drop_open, &m);
    pl_local_maps_destroy(m.maps, threads);
    pl_free(m.tables);
    if (done)
        return PLANISH_OK;
    pl_rings_destroy(rings);
    return pl_fail_memory(error, "the neighbours of the nodes");
}

void pl_rings_destroy(pl_rings *rings) {
    pl_free(rings->offset);
    pl_free(rings->neighbour);
    pl_free(rings->link_offset);
    pl_link_free(&rings->link);
    pl_free(rings->form);
    *rings = (pl_rings){0};
}
