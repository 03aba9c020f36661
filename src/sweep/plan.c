/* plan: validate a mesh, find its free nodes, order and colour them, gather their stars. */
#include "sweep/plan.h"

#include "sweep/sweep.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { CHUNK_ELEMENTS = 4096, CHUNK_NODES = 4096 };

/** What plan creation needs only while it runs. */
typedef struct draft {
    const planish_mesh *mesh;
    pl_incidence incidence;
    pl_boundary boundary;
    int32_t *order; /* [n] the caller's numbers along the curve */
    int32_t *node;  /* [n_free] the caller's numbers of the free nodes, along the curve */
    int64_t n_free;
    pl_rings rings;  /* of node */
    int32_t *colour; /* [n_free] of node */
    int32_t *visit;  /* [n_free] indices into node, colour by colour */
} draft;

static void draft_destroy(draft *d) {
    pl_incidence_destroy(&d->incidence);
    pl_boundary_destroy(&d->boundary);
    pl_rings_destroy(&d->rings);
    pl_free(d->order);
    pl_free(d->node);
    pl_free(d->colour);
    pl_free(d->visit);
}

/* ---- free nodes --------------------------------------------------------------------------- */

/** A node is free if it has elements, is not on the boundary, and its constraint says so. */
static void mark_free(planish_plan *plan, draft *d) {
    const planish_mesh *mesh = d->mesh;
    for (int64_t i = 0; i < plan->n_nodes; i++) {
        int used = d->incidence.offset[i + 1] > d->incidence.offset[i];
        int fixed = mesh->constraint && mesh->constraint[i] != PLANISH_FREE;
        plan->is_used[i] = (uint8_t)used;
        plan->is_free[i] = used && !fixed && !d->boundary.on_boundary[i];
        plan->info.n_unused += !used;
    }
}

/** order and inner from the curve, node from those of them that are free. */
static int order_nodes(planish_plan *plan, draft *d, planish_error *error) {
    int64_t n = plan->n_nodes;
    d->order = pl_alloc(n, sizeof *d->order);
    d->node = pl_alloc(n, sizeof *d->node);
    if (!d->order || !d->node)
        return pl_fail_memory(error, "the order of nodes");
    int status = pl_curve_order(d->mesh, plan->threads, d->order, error);
    if (status)
        return status;
    for (int64_t i = 0; i < n; i++) {
        int32_t node = d->order[i];
        plan->inner[node] = (int32_t)i;
        if (plan->is_free[node])
            d->node[d->n_free++] = node;
    }
    return PLANISH_OK;
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

/** Colour the rings and put them in order of colour, along the curve within each. */
static int order_visits(planish_plan *plan, draft *d, planish_error *error) {
    int64_t n = d->n_free;
    d->colour = pl_alloc(n, sizeof *d->colour);
    d->visit = pl_alloc(n, sizeof *d->visit);
    plan->centre = pl_alloc(n, sizeof *plan->centre);
    if (!d->colour || !d->visit || !plan->centre)
        return pl_fail_memory(error, "the colours of nodes");
    int status = pl_colouring_create(&d->rings, d->node, plan->n_nodes, plan->threads, d->colour,
                                     &plan->n_colours, error);
    if (status)
        return status;
    plan->colour_begin = pl_alloc_zero(plan->n_colours + 2, sizeof *plan->colour_begin);
    if (!plan->colour_begin)
        return pl_fail_memory(error, "the colours of nodes");
    for (int64_t i = 0; i < n; i++)
        plan->colour_begin[d->colour[i] + 2]++;
    for (int c = 0; c < plan->n_colours; c++)
        plan->colour_begin[c + 2] += plan->colour_begin[c + 1];
    for (int64_t i = 0; i < n; i++) {
        int64_t place = plan->colour_begin[d->colour[i] + 1]++;
        d->visit[place] = (int32_t)i;
        plan->centre[place] = plan->inner[d->node[i]];
    }
    return PLANISH_OK;
}

/* ---- the steps of a plan ------------------------------------------------------------------ */

static int prepare_topology(planish_plan *plan, draft *d, planish_error *error) {
    const planish_mesh *mesh = d->mesh;
    plan->is_free = pl_alloc(plan->n_nodes, sizeof *plan->is_free);
    plan->is_used = pl_alloc(plan->n_nodes, sizeof *plan->is_used);
    plan->inner = pl_alloc(plan->n_nodes, sizeof *plan->inner);
    if (!plan->is_free || !plan->is_used || !plan->inner)
        return pl_fail_memory(error, "nodes");
    int status = pl_incidence_create(mesh, plan->threads, &d->incidence, error);
    if (!status)
        status = pl_boundary_create(mesh, &d->incidence, plan->threads, &d->boundary, error);
    if (status)
        return status;
    plan->sign = d->boundary.sign;
    d->boundary.sign = NULL;
    mark_free(plan, d);
    status = order_nodes(plan, d, error);
    if (!status)
        status = pl_rings_create(mesh, &d->incidence, plan->sign, plan->is_free, d->node,
                                 &d->n_free, plan->threads, &d->rings, error);
    if (!status)
        status = order_visits(plan, d, error);
    if (!mesh->min_volume)
        pl_incidence_destroy(&d->incidence);
    if (!status)
        status = pl_stars_create(mesh, &d->incidence, &d->rings, d->node, d->visit, plan->inner,
                                 plan->threads, &plan->stars, error);
    return status;
}

static int64_t chunks_of(int64_t n, int64_t chunk) {
    return n / chunk + 1;
}

static int prepare_scratch(planish_plan *plan, planish_error *error) {
    int64_t values = plan->n_nodes * plan->dim;
    int64_t bytes = pl_star_scratch_size(plan->dim, plan->stars.max_ring, plan->stars.max_link);
    plan->scratch_stride = bytes / (int64_t)sizeof(double);
    plan->coordinates = pl_alloc(values, sizeof(double));
    plan->measured = pl_alloc(values, sizeof(double));
    plan->changed = pl_alloc(plan->n_nodes, 1);
    plan->partial = pl_alloc(chunks_of(plan->stars.n_stars, PL_CHUNK_STARS) +
                                 chunks_of(plan->n_elements, CHUNK_ELEMENTS),
                             sizeof(double));
    plan->scratch = pl_alloc(plan->scratch_stride * plan->threads, sizeof(double));
    if (!plan->coordinates || !plan->measured || !plan->changed || !plan->partial || !plan->scratch)
        return pl_fail_memory(error, "the working space of a plan");
    return PLANISH_OK;
}

static void fill_info(planish_plan *plan, const draft *d) {
    planish_plan_info *info = &plan->info;
    info->n_free = plan->stars.n_stars;
    info->n_fixed_elements = (int64_t)pl_parallel_sum(
        plan->threads, plan->n_elements, CHUNK_ELEMENTS, count_fixed, plan, plan->partial);
    info->n_components = d->boundary.n_components;
    info->n_reversed = d->boundary.n_reversed;
    info->n_boundary_facets = d->boundary.n_boundary_facets;
    info->n_nonmanifold_facets = d->boundary.n_nonmanifold_facets;
    info->n_duplicate_elements = d->boundary.n_duplicate_elements;
    info->n_colours = plan->n_colours;
    info->threads = plan->threads;
    info->isa = plan->kernel->name;
    info->binding = pl_placement_text(plan->placement);
    info->bytes =
        plan->n_nodes * (int64_t)(2 * (size_t)plan->dim * sizeof(double) + sizeof(int32_t) + 3) +
        (plan->sign ? plan->n_elements : 0) +
        (plan->min_volume ? (plan->n_elements + plan->stars.link_offset[plan->stars.n_stars]) *
                                (int64_t)sizeof(double)
                          : 0) +
        plan->stars.n_stars * (int64_t)(2 * sizeof(int64_t) + sizeof(int32_t)) +
        plan->stars.ring_offset[plan->stars.n_stars] * (int64_t)sizeof(int32_t) +
        plan->stars.link_offset[plan->stars.n_stars] * pl_link_positions(plan->dim) *
            (plan->stars.link.high ? 2 : 1) +
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

static int build(planish_plan *plan, const planish_mesh *mesh, planish_error *error) {
    draft d = {.mesh = mesh};
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
    status = build(plan, mesh, error);
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
    pl_stars_destroy(&plan->stars);
    pl_placement_destroy(plan->placement);
    pl_free(plan->min_volume);
    pl_free(plan->sign);
    pl_free(plan->is_free);
    pl_free(plan->is_used);
    pl_free(plan->inner);
    pl_free(plan->centre);
    pl_free(plan->colour_begin);
    pl_free(plan->coordinates);
    pl_free(plan->measured);
    pl_free(plan->changed);
    pl_free(plan->partial);
    pl_free(plan->scratch);
    pl_free(plan);
}

pl_star_problem pl_plan_problem(const planish_plan *plan) {
    return (pl_star_problem){.coordinates = plan->coordinates,
                             .node = plan->centre,
                             .ring_offset = plan->stars.ring_offset,
                             .ring = plan->stars.ring,
                             .link_offset = plan->stars.link_offset,
                             .link = plan->stars.link,
                             .changed = plan->changed,
                             .rr2_limit = INFINITY};
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
