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
#include "geometry/cell.h"
#include "topology/cells.h"
#include "topology/facets.h"

#include <string.h>

/** The search for reasons. n nodes: those of the mesh, or of the part of it that alone is known. */
typedef struct hold_search {
    const planish_plan *plan;
    planish_mesh mesh;        /* dim, n_nodes and elements */
    const int32_t *node_of;   /* [n] number of each node in reason; NULL: the same */
    uint8_t *moves;           /* [n] PL_HELD, ... */
    uint8_t *by_plan;         /* [n] reasons known to the plan */
    uint8_t *is_inside;       /* [n] 1: PL_INTERIOR */
    uint8_t *facts;           /* [n] of planish_hold_reason, by facets; shared */
    pl_incidence incidence;   /* of nodes that are not inside */
    const planish_part *part; /* of which facets at its own nodes are looked at */
} hold_search;

static void note_reason(hold_search *s, int32_t node, uint8_t reason) {
    if (!(__atomic_load_n(&s->facts[node], __ATOMIC_RELAXED) & reason))
        __atomic_fetch_or(&s->facts[node], reason, __ATOMIC_RELAXED);
}

static void note_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                        int thread) {
    hold_search *s = context;
    const int corners = s->mesh.dim + 1;
    (void)thread;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        const uint8_t reason = facet->count == 1  ? PLANISH_HELD_BOUNDARY
                               : facet->count > 2 ? PLANISH_HELD_NONMANIFOLD
                                                  : 0;
        if (!pl_is_own(s->part, node) && !pl_is_own(s->part, facet->node[0]) &&
            (facet->node[1] < 0 || !pl_is_own(s->part, facet->node[1])))
            continue; /* another process looks at it */
        for (int j = 0; reason && j < s->mesh.dim; j++)
            note_reason(s, j ? facet->node[j - 1] : node, reason);
        for (int j = 0; facet->twin && j < corners; j++)
            note_reason(s, s->mesh.elements[(int64_t)facet->element[0] * corners + j],
                        PLANISH_HELD_NONMANIFOLD);
    }
}

/** Note what facets of cells say: those of their corners say nothing. coordinates [n][dim] or NULL. */
static int note_cell_facets(hold_search *s, const double *coordinates, planish_error *error) {
    const planish_plan *plan = s->plan;
    const planish_cells *cells = &plan->cells;
    const pl_points points = pl_plan_all_points(plan, coordinates);
    double *x = pl_alloc_zero(points.n * points.dim, sizeof *x);
    pl_cell_census census = {.n_sharing = NULL};
    if (x && coordinates)
        pl_points_gather(&points, plan->threads, x);
    const int status =
        x ? pl_cell_census_find(cells, plan->dim, s->mesh.n_nodes, x, plan->threads, &census, error)
          : pl_fail_memory(error, "held nodes");
    for (int64_t i = 0; !status && i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        const int n_facets = type && type->shape->dim == plan->dim ? type->shape->n_facets : 0;
        for (int j = 0; census.is_duplicate[i] && j < type->shape->n_corners; j++)
            note_reason(s, cells->node[cells->offset[i] + j], PLANISH_HELD_NONMANIFOLD);
        for (int k = 0; k < n_facets; k++) {
            const int n = census.n_sharing[i * PL_CELL_FACET_PLACES + k];
            for (int j = 0; (n == 1 || n > 2) && j < 4 && type->shape->facet[k][j] >= 0; j++)
                note_reason(s, cells->node[cells->offset[i] + type->shape->facet[k][j]],
                            n == 1 ? PLANISH_HELD_BOUNDARY : PLANISH_HELD_NONMANIFOLD);
        }
    }
    pl_free(x);
    pl_cell_census_destroy(&census);
    return status;
}

static int is_used(const hold_search *s, int64_t node) {
    return s->incidence.offset[node + 1] > s->incidence.offset[node];
}

/** Note the nodes at the place of another one, of those that are not inside. */
static int note_doubled(hold_search *s, const double *coordinates, planish_error *error) {
    int64_t n = 0;
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
        coordinates, n, s->mesh.dim, s->plan->node_stride, s->plan->component_stride, place};
    if (!status)
        status = pl_points_find_doubled(&points, is_doubled, error);
    for (int64_t i = 0; !status && i < n; i++)
        if (is_doubled[i])
            note_reason(s, node[i], PLANISH_HELD_DOUBLED);
    pl_free(is_doubled);
    pl_free(place);
    pl_free(node);
    return status;
}

/** Copy the plan's facts about the nodes of the search, whose numbers may be others. */
static void take_facts_of_plan(hold_search *s) {
    const planish_plan *plan = s->plan;
    const int is_subset = plan->all != &plan->work;
    if (is_subset) {
        memset(s->by_plan, PLANISH_HELD_NOT_CHOSEN, (size_t)s->mesh.n_nodes);
        memset(s->moves, PL_HELD, (size_t)s->mesh.n_nodes);
    }
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int64_t node = is_subset ? plan->node_of[i] : i;
        const uint8_t use = plan->is_used[i];
        s->by_plan[node] = (uint8_t)((use & PL_FIXED_BY_CALLER ? PLANISH_HELD_FIXED : 0) |
                                     (use & PL_IN_PAIR ? PLANISH_HELD_PERIODIC : 0) |
                                     (use & PL_OF_WRAPPED ? PLANISH_HELD_WRAPPED : 0) |
                                     (use & PL_NOT_CHOSEN ? PLANISH_HELD_NOT_CHOSEN : 0));
        s->moves[node] = plan->work.mobility[i];
    }
}

/** All reasons of a node of the search that is held. No facet tells of too many elements, and of
 *  neighbours that cannot be oriented alike. */
static uint8_t reason_of(const hold_search *s, int64_t node) {
    if (!is_used(s, node))
        return PLANISH_HELD_UNUSED;
    if (s->plan->scope == PL_SUBSET_ALONE && (s->by_plan[node] & PLANISH_HELD_NOT_CHOSEN))
        return PLANISH_HELD_NOT_CHOSEN; /* not all facets of it are known */
    const uint8_t reason = s->facts[node] | s->by_plan[node];
    return reason & (uint8_t)~PLANISH_HELD_DOUBLED ? reason : reason | PLANISH_HELD_NONMANIFOLD;
}

/** Give mids the reasons of their ends, or none if an end moves. Nodes of other elements are fixed.
 */
static void give_reasons_of_cells(const planish_plan *plan, uint8_t *reason) {
    const planish_cells *cells = &plan->cells;
    for (int64_t i = 0; i < plan->whole.n_nodes; i++)
        if (pl_follows(plan->role[i]))
            reason[i] = 0;
        else if ((plan->role[i] & PL_OF_OTHER) && reason[i] == PLANISH_HELD_UNUSED)
            reason[i] = PLANISH_HELD_FIXED;
    for (int64_t i = 0; i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        const int32_t *node = cells->node + cells->offset[i];
        const int is_smoothed = pl_is_smoothed(cells, i, plan->dim);
        for (int j = is_smoothed ? type->shape->n_corners : 0; is_smoothed && j < type->n_nodes;
             j++) {
            const uint8_t a = reason[node[type->between[j][0]]];
            const uint8_t b = reason[node[type->between[j][1]]];
            if (node[j] >= 0 && pl_follows(plan->role[node[j]]) && a && b)
                reason[node[j]] |= a | b;
        }
    }
}

int planish_plan_get_held(const planish_plan *plan, const double *coordinates, uint8_t *reason,
                          planish_error *error) {
    if (!plan || !reason)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "plan and reason must not be NULL");
    const pl_outside outside = pl_call_enter(plan->context);
    const int64_t n = plan->all->n_nodes;
    hold_search s = {.plan = plan,
                     .mesh = {.dim = plan->dim,
                              .n_nodes = n,
                              .n_elements = plan->all->n_elements,
                              .elements = plan->all->elements},
                     .node_of = plan->all == &plan->work ? plan->node_of : NULL,
                     .moves = pl_alloc(n, sizeof *s.moves),
                     .by_plan = pl_alloc(n, sizeof *s.by_plan),
                     .is_inside = pl_alloc(n, sizeof *s.is_inside),
                     .facts = pl_alloc_zero(n, sizeof *s.facts),
                     .part = pl_part_here()};
    int status = s.by_plan && s.moves && s.is_inside && s.facts
                     ? PLANISH_OK
                     : pl_fail_memory(error, "held nodes");
    if (!status) {
        take_facts_of_plan(&s);
        for (int64_t i = 0; i < n; i++)
            s.is_inside[i] = s.moves[i] == PL_INTERIOR;
        status = pl_incidence_create(&s.mesh, s.is_inside, plan->threads, &s.incidence, error);
    }
    if (!status && plan->work.corner)
        status = note_cell_facets(&s, coordinates, error);
    else if (!status)
        status = pl_facets_match(&s.mesh, &s.incidence, s.is_inside, plan->threads, note_facets, &s,
                                 error);
    if (!status && coordinates)
        status = note_doubled(&s, coordinates, error);
    if (!status && plan->scope == PL_SUBSET_ALONE)
        memset(reason, PLANISH_HELD_NOT_CHOSEN, (size_t)plan->whole.n_nodes);
    for (int64_t i = 0; !status && i < n; i++)
        reason[s.node_of ? s.node_of[i] : i] = s.moves[i] ? 0 : reason_of(&s, i);
    if (!status && plan->role)
        give_reasons_of_cells(plan, reason);
    pl_incidence_destroy(&s.incidence);
    pl_free(s.facts);
    pl_free(s.is_inside);
    pl_free(s.by_plan);
    pl_free(s.moves);
    pl_call_leave(&outside);
    return status;
}
