/* ghosts: nodes that other processes move. */
#include "plan/plan.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "plan/ghosts.h"
#include "quality/measure.h"

#include <string.h>

/* ---- their neighbours ----------------------------------------------------------------------- */

/** List the nodes of this process that an element joins to a ghost; often more than once. */
static int find_neighbours(const planish_plan *plan, const planish_mesh *mesh, pl_ghosts *g,
                           planish_error *error) {
    const int corners = mesh->dim + 1;
    const uint8_t *role = mesh->part->node_role;
    g->offset = pl_alloc_zero(mesh->n_nodes + 1, sizeof *g->offset);
    if (!g->offset)
        return pl_fail_memory(error, "the neighbours of ghosts");
    for (int pass = 0; pass < 2; pass++) { /* count; list */
        if (pass == 1) {
            g->neighbour =
                pl_alloc(pl_prefix_sum(1, mesh->n_nodes, g->offset), sizeof *g->neighbour);
            if (!g->neighbour)
                return pl_fail_memory(error, "the neighbours of ghosts");
        }
        for (int64_t i = 0; i < mesh->n_elements * corners; i++) {
            const int32_t ghost = mesh->elements[i];
            const int32_t *node = mesh->elements + i / corners * corners;
            for (int k = 0; role[ghost] == PLANISH_ROLE_GHOST && k < corners; k++) {
                if (role[node[k]] == PLANISH_ROLE_GHOST)
                    continue;
                if (pass == 1)
                    g->neighbour[g->offset[ghost]] = plan->inner[node[k]];
                g->offset[ghost]++;
            }
        }
    }
    /* Each offset is now the next ghost's. */
    memmove(g->offset + 1, g->offset, (size_t)mesh->n_nodes * sizeof *g->offset);
    g->offset[0] = 0;
    return PLANISH_OK;
}

/* ---- the plan's part ------------------------------------------------------------------------ */

static int64_t message_size(const planish_plan *plan) {
    return plan->dim * (int64_t)sizeof(double) + 1;
}

int pl_ghosts_create(planish_plan *plan, const planish_mesh *mesh, const int32_t *order,
                     planish_error *error) {
    pl_ghosts *g = &plan->ghosts;
    pl_plan_scratch *scratch = &plan->scratch;
    if (!mesh->part)
        return PLANISH_OK;
    const pl_visits *visits[] = {&plan->interior, &plan->sliding};
    int64_t most = 0; /* SHARED stars of a colour */
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < visits[i]->n_colours; c++) {
            const int64_t n = visits[i]->inside_begin[c] - visits[i]->colour_begin[c];
            most = n > most ? n : most;
        }
    g->node = pl_alloc(mesh->n_nodes, sizeof *g->node);
    g->is_movable = pl_alloc(mesh->n_elements, sizeof *g->is_movable);
    scratch->before = pl_alloc(most * mesh->dim, sizeof *scratch->before);
    scratch->moved = pl_alloc(most, sizeof *scratch->moved);
    scratch->message = pl_alloc(most, (size_t)message_size(plan));
    if (!g->node || !g->is_movable || !scratch->before || !scratch->moved || !scratch->message)
        return pl_fail_memory(error, "the ghosts");
    memcpy(g->node, order, (size_t)mesh->n_nodes * sizeof *g->node);
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const int32_t *node = mesh->elements + i * (mesh->dim + 1);
        const int movable = pl_any_moves(plan->work.mobility, node, mesh->dim + 1);
        g->is_movable[i] = (uint8_t)(mesh->part->is_counted[i] ? movable : PL_ELSEWHERE);
    }
    return find_neighbours(plan, mesh, g, error);
}

void pl_ghosts_destroy(pl_ghosts *g) {
    pl_free(g->node);
    pl_free(g->offset);
    pl_free(g->neighbour);
    pl_free(g->is_movable);
    *g = (pl_ghosts){0};
}

/* ---- news ------------------------------------------------------------------------------------ */

static double *place_of(const planish_plan *plan, int64_t inner) {
    return plan->scratch.coordinates + inner * plan->dim;
}

void pl_ghosts_note(const planish_plan *plan, const pl_visits *visits, int64_t begin, int64_t end) {
    const int dim = plan->dim;
    for (int64_t s = begin; s < end; s++)
        memcpy(plan->scratch.before + (s - begin) * dim, place_of(plan, visits->centre[s]),
               (size_t)dim * sizeof(double));
}

void pl_ghosts_send(const planish_plan *plan, const pl_visits *visits, int64_t begin, int64_t end) {
    const size_t size = (size_t)plan->dim * sizeof(double);
    const pl_plan_scratch *scratch = &plan->scratch;
    int64_t n = 0;
    for (int64_t s = begin; s < end; s++) {
        const int32_t inner = visits->centre[s];
        const double *place = place_of(plan, inner);
        if (memcmp(place, scratch->before + (s - begin) * plan->dim, size) == 0)
            continue;
        char *message = scratch->message + n * message_size(plan);
        memcpy(message, place, size);
        message[size] = (char)scratch->changed[inner];
        scratch->moved[n++] = plan->ghosts.node[inner];
    }
    pl_parts_send(scratch->moved, n, scratch->message, message_size(plan));
}

/** Wake the neighbours of a ghost; other nodes have no list of neighbours. is_bad: its star is
 *  bad (move_node). */
static void wake_neighbours(const planish_plan *plan, int32_t ghost, int is_bad) {
    const pl_ghosts *g = &plan->ghosts;
    for (int64_t k = g->offset[ghost]; k < g->offset[ghost + 1]; k++)
        if (is_bad || plan->scratch.changed[g->neighbour[k]] & PL_BAD)
            plan->scratch.changed[g->neighbour[k]] = PL_CHANGED;
}

/** Take the news of a ghost. */
static void take_ghost(int32_t ghost, const void *value, void *taker) {
    const planish_plan *plan = taker;
    const size_t size = (size_t)plan->dim * sizeof(double);
    memcpy(place_of(plan, plan->inner[ghost]), value, size);
    const int flags = ((const char *)value)[size];
    if (flags & PL_TOLD)
        wake_neighbours(plan, ghost, flags & PL_BAD);
}

void pl_ghosts_wake(const planish_plan *plan, const double *before) {
    const size_t size = (size_t)plan->dim * sizeof(double);
    for (int64_t i = 0; plan->context->part && i < plan->work.n_nodes; i++) {
        const int64_t inner = plan->inner[i];
        if (memcmp(place_of(plan, inner), before + inner * plan->dim, size) != 0)
            wake_neighbours(plan, (int32_t)i, 1);
    }
}

void pl_ghosts_receive(const planish_plan *plan) {
    pl_parts_receive(take_ghost, (void *)plan);
}

void pl_ghosts_update(const planish_plan *plan, void *values, int64_t size) {
    pl_parts_update(plan->inner, values, size);
}
