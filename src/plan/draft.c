/* draft: find the free nodes of a plan, order and colour them, gather their stars. */
#include "plan/draft.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "geometry/fetch.h"
#include "geometry/simplex.h"
#include "shape/curved.h"

#include <inttypes.h>
#include <string.h>

enum {
    CHUNK_NODES = 1024,
    CHUNK_RINGS = 2048,
    AHEAD = 16 /* nodes that are asked for before they are written */
};

static void candidates_destroy(pl_candidates *c) {
    pl_rings_destroy(&c->rings);
    pl_free(c->node);
    pl_free(c->colour);
    pl_free(c->star_of);
}

void pl_draft_destroy(pl_draft *d) {
    pl_dense_destroy(&d->dense);
    pl_subset_destroy(&d->subset);
    pl_submesh_destroy(&d->submesh);
    pl_incidence_destroy(&d->incidence);
    pl_boundary_destroy(&d->boundary);
    candidates_destroy(&d->interior);
    candidates_destroy(&d->sliding);
    pl_periodic_destroy(&d->periodic);
    pl_incidence_destroy(&d->around);
    pl_free(d->number_of);
    pl_free(d->is_selected);
    pl_free(d->is_paired);
    pl_free(d->slides);
    pl_free(d->order);
    pl_free(d->count);
}

/* ---- free nodes --------------------------------------------------------------------------- */

/** Mark how nodes are used, and those that may be free: a node can be free if it has elements, is
 *  selected, is not known to be on the boundary, and its constraint says so. */
static void mark_candidates(void *context, int64_t begin, int64_t end, int thread) {
    const pl_draft *d = context;
    const uint8_t *constraint = d->mesh->constraint, *role = d->plan->role;
    int64_t unused = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int used = d->incidence.offset[i + 1] > d->incidence.offset[i];
        const int is_chosen = !d->is_selected || d->is_selected[i];
        const int is_paired = d->is_paired && d->is_paired[i];
        const int of_caller = constraint ? constraint[i] : PLANISH_CONSTRAINT_FREE;
        d->plan->is_used[i] =
            used ? (uint8_t)(PL_USED |
                             (of_caller == PLANISH_CONSTRAINT_FIXED ? PL_FIXED_BY_CALLER : 0) |
                             (is_paired ? PL_IN_PAIR : 0) | (is_chosen ? 0 : PL_NOT_CHOSEN))
                 : 0;
        d->mobility[i] = used && pl_is_own(d->mesh->part, i) && is_chosen && !is_paired &&
                         of_caller == PLANISH_CONSTRAINT_FREE && !d->boundary.on_boundary[i];
        unused += !used && !(role && role[pl_plan_node(d->plan, i)]);
    }
    __atomic_fetch_add(&d->plan->info.n_unused, unused, __ATOMIC_RELAXED);
}

/** Number the nodes inside, along the curve, and count the candidates among them. The numbers are
 *  written all over memory. */
static void number_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const pl_draft *d = context;
    int64_t found = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        if (i + AHEAD < end)
            pl_fetch_to_write(&d->plan->inner[d->order[i + AHEAD]]);
        d->plan->inner[d->order[i]] = (int32_t)i;
        found += d->mobility[d->order[i]];
    }
    d->count[begin / CHUNK_NODES] = found;
}

static void list_candidates(void *context, int64_t begin, int64_t end, int thread) {
    const pl_draft *d = context;
    int64_t n = d->count[begin / CHUNK_NODES];
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (d->mobility[d->order[i]])
            d->interior.node[n++] = d->order[i];
}

/** Find the candidates of the interior, and by their rings which of them are inside. */
static int make_rings(pl_draft *d, planish_error *error) {
    planish_plan *plan = d->plan;
    const int64_t n = plan->work.n_nodes;
    plan->info.n_unused = 0;
    pl_parallel_for(plan->threads, n, CHUNK_NODES, mark_candidates, d);
    pl_parallel_for(pl_paying_threads(plan->threads, n), n, CHUNK_NODES, number_nodes, d);
    d->interior.n = pl_prefix_sum(plan->threads, (n + CHUNK_NODES - 1) / CHUNK_NODES, d->count);
    pl_parallel_for(plan->threads, n, CHUNK_NODES, list_candidates, d);
    const int status = pl_rings_create(d->mesh, &d->incidence, d->boundary.sign, plan->work.corner,
                                       d->mobility, d->interior.node, d->interior.n, 0,
                                       plan->threads, &d->interior.rings, error);
    pl_parts_update(NULL, d->mobility, sizeof *d->mobility);
    return status ? status : pl_parts_check(error);
}

/** Find the boundary, the free nodes and their rings. Usually the measures tell the orientation;
 *  then links tell which nodes are inside, and only the facets between others need to be looked at:
 *  none, if only few nodes are asked for. */
static int find_free(pl_draft *d, planish_error *error) {
    planish_plan *plan = d->plan;
    pl_boundary *boundary = &d->boundary;
    int status = PLANISH_OK;
    const int guessed = boundary->is_guess;
    if (guessed)
        status = make_rings(d, error);
    if (!status && !plan->work.corner &&
        !(guessed && d->is_selected)) /* of a subset not all facets are known */
        status = pl_boundary_find(d->mesh, &d->incidence, guessed ? d->mobility : NULL,
                                  plan->threads, boundary, error);
    if (!status && !boundary->is_guess) {
        pl_rings_destroy(&d->interior.rings);
        if (plan->is_selective)
            status = pl_draft_select(d, error);
        if (!status)
            status = make_rings(d, error);
    }
    plan->work.sign = boundary->sign;
    boundary->sign = NULL;
    if (status || boundary->n_wrapped == 0)
        return status;
    /* List the elements that wrap around. */
    plan->wrapped = pl_alloc(boundary->n_wrapped, sizeof *plan->wrapped);
    if (!plan->wrapped)
        return pl_fail_memory(error, "the elements that wrap around");
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        if (!(boundary->flags[i] & PL_WRAPPED))
            continue;
        plan->wrapped[plan->n_wrapped++] = (int32_t)i;
        for (int j = 0; j <= plan->dim; j++)
            plan->is_used[d->mesh->elements[i * (plan->dim + 1) + j]] |= PL_OF_WRAPPED;
    }
    return PLANISH_OK;
}

/* ---- visiting order ----------------------------------------------------------------------- */

/** Visits being put in order. */
typedef struct arrangement {
    const planish_plan *plan;
    const planish_part *part;
    const pl_candidates *c;
    pl_visits *visits;
    int n_groups; /* 2 n_colours */
    int64_t row;
    int64_t *next; /* [chunks][row] next visit of each group in each chunk; counts at first */
} arrangement;

/** Group of ring r: within a colour, nodes that other processes wait for come first. */
static int group_of(const arrangement *a, int64_t r) {
    const planish_part *part = a->part;
    const int waits = !part || part->node_role[a->c->node[r]] != PLANISH_ROLE_SHARED;
    return 2 * a->c->colour[r] + waits;
}

static void count_colours(void *context, int64_t begin, int64_t end, int thread) {
    const arrangement *a = context;
    int64_t *count = a->next + begin / CHUNK_RINGS * a->row;
    (void)thread;
    for (int g = 0; g < a->n_groups; g++)
        count[g] = 0;
    for (int64_t r = begin; r < end; r++)
        if (a->c->colour[r] >= 0)
            count[group_of(a, r)]++;
}

static void list_visits(void *context, int64_t begin, int64_t end, int thread) {
    const arrangement *a = context;
    int64_t *next = a->next + begin / CHUNK_RINGS * a->row;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        a->c->star_of[r] = -1;
        if (a->c->colour[r] < 0)
            continue;
        const int64_t place = next[group_of(a, r)]++;
        a->c->star_of[r] = (int32_t)place;
        a->visits->centre[place] = a->plan->inner[a->c->node[r]];
    }
}

/** Colour the rings and list their visits colour by colour, along the curve within each. apart: as
 *  the rings of c, with the other nodes that are to have another colour. */
static int order_visits(const planish_plan *plan, const pl_periodic *periodic, pl_candidates *c,
                        const pl_rings *apart, pl_visits *visits, planish_error *error) {
    static const char what[] = "the colours of nodes";
    arrangement a = {.plan = plan, .part = pl_part_here(), .c = c, .visits = visits};
    const int threads = plan->threads;
    const int64_t n_chunks = (c->n + CHUNK_RINGS - 1) / CHUNK_RINGS;
    c->colour = pl_alloc(c->n + pl_parts_ghosts(plan->work.n_nodes), sizeof *c->colour);
    c->star_of = pl_alloc(c->n, sizeof *c->star_of);
    visits->centre = pl_alloc(c->rings.n_free, sizeof *visits->centre);
    if (!c->colour || !c->star_of || !visits->centre)
        return pl_fail_memory(error, what);
    const int status = pl_colouring_create(
        apart, c->node, plan->node_of, periodic ? periodic->n_nodes : plan->work.n_nodes,
        periodic ? periodic->moves_with : NULL, threads, c->colour, &visits->n_colours, error);
    if (status)
        return status;
    visits->n_all = c->rings.n_free;
    pl_parts_add(&visits->n_all, 1);
    a.n_groups = 2 * visits->n_colours;
    a.row = pl_counts_row(a.n_groups);
    a.next = pl_alloc(n_chunks * a.row, sizeof *a.next);
    int64_t *begin = pl_alloc(a.n_groups + 1, sizeof *begin);
    visits->colour_begin = pl_alloc(visits->n_colours + 1, sizeof *visits->colour_begin);
    visits->inside_begin = pl_alloc(visits->n_colours, sizeof *visits->inside_begin);
    const int done = a.next && begin && visits->colour_begin && visits->inside_begin;
    if (done) {
        pl_parallel_for(threads, c->n, CHUNK_RINGS, count_colours, &a);
        pl_counts_to_places(threads, a.n_groups, n_chunks, a.next, begin);
        for (int i = 0; i <= visits->n_colours; i++)
            visits->colour_begin[i] = begin[2 * i];
        for (int i = 0; i < visits->n_colours; i++)
            visits->inside_begin[i] = begin[2 * i + 1];
        pl_parallel_for(pl_paying_threads(threads, c->n), c->n, CHUNK_RINGS, list_visits, &a);
    }
    pl_free(a.next);
    pl_free(begin);
    return done ? PLANISH_OK : pl_fail_memory(error, what);
}

/* ---- nodes that slide --------------------------------------------------------------------- */

static int may_slide(const planish_mesh *mesh, int64_t node) {
    return mesh->constraint && mesh->constraint[node] >= PLANISH_CONSTRAINT_ON_PLANE;
}

/** Check that a node that is to slide on a patch or curve of the shape is on one. */
static int check_class(const pl_draft *d, int64_t node, planish_constraint constraint,
                       planish_error *error) {
    const planish_shape *shape = d->options->shape;
    const int is_curve = constraint == PLANISH_CONSTRAINT_ON_CURVE;
    const int64_t given = pl_plan_node(d->plan, node);
    if (!shape || constraint < PLANISH_CONSTRAINT_ON_PATCH ||
        (shape->number[given] >= 0 &&
         shape->node_class[shape->number[given]] == (is_curve ? PL_ON_CURVE : PL_ON_PATCH)))
        return PLANISH_OK;
    return pl_fail_at(
        error, PLANISH_ERROR_ARGUMENT, -1, given,
        "mesh.constraint of node %" PRId64
        " is PLANISH_CONSTRAINT_ON_%s, but it is on no %s of options.shape; give what "
        "planish_find_slides finds with this shape",
        given, is_curve ? "CURVE" : "PATCH", is_curve ? "curve" : "patch");
}

/** Check how the nodes may move; count those that slide. */
static int check_constraints(const pl_draft *d, int64_t *n_sliding, planish_error *error) {
    const planish_plan *plan = d->plan;
    const planish_mesh *mesh = d->mesh;
    double unit[3];
    for (int64_t i = 0; mesh->constraint && i < mesh->n_nodes; i++) {
        const int constraint = mesh->constraint[i];
        if (constraint > PLANISH_CONSTRAINT_ON_CURVE)
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, pl_plan_node(plan, i),
                              "mesh.constraint of node %" PRId64
                              " is %d; give a planish_constraint, 0 to %d",
                              pl_plan_node(plan, i), constraint, PLANISH_CONSTRAINT_ON_CURVE);
        const int status = check_class(d, i, (planish_constraint)constraint, error);
        if (status)
            return status;
        *n_sliding += may_slide(mesh, i);
        if ((constraint == PLANISH_CONSTRAINT_ON_PLANE ||
             constraint == PLANISH_CONSTRAINT_ON_LINE) &&
            !(mesh->direction && pl_unit(mesh->dim, mesh->direction + i * mesh->dim, unit)))
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, pl_plan_node(plan, i),
                              "node %" PRId64
                              " slides, but mesh.direction has none for it; give the normal of its "
                              "plane, or the direction of its line",
                              pl_plan_node(plan, i));
    }
    return PLANISH_OK;
}

/** Whether a corner of a cell of the caller's may slide though the middle of an edge, face or the cell is not
 *  where that of a straight one would be. On a shape of curved facets a mid goes along. In the plane of a face
 *  its middle may be anywhere: it stays there when the corner moves in that plane. */
static int slides_all_the_same(const pl_draft *d, int64_t cell, const pl_cell_type *type,
                               int32_t corner, int middle) {
    const planish_shape *shape = d->options->shape;
    const uint8_t constraint = d->mesh->constraint[corner];
    if (shape && shape->whole && constraint >= PLANISH_CONSTRAINT_ON_PATCH)
        return 1;
    return __builtin_popcount(pl_cell_parents(type, middle)) == 4 &&
           (constraint == PLANISH_CONSTRAINT_ON_PLANE ||
            constraint == PLANISH_CONSTRAINT_ON_LINE) &&
           !pl_is_off_face(d->given, cell, middle, d->options->rounding);
}

/** Hold the ends of a curved edge, or corners of a curved face, that may slide: the boundary would
 *  change its shape. One with an end that goes anywhere is inside, and does not matter, nor does the
 *  middle of a cell. node: corners of the cell. */
static void hold_ends(pl_draft *d, int64_t cell, const pl_cell_type *type, const int32_t *node,
                      int middle) {
    const int n = type->shape->n_corners;
    const uint8_t parents = pl_cell_parents(type, middle);
    int is_inside = __builtin_popcount(parents) == n;
    for (int j = 0; j < n; j++)
        is_inside |= (parents >> j & 1) && d->mobility[node[j]] == PL_INTERIOR;
    for (int j = 0; j < n && !is_inside; j++)
        if ((parents >> j & 1) && d->slides[node[j]] &&
            !slides_all_the_same(d, cell, type, node[j], middle)) {
            d->slides[node[j]] = 0;
            d->plan->is_used[node[j]] |= PL_FIXED_BY_CALLER;
        }
}

/** Hold the nodes that cannot slide because of curved edges. */
static void hold_curved(pl_draft *d) {
    const planish_plan *plan = d->plan;
    for (int64_t i = 0; plan->cells.n > 0 && i < plan->work.n_elements; i++) {
        if (plan->work.corner && pl_corner_index(plan->work.corner[i]) > 0)
            continue;
        const int64_t cell = pl_plan_element(plan, i);
        const pl_cell_type *type = pl_cell_type_of(plan->cells.type[cell]);
        const int n_corners = type->shape->n_corners;
        const int32_t *node = plan->work.corner ? plan->cells.node + plan->cells.offset[cell]
                                                : d->mesh->elements + i * (plan->dim + 1);
        if (type->order == 1 || !pl_any_moves(d->slides, node, n_corners))
            continue;
        const int curved = pl_curved_edges(d->given, cell, d->options->rounding);
        for (int e = 0; curved >> e; e++)
            if (curved >> e & 1)
                hold_ends(d, cell, type, node, n_corners + e);
    }
}

/** Give the copies of elements the targets of these. */
static int copy_targets(planish_plan *plan, const pl_periodic *periodic, planish_error *error) {
    if (!plan->work.target)
        return PLANISH_OK;
    pl_target *target = pl_alloc(periodic->n_elements, sizeof *target);
    if (!target)
        return pl_fail_memory(error, "the targets of the elements");
    for (int64_t i = 0; i < periodic->n_elements; i++)
        target[i] = plan->work.target[periodic->source[i]];
    pl_free((void *)plan->work.target);
    plan->work.target = target;
    return PLANISH_OK;
}

/** Find the nodes that may slide, and the mesh that they are in: with copies where some of them
 * move together. */
static int prepare_periodic(pl_draft *d, planish_mesh *around, planish_error *error) {
    planish_plan *plan = d->plan;
    const planish_mesh *mesh = d->mesh;
    pl_periodic *periodic = &d->periodic;
    /* A node of a group is chosen if one of its group is: handed on from pair to pair. */
    for (int changed = d->is_selected != NULL; changed;) {
        changed = 0;
        for (int64_t i = 0; i < mesh->n_periodic; i++) {
            uint8_t *a = &d->is_selected[mesh->periodic[2 * i]];
            uint8_t *b = &d->is_selected[mesh->periodic[2 * i + 1]];
            changed |= *a != *b;
            *a = *b = *a | *b;
        }
    }
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        d->slides[i] =
            may_slide(mesh, i) && plan->is_used[i] && (!d->is_selected || d->is_selected[i]);
    for (int64_t i = 0; i < plan->n_wrapped; i++)
        for (int j = 0; j <= plan->dim; j++)
            d->slides[mesh->elements[(int64_t)plan->wrapped[i] * (plan->dim + 1) + j]] = 0;
    hold_curved(d);
    *around = *mesh;
    if (mesh->n_periodic == 0)
        return PLANISH_OK;
    int status = pl_periodic_create(mesh, &d->incidence, plan->work.sign, plan->work.corner,
                                    d->slides, periodic, error);
    if (!status)
        status = copy_targets(plan, periodic, error);
    if (status)
        return status;
    plan->n_images = periodic->n_nodes - plan->work.n_nodes;
    around->n_nodes = periodic->n_nodes;
    around->n_elements = periodic->n_elements;
    around->elements = periodic->elements;
    around->min_volume = periodic->min_volume;
    d->number_of = pl_alloc(periodic->n_nodes, sizeof *d->number_of);
    if (!d->number_of)
        return pl_fail_memory(error, "periodic nodes");
    for (int64_t i = 0; i < periodic->n_nodes; i++)
        d->number_of[i] = i < plan->work.n_nodes ? plan->inner[i] : (int32_t)i;
    return periodic->corner ? pl_cell_incidence_create(around, periodic->corner, plan->threads,
                                                       &d->around, error)
                            : pl_incidence_create(around, NULL, plan->threads, &d->around, error);
}

/** Tell the plan where nodes slide, and who follows whom. Nodes that lead others slide with them,
 * or none does. */
static void keep_slides(pl_draft *d) {
    planish_plan *plan = d->plan;
    const planish_mesh *mesh = d->mesh;
    pl_periodic *periodic = &d->periodic;
    for (int64_t k = 0; k < periodic->n_followers; k++) {
        pl_follower *f = &periodic->follower[k];
        if (f->node < plan->work.n_nodes)
            d->mobility[f->node] = d->mobility[f->of];
        f->node = d->number_of[f->node];
        f->of = d->number_of[f->of];
        f->from = d->number_of[f->from];
        f->to = d->number_of[f->to];
    }
    plan->sliding.n_followers = periodic->n_followers;
    plan->sliding.follower = periodic->follower;
    periodic->follower = NULL;
    for (int64_t r = 0; r < d->sliding.n; r++) {
        const int32_t node = d->sliding.node[r], s = d->sliding.star_of[r];
        if (s < 0)
            continue;
        pl_star_slide *slide = &plan->slide[s];
        const planish_constraint by = (planish_constraint)mesh->constraint[node];
        const int is_of_shape = by >= PLANISH_CONSTRAINT_ON_PATCH; /* along no line: it stays */
        *slide = (pl_star_slide){.kind = is_of_shape ? PLANISH_CONSTRAINT_ON_LINE : by,
                                 .node = (int32_t)pl_plan_node(plan, node)};
        plan->slides_by[s] = (uint8_t)by;
        if (by < PLANISH_CONSTRAINT_ON_SURFACE)
            pl_unit(mesh->dim, mesh->direction + (int64_t)node * mesh->dim, slide->direction);
    }
}

/** Find the nodes that slide and their stars, whose links may be open. */
static int prepare_sliding(pl_draft *d, planish_error *error) {
    planish_plan *plan = d->plan;
    pl_candidates *c = &d->sliding;
    planish_mesh around;
    int64_t n = 0;
    int status = check_constraints(d, &n, error);
    if (status || !(plan->context->part ? pl_parts_any(n > 0) : n > 0))
        return status;
    d->slides = pl_alloc(plan->work.n_nodes, 1);
    c->node = pl_alloc(n, sizeof *c->node);
    plan->slide = pl_alloc(n, sizeof *plan->slide);
    plan->slides_by = pl_alloc(n, sizeof *plan->slides_by);
    if (!d->slides || !c->node || !plan->slide || !plan->slides_by)
        return pl_fail_memory(error, "nodes that slide");
    status = prepare_periodic(d, &around, error);
    if (status)
        return status;
    const pl_periodic *periodic = d->periodic.moves_with ? &d->periodic : NULL;
    const pl_incidence *incidence = periodic ? &d->around : &d->incidence;
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int32_t node = d->order[i];
        if (!d->slides[node] || !pl_is_own(d->mesh->part, node) ||
            (periodic && periodic->moves_with[node] != node))
            continue;
        d->mobility[node] = PL_SLIDES;
        c->node[c->n++] = node;
    }
    status = pl_rings_create(&around, incidence, periodic ? periodic->sign : plan->work.sign,
                             periodic ? periodic->corner : plan->work.corner, d->mobility, c->node,
                             c->n, 1, plan->threads, &c->rings, error);
    pl_parts_update(NULL, d->mobility, sizeof *d->mobility);
    pl_rings apart = {.n_rings = 0};
    if (!status && d->options->shape)
        status = pl_rings_across(d, c, &apart, error);
    if (!status)
        status = order_visits(plan, periodic, c, apart.neighbour ? &apart : &c->rings,
                              &plan->sliding, error);
    pl_free(apart.offset);
    pl_free(apart.neighbour);
    if (!status)
        status =
            pl_stars_create(&around, incidence, periodic ? periodic->corner : plan->work.corner,
                            &c->rings, c->node, c->star_of, periodic ? d->number_of : plan->inner,
                            plan->threads, &plan->sliding.stars, error);
    if (!status)
        keep_slides(d);
    return status;
}

/* ---- all of it ---------------------------------------------------------------------------- */

/** Make arrays over the nodes, and list the elements of every node; of selected ones alone if
 * facets will not be looked at. */
static int prepare_nodes(pl_draft *d, planish_error *error) {
    planish_plan *plan = d->plan;
    const int64_t n = plan->work.n_nodes;
    uint8_t *unasked = NULL;
    plan->work.mobility = d->mobility = pl_alloc(n, sizeof *d->mobility);
    plan->is_used = pl_alloc(n, sizeof *plan->is_used);
    plan->inner = pl_alloc(n, sizeof *plan->inner);
    d->order = pl_alloc(n, sizeof *d->order);
    d->interior.node = pl_alloc(n, sizeof *d->interior.node);
    d->count = pl_alloc(n / CHUNK_NODES + 2, sizeof *d->count);
    d->is_partial = d->is_selected && d->boundary.is_guess && d->mesh->n_periodic == 0;
    if (d->is_partial)
        unasked = pl_alloc(n, sizeof *unasked);
    if (!d->mobility || !plan->is_used || !plan->inner || !d->order || !d->interior.node ||
        !d->count || (d->is_partial && !unasked)) {
        pl_free(unasked);
        return pl_fail_memory(error, "nodes");
    }
    for (int64_t i = 0; unasked && i < n; i++)
        unasked[i] = !d->is_selected[i];
    const int status =
        plan->work.corner
            ? pl_cell_incidence_create(d->mesh, plan->work.corner, plan->threads, &d->incidence,
                                       error)
            : pl_incidence_create(d->mesh, unasked, plan->threads, &d->incidence, error);
    pl_free(unasked);
    return status;
}

/** Put mids behind the other nodes of the order: what sweeps read stays together. */
static int put_mids_last(pl_draft *d, planish_error *error) {
    const int64_t n = d->plan->work.n_nodes;
    const uint8_t *role = d->plan->role;
    uint8_t roles = 0;
    for (int64_t i = 0; role && d->plan->scope == PL_ALL && i < n; i++)
        roles |= role[i];
    if (!(roles & PL_OF_MID))
        return PLANISH_OK;
    int32_t *mid = pl_alloc(n, sizeof *mid);
    int64_t n_mids = 0;
    if (!mid)
        return pl_fail_memory(error, "nodes");
    for (int64_t i = 0; i < n; i++)
        if (pl_follows(role[d->order[i]]))
            mid[n_mids++] = d->order[i];
        else
            d->order[i - n_mids] = d->order[i];
    memcpy(d->order + n - n_mids, mid, (size_t)n_mids * sizeof *mid);
    pl_free(mid);
    return PLANISH_OK;
}

int pl_draft_finish(pl_draft *d, planish_error *error) {
    planish_plan *plan = d->plan;
    int status = pl_check_periodic(d->mesh, error);
    if (status)
        return status;
    if (d->mesh->n_periodic > 0) {
        d->is_paired = pl_alloc_zero(plan->work.n_nodes, 1);
        if (!d->is_paired)
            return pl_fail_memory(error, "periodic nodes");
    }
    for (int64_t i = 0; i < 2 * d->mesh->n_periodic; i++)
        d->is_paired[d->mesh->periodic[i]] = 1;
    status = pl_draft_choose_scope(d, error);
    if (!status)
        status = prepare_nodes(d, error);
    if (!status)
        status = pl_curve_order(d->mesh, plan->threads, d->order, error);
    if (!status)
        status = put_mids_last(d, error);
    if (!status)
        status = find_free(d, error);
    if (!status)
        status = prepare_sliding(d, error);
    if (!d->mesh->min_volume && !pl_has_targets(d->mesh))
        pl_incidence_destroy(&d->incidence);
    if (!status)
        status = order_visits(plan, NULL, &d->interior, &d->interior.rings, &plan->interior, error);
    if (status)
        return status;
    /* Of the candidates' rings nothing is left then. */
    return pl_stars_create(d->mesh, &d->incidence, plan->work.corner, &d->interior.rings,
                           d->interior.node, d->interior.star_of, plan->inner, plan->threads,
                           &plan->interior.stars, error);
}
