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

/** Nodes under way. */
typedef struct across {
    const pl_draft *d;
    const pl_candidates *c;
    const planish_shape *shape;
    int32_t *node_of; /* [shape->n_nodes] of the plan's mesh; -1: it has not this one */
} across;

/** Number the shape's nodes by the plan's mesh; 0 without memory. */
static int number_nodes(across *a) {
    const planish_plan *plan = a->d->plan;
    a->node_of = pl_alloc(a->shape->n_nodes, sizeof *a->node_of);
    if (!a->node_of)
        return 0;
    memset(a->node_of, -1, (size_t)a->shape->n_nodes * sizeof *a->node_of);
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int32_t own = a->shape->number[pl_plan_node(plan, i)];
        if (own >= 0)
            a->node_of[own] = (int32_t)i;
    }
    return 1;
}

static int has(const int32_t *list, int64_t n, int32_t node) {
    for (int64_t i = 0; i < n; i++)
        if (list[i] == node)
            return 1;
    return 0;
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

/** The nodes of facet t, of second order its corners. */
static const int32_t *corners_of(const planish_shape *shape, int32_t t) {
    return shape->whole ? shape->whole[t / 4] : shape->facet[t];
}

/** Check that the nodes of the facets around the node of ring r are its neighbours. */
static int check_facets(const across *a, int64_t r, planish_error *error) {
    const planish_shape *shape = a->shape;
    const int32_t own = number_of(a, r);
    int64_t n, n_facets = 0;
    const int32_t *ring = ring_of(a, r, &n);
    const int32_t *facets = own < 0 ? NULL : pl_shape_star(shape, own, &n_facets);
    for (int64_t i = 0; i < n_facets; i += shape->whole ? 4 : 1) {
        const int32_t *corner = corners_of(shape, facets[i]);
        for (int j = 0; j < 3; j++)
            if (corner[j] != own && !has(ring, n, a->node_of[corner[j]]))
                return pl_fail_at(
                    error, PLANISH_ERROR_ARGUMENT, -1, shape->node[own],
                    "options.shape has a facet of the nodes %" PRId32 ", %" PRId32 " and %" PRId32
                    ", which the mesh has not; make the shape of this mesh",
                    shape->node[corner[0]], shape->node[corner[1]], shape->node[corner[2]]);
    }
    return PLANISH_OK;
}

/** The facet across the edge of facet t opposite to a node; -1: there is none. */
static int32_t find_across(const planish_shape *shape, int32_t t, int32_t own) {
    const int32_t *corner = corners_of(shape, t);
    const int k = corner[0] == own ? 1 : corner[1] == own ? 2 : 0; /* where the edge begins */
    if (!shape->whole)
        return shape->across[t][k];
    const int32_t at_corner = t / 4 * 4 + k;
    const int edge = pl_edge_of(shape->facet[at_corner], corner[k], corner[3 + k]);
    return shape->across[at_corner][edge];
}

/** Add to the n nodes of list, which begins with ring r, the nodes across; returns how many there are
 *  then. */
static int64_t add_across(const across *a, int64_t r, int64_t n, int32_t *list) {
    const planish_shape *shape = a->shape;
    const int32_t own = number_of(a, r);
    int64_t n_facets = 0;
    const int32_t *facets = own < 0 ? NULL : pl_shape_star(shape, own, &n_facets);
    for (int64_t i = 0; i < n_facets; i += shape->whole ? 4 : 1) {
        const int32_t *corner = corners_of(shape, facets[i]);
        const int32_t other = find_across(shape, facets[i], own);
        for (int j = 0; other >= 0 && j < 3; j++) {
            const int32_t w = corners_of(shape, other)[j];
            if (w != corner[0] && w != corner[1] && w != corner[2] && a->node_of[w] >= 0 &&
                !has(list, n, a->node_of[w]))
                list[n++] = a->node_of[w];
        }
    }
    return n;
}

/** Fill rings, whose neighbours have room for one node across for each facet. */
static int fill_rings(const across *a, pl_rings *rings, planish_error *error) {
    int64_t end = 0;
    for (int64_t r = 0; r < rings->n_rings; r++) {
        int64_t n;
        const int32_t *ring = ring_of(a, r, &n);
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
        room += n;
    }
    *rings = (pl_rings){.n_rings = c->n,
                        .n_free = c->rings.n_free,
                        .offset = pl_alloc(c->n + 1, sizeof *rings->offset),
                        .neighbour = pl_alloc(room, sizeof *rings->neighbour)};
    const int done = rings->offset && rings->neighbour && number_nodes(&a);
    const int status =
        done ? fill_rings(&a, rings, error) : pl_fail_memory(error, "the colours of nodes");
    pl_free(a.node_of);
    return status;
}
