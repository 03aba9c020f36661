/* plan: validate a mesh, find its free nodes, order and colour them, gather their stars. */
#include "sweep/plan.h"

#include "sweep/sweep.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/simplex.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { CHUNK_ELEMENTS = 4096, CHUNK_NODES = 4096, CHUNK_RINGS = 16384 };

/** Nodes that shall be visited, if their links allow it. */
typedef struct candidates {
    int64_t n;
    int32_t *node;   /* [n] the caller's numbers, along the curve; -1: not free after all */
    pl_rings rings;  /* of node */
    int32_t *colour; /* [n] of node */
    int32_t *visit;  /* [rings.n_free] indices into node, colour by colour */
} candidates;

/** What plan creation needs only while it runs. */
typedef struct draft {
    const planish_mesh *mesh;
    const planish_options *options;
    uint8_t *is_selected; /* [n] not 0: may be free; NULL: all may */
    uint8_t *is_paired;   /* [n] 1: periodic, to slide or to stay; NULL: none is */
    pl_incidence incidence;
    pl_boundary boundary;
    int32_t *order;               /* [n] the caller's numbers along the curve */
    candidates interior, sliding; /* nodes that are free if they are inside, and those that slide */
    int64_t *count;               /* [chunks of nodes + 1] */
    pl_periodic periodic;         /* for nodes that slide, */
    pl_incidence around;          /* its incidence, */
    int32_t *number_of;           /* [its nodes] and their inner numbers */
} draft;

static void candidates_destroy(candidates *c) {
    pl_rings_destroy(&c->rings);
    pl_free(c->node);
    pl_free(c->colour);
    pl_free(c->visit);
}

static void draft_destroy(draft *d) {
    pl_incidence_destroy(&d->incidence);
    pl_boundary_destroy(&d->boundary);
    candidates_destroy(&d->interior);
    candidates_destroy(&d->sliding);
    pl_periodic_destroy(&d->periodic);
    pl_incidence_destroy(&d->around);
    pl_free(d->number_of);
    pl_free(d->is_selected);
    pl_free(d->is_paired);
    pl_free(d->order);
    pl_free(d->count);
}

/* ---- free nodes --------------------------------------------------------------------------- */

/** A node can be free if it has elements, is selected, is not known to be on the boundary, and its
 *  constraint says so. */
static int can_be_free(const draft *d, int64_t i, int used) {
    const uint8_t *constraint = d->mesh->constraint;
    return used && (!d->is_selected || d->is_selected[i]) &&
           (!constraint || constraint[i] == PLANISH_FREE) && !(d->is_paired && d->is_paired[i]) &&
           !d->boundary.on_boundary[i];
}

/** The work of find_candidates. */
typedef struct candidacy {
    planish_plan *plan;
    draft *d;
} candidacy;

/** Of the nodes along the curve. */
static void mark_candidates(void *context, int64_t begin, int64_t end, int thread) {
    const candidacy *c = context;
    const int64_t *offset = c->d->incidence.offset;
    int64_t found = 0, unused = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t node = c->d->order[i];
        const int used = offset[node + 1] > offset[node];
        c->plan->inner[node] = (int32_t)i;
        c->plan->is_used[node] = (uint8_t)used;
        c->plan->is_free[node] = (uint8_t)can_be_free(c->d, node, used);
        found += c->plan->is_free[node];
        unused += !used;
    }
    c->d->count[begin / CHUNK_NODES] = found;
    __atomic_fetch_add(&c->plan->info.n_unused, unused, __ATOMIC_RELAXED);
}

static void list_candidates(void *context, int64_t begin, int64_t end, int thread) {
    const candidacy *c = context;
    int64_t n = c->d->count[begin / CHUNK_NODES];
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (c->plan->is_free[c->d->order[i]])
            c->d->interior.node[n++] = c->d->order[i];
}

/** inner, is_used, and is_free of the interior's candidates; and these. */
static void find_candidates(planish_plan *plan, draft *d) {
    candidacy c = {plan, d};
    plan->info.n_unused = 0;
    pl_parallel_for(plan->threads, plan->n_nodes, CHUNK_NODES, mark_candidates, &c);
    d->interior.n = pl_prefix_sum(plan->threads, (plan->n_nodes - 1) / CHUNK_NODES + 1, d->count);
    pl_parallel_for(plan->threads, plan->n_nodes, CHUNK_NODES, list_candidates, &c);
}

/** Select the nodes that only_worse_than is about, with the boundary's sign. *all_positive: no
 *  element was found that is not. */
static int select_nodes(planish_plan *plan, draft *d, int *all_positive, planish_error *error) {
    if (!d->is_selected)
        d->is_selected = pl_alloc(plan->n_nodes, sizeof *d->is_selected);
    if (!d->is_selected)
        return pl_fail_memory(error, "the nodes of bad elements");
    plan->is_selective = 1;
    return pl_select(d->mesh, d->boundary.sign, d->options, plan->threads, d->is_selected,
                     all_positive, error);
}

/** What the measures say of the orientation, and of which elements are bad, if that is asked for:
 *  most often all are positive as they stand, and one look is enough. */
static int look_at_measures(planish_plan *plan, draft *d, planish_error *error) {
    const int selective = d->options->only_worse_than > 0;
    int all_positive = 0, status = PLANISH_OK;
    if (selective)
        status = select_nodes(plan, d, &all_positive, error);
    if (!status)
        status = pl_boundary_create(d->mesh, all_positive, plan->threads, &d->boundary, error);
    if (!status && selective && d->boundary.sign)
        status = select_nodes(plan, d, &all_positive, error);
    return status;
}

static int make_rings(planish_plan *plan, draft *d, planish_error *error) {
    find_candidates(plan, d);
    return pl_rings_create(d->mesh, &d->incidence, d->boundary.sign, plan->is_free,
                           d->interior.node, d->interior.n, 0, plan->threads, &d->interior.rings,
                           error);
}

/** The boundary, the free nodes and their rings. Usually the measures tell the orientation; then
 *  links tell which nodes are inside, and only the facets between others need to be looked at:
 * none, if only few nodes are asked for. */
static int find_free(planish_plan *plan, draft *d, planish_error *error) {
    int status = PLANISH_OK, all_positive;
    const int guessed = d->boundary.is_guess;
    if (guessed)
        status = make_rings(plan, d, error);
    if (!status && !(guessed && d->is_selected))
        status = pl_boundary_find(d->mesh, &d->incidence, guessed ? plan->is_free : NULL,
                                  plan->threads, &d->boundary, error);
    if (!status && !d->boundary.is_guess) {
        pl_rings_destroy(&d->interior.rings);
        if (d->is_selected)
            status = select_nodes(plan, d, &all_positive, error);
        if (!status)
            status = make_rings(plan, d, error);
    }
    plan->sign = d->boundary.sign;
    d->boundary.sign = NULL;
    return status;
}

static double count_fixed(void *context, int64_t begin, int64_t end, int thread) {
    const planish_plan *plan = context;
    (void)thread;
    int64_t count = 0;
    for (int64_t i = begin; i < end; i++) {
        const int32_t *element = plan->elements + i * (plan->dim + 1);
        int movable = 0;
        for (int j = 0; j <= plan->dim; j++)
            movable |= plan->is_free[element[j]];
        count += !movable;
    }
    return (double)count;
}

/* ---- visiting order ----------------------------------------------------------------------- */

/** The work of order_visits. */
typedef struct arrangement {
    const planish_plan *plan;
    const candidates *c;
    pl_visits *visits;
    int64_t n_chunks;
    int64_t *begin; /* [n_colours * n_chunks + 1] first visit of colour c in chunk k, at
                       c * n_chunks + k; counts at first */
} arrangement;

static void count_colours(void *context, int64_t begin, int64_t end, int thread) {
    const arrangement *a = context;
    int64_t *count = a->begin + begin / CHUNK_RINGS;
    (void)thread;
    for (int c = 0; c < a->visits->n_colours; c++)
        count[c * a->n_chunks] = 0;
    for (int64_t r = begin; r < end; r++)
        if (a->c->colour[r] >= 0)
            count[a->c->colour[r] * a->n_chunks]++;
}

static void list_visits(void *context, int64_t begin, int64_t end, int thread) {
    const arrangement *a = context;
    int64_t *next = a->begin + begin / CHUNK_RINGS;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        if (a->c->colour[r] < 0)
            continue;
        int64_t place = next[a->c->colour[r] * a->n_chunks]++;
        a->c->visit[place] = (int32_t)r;
        a->visits->centre[place] = a->plan->inner[a->c->node[r]];
    }
}

/** Colour the rings and put them in order of colour, along the curve within each. */
static int order_visits(const planish_plan *plan, const pl_periodic *periodic, candidates *c,
                        pl_visits *visits, planish_error *error) {
    arrangement a = {.plan = plan, .c = c, .visits = visits, .n_chunks = c->n / CHUNK_RINGS + 1};
    c->colour = pl_alloc(c->n, sizeof *c->colour);
    c->visit = pl_alloc(c->rings.n_free, sizeof *c->visit);
    visits->centre = pl_alloc(c->rings.n_free, sizeof *visits->centre);
    if (!c->colour || !c->visit || !visits->centre)
        return pl_fail_memory(error, "the colours of nodes");
    int status =
        pl_colouring_create(&c->rings, c->node, periodic ? periodic->n_nodes : plan->n_nodes,
                            periodic ? periodic->moves_with : NULL, plan->threads, c->colour,
                            &visits->n_colours, error);
    if (status)
        return status;
    visits->colour_begin = pl_alloc(visits->n_colours + 1, sizeof *visits->colour_begin);
    a.begin = pl_alloc_zero(visits->n_colours * a.n_chunks + 1, sizeof *a.begin);
    if (!visits->colour_begin || !a.begin) {
        pl_free(a.begin);
        return pl_fail_memory(error, "the colours of nodes");
    }
    pl_parallel_for(plan->threads, c->n, CHUNK_RINGS, count_colours, &a);
    pl_prefix_sum(plan->threads, visits->n_colours * a.n_chunks, a.begin);
    for (int i = 0; i <= visits->n_colours; i++)
        visits->colour_begin[i] = a.begin[i * a.n_chunks];
    pl_parallel_for(plan->threads, c->n, CHUNK_RINGS, list_visits, &a);
    pl_free(a.begin);
    return PLANISH_OK;
}

/** The stars of the visits; of the candidates' rings nothing is left. */
static int make_stars(const planish_plan *plan, draft *d, candidates *c, pl_visits *visits,
                      planish_error *error) {
    return pl_stars_create(d->mesh, &d->incidence, &c->rings, c->node, c->visit, visits->n_colours,
                           plan->inner, plan->threads, &visits->stars, error);
}

static void visits_destroy(pl_visits *visits) {
    pl_stars_destroy(&visits->stars);
    pl_free(visits->centre);
    pl_free(visits->colour_begin);
    pl_free(visits->follower);
}

/* ---- nodes that slide --------------------------------------------------------------------- */

static int may_slide(const planish_mesh *mesh, int64_t node) {
    return mesh->constraint && mesh->constraint[node] >= PLANISH_ON_PLANE;
}

/** Check how the nodes may move; count those that slide. */
static int check_constraints(const planish_mesh *mesh, int64_t *n_sliding, planish_error *error) {
    double unit[3];
    for (int64_t i = 0; mesh->constraint && i < mesh->n_nodes; i++) {
        const int constraint = mesh->constraint[i];
        if (constraint > PLANISH_ON_SURFACE)
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, i,
                              "mesh.constraint of node %" PRId64
                              " is %d; give a planish_constraint, 0 to %d",
                              i, constraint, PLANISH_ON_SURFACE);
        *n_sliding += may_slide(mesh, i);
        if ((constraint == PLANISH_ON_PLANE || constraint == PLANISH_ON_LINE) &&
            !(mesh->direction && pl_unit(mesh->dim, mesh->direction + i * mesh->dim, unit)))
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, i,
                              "node %" PRId64
                              " slides, but mesh.direction has none for it; give the normal of its "
                              "plane, or the direction of its line",
                              i);
    }
    return PLANISH_OK;
}

static void note_slides(planish_plan *plan, const draft *d) {
    const planish_mesh *mesh = d->mesh;
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++) {
        const int32_t node = d->sliding.node[d->sliding.visit[s]];
        pl_star_slide *slide = &plan->slide[s];
        *slide = (pl_star_slide){.kind = (planish_constraint)mesh->constraint[node], .node = node};
        if (slide->kind != PLANISH_ON_SURFACE)
            pl_unit(mesh->dim, mesh->direction + (int64_t)node * mesh->dim, slide->direction);
    }
}

/** A node of a group is chosen if one of its group is. */
static void select_groups(const draft *d) {
    enum { STEPS = 8 }; /* from node to node of a group, at most */
    const planish_mesh *mesh = d->mesh;
    for (int step = 0; d->is_selected && step < STEPS; step++)
        for (int64_t i = 0; i < mesh->n_periodic; i++) {
            uint8_t *a = &d->is_selected[mesh->periodic[2 * i]];
            uint8_t *b = &d->is_selected[mesh->periodic[2 * i + 1]];
            *a = *b = *a | *b;
        }
}

/** The mesh that the nodes that slide are in: with copies where some of them move together. slides
 *  [n] becomes 1 for those that may slide. */
static int prepare_periodic(planish_plan *plan, draft *d, uint8_t *slides, planish_mesh *around,
                            planish_error *error) {
    const planish_mesh *mesh = d->mesh;
    pl_periodic *periodic = &d->periodic;
    int status = PLANISH_OK;
    select_groups(d);
    for (int64_t i = 0; i < plan->n_nodes; i++)
        slides[i] =
            may_slide(mesh, i) && plan->is_used[i] && (!d->is_selected || d->is_selected[i]);
    *around = *mesh;
    if (mesh->n_periodic == 0)
        return PLANISH_OK;
    status = pl_periodic_create(mesh, &d->incidence, plan->sign, slides, periodic, error);
    if (status)
        return status;
    plan->n_images = periodic->n_nodes - plan->n_nodes;
    around->n_nodes = periodic->n_nodes;
    around->n_elements = periodic->n_elements;
    around->elements = periodic->elements;
    around->min_volume = periodic->min_volume;
    d->number_of = pl_alloc(periodic->n_nodes, sizeof *d->number_of);
    if (!d->number_of)
        return pl_fail_memory(error, "periodic nodes");
    for (int64_t i = 0; i < periodic->n_nodes; i++)
        d->number_of[i] = i < plan->n_nodes ? plan->inner[i] : (int32_t)i;
    return pl_incidence_create(around, NULL, plan->threads, &d->around, error);
}

/** Nodes that lead others slide with them, or none does; the plan keeps who follows whom. */
static void settle_followers(planish_plan *plan, draft *d) {
    pl_periodic *periodic = &d->periodic;
    for (int64_t k = 0; k < periodic->n_followers; k++) {
        pl_follower *f = &periodic->follower[k];
        if (f->node < plan->n_nodes)
            plan->is_free[f->node] = plan->is_free[f->of];
        f->node = d->number_of[f->node];
        f->of = d->number_of[f->of];
        f->from = d->number_of[f->from];
        f->to = d->number_of[f->to];
    }
    plan->sliding.n_followers = periodic->n_followers;
    plan->sliding.follower = periodic->follower;
    periodic->follower = NULL;
}

/** The stars of the nodes that slide, whose links may be open. */
static int prepare_sliding_stars(planish_plan *plan, draft *d, uint8_t *slides,
                                 planish_error *error) {
    candidates *c = &d->sliding;
    planish_mesh around;
    int status = prepare_periodic(plan, d, slides, &around, error);
    if (status)
        return status;
    const pl_periodic *periodic = d->periodic.moves_with ? &d->periodic : NULL;
    const pl_incidence *incidence = periodic ? &d->around : &d->incidence;
    for (int64_t i = 0; i < plan->n_nodes; i++) {
        const int32_t node = d->order[i];
        if (!slides[node] || (periodic && periodic->moves_with[node] != node))
            continue;
        plan->is_free[node] = PL_SLIDES;
        c->node[c->n++] = node;
    }
    status = pl_rings_create(&around, incidence, periodic ? periodic->sign : plan->sign,
                             plan->is_free, c->node, c->n, 1, plan->threads, &c->rings, error);
    if (!status)
        status = order_visits(plan, periodic, c, &plan->sliding, error);
    if (!status)
        status = pl_stars_create(&around, incidence, &c->rings, c->node, c->visit,
                                 plan->sliding.n_colours, periodic ? d->number_of : plan->inner,
                                 plan->threads, &plan->sliding.stars, error);
    if (!status && periodic)
        settle_followers(plan, d);
    if (!status)
        note_slides(plan, d);
    return status;
}

static int prepare_sliding(planish_plan *plan, draft *d, planish_error *error) {
    int64_t n = 0;
    int status = check_constraints(d->mesh, &n, error);
    if (status || n == 0)
        return status;
    uint8_t *slides = pl_alloc(plan->n_nodes, 1);
    d->sliding.node = pl_alloc(n, sizeof *d->sliding.node);
    plan->slide = pl_alloc(n, sizeof *plan->slide);
    if (slides && d->sliding.node && plan->slide)
        status = prepare_sliding_stars(plan, d, slides, error);
    else
        status = pl_fail_memory(error, "nodes that slide");
    pl_free(slides);
    return status;
}

/* ---- the steps of a plan ------------------------------------------------------------------ */

static int find_paired(const planish_plan *plan, draft *d, planish_error *error) {
    const planish_mesh *mesh = d->mesh;
    const int status = pl_check_periodic(mesh, error);
    if (status || mesh->n_periodic == 0)
        return status;
    d->is_paired = pl_alloc_zero(plan->n_nodes, 1);
    if (!d->is_paired)
        return pl_fail_memory(error, "periodic nodes");
    for (int64_t i = 0; i < 2 * mesh->n_periodic; i++)
        d->is_paired[mesh->periodic[i]] = 1;
    return PLANISH_OK;
}

static int prepare_topology(planish_plan *plan, draft *d, planish_error *error) {
    const planish_mesh *mesh = d->mesh;
    int64_t n = plan->n_nodes;
    plan->is_free = pl_alloc(n, sizeof *plan->is_free);
    plan->is_used = pl_alloc(n, sizeof *plan->is_used);
    plan->inner = pl_alloc(n, sizeof *plan->inner);
    d->order = pl_alloc(n, sizeof *d->order);
    d->interior.node = pl_alloc(n, sizeof *d->interior.node);
    d->count = pl_alloc(n / CHUNK_NODES + 2, sizeof *d->count);
    if (!plan->is_free || !plan->is_used || !plan->inner || !d->order || !d->interior.node ||
        !d->count)
        return pl_fail_memory(error, "nodes");
    int status = find_paired(plan, d, error);
    if (!status)
        status = look_at_measures(plan, d, error);
    if (!status)
        status = pl_incidence_create(mesh, NULL, plan->threads, &d->incidence, error);
    if (!status)
        status = pl_curve_order(mesh, plan->threads, d->order, error);
    if (!status)
        status = find_free(plan, d, error);
    if (!status)
        status = prepare_sliding(plan, d, error);
    if (!status)
        status = order_visits(plan, NULL, &d->interior, &plan->interior, error);
    if (!mesh->min_volume)
        pl_incidence_destroy(&d->incidence);
    return status ? status : make_stars(plan, d, &d->interior, &plan->interior, error);
}

static int64_t chunks_of(int64_t n, int64_t chunk) {
    return n / chunk + 1;
}

static int64_t larger(int64_t a, int64_t b) {
    return a > b ? a : b;
}

static int prepare_scratch(planish_plan *plan, planish_error *error) {
    int64_t values = plan->n_nodes * plan->dim;
    const pl_stars *interior = &plan->interior.stars, *sliding = &plan->sliding.stars;
    const int64_t n_stars = larger(interior->n_stars, sliding->n_stars);
    int64_t bytes = pl_star_scratch_size(plan->dim, larger(interior->max_ring, sliding->max_ring),
                                         larger(interior->max_link, sliding->max_link));
    plan->scratch_stride = bytes / (int64_t)sizeof(double);
    plan->coordinates = pl_alloc(values + plan->n_images * plan->dim, sizeof(double));
    plan->measured = pl_alloc(values, sizeof(double));
    plan->changed = pl_alloc_zero(plan->n_nodes + plan->n_images, 1);
    plan->partial =
        pl_alloc(chunks_of(n_stars, PL_CHUNK_STARS) + chunks_of(plan->n_elements, CHUNK_ELEMENTS),
                 sizeof(double));
    plan->scratch = pl_alloc(plan->scratch_stride * plan->threads, sizeof(double));
    if (!plan->coordinates || !plan->measured || !plan->changed || !plan->partial || !plan->scratch)
        return pl_fail_memory(error, "the working space of a plan");
    return PLANISH_OK;
}

static int64_t bytes_of(const planish_plan *plan, const pl_visits *visits) {
    const pl_stars *stars = &visits->stars;
    if (stars->n_stars == 0)
        return 0;
    const int64_t links = stars->link_offset[stars->n_stars];
    return stars->n_stars * (int64_t)(2 * sizeof(int64_t) + sizeof(int32_t)) +
           stars->ring_offset[stars->n_stars] * (int64_t)sizeof(int32_t) +
           links * pl_link_positions(plan->dim) * (stars->link.high ? 2 : 1) +
           (stars->min_volume ? links * (int64_t)sizeof(double) : 0);
}

/** Nodes that move with others. */
static int64_t count_followers(const planish_plan *plan) {
    int64_t n = 0;
    for (int64_t i = 0; i < plan->n_nodes; i++)
        n += plan->is_free[i] == PL_SLIDES;
    return n - plan->sliding.stars.n_stars;
}

static void fill_info(planish_plan *plan, const draft *d) {
    planish_plan_info *info = &plan->info;
    info->n_free = plan->interior.stars.n_stars;
    info->n_sliding = plan->sliding.stars.n_stars + count_followers(plan);
    info->n_fixed_elements = (int64_t)pl_parallel_sum(
        plan->threads, plan->n_elements, CHUNK_ELEMENTS, count_fixed, plan, plan->partial);
    info->n_components = d->boundary.n_components;
    info->n_reversed = d->boundary.n_reversed;
    info->n_boundary_facets = d->boundary.n_boundary_facets;
    info->n_nonmanifold_facets = d->boundary.n_nonmanifold_facets;
    info->n_duplicate_elements = d->boundary.n_duplicate_elements;
    info->n_colours = pl_plan_colours(plan);
    info->threads = plan->threads;
    info->isa = plan->kernel->name;
    info->binding = pl_placement_text(plan->placement);
    info->bytes =
        plan->n_nodes * (int64_t)(2 * (size_t)plan->dim * sizeof(double) + sizeof(int32_t) + 3) +
        (plan->sign ? plan->n_elements : 0) +
        (plan->min_volume ? plan->n_elements * (int64_t)sizeof(double) : 0) +
        bytes_of(plan, &plan->interior) + bytes_of(plan, &plan->sliding) +
        plan->sliding.stars.n_stars * (int64_t)sizeof *plan->slide +
        plan->sliding.n_followers * (int64_t)sizeof *plan->sliding.follower +
        plan->scratch_stride * plan->threads * (int64_t)sizeof(double);
}

/** A copy of the elements' least volumes. */
static int copy_min_volumes(planish_plan *plan, const planish_mesh *mesh, planish_error *error) {
    if (!mesh->min_volume)
        return PLANISH_OK;
    plan->min_volume = pl_alloc(plan->n_elements, sizeof *plan->min_volume);
    if (!plan->min_volume)
        return pl_fail_memory(error, "the least volumes of the elements");
    for (int64_t i = 0; i < plan->n_elements; i++) {
        double least = mesh->min_volume[i];
        if (!(least >= 0) || !isfinite(least))
            return pl_fail_at(error, PLANISH_ERROR_MESH, i, -1,
                              "element %" PRId64 " has the least volume %g; give a finite number, "
                              "0 for none",
                              i, least);
        plan->min_volume[i] = least;
    }
    return PLANISH_OK;
}

static int build(planish_plan *plan, const planish_mesh *mesh, const planish_options *options,
                 planish_error *error) {
    draft d = {.mesh = mesh, .options = options};
    int status = pl_validate_mesh(mesh, plan->threads, error);
    if (!status)
        status = copy_min_volumes(plan, mesh, error);
    if (!status)
        status = prepare_topology(plan, &d, error);
    if (!status)
        status = prepare_scratch(plan, error);
    if (!status)
        fill_info(plan, &d);
    draft_destroy(&d);
    return status;
}

static int check_kernel(const planish_options *options, planish_error *error) {
    if (!pl_star_kernel_select(options->isa))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.isa %d is not a kernel that this CPU can run; use "
                       "PLANISH_ISA_AUTO",
                       (int)options->isa);
    return PLANISH_OK;
}

int planish_plan_create(const planish_mesh *mesh, const planish_options *options,
                        planish_plan **out, planish_error *error) {
    planish_options defaults;
    if (!mesh || !out)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh and plan must not be NULL");
    if (!options) {
        planish_options_init(&defaults);
        options = &defaults;
    }
    int status = pl_options_check(options, error);
    if (!status)
        status = check_kernel(options, error);
    if (status)
        return status;

    planish_plan *plan = pl_alloc_zero(1, sizeof *plan);
    pl_placement *placement = pl_placement_create(options->threads, options->bind);
    if (!plan || !placement) {
        pl_placement_destroy(placement);
        pl_free(plan);
        return pl_fail_memory(error, "a plan");
    }
    plan->placement = placement;
    plan->threads = pl_placement_threads(placement);
    plan->kernel = pl_star_kernel_select(options->isa);
    plan->dim = mesh->dim;
    plan->n_nodes = mesh->n_nodes;
    plan->n_elements = mesh->n_elements;
    plan->elements = mesh->elements;
    pl_placement_enter(placement);
    status = build(plan, mesh, options, error);
    pl_placement_leave(placement);
    if (status) {
        planish_plan_destroy(plan);
        return status;
    }
    *out = plan;
    return PLANISH_OK;
}

void planish_plan_destroy(planish_plan *plan) {
    if (!plan)
        return;
    visits_destroy(&plan->interior);
    visits_destroy(&plan->sliding);
    pl_free(plan->slide);
    pl_placement_destroy(plan->placement);
    pl_free(plan->min_volume);
    pl_free(plan->sign);
    pl_free(plan->is_free);
    pl_free(plan->is_used);
    pl_free(plan->inner);
    pl_free(plan->coordinates);
    pl_free(plan->measured);
    pl_free(plan->changed);
    pl_free(plan->partial);
    pl_free(plan->scratch);
    pl_free(plan);
}

void planish_plan_get_free(const planish_plan *plan, uint8_t *is_free) {
    for (int64_t i = 0; i < plan->n_nodes; i++)
        is_free[i] = plan->is_free[i] == PL_INTERIOR;
}

/* See pl_star_problem.still. Where only bad elements are mended, many of them stand at a boundary
 * that cannot be: they are not looked at again for every tremor around. */
#define STILL        1e-4
#define STILL_OF_FEW 1e-2

static pl_star_problem problem_of(const planish_plan *plan, const pl_visits *visits) {
    return (pl_star_problem){.coordinates = plan->coordinates,
                             .node = visits->centre,
                             .ring_offset = visits->stars.ring_offset,
                             .ring = visits->stars.ring,
                             .link_offset = visits->stars.link_offset,
                             .link = visits->stars.link,
                             .changed = plan->changed,
                             .limits = pl_star_no_limits(),
                             .still = plan->is_selective ? STILL_OF_FEW : STILL};
}

pl_star_problem pl_plan_problem(const planish_plan *plan) {
    return problem_of(plan, &plan->interior);
}

pl_star_problem pl_plan_sliding_problem(const planish_plan *plan) {
    pl_star_problem problem = problem_of(plan, &plan->sliding);
    problem.slide = plan->slide;
    return problem;
}

int pl_plan_colours(const planish_plan *plan) {
    return plan->interior.n_colours + plan->sliding.n_colours;
}

/** The work of pl_plan_order. */
typedef struct load {
    const planish_plan *plan;
    const double *coordinates;
    double *inside;
} load;

static void load_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const load *w = context;
    const int dim = w->plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < dim; d++)
            w->inside[(int64_t)w->plan->inner[i] * dim + d] = w->coordinates[i * dim + d];
}

void pl_plan_order(const planish_plan *plan, const double *coordinates, double *inside) {
    load w = {plan, coordinates, inside};
    pl_parallel_for(plan->threads, plan->n_nodes, CHUNK_NODES, load_nodes, &w);
}

void planish_plan_get_info(const planish_plan *plan, planish_plan_info *info) {
    *info = plan->info;
}
