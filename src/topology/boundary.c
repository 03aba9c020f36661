/* boundary: count the facets by their number of elements and mark the nodes that they hold. */
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "topology/facets.h"
#include "topology/local_map.h"

/** Counts of a thread; no line of the cache is shared with another thread's. */
typedef struct counts {
    _Alignas(64) int64_t boundary_facets;
    int64_t nonmanifold_facets, duplicate_elements;
} counts;

/** Work on the facets. Several threads write flags, but only ever the same value. */
typedef struct census {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    pl_boundary *boundary;
    counts *counts;           /* [threads] */
    const planish_part *part; /* of which facets at its own nodes are looked at: all their elements
                                 are here */
    int consistent;           /* elements joined by a facet traverse it in opposite directions */
    int failed;               /* memory ran out */
} census;

static void hold(census *c, int32_t node) {
    pl_set_flag(&c->boundary->on_boundary[node], 1);
}

/* ---- duplicates --------------------------------------------------------------------------- */

/** Count and hold the duplicates among the elements of which node is the smallest. Rare, so that
 *  the map is made for the occasion. */
static void find_duplicates(census *c, int32_t node, counts *count) {
    int dim = c->mesh->dim;
    int64_t begin = c->incidence->offset[node], end = c->incidence->offset[node + 1];
    pl_local_map map = {0};
    if (pl_local_map_empty(&map, 2 * (end - begin)) != 0) {
        __atomic_store_n(&c->failed, 1, __ATOMIC_RELAXED);
        return;
    }
    for (int64_t i = begin; i < end; i++) {
        int32_t s[4], element = c->incidence->element[i];
        pl_sort_element(dim, c->mesh->elements + (int64_t)element * (dim + 1), s);
        if (s[0] != node)
            continue;
        /* The other nodes are numbered in two steps, since a key holds two numbers of 31 bits
         * beside a mark that tells the second step's keys from the first one's. */
        const int32_t known = map.count;
        int32_t number = pl_local_map_add(&map, (uint64_t)(uint32_t)s[1] << 32 | (uint32_t)s[2]);
        if (dim == 3)
            number =
                pl_local_map_add(&map, UINT64_C(1) << 63 | (uint64_t)number << 31 | (uint32_t)s[3]);
        if (number >= known)
            continue;
        count->duplicate_elements += pl_is_own(c->part, node);
        for (int j = 0; j <= dim; j++)
            hold(c, s[j]);
    }
    pl_local_map_destroy(&map);
}

/* ---- facets ------------------------------------------------------------------------------- */

static void count_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                         int thread) {
    census *c = context;
    counts *count = &c->counts[thread];
    int64_t outer = 0, nonmanifold = 0;
    int same_direction = 0, twins = 0;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        if (!pl_facet_is_here(c->part, node, facet))
            continue;
        outer += facet->count == 1;
        nonmanifold += facet->count > 2;
        twins |= facet->twin;
        same_direction |= pl_facet_joins(facet) && facet->parity[0] == facet->parity[1];
        if (facet->count == 2)
            continue;
        hold(c, node);
        for (int i = 0; i < 2 && facet->node[i] >= 0; i++)
            hold(c, facet->node[i]);
    }
    if (pl_is_own(c->part, node)) { /* each in one process */
        count->boundary_facets += outer;
        count->nonmanifold_facets += nonmanifold;
    }
    if (same_direction)
        __atomic_store_n(&c->consistent, 0, __ATOMIC_RELAXED);
    if (twins || nonmanifold)
        find_duplicates(c, node, count);
}

/* ---- the boundary ------------------------------------------------------------------------- */

int pl_boundary_create(const planish_mesh *mesh, int all_positive, int threads,
                       pl_boundary *boundary, planish_error *error) {
    *boundary = (pl_boundary){0};
    boundary->on_boundary = pl_alloc_zero(mesh->n_nodes, sizeof *boundary->on_boundary);
    if (!boundary->on_boundary)
        return pl_fail_memory(error, "the boundary");
    boundary->is_guess = all_positive;
    int status = all_positive ? PLANISH_OK : pl_orientation_guess(mesh, threads, boundary, error);
    if (status)
        pl_boundary_destroy(boundary);
    return status;
}

int pl_boundary_find(const planish_mesh *mesh, const pl_incidence *incidence,
                     const uint8_t *is_inside, int threads, pl_boundary *boundary,
                     planish_error *error) {
    census c = {.mesh = mesh,
                .incidence = incidence,
                .boundary = boundary,
                .counts = pl_alloc_zero(threads, sizeof *c.counts),
                .part = pl_part_here(),
                .consistent = 1};
    int status = c.counts
                     ? pl_facets_match(mesh, incidence, is_inside, threads, count_facets, &c, error)
                     : pl_fail_memory(error, "the facets");
    if (!status && c.failed)
        status = pl_fail_memory(error, "duplicate elements");
    for (int t = 0; !status && t < threads; t++) {
        boundary->n_boundary_facets += c.counts[t].boundary_facets;
        boundary->n_nonmanifold_facets += c.counts[t].nonmanifold_facets;
        boundary->n_duplicate_elements += c.counts[t].duplicate_elements;
    }
    pl_free(c.counts);
    const int is_consistent = !pl_parts_any(!c.consistent);
    if (!status && !(boundary->is_guess && is_consistent))
        status = pl_orientation_create(mesh, incidence, threads, boundary, error);
    return status;
}

void pl_boundary_destroy(pl_boundary *boundary) {
    pl_free(boundary->on_boundary);
    pl_free(boundary->sign);
    pl_free(boundary->flags);
    *boundary = (pl_boundary){0};
}
