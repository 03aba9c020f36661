/* boundary: count the facets by their number of elements and mark the nodes that they hold. */
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "topology/facets.h"
#include "topology/local_map.h"
#include "topology/orientation.h"

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

/** Number the sorted nodes s[1] .. s[dim] in map: two steps, since a key holds two numbers of 31
 *  bits beside a mark that tells the second step's keys from the first one's. */
static int32_t number_of_nodes(int dim, pl_local_map *map, const int32_t *s) {
    int32_t number = pl_local_map_add(map, (uint64_t)(uint32_t)s[1] << 32 | (uint32_t)s[2]);
    if (dim == 2)
        return number;
    return pl_local_map_add(map, UINT64_C(1) << 63 | (uint64_t)number << 31 | (uint32_t)s[3]);
}

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
        int32_t known = map.count;
        int32_t number = number_of_nodes(dim, &map, s);
        if (number >= known)
            continue;
        count->duplicate_elements += pl_is_own(c->part, node);
        for (int j = 0; j <= dim; j++)
            hold(c, s[j]);
    }
    pl_local_map_destroy(&map);
}

/* ---- facets ------------------------------------------------------------------------------- */

static void hold_facet(census *c, int32_t node, const pl_facet *facet) {
    hold(c, node);
    hold(c, facet->node[0]);
    if (facet->node[1] >= 0)
        hold(c, facet->node[1]);
}

static int is_here(const census *c, int32_t node, const pl_facet *facet) {
    return pl_is_own(c->part, node) || pl_is_own(c->part, facet->node[0]) ||
           (facet->node[1] >= 0 && pl_is_own(c->part, facet->node[1]));
}

static void count_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                         int thread) {
    census *c = context;
    counts *count = &c->counts[thread];
    int64_t outer = 0, nonmanifold = 0;
    int same_direction = 0, twins = 0;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        if (!is_here(c, node, facet))
            continue;
        outer += facet->count == 1;
        nonmanifold += facet->count > 2;
        twins |= facet->twin;
        same_direction |= pl_facet_joins(facet) && facet->parity[0] == facet->parity[1];
        if (facet->count != 2)
            hold_facet(c, node, facet);
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

/** Ask all facets, and add up what the threads have counted. */
static int take_census(census *c, const uint8_t *is_inside, int threads, planish_error *error) {
    pl_boundary *boundary = c->boundary;
    c->counts = pl_alloc_zero(threads, sizeof *c->counts);
    if (!c->counts)
        return pl_fail_memory(error, "the facets");
    int status = pl_facets_match(c->mesh, c->incidence, is_inside, threads, count_facets, c, error);
    if (!status && c->failed)
        status = pl_fail_memory(error, "duplicate elements");
    for (int t = 0; t < threads; t++) {
        boundary->n_boundary_facets += c->counts[t].boundary_facets;
        boundary->n_nonmanifold_facets += c->counts[t].nonmanifold_facets;
        boundary->n_duplicate_elements += c->counts[t].duplicate_elements;
    }
    pl_free(c->counts);
    return status;
}

int pl_boundary_find(const planish_mesh *mesh, const pl_incidence *incidence,
                     const uint8_t *is_inside, int threads, pl_boundary *boundary,
                     planish_error *error) {
    census c = {.mesh = mesh,
                .incidence = incidence,
                .boundary = boundary,
                .part = pl_part_here(),
                .consistent = 1};
    int status = take_census(&c, is_inside, threads, error);
    const int consistent = !pl_parts_any(!c.consistent);
    const int agree = boundary->is_guess && consistent;
    if (!status && !agree)
        status = pl_orientation_create(mesh, incidence, threads, boundary, error);
    return status;
}

void pl_boundary_destroy(pl_boundary *boundary) {
    pl_free(boundary->on_boundary);
    pl_free(boundary->sign);
    pl_free(boundary->flags);
    *boundary = (pl_boundary){0};
}
