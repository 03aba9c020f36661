/* held: planish_plan_get_held, why each node of a plan does not move.
 *
 * In go a plan and coordinates, out come bits for each node. The facets are matched again, as a
 * plan keeps nothing of them, but only those of nodes that are not inside: about the surface.
 */
#include "plan/plan.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "topology/facets.h"

#include <string.h>

/** The work. n nodes: those of the mesh, or of the part of it that alone is known. */
typedef struct search {
    const planish_plan *plan;
    planish_mesh mesh;         /* dim, n_nodes and elements */
    const int32_t *node_of;    /* [n] number of each node in reason; NULL: the same */
    uint8_t *moves;            /* [n] PL_HELD, ... */
    uint8_t *is_inside;        /* [n] 1: PL_INTERIOR */
    uint8_t *facts;            /* [n] of planish_hold_reason, by facets; shared */
    pl_incidence incidence;    /* of nodes that are not inside */
    const planish_part *part;  /* of which facets at its own nodes are looked at */
    const double *coordinates; /* the caller's, or NULL */
} search;

/* ---- facets --------------------------------------------------------------------------------- */

static void note(search *s, int32_t node, uint8_t reason) {
    if (!(__atomic_load_n(&s->facts[node], __ATOMIC_RELAXED) & reason))
        __atomic_fetch_or(&s->facts[node], reason, __ATOMIC_RELAXED);
}

static int is_here(const search *s, int32_t node, const pl_facet *facet) {
    return pl_is_own(s->part, node) || pl_is_own(s->part, facet->node[0]) ||
           (facet->node[1] >= 0 && pl_is_own(s->part, facet->node[1]));
}

static void note_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                        int thread) {
    search *s = context;
    const int corners = s->mesh.dim + 1;
    (void)thread;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        const uint8_t reason = facet->count == 1  ? PLANISH_HELD_BOUNDARY
                               : facet->count > 2 ? PLANISH_HELD_NONMANIFOLD
                                                  : 0;
        if (!is_here(s, node, facet))
            continue;
        for (int j = 0; reason && j < s->mesh.dim; j++)
            note(s, j ? facet->node[j - 1] : node, reason);
        for (int j = 0; facet->twin && j < corners; j++)
            note(s, s->mesh.elements[(int64_t)facet->element[0] * corners + j],
                 PLANISH_HELD_NONMANIFOLD);
    }
}

static int look_at_facets(search *s, planish_error *error) {
    const int threads = s->plan->threads;
    for (int64_t i = 0; i < s->mesh.n_nodes; i++)
        s->is_inside[i] = s->moves[i] == PL_INTERIOR;
    int status = pl_incidence_create(&s->mesh, s->is_inside, threads, &s->incidence, error);
    if (!status)
        status =
            pl_facets_match(&s->mesh, &s->incidence, s->is_inside, threads, note_facets, s, error);
    return status;
}

/* ---- places --------------------------------------------------------------------------------- */

static int is_used(const search *s, int64_t node) {
    return s->incidence.offset[node + 1] > s->incidence.offset[node];
}

/** Note the nodes at the place of another one, of those that are not inside. */
static int look_at_places(search *s, planish_error *error) {
    int64_t n = 0;
    if (!s->coordinates)
        return PLANISH_OK;
    for (int64_t i = 0; i < s->mesh.n_nodes; i++)
        n += !s->is_inside[i] && is_used(s, i);
    int32_t *node = pl_alloc(n, sizeof *node), *place = pl_alloc(n, sizeof *place);
    uint8_t *is_doubled = pl_alloc(n, sizeof *is_doubled);
    int status = node && place && is_doubled ? PLANISH_OK : pl_fail_memory(error, "held nodes");
    n = 0;
    for (int64_t i = 0; !status && i < s->mesh.n_nodes; i++)
        if (!s->is_inside[i] && is_used(s, i)) {
            node[n] = (int32_t)i;
            place[n++] = s->node_of ? s->node_of[i] : (int32_t)i;
        }
    const pl_points points = {
        s->coordinates, n, s->mesh.dim, s->plan->node_stride, s->plan->component_stride, place};
    if (!status)
        status = pl_points_find_doubled(&points, is_doubled, error);
    for (int64_t i = 0; !status && i < n; i++)
        if (is_doubled[i])
            note(s, node[i], PLANISH_HELD_DOUBLED);
    pl_free(is_doubled);
    pl_free(place);
    pl_free(node);
    return status;
}

/* ---- all of it ------------------------------------------------------------------------------ */

/** Reasons known to the plan why a node is held, as PLANISH_HELD_ bits; node is the plan's
 *  number. */
static uint8_t told(const planish_plan *plan, int64_t node) {
    const uint8_t use = plan->is_used[node];
    return (uint8_t)((use & PL_FIXED_BY_CALLER ? PLANISH_HELD_FIXED : 0) |
                     (use & PL_IN_PAIR ? PLANISH_HELD_PERIODIC : 0) |
                     (use & PL_OF_WRAPPED ? PLANISH_HELD_WRAPPED : 0) |
                     (use & PL_NOT_CHOSEN ? PLANISH_HELD_NOT_CHOSEN : 0));
}

/** All reasons of a node of the search that is held. No facet tells of too many elements, and of
 *  neighbours that cannot be oriented alike. */
static uint8_t reason_of(const search *s, int64_t node, uint8_t by_plan) {
    if (!is_used(s, node))
        return PLANISH_HELD_UNUSED;
    if (s->plan->scope == PL_SUBSET_ALONE && (by_plan & PLANISH_HELD_NOT_CHOSEN))
        return PLANISH_HELD_NOT_CHOSEN; /* not all facets of it are known */
    const uint8_t reason = s->facts[node] | by_plan;
    return reason & (uint8_t)~PLANISH_HELD_DOUBLED ? reason : reason | PLANISH_HELD_NONMANIFOLD;
}

/** by_plan [n]: what the plan was told of the nodes. */
static void fill(const search *s, const uint8_t *by_plan, uint8_t *reason) {
    for (int64_t i = 0; i < s->mesh.n_nodes; i++)
        reason[s->node_of ? s->node_of[i] : i] = s->moves[i] ? 0 : reason_of(s, i, by_plan[i]);
}

/** Copy the plan's facts about the nodes of the search to by_plan [n] and s->moves. */
static void take_plan(search *s, uint8_t *by_plan) {
    const planish_plan *plan = s->plan;
    const int is_part = plan->all != &plan->work;
    if (is_part) {
        memset(by_plan, PLANISH_HELD_NOT_CHOSEN, (size_t)s->mesh.n_nodes);
        memset(s->moves, PL_HELD, (size_t)s->mesh.n_nodes);
    }
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int64_t node = is_part ? plan->node_of[i] : i;
        by_plan[node] = told(plan, i);
        s->moves[node] = plan->work.mobility[i];
    }
}

static int find_held(search *s, uint8_t *reason, planish_error *error) {
    const int64_t n = s->mesh.n_nodes;
    uint8_t *by_plan = pl_alloc(n, sizeof *by_plan);
    s->moves = pl_alloc(n, sizeof *s->moves);
    s->is_inside = pl_alloc(n, sizeof *s->is_inside);
    s->facts = pl_alloc_zero(n, sizeof *s->facts);
    int status = by_plan && s->moves && s->is_inside && s->facts
                     ? PLANISH_OK
                     : pl_fail_memory(error, "held nodes");
    if (!status) {
        take_plan(s, by_plan);
        status = look_at_facets(s, error);
    }
    if (!status)
        status = look_at_places(s, error);
    if (!status && s->plan->scope == PL_SUBSET_ALONE)
        memset(reason, PLANISH_HELD_NOT_CHOSEN, (size_t)s->plan->whole.n_nodes);
    if (!status)
        fill(s, by_plan, reason);
    pl_incidence_destroy(&s->incidence);
    pl_free(s->facts);
    pl_free(s->is_inside);
    pl_free(s->moves);
    pl_free(by_plan);
    return status;
}

int planish_plan_get_held(const planish_plan *plan, const double *coordinates, uint8_t *reason,
                          planish_error *error) {
    if (!plan || !reason)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "plan and reason must not be NULL");
    const pl_outside outside = pl_call_enter(plan->context);
    const int is_part = plan->all != &plan->work;
    search s = {.plan = plan,
                .mesh = {.dim = plan->dim,
                         .n_nodes = plan->all->n_nodes,
                         .n_elements = plan->all->n_elements,
                         .elements = plan->all->elements},
                .node_of = is_part ? NULL : plan->node_of,
                .part = pl_part_here(),
                .coordinates = coordinates};
    const int status = find_held(&s, reason, error);
    pl_call_leave(&outside);
    return status;
}
