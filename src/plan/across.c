/* across: nodes that slide on a shape, and the nodes across the edges opposite to them.
 *
 * A facet that turns bends the smooth edge opposite to its node, as far as the facet across that edge
 * allows: the visit of a node reads the nodes across (sweep/skin.c). No element need have both, so
 * the colours of visits are told of them here.
 */
#include "plan/draft.h"

#include "base/memory.h"
#include "base/status.h"
#include "shape/curved.h"

#include <inttypes.h>
#include <string.h>

/* Nodes across the edges of a quadrilateral that its corner is no end of: two for each, which may lead to two
 * facets. */
enum { MOST_ACROSS = 8 };

/** Nodes under way. */
typedef struct across {
    const pl_draft *d;
    const pl_candidates *c;
    const planish_shape *shape;
    int32_t *node_of; /* [shape->n_nodes] of the plan's mesh; -1: it has not this one */
    int32_t *ring_at; /* [shape->n_nodes] last ring that was found to have it, or -1 */
} across;

/** Number the shape's nodes by the plan's mesh; 0 without memory. */
static int number_nodes(across *a) {
    const planish_plan *plan = a->d->plan;
    const size_t bytes = (size_t)a->shape->n_nodes * sizeof *a->node_of;
    a->node_of = pl_alloc(a->shape->n_nodes, sizeof *a->node_of);
    a->ring_at = pl_alloc(a->shape->n_nodes, sizeof *a->ring_at);
    if (!a->node_of || !a->ring_at)
        return 0;
    memset(a->node_of, -1, bytes);
    memset(a->ring_at, -1, bytes);
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int32_t own = a->shape->number[pl_plan_node(plan, i)];
        if (own >= 0)
            a->node_of[own] = (int32_t)i;
    }
    return 1;
}

/** Ring r of c. */
static const int32_t *ring_of(const across *a, int64_t r, int64_t *n) {
    *n = a->c->rings.offset[r + 1] - a->c->rings.offset[r];
    return a->c->rings.neighbour + a->c->rings.offset[r];
}

/** Own number in the shape of the node of ring r; -1: it is not of the shape, or there is no node. */
static int32_t number_of(const across *a, int64_t r) {
    const int32_t node = a->c->node[r];
    return node < 0 ? -1 : a->shape->number[pl_plan_node(a->d->plan, node)];
}

/** Note the nodes of ring r that are of the shape. */
static void note_ring(const across *a, int64_t r) {
    int64_t n;
    const int32_t *ring = ring_of(a, r, &n);
    for (int64_t i = 0; i < n; i++) {
        const int32_t own = ring[i] < a->d->plan->work.n_nodes
                                ? a->shape->number[pl_plan_node(a->d->plan, ring[i])]
                                : -1;
        if (own >= 0)
            a->ring_at[own] = (int32_t)r;
    }
}

/** Check that the nodes of the facets around the node of ring r are its neighbours. */
static int check_facets(const across *a, int64_t r, planish_error *error) {
    const planish_shape *shape = a->shape;
    const int32_t own = number_of(a, r);
    int64_t n_facets = 0;
    const int32_t *facets = own < 0 ? NULL : pl_shape_star(shape, own, &n_facets);
    for (int64_t i = 0; i < n_facets; i += pl_shape_parts(shape, facets[i])) {
        int n_corners;
        const int32_t *corner = pl_shape_corners(shape, facets[i], &n_corners);
        for (int j = 0; j < n_corners; j++)
            if (corner[j] != own && a->ring_at[corner[j]] != r)
                return pl_fail_at(
                    error, PLANISH_ERROR_ARGUMENT, -1, shape->node[own],
                    "options.shape has a facet of the nodes %" PRId32 ", %" PRId32 " and %" PRId32
                    ", which the mesh has not; make the shape of this mesh",
                    shape->node[corner[0]], shape->node[corner[1]], shape->node[corner[2]]);
    }
    return PLANISH_OK;
}

/** The facets across the edges of the facet of t that a node is no end of: of second order both halves lead
 *  to the same one, as a rule. Returns how many there are, -1 among them where there is none. */
static int find_across(const planish_shape *shape, int32_t t, int32_t own,
                       int32_t found[2 * PL_WHOLE_FOLLOWERS]) {
    int n_corners, n = 0;
    const int32_t *corner = pl_shape_corners(shape, t, &n_corners);
    for (int k = 0; k < n_corners; k++) {
        const int32_t end = corner[(k + 1) % n_corners];
        if (corner[k] == own || end == own)
            continue;
        const pl_whole *whole = shape->whole ? pl_whole_of(shape, t) : NULL;
        const int has_mid = whole && pl_whole_has_mids(whole);
        for (int half = 0; half < 1 + has_mid; half++) {
            const int32_t f = whole ? pl_whole_rim(whole, k, half) : t;
            const int32_t to = has_mid ? whole->node[n_corners + k] : end;
            found[n++] = shape->across[f][pl_edge_of(shape->facet[f], half ? end : corner[k], to)];
        }
    }
    return n;
}

/** Add to the n nodes of list, which begins with ring r, as is noted, the nodes across; returns how many there are
 *  then. */
static int64_t add_across(const across *a, int64_t r, int64_t n, int32_t *list) {
    const planish_shape *shape = a->shape;
    const int32_t own = number_of(a, r);
    int64_t n_facets = 0;
    const int32_t *facets = own < 0 ? NULL : pl_shape_star(shape, own, &n_facets);
    for (int64_t i = 0; i < n_facets; i += pl_shape_parts(shape, facets[i])) {
        int32_t others[2 * PL_WHOLE_FOLLOWERS];
        const int n_others = find_across(shape, facets[i], own, others);
        for (int k = 0; k < n_others; k++) {
            int n_corners;
            const int32_t *w =
                others[k] < 0 ? NULL : pl_shape_corners(shape, others[k], &n_corners);
            for (int j = 0; w && j < n_corners; j++)
                if (w[j] != own && a->node_of[w[j]] >= 0 && a->ring_at[w[j]] != r) {
                    a->ring_at[w[j]] = (int32_t)r;
                    list[n++] = a->node_of[w[j]];
                }
        }
    }
    return n;
}

/** Fill rings, whose neighbours have room for the nodes across. */
static int fill_rings(const across *a, pl_rings *rings, planish_error *error) {
    int64_t end = 0;
    for (int64_t r = 0; r < rings->n_rings; r++) {
        int64_t n;
        const int32_t *ring = ring_of(a, r, &n);
        note_ring(a, r);
        const int status = check_facets(a, r, error);
        if (status)
            return status;
        rings->offset[r] = end;
        memcpy(rings->neighbour + end, ring, (size_t)n * sizeof *ring);
        end += add_across(a, r, n, rings->neighbour + end);
    }
    rings->offset[rings->n_rings] = end;
    return PLANISH_OK;
}

int pl_rings_across(const pl_draft *d, const pl_candidates *c, pl_rings *rings,
                    planish_error *error) {
    across a = {.d = d, .c = c, .shape = d->options->shape};
    int64_t room = c->rings.offset[c->n];
    for (int64_t r = 0; r < c->n; r++) {
        const int32_t own = number_of(&a, r);
        int64_t n = 0;
        if (own >= 0)
            pl_shape_star(a.shape, own, &n);
        room += (a.shape->whole ? MOST_ACROSS : 1) * n;
    }
    *rings = (pl_rings){.n_rings = c->n,
                        .n_free = c->rings.n_free,
                        .offset = pl_alloc(c->n + 1, sizeof *rings->offset),
                        .neighbour = pl_alloc(room, sizeof *rings->neighbour)};
    const int done = rings->offset && rings->neighbour && number_nodes(&a);
    const int status =
        done ? fill_rings(&a, rings, error) : pl_fail_memory(error, "the colours of nodes");
    pl_free(a.node_of);
    pl_free(a.ring_at);
    return status;
}
