/* stars: the terms of the nodes of a surface mesh, and colours. */
#include "surface/surface_mesh.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/topology.h"

#include <stdlib.h>

enum { CHUNK = 512 };

/** Stars that are being made, by movable nodes in ascending order. */
typedef struct stars_draft {
    const planish_shape *shape;
    int64_t n;
    int32_t *node;       /* [n] */
    int64_t *offset;     /* [n + 1] */
    pl_facet_term *term; /* NULL: they are counted */
    pl_rings rings;
    int32_t *colour; /* [n] */
} stars_draft;

/** Position of node in a facet, or -1. */
static int corner_of(const planish_shape *s, int32_t facet, int32_t node) {
    for (int k = 0; k < 3; k++)
        if (s->facet[facet][k] == node)
            return k;
    return -1;
}

void pl_surface_quadrilateral(const planish_shape *shape, int32_t facet, int32_t corner[4]) {
    const int32_t *a = shape->facet[facet], *b = shape->facet[facet + 1];
    int k = 0; /* of the corner that the second half has not */
    while (k < 2 && corner_of(shape, facet + 1, a[k]) >= 0)
        k++;
    corner[0] = a[k];
    corner[1] = a[(k + 1) % 3];
    corner[3] = a[(k + 2) % 3];
    corner[2] = b[0];
    for (int j = 1; j < 3; j++)
        if (corner_of(shape, facet, b[j]) < 0)
            corner[2] = b[j];
}

/** Half of a quadrilateral that facet is, 0: it is a triangle. */
static int half_of(const planish_shape *s, int32_t facet) {
    return s->half ? s->half[facet] : 0;
}

/** Find the terms of a node in a facet, or in the quadrilateral of which it is a half; returns how
 *  many. Where the node has both halves the second one has none. */
static int terms_in(const planish_shape *s, int32_t facet, int32_t node, pl_facet_term term[3]) {
    const int half = half_of(s, facet), k = corner_of(s, facet, node);
    const int32_t *v = s->facet[facet];
    int32_t c[4];
    int at = 0;
    if (half == 0) {
        term[0] = (pl_facet_term){v[(k + 1) % 3], v[(k + 2) % 3], facet, PL_TERM_TRIANGLE};
        return 1;
    }
    if (half == 2 && corner_of(s, facet - 1, node) >= 0)
        return 0;
    const int32_t first = half == 2 ? facet - 1 : facet;
    pl_surface_quadrilateral(s, first, c);
    while (c[at] != node)
        at++;
    const int32_t next = c[(at + 1) % 4], opposite = c[(at + 2) % 4], before = c[(at + 3) % 4];
    term[0] = (pl_facet_term){next, before, first, PL_TERM_OWN};
    term[1] = (pl_facet_term){before, opposite, first, PL_TERM_NEXT};
    term[2] = (pl_facet_term){next, opposite, first, PL_TERM_BEFORE};
    return 3;
}

/** Add node to the ring of n neighbours, if it is not there, or in any case: of a hub; returns their
 *  number. */
static int64_t join_ring(int32_t *ring, int64_t n, int32_t node, int is_hub) {
    for (int64_t i = 0; !is_hub && i < n; i++)
        if (ring[i] == node)
            return n;
    ring[n] = node;
    return n + 1;
}

/** Node opposite to the edge of facet that is opposite to its corner k, in the facet across it; or
 *  -1. */
static int32_t node_across(const planish_shape *s, int32_t facet, int k) {
    const int32_t other = s->across[facet][(k + 1) % 3];
    for (int j = 0; other >= 0 && j < 3; j++)
        if (corner_of(s, facet, s->facet[other][j]) < 0)
            return s->facet[other][j];
    return -1;
}

/** Most neighbours that a node with so many facets may have: two of each, one opposite. While those of a hub
 *  are listed there are those of other halves as well. */
static int64_t room_of_ring(const planish_shape *s, int32_t node) {
    return (pl_is_hub(s, node) ? 6 : 4) * (int64_t)(s->offset[node + 1] - s->offset[node]);
}

static int compare_nodes(const void *a, const void *b) {
    const int32_t s = *(const int32_t *)a, t = *(const int32_t *)b;
    return (s > t) - (s < t);
}

/** Sort a ring of n nodes, and keep one of those that are the same; returns how many are left. */
static int64_t unite(int32_t *ring, int64_t n) {
    int64_t left = 0;
    qsort(ring, (size_t)n, sizeof *ring, compare_nodes);
    for (int64_t i = 0; i < n; i++)
        if (i == 0 || ring[i] != ring[left - 1])
            ring[left++] = ring[i];
    return left;
}

/** Fill the ring of a node: nodes of its elements, and those that decide how edges bend; returns how
 *  many. */
static int64_t fill_ring(const planish_shape *s, int32_t node, int32_t *ring) {
    const int is_hub = pl_is_hub(s, node);
    int64_t n = 0;
    for (int64_t i = s->offset[node]; i < s->offset[node + 1]; i++) {
        const int32_t facet = s->facet_of[i], half = half_of(s, facet);
        const int32_t across = node_across(s, facet, corner_of(s, facet, node));
        for (int j = 0; j < 3; j++)
            if (s->facet[facet][j] != node)
                n = join_ring(ring, n, s->facet[facet][j], is_hub);
        if (half) {
            const int32_t other = half == 1 ? facet + 1 : facet - 1;
            for (int j = 0; j < 3; j++)
                if (s->facet[other][j] != node)
                    n = join_ring(ring, n, s->facet[other][j], is_hub);
        }
        if (across >= 0)
            n = join_ring(ring, n, across, is_hub);
    }
    return is_hub ? unite(ring, n) : n;
}

static void count_chunk(void *context, int64_t begin, int64_t end, int thread) {
    stars_draft *d = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const planish_shape *s = d->shape;
        pl_facet_term term[3];
        d->offset[i] = 0;
        for (int64_t k = s->offset[d->node[i]]; k < s->offset[d->node[i] + 1]; k++)
            d->offset[i] += terms_in(s, s->facet_of[k], d->node[i], term);
        d->rings.offset[i] = room_of_ring(s, d->node[i]);
    }
}

/** Fill in rings, in their room; what is left of it holds the node itself, which is no neighbour. */
static void fill_rings_chunk(void *context, int64_t begin, int64_t end, int thread) {
    stars_draft *d = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int32_t *ring = d->rings.neighbour + d->rings.offset[i];
        const int64_t room = d->rings.offset[i + 1] - d->rings.offset[i];
        for (int64_t k = fill_ring(d->shape, d->node[i], ring); k < room; k++)
            ring[k] = ring[0];
    }
}

/** List the nodes that move, and make their rings. Returns 0 without memory. */
static int draft_rings(stars_draft *d, const uint8_t *moves, int threads) {
    const int64_t n_nodes = d->shape->n_nodes;
    d->node = pl_alloc(n_nodes, sizeof *d->node);
    for (int64_t i = 0; d->node && i < n_nodes; i++)
        if (moves[i])
            d->node[d->n++] = (int32_t)i;
    d->offset = pl_alloc(d->n + 1, sizeof *d->offset);
    d->rings.offset = pl_alloc(d->n + 1, sizeof *d->rings.offset);
    d->rings.n_rings = d->rings.n_free = d->n;
    d->colour = pl_alloc(d->n, sizeof *d->colour);
    if (!d->node || !d->offset || !d->rings.offset || !d->colour)
        return 0;
    pl_parallel_for(threads, d->n, CHUNK, count_chunk, d);
    pl_prefix_sum(threads, d->n, d->offset);
    const int64_t room = pl_prefix_sum(threads, d->n, d->rings.offset);
    d->rings.neighbour = pl_alloc(room, sizeof *d->rings.neighbour);
    if (d->rings.neighbour)
        pl_parallel_for(threads, d->n, CHUNK, fill_rings_chunk, d);
    return d->rings.neighbour != NULL;
}

/** Order the stars by colours, ascending within each, with their terms. Returns 0 without memory. */
static int order_stars(const stars_draft *d, pl_surface_mesh *mesh) {
    const planish_shape *s = d->shape;
    mesh->n_stars = d->n;
    mesh->node = pl_alloc(d->n, sizeof *mesh->node);
    mesh->term_offset = pl_alloc(d->n + 1, sizeof *mesh->term_offset);
    mesh->term = pl_alloc(d->offset[d->n], sizeof *mesh->term);
    mesh->colour_begin = pl_alloc_zero(mesh->n_colours + 2, sizeof *mesh->colour_begin);
    if (!mesh->node || !mesh->term_offset || !mesh->term || !mesh->colour_begin)
        return 0;
    int64_t *next = mesh->colour_begin + 1, n_terms = 0;
    for (int64_t i = 0; i < d->n; i++)
        next[d->colour[i]]++;
    pl_prefix_sum(1, mesh->n_colours, next);
    for (int64_t i = 0; i < d->n; i++)
        mesh->node[next[d->colour[i]]++] = d->node[i];
    for (int64_t i = 0; i < d->n; i++) {
        const int32_t node = mesh->node[i];
        mesh->term_offset[i] = n_terms;
        for (int64_t k = s->offset[node]; k < s->offset[node + 1]; k++)
            n_terms += terms_in(s, s->facet_of[k], node, mesh->term + n_terms);
    }
    mesh->term_offset[d->n] = n_terms;
    return 1;
}

int pl_surface_mesh_create(const planish_shape *shape, const uint8_t *moves, int threads,
                           pl_surface_mesh *mesh, planish_error *error) {
    static const char what[] = "the stars of a surface";
    stars_draft d = {.shape = shape};
    *mesh = (pl_surface_mesh){.shape = shape, .by_radius = shape->half == NULL};
    int status = draft_rings(&d, moves, threads) ? PLANISH_OK : pl_fail_memory(error, what);
    if (!status)
        status = pl_colouring_create(&d.rings, d.node, NULL, shape->n_nodes, NULL, threads,
                                     d.colour, &mesh->n_colours, error);
    if (!status && !order_stars(&d, mesh))
        status = pl_fail_memory(error, what);
    pl_free(d.node);
    pl_free(d.offset);
    pl_free(d.rings.offset);
    pl_free(d.rings.neighbour);
    pl_free(d.colour);
    if (status)
        pl_surface_mesh_destroy(mesh);
    return status;
}

void pl_surface_mesh_destroy(pl_surface_mesh *mesh) {
    pl_free(mesh->node);
    pl_free(mesh->term_offset);
    pl_free(mesh->term);
    pl_free(mesh->colour_begin);
    *mesh = (pl_surface_mesh){0};
}
