/* stars: the star of every free node, with its link facets oriented.
 *
 * Stars are stored in the order of their visits but made in the order of the rings, which runs
 * along the space-filling curve: what is read, the elements, lies all over memory, what is written
 * does not.
 */
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/elements.h"
#include "topology/local_map.h"

enum {
    CHUNK = 256 /* stars that one thread takes at a time */
};

/** The work on all stars. */
typedef struct work {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    const int8_t *sign;
    const pl_rings *rings;
    const int32_t *node, *visit, *number_of;
    int32_t *star_of; /* [n_rings] star of each ring: the inverse of visit */
    pl_stars *stars;
    pl_local_map *maps; /* [threads] positions in the ring of one star */
} work;

/** Raise *largest to value, whichever thread comes first. */
static void raise_to(int64_t *largest, int64_t value) {
    int64_t seen = __atomic_load_n(largest, __ATOMIC_RELAXED);
    while (value > seen && !__atomic_compare_exchange_n(largest, &seen, value, 1, __ATOMIC_RELAXED,
                                                        __ATOMIC_RELAXED)) {
    }
}

/** Lengths into the offsets, and the inverse of visit. */
static void measure_stars(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    pl_stars *stars = w->stars;
    int64_t max_ring = 0, max_link = 0;
    (void)thread;
    for (int64_t s = begin; s < end; s++) {
        int32_t r = w->visit[s];
        int64_t node = w->node[r];
        int64_t ring = w->rings->offset[r + 1] - w->rings->offset[r];
        int64_t link = w->incidence->offset[node + 1] - w->incidence->offset[node];
        w->star_of[r] = (int32_t)s;
        stars->ring_offset[s] = ring;
        stars->link_offset[s] = link;
        max_ring = ring > max_ring ? ring : max_ring;
        max_link = link > max_link ? link : max_link;
    }
    raise_to(&stars->max_ring, max_ring);
    raise_to(&stars->max_link, max_link);
}

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

/** Number the edges of the n facets of a star's link. map holds its nodes. */
static inline void write_edges(pl_local_map *map, const pl_link *link, int64_t n) {
    const int32_t n_nodes = map->count;
    for (int64_t i = 0; i < 3 * n; i++) {
        const int32_t p = pl_link_get(link, i), q = pl_link_get(link, i % 3 < 2 ? i + 1 : i - 2);
        const int32_t low = p < q ? p : q, high = p < q ? q : p;
        const uint64_t key = (uint64_t)(high + 1) << 32 | (uint64_t)low; /* that of no node */
        const int32_t edge = pl_local_map_add(map, key) - n_nodes;
        pl_link_set(link, 3 * n + i, edge);
        if (edge < pl_link_edges(3, n)) { /* they all are around a free node */
            pl_link_set(link, 6 * n + 2 * edge, p);
            pl_link_set(link, 6 * n + 2 * edge + 1, q);
        }
    }
}

static inline int make_star(const work *w, int dim, int64_t r, pl_local_map *thread_map) {
    const pl_stars *stars = w->stars;
    int32_t node = w->node[r], star = w->star_of[r];
    int64_t begin = w->incidence->offset[node], n = w->incidence->offset[node + 1] - begin;
    const pl_link link = pl_link_at(&stars->link, dim, stars->link_offset[star]);
    if (pl_local_map_empty(thread_map, n * dim * (dim == 3 ? 2 : 1)) != 0)
        return -1;
    pl_local_map map = *thread_map; /* in registers */
    for (int64_t i = 0; i < n; i++) {
        int32_t index = w->incidence->element[begin + i];
        const int32_t *element = w->mesh->elements + (int64_t)index * (dim + 1);
        int place = pl_place_in_element(dim, element, node);
        int32_t position[3]; /* as in the ring, which was numbered in the same way */
        for (int j = 0; j < dim; j++)
            position[j] = pl_local_map_add(&map, (uint64_t)pl_other_node(element, place, j));
        write_facet(dim, position, place, w->sign && w->sign[index] < 0, &link, i);
        if (stars->min_volume)
            stars->min_volume[stars->link_offset[star] + i] = w->mesh->min_volume[index];
    }
    if (dim == 3)
        write_edges(&map, &link, n);
    return 0;
}

static void copy_ring(const work *w, int64_t r) {
    const int32_t *neighbour = w->rings->neighbour + w->rings->offset[r];
    int64_t n_ring = w->rings->offset[r + 1] - w->rings->offset[r];
    int32_t *ring = w->stars->ring + w->stars->ring_offset[w->star_of[r]];
    for (int64_t i = 0; i < n_ring; i++)
        ring[i] = w->number_of[neighbour[i]];
}

static inline void make_stars(const work *w, int dim, int64_t begin, int64_t end, int thread) {
    for (int64_t r = begin; r < end; r++) {
        pl_fetch_ahead(w->mesh, dim, w->incidence, w->node, r, end);
        copy_ring(w, r);
        if (make_star(w, dim, r, w->maps + thread) != 0)
            return;
    }
}

static void make_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const work *w = context;
    if (w->mesh->dim == 3)
        make_stars(w, 3, begin, end, thread);
    else
        make_stars(w, 2, begin, end, thread);
}

/** Everything behind the offsets' allocation; returns -1 without memory. */
static int fill(work *w, int threads) {
    pl_stars *stars = w->stars;
    int64_t n = stars->n_stars;
    pl_parallel_for(threads, n, CHUNK, measure_stars, w);
    int64_t n_ring = pl_prefix_sum(threads, n, stars->ring_offset);
    int64_t n_link = pl_prefix_sum(threads, n, stars->link_offset);
    stars->ring = pl_alloc(n_ring, sizeof *stars->ring);
    stars->link.low = pl_alloc(n_link, (size_t)pl_link_positions(w->mesh->dim));
    if (stars->max_link > PL_BYTE_LINK)
        stars->link.high = pl_alloc(n_link, (size_t)pl_link_positions(w->mesh->dim));
    if (!stars->ring || !stars->link.low || (stars->max_link > PL_BYTE_LINK && !stars->link.high))
        return -1;
    if (w->mesh->min_volume) {
        stars->min_volume = pl_alloc(n_link, sizeof *stars->min_volume);
        if (!stars->min_volume)
            return -1;
    }
    pl_parallel_for(threads, n, CHUNK, make_chunk, w);
    return pl_local_maps_failed(w->maps, threads) ? -1 : 0;
}

int pl_stars_create(const planish_mesh *mesh, const pl_incidence *incidence, const int8_t *sign,
                    const pl_rings *rings, const int32_t *node, const int32_t *visit,
                    const int32_t *number_of, int threads, pl_stars *stars, planish_error *error) {
    int64_t n = rings->n_rings;
    *stars = (pl_stars){.n_stars = n};
    work w = {.mesh = mesh,
              .incidence = incidence,
              .sign = sign,
              .rings = rings,
              .node = node,
              .visit = visit,
              .number_of = number_of,
              .stars = stars};
    w.star_of = pl_alloc(n, sizeof *w.star_of);
    w.maps = pl_local_maps_create(threads);
    stars->ring_offset = pl_alloc(n + 1, sizeof *stars->ring_offset);
    stars->link_offset = pl_alloc(n + 1, sizeof *stars->link_offset);
    int done =
        w.star_of && w.maps && stars->ring_offset && stars->link_offset && fill(&w, threads) == 0;
    pl_free(w.star_of);
    pl_local_maps_destroy(w.maps, threads);
    if (done)
        return PLANISH_OK;
    pl_stars_destroy(stars);
    return pl_fail_memory(error, "the stars of the nodes");
}

void pl_stars_destroy(pl_stars *stars) {
    pl_free(stars->ring_offset);
    pl_free(stars->ring);
    pl_free(stars->link_offset);
    pl_free(stars->link.low);
    pl_free(stars->link.high);
    pl_free(stars->min_volume);
    *stars = (pl_stars){0};
}
