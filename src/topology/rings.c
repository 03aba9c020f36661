/* rings: the neighbours of every free node.
 *
 * The link of an interior node is a sphere (a circle in 2-D), so Euler's formula foretells its
 * number of vertices, and one pass fills all rings. Where a node disproves that, all rings are
 * counted and filled again.
 */
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/elements.h"
#include "topology/local_map.h"

enum { CHUNK = 256 }; /* rings that one thread takes at a time */

/** The work on all rings. */
typedef struct work {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    const int32_t *node; /* [n_rings] */
    pl_rings *rings;
    pl_local_map *maps; /* [threads] the ring of one node */
    int counting;       /* lengths are wanted, not nodes */
    int foretold_wrong; /* a ring has another length than its room */
} work;

static int64_t degree(const pl_incidence *incidence, int32_t node) {
    return incidence->offset[node + 1] - incidence->offset[node];
}

/* ---- one ring ----------------------------------------------------------------------------- */

/** Put the ring of node, or its first room nodes, into ring. Returns its length, or -1 without
 *  memory. */
static inline int64_t find_ring(const work *w, int dim, pl_local_map *thread_map, int32_t node,
                                int32_t *ring, int64_t room) {
    const pl_incidence *incidence = w->incidence;
    int64_t begin = incidence->offset[node], end = incidence->offset[node + 1];
    if (pl_local_map_empty(thread_map, (end - begin) * dim) != 0)
        return -1;
    pl_local_map map = *thread_map; /* in registers */
    for (int64_t i = begin; i < end; i++) {
        const int32_t *element = w->mesh->elements + (int64_t)incidence->element[i] * (dim + 1);
        int place = pl_place_in_element(dim, element, node);
        for (int j = 0; j < dim; j++) {
            int32_t other = pl_other_node(element, place, j);
            int32_t position = pl_local_map_add(&map, (uint64_t)other);
            if (position < room) /* writes known nodes again: cheaper than to ask */
                ring[position] = other;
        }
    }
    return map.count;
}

/* ---- all rings ---------------------------------------------------------------------------- */

/** Lengths after Euler: V = F / 2 + 2 on a sphere of triangles, V = F on a circle of edges. */
static void foretell_lengths(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        int64_t facets = degree(w->incidence, w->node[r]);
        w->rings->offset[r] = w->mesh->dim == 3 ? facets / 2 + 2 : facets;
    }
}

/** Count the nodes of rings begin .. end-1 into their offsets, or fill the room that the offsets
 * say and compare. */
static inline void find_rings(work *w, int dim, int64_t begin, int64_t end, int thread) {
    pl_rings *rings = w->rings;
    for (int64_t r = begin; r < end; r++) {
        pl_fetch_ahead(w->mesh, dim, w->incidence, w->node, r, end);
        pl_local_map *map = w->maps + thread;
        if (w->counting) {
            rings->offset[r] = find_ring(w, dim, map, w->node[r], NULL, 0);
            continue;
        }
        int64_t room = rings->offset[r + 1] - rings->offset[r];
        int32_t *ring = rings->neighbour + rings->offset[r];
        if (find_ring(w, dim, map, w->node[r], ring, room) != room)
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
static void hold_large(const work *w, int32_t *node, uint8_t *is_free) {
    int64_t kept = 0;
    for (int64_t r = 0; r < w->rings->n_rings; r++)
        if (degree(w->incidence, node[r]) > PL_MAX_LINK)
            is_free[node[r]] = 0;
        else
            node[kept++] = node[r];
    w->rings->n_rings = kept;
}

/** Foretell, fill, and where that does not hold: count, fill. */
static int make_rings(work *w, int threads) {
    pl_rings *rings = w->rings;
    pl_parallel_for(threads, rings->n_rings, CHUNK, foretell_lengths, w);
    if (fill(w, threads) != 0)
        return -1;
    if (!w->foretold_wrong)
        return 0;
    w->counting = 1;
    pl_parallel_for(threads, rings->n_rings, CHUNK, find_chunk, w);
    return pl_local_maps_failed(w->maps, threads) ? -1 : fill(w, threads);
}

int pl_rings_create(const planish_mesh *mesh, const pl_incidence *incidence, uint8_t *is_free,
                    int32_t *node, int64_t *n_free, int threads, pl_rings *rings,
                    planish_error *error) {
    *rings = (pl_rings){.n_rings = *n_free};
    work w = {mesh, incidence, node, rings, pl_local_maps_create(threads), 0, 0};
    hold_large(&w, node, is_free);
    rings->offset = pl_alloc(rings->n_rings + 1, sizeof *rings->offset);
    int done = w.maps && rings->offset && make_rings(&w, threads) == 0;
    pl_local_maps_destroy(w.maps, threads);
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
    *rings = (pl_rings){0};
}
