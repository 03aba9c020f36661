/* tangle: find what is tangled, what of that cannot be helped, and the patch of nodes around what
 * is tangled. */
#include "improve/untangle/tangle.h"
#include "improve/untangle/proofs.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "improve/patch.h"
#include "plan/ghosts.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 256 }; /* stars that one thread takes at a time */

static const char CANNOT_BE_HELPED[] = "the elements that cannot be helped";

/* ---- elements ------------------------------------------------------------------------------ */

/** Count the tangled cells of all processes. */
static void count_tangled(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    const uint8_t *is_counted = plan->work.is_counted;
    t->n_tangled = 0;
    for (int64_t c = 0; c < pl_view_cells(&plan->work); c++)
        t->n_tangled += pl_tangle_is_tangled(t, c) && (!is_counted || is_counted[c]);
    pl_parts_add(&t->n_tangled, 1);
}

int pl_tangle_is_tangled(const pl_tangle *t, int64_t cell) {
    const pl_view *mesh = &t->run->plan->work;
    const int64_t begin = pl_first_of_cell(mesh, cell), end = pl_first_of_cell(mesh, cell + 1);
    int is_tangled = t->is_inside && t->is_inside[begin];
    for (int64_t i = begin; i < end; i++)
        is_tangled |= t->state[i] == PL_TANGLED;
    return is_tangled;
}

/** Find the cells that are invalid inside: with positive corners and a node that moves. */
static void find_inside(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    const pl_watch *watch = &t->run->watch;
    memset(t->is_inside, 0, (size_t)plan->work.n_elements);
    for (int64_t w = 0; w < watch->n; w++) {
        const int64_t cell = pl_watch_cell(watch, w);
        const int64_t first = pl_first_of_cell(&plan->work, cell);
        const int64_t end = pl_first_of_cell(&plan->work, cell + 1);
        int is_sound = 1, moves = 0;
        for (int64_t i = first; !pl_watch_is_valid(watch, w) && i < end; i++) {
            is_sound &= t->state[i] == PLANISH_VOLUME_MET;
            for (int j = 0; j <= plan->dim; j++)
                moves |= t->star_of[pl_plan_inner(plan, i, j)] >= 0;
        }
        t->is_inside[first] = is_sound && moves;
    }
}

void pl_tangle_find(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    pl_objective_problem problem = pl_run_objective_problem(t->run);
    problem.min_volume = t->guard.min_volume;
    if (!t->guard.link_min_volume)
        problem.mesh.min_volume = NULL;
    pl_find_tangled(&problem, t->state);
    for (int64_t i = 0; t->is_given_up && i < plan->work.n_elements; i++)
        if (t->is_given_up[i] && t->state[i] == PL_TANGLED)
            t->state[i] = PL_GIVEN_UP;
    if (t->is_inside)
        find_inside(t);
    count_tangled(t);
}

/** Give up whole cells: those that a corner is given up of, with their other corners. These are
 *  skipped if they are not positive; the others stay as they are. */
static int give_up_cells(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    const pl_view *mesh = &plan->work;
    int32_t *star_of = pl_alloc(mesh->n_nodes, sizeof *star_of);
    int64_t *next = pl_alloc(plan->interior.stars.n_stars, sizeof *next); /* facet of each star */
    if (star_of && next) {
        pl_plan_number_stars(plan, star_of);
        memcpy(next, plan->interior.stars.link_offset,
               (size_t)plan->interior.stars.n_stars * sizeof *next);
    }
    for (int64_t c = 0; star_of && next && c < mesh->n_cells; c++) {
        const int64_t begin = mesh->cell_begin[c], end = mesh->cell_begin[c + 1];
        int is_any = 0;
        for (int64_t i = begin; i < end; i++)
            is_any |= t->is_given_up[i];
        for (int64_t i = begin; i < end; i++)
            for (int j = 0; j <= plan->dim; j++) {
                const int32_t star = star_of[pl_plan_inner(plan, i, j)];
                if (star < 0)
                    continue;
                if (is_any && t->state[i] == PL_TANGLED)
                    t->link_skip[next[star]] = 1;
                next[star]++;
            }
        for (int64_t i = begin; is_any && i < end; i++) {
            t->is_given_up[i] = 1;
            t->state[i] = t->state[i] == PL_TANGLED ? PL_GIVEN_UP : t->state[i];
        }
    }
    pl_free(star_of);
    pl_free(next);
    return star_of && next;
}

/** Note what is given up, by the elements' states and the stars' roles [n_links]. */
static int note_given_up(pl_tangle *t, const uint8_t *roles, planish_error *error) {
    const planish_plan *plan = t->run->plan;
    const int64_t n_links = plan->interior.stars.link_offset[plan->interior.stars.n_stars];
    t->is_given_up = pl_alloc(plan->work.n_elements, sizeof *t->is_given_up);
    t->link_skip = pl_alloc(n_links, sizeof *t->link_skip);
    if (!t->is_given_up || !t->link_skip)
        return pl_fail_memory(error, CANNOT_BE_HELPED);
    for (int64_t i = 0; i < n_links; i++)
        t->link_skip[i] = roles[i] == PL_PROOF_GIVEN_UP;
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        t->is_given_up[i] = t->state[i] == PL_GIVEN_UP; /* PLANISH_VOLUME_INFEASIBLE, too */
    if (plan->work.corner && !give_up_cells(t))
        return pl_fail_memory(error, CANNOT_BE_HELPED);
    count_tangled(t);
    return PLANISH_OK;
}

/** Give up the elements that are proved infeasible: with all nodes of a part of the mesh whose
 *  boundary encloses nothing; without a free node; and as many of those that contradict each other
 *  as must be. */
static int give_up(pl_tangle *t, planish_error *error) {
    const planish_plan *plan = t->run->plan;
    pl_infeasible found = {0, 0};
    pl_stop_check limit = pl_run_stop_check(t->run);
    uint8_t *roles = NULL; /* [n_links] pl_proof_role */
    int status = PLANISH_OK;
    if (!(t->guard.min_volume > 0) && !t->guard.link_min_volume && !pl_part_here()) {
        t->node_is_given_up = pl_alloc_zero(plan->work.n_nodes, sizeof *t->node_is_given_up);
        if (!t->node_is_given_up)
            return pl_fail_memory(error, CANNOT_BE_HELPED);
        status = pl_mark_enclosed(plan, plan->scratch.coordinates, t->state, t->node_is_given_up,
                                  &t->run->result->n_not_enclosed, error);
    }
    if (!status)
        status = pl_mark_infeasible(plan, &t->problem, t->state, &limit, &found, &roles, error);
    t->stopped = limit.answer;
    if (!status && !t->stopped && pl_parts_any(found.n > 0)) {
        status = pl_send_given_up(plan, roles, t->state, error);
        if (!status)
            status = note_given_up(t, roles, error);
    }
    pl_free(roles);
    return status;
}

/* ---- rounds --------------------------------------------------------------------------------- */

int pl_tangle_begin_rounds(pl_tangle *t, planish_error *error) {
    const planish_plan *plan = t->run->plan;
    const int64_t m = plan->work.n_elements;
    const int64_t n_links = plan->interior.stars.link_offset[plan->interior.stars.n_stars];
    t->is_given_up = t->is_given_up ? t->is_given_up : pl_alloc_zero(m, sizeof *t->is_given_up);
    t->link_skip = t->link_skip ? t->link_skip : pl_alloc_zero(n_links, sizeof *t->link_skip);
    t->is_inside = pl_alloc_zero(m, sizeof *t->is_inside);
    t->is_marked = pl_alloc_zero(m, sizeof *t->is_marked);
    if (!t->is_given_up || !t->link_skip || !t->is_inside || !t->is_marked)
        return pl_fail_memory(error, "the rounds of untangling");
    t->asked.link_skip = t->link_skip;
    for (int64_t i = 0; i < m; i++)
        t->is_given_up[i] |= t->state[i] == PL_TANGLED;
    return give_up_cells(t) ? PLANISH_OK : pl_fail_memory(error, CANNOT_BE_HELPED);
}

int pl_tangle_add_rows(pl_tangle *t, int64_t *n, planish_error *error) {
    const planish_plan *plan = t->run->plan;
    *n = 0;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        *n += t->is_inside[i] && !t->is_marked[i];
        t->is_marked[i] |= t->is_inside[i];
    }
    if (*n == 0)
        return PLANISH_OK;
    pl_marked_destroy(&t->marked);
    const int status = pl_marked_make(&t->run->watch, t->is_marked, 1, &t->marked, error);
    t->marked.in_patch = t->in_patch;
    t->marked.size = t->asked.size;
    if (!status) {
        pl_marked_use(&t->marked, &t->problem);
        return PLANISH_OK;
    }
    t->problem.more = NULL; /* and all goes on without */
    t->problem.scratch = t->run->problem.scratch;
    t->problem.scratch_stride = t->run->problem.scratch_stride;
    return status;
}

/* ---- the patch ----------------------------------------------------------------------------- */

/** End a ring: ghosts are in the patch where their processes have marked them. */
static void update_ghosts(pl_tangle *t) {
    for (int64_t i = 0; i < t->n_ghosts; i++)
        t->was_in_patch[i] = t->in_patch[t->ghost[i]];
    pl_ghosts_update(t->run->plan, t->in_patch, 1);
}

/** Mark a free node, and queue its star, unless that has been done. */
static void mark_node(pl_tangle *t, int32_t node, int64_t *n) {
    if (t->in_patch[node] || t->star_of[node] < 0)
        return;
    t->in_patch[node] = 1;
    t->queue[(*n)++] = t->star_of[node];
}

/** Mark the free nodes in so many rings around those that are marked. */
static void mark_rings(pl_tangle *t, int rings) {
    const planish_plan *plan = t->run->plan;
    const pl_stars *stars = &plan->interior.stars;
    const pl_ghosts *g = &plan->ghosts;
    int64_t n = 0;
    /* The first ring: all stars beside a marked node, which may be a held one. */
    for (int64_t s = 0; s < stars->n_stars; s++) {
        int beside = 0;
        for (int64_t i = stars->ring_offset[s];
             !t->in_patch[plan->interior.centre[s]] && !beside && i < stars->ring_offset[s + 1];
             i++)
            beside = t->in_patch[stars->ring[i]];
        if (beside)
            t->queue[n++] = (int32_t)s;
    }
    for (int64_t i = 0; i < n; i++)
        t->in_patch[plan->interior.centre[t->queue[i]]] = 1;
    update_ghosts(t);
    /* The others, breadth first; around ghosts that the last ring has marked in their processes,
     * too. */
    for (int64_t begin = 0, end = n; --rings > 0 && pl_parts_any(begin < end); end = n) {
        for (; begin < end; begin++)
            for (int64_t i = stars->ring_offset[t->queue[begin]];
                 i < stars->ring_offset[t->queue[begin] + 1]; i++)
                mark_node(t, stars->ring[i], &n);
        for (int64_t i = 0; i < t->n_ghosts; i++) {
            const int32_t node = g->node[t->ghost[i]];
            if (!t->in_patch[t->ghost[i]] || t->was_in_patch[i])
                continue;
            for (int64_t k = g->offset[node]; k < g->offset[node + 1]; k++)
                mark_node(t, g->neighbour[k], &n);
        }
        update_ghosts(t);
    }
}

void pl_tangle_mark(pl_tangle *t, int rings) {
    const planish_plan *plan = t->run->plan;
    memset(t->in_patch, 0, (size_t)plan->work.n_nodes);
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        for (int j = 0; t->state[i] == PL_TANGLED && j <= plan->dim; j++)
            t->in_patch[pl_plan_inner(plan, i, j)] = 1;
    for (int64_t c = 0; t->is_inside && c < plan->work.n_cells; c++)
        for (int64_t i = plan->work.cell_begin[c];
             t->is_inside[plan->work.cell_begin[c]] && i < plan->work.cell_begin[c + 1]; i++)
            for (int j = 0; j <= plan->dim; j++)
                t->in_patch[pl_plan_inner(plan, i, j)] = 1;
    pl_ghosts_update(plan, t->in_patch, 1);
    if (rings > 0)
        mark_rings(t, rings);
    t->n_patch = 0;
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int32_t node = plan->inner[i];
        t->in_patch[node] = t->in_patch[node] && plan->work.mobility[i] == PL_INTERIOR &&
                            !pl_star_is_held(&t->guard, node, plan->dim) &&
                            !(t->node_is_given_up && t->node_is_given_up[node]);
        t->n_patch += t->in_patch[node] && !(t->is_ghost && t->is_ghost[node]);
    }
    pl_parts_add(&t->n_patch, 1);
}

/* ---- energy -------------------------------------------------------------------------------- */

static void add_energy(pl_star_energy *energy, pl_star_energy *part) {
    pl_sum_merge(&energy->sum, &part->sum);
    energy->least = fmin(energy->least, part->least);
    energy->tangled += part->tangled;
}

static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    pl_tangle *t = context;
    const planish_plan *plan = t->run->plan;
    pl_star_energy found = plan->kernel->guarded->energy[plan->dim - 2](
        &t->problem, begin, end, pl_star_scratch_of(&t->problem, thread),
        t->slope ? t->slope + begin : NULL);
    add_energy(&t->of_thread[thread], &found);
}

void pl_tangle_measure(pl_tangle *t, pl_star_slope *slope) {
    static const pl_star_energy none = {.least = INFINITY};
    const planish_plan *plan = t->run->plan;
    for (int i = 0; i < plan->threads; i++)
        t->of_thread[i] = none;
    t->slope = slope;
    pl_parallel_for(plan->threads, plan->interior.stars.n_stars, CHUNK, measure_chunk, t);
    t->energy = none;
    for (int i = 0; i < plan->threads; i++)
        add_energy(&t->energy, &t->of_thread[i]);
    pl_parts_add_sums(&t->energy.sum, 1);
    pl_parts_smallest(&t->energy.least, 1);
    pl_parts_add(&t->energy.tangled, 1);
}

double pl_tangle_energy(const pl_tangle *t) {
    return pl_sum_value(&t->energy.sum);
}

/* ---- all of it ----------------------------------------------------------------------------- */

/** List the ghosts, and those of them that may be in the patch. Returns 0 without memory. */
static int list_ghosts(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    const planish_part *part = plan->context->part;
    if (!part)
        return 1;
    const int64_t n = pl_parts_ghosts(plan->work.n_nodes);
    t->is_ghost = pl_alloc_zero(plan->work.n_nodes, sizeof *t->is_ghost);
    t->ghost = pl_alloc(n, sizeof *t->ghost);
    t->was_in_patch = pl_alloc_zero(n, sizeof *t->was_in_patch);
    if (!t->is_ghost || !t->ghost || !t->was_in_patch)
        return 0;
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        if (part->node_role[i] != PLANISH_ROLE_GHOST)
            continue;
        t->is_ghost[plan->inner[i]] = 1;
        if (plan->work.mobility[i] == PL_INTERIOR)
            t->ghost[t->n_ghosts++] = plan->inner[i];
    }
    return 1;
}

int pl_tangle_create(pl_run *r, int raises, pl_tangle *t, planish_error *error) {
    const planish_plan *plan = r->plan;
    *t = (pl_tangle){.run = r, .problem = r->problem, .guard = r->guard.star};
    t->guard.ratio_weight = 1;
    if (!raises) {
        t->guard.min_volume = 0;
        t->guard.link_min_volume = NULL;
    }
    t->problem.guard = &t->guard;
    t->problem.limits = pl_star_no_limits();
    t->problem.calm = 0;
    t->state = pl_alloc(plan->work.n_elements, sizeof *t->state);
    if (!t->state)
        return pl_fail_memory(error, "the tangled elements");
    pl_tangle_find(t);
    const int status = t->n_tangled > 0 ? give_up(t, error) : PLANISH_OK;
    if (status || (t->n_tangled == 0 && !pl_tangle_has_rounds(t)) || t->stopped)
        return status;
    t->in_patch = pl_alloc_zero(plan->work.n_nodes, sizeof *t->in_patch);
    t->size = pl_alloc_zero(plan->work.n_nodes, sizeof *t->size);
    t->before = pl_alloc(plan->work.n_nodes * plan->dim, sizeof *t->before);
    t->begin = pl_alloc(plan->work.n_nodes * plan->dim, sizeof *t->begin);
    t->star_of = pl_alloc(plan->work.n_nodes, sizeof *t->star_of);
    t->queue = pl_alloc(plan->interior.stars.n_stars, sizeof *t->queue);
    t->of_thread = pl_alloc(plan->threads, sizeof *t->of_thread);
    if (!t->in_patch || !t->size || !t->before || !t->begin || !t->star_of || !t->queue ||
        !t->of_thread || !list_ghosts(t))
        return pl_fail_memory(error, "untangling");
    memcpy(t->begin, plan->scratch.coordinates,
           (size_t)(plan->work.n_nodes * plan->dim) * sizeof *t->begin);
    pl_plan_number_stars(plan, t->star_of);
    t->scale = pl_box_of_fixed(plan).scale;
    t->asked = (pl_star_untangling){t->in_patch, t->size, t->link_skip, 1, 1};
    return PLANISH_OK;
}

void pl_tangle_destroy(pl_tangle *t) {
    pl_free(t->state);
    pl_free(t->is_given_up);
    pl_free(t->node_is_given_up);
    pl_free(t->link_skip);
    pl_free(t->is_inside);
    pl_free(t->is_marked);
    pl_marked_destroy(&t->marked);
    pl_free(t->in_patch);
    pl_free(t->size);
    pl_free(t->before);
    pl_free(t->begin);
    pl_free(t->star_of);
    pl_free(t->is_ghost);
    pl_free(t->ghost);
    pl_free(t->was_in_patch);
    pl_free(t->queue);
    pl_free(t->of_thread);
    *t = (pl_tangle){0};
}
