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

/** Check that the nodes of the facets around the node of ring r are its neighbours. */
static int check_facets(const across *a, int64_t r, planish_error *error) {
    const planish_shape *shape = a->shape;
    const int32_t own = number_of(a, r);
    int64_t n;
    const int32_t *ring = ring_of(a, r, &n);
    for (int64_t i = own < 0 ? 0 : shape->offset[own]; own >= 0 && i < shape->offset[own + 1];
         i++) {
        const int32_t *facet = shape->facet[shape->facet_of[i]];
        for (int j = 0; j < 3; j++)
            if (facet[j] != own && !has(ring, n, a->node_of[facet[j]]))
                return pl_fail_at(
                    error, PLANISH_ERROR_ARGUMENT, -1, shape->node[own],
                    "options.shape has a facet of the nodes %" PRId32 ", %" PRId32 " and %" PRId32
                    ", which the mesh has not; make the shape of this mesh",
                    shape->node[facet[0]], shape->node[facet[1]], shape->node[facet[2]]);
    }
    return PLANISH_OK;
}

/** Add to the n nodes of list, which begins with ring r, the nodes across; returns how many there are
 *  then. */
static int64_t add_across(const across *a, int64_t r, int64_t n, int32_t *list) {
    const planish_shape *shape = a->shape;
    const int32_t own = number_of(a, r);
    for (int64_t i = own < 0 ? 0 : shape->offset[own]; own >= 0 && i < shape->offset[own + 1];
         i++) {
        const int32_t t = shape->facet_of[i], *facet = shape->facet[t];
        const int k = facet[0] == own ? 1 : facet[1] == own ? 2 : 0; /* where the edge begins */
        const int32_t other = shape->across[t][k];
        for (int j = 0; other >= 0 && j < 3; j++) {
            const int32_t w = shape->facet[other][j];
            if (w != own && w != facet[k] && w != facet[(k + 1) % 3] && a->node_of[w] >= 0 &&
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
        room += own < 0 ? 0 : a.shape->offset[own + 1] - a.shape->offset[own];
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
