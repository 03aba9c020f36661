/* plan: made once for a connectivity; what the other parts of the folder ask of it. */
#include "plan/plan.h"

#include "plan/draft.h"
#include "plan/options.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"

#include <string.h>

enum { CHUNK_ELEMENTS = 4096, CHUNK_NODES = 1024 };

/** A last look at all elements. */
typedef struct look {
    planish_plan *plan;
    int marks; /* which nodes are used is not known of all yet */
} look;

/** How many elements have no free node. */
static inline int64_t count_fixed(const planish_plan *plan, int dim, int64_t begin, int64_t end) {
    const int32_t *elements = plan->work.elements;
    const uint8_t *mobility = plan->work.mobility, *is_counted = plan->work.is_counted;
    int64_t n = 0;
    for (int64_t i = begin; i < end; i++)
        n += !pl_any_moves(mobility, elements + i * (dim + 1), dim + 1) &&
             (!is_counted || is_counted[i]);
    return n;
}

/** Count the elements without a free node. Mark nodes that were not asked for as used. */
static void look_at_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const look *l = context;
    planish_plan *plan = l->plan;
    const int64_t k = plan->dim + 1;
    (void)thread;
    const int64_t n =
        plan->dim == 3 ? count_fixed(plan, 3, begin, end) : count_fixed(plan, 2, begin, end);
    __atomic_fetch_add(&plan->info.n_fixed_elements, n, __ATOMIC_RELAXED);
    for (int64_t i = begin * k; l->marks && i < end * k; i++)
        if (!__atomic_load_n(&plan->is_used[plan->work.elements[i]], __ATOMIC_RELAXED))
            __atomic_store_n(&plan->is_used[plan->work.elements[i]], PL_USED | PL_NOT_CHOSEN,
                             __ATOMIC_RELAXED);
}

static int64_t larger(int64_t a, int64_t b) {
    return a > b ? a : b;
}

static int prepare_scratch(planish_plan *plan, planish_error *error) {
    int64_t values = plan->work.n_nodes * plan->dim;
    const pl_stars *interior = &plan->interior.stars, *sliding = &plan->sliding.stars;
    int64_t bytes = pl_star_scratch_size(plan->dim, larger(interior->max_ring, sliding->max_ring),
                                         larger(interior->max_link, sliding->max_link));
    plan->scratch_stride = bytes / (int64_t)sizeof(double);
    plan->coordinates = pl_alloc(values + plan->n_images * plan->dim, sizeof(double));
    plan->measured = pl_alloc(values, sizeof(double));
    plan->changed = pl_alloc_zero(plan->work.n_nodes + plan->n_images, 1);
    plan->scratch = pl_alloc(plan->scratch_stride * plan->threads, sizeof(double));
    plan->tally = pl_alloc(plan->threads, sizeof *plan->tally);
    if (plan->dim == 3)
        plan->kept = pl_alloc(interior->n_stars, sizeof *plan->kept);
    if (!plan->coordinates || !plan->measured || !plan->changed || !plan->scratch || !plan->tally ||
        (plan->dim == 3 && !plan->kept))
        return pl_fail_memory(error, "the working space of a plan");
    const pl_points points = pl_plan_points(plan, plan->coordinates);
    if (pl_points_are_dense(&points))
        return PLANISH_OK;
    plan->start = pl_alloc(values, sizeof *plan->start);
    return plan->start ? PLANISH_OK : pl_fail_memory(error, "the working space of a plan");
}

/** Nodes that move with others. */
static int64_t count_followers(const planish_plan *plan) {
    int64_t n = 0;
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        n += plan->work.mobility[i] == PL_SLIDES && pl_is_own(pl_part_here(), i);
    return n - plan->sliding.stars.n_stars;
}

static void fill_info(planish_plan *plan, const pl_draft *d) {
    planish_plan_info *info = &plan->info;
    look l = {plan, d->is_partial};
    info->n_free = plan->interior.stars.n_stars;
    info->n_sliding = plan->sliding.stars.n_stars + count_followers(plan);
    info->n_fixed_elements = 0;
    pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK_ELEMENTS, look_at_chunk, &l);
    if (plan->scope == PL_SUBSET_OF_ALL)
        info->n_fixed_elements += plan->whole.n_elements - plan->work.n_elements;
    info->n_components = d->boundary.n_components;
    if (plan->is_selective || plan->scope == PL_SUBSET_ALONE) /* in a subset nobody knows of them */
        info->n_unused = 0;
    if (plan->scope != PL_SUBSET_OF_ALL)
        info->n_reversed = d->boundary.n_reversed;
    info->n_boundary_facets = d->boundary.n_boundary_facets;
    info->n_nonmanifold_facets = d->boundary.n_nonmanifold_facets;
    info->n_duplicate_elements = d->boundary.n_duplicate_elements;
    info->n_wrapped = plan->n_wrapped;
    info->n_colours = pl_plan_colours(plan);
    info->threads = plan->threads;
    info->isa = plan->kernel->name;
    info->binding = pl_placement_text(plan->placement);
}

/** Sum the counts of this process over all processes. */
static void fill_info_of_all(planish_plan *plan) {
    planish_plan_info *info = &plan->info;
    int64_t *const count[] = {&info->n_free,
                              &info->n_sliding,
                              &info->n_fixed_elements,
                              &info->n_reversed,
                              &info->n_boundary_facets,
                              &info->n_nonmanifold_facets,
                              &info->n_duplicate_elements,
                              &info->n_unused};
    enum { N = sizeof count / sizeof *count };
    int64_t values[N];
    for (int i = 0; i < N; i++)
        values[i] = *count[i];
    pl_parts_add(values, N);
    for (int i = 0; i < N; i++)
        *count[i] = values[i];
}

static int prepare(planish_plan *plan, pl_draft *d, planish_error *error) {
    int status = pl_draft_finish(plan, d, error);
    if (!status)
        status = pl_ghosts_create(plan, d->mesh, d->order, error);
    plan->work.is_movable = plan->ghosts.is_movable;
    if (!status)
        status = prepare_scratch(plan, error);
    if (status)
        return status;
    fill_info(plan, d);
    fill_info_of_all(plan);
    /* What planish_measure tells of all of the mesh. */
    for (int64_t i = 0; d->whole_mobility && i < plan->work.n_nodes; i++)
        d->whole_mobility[plan->node_of[i]] = plan->work.mobility[i];
    return pl_parts_check(error);
}

static int build(planish_plan *plan, const planish_mesh *mesh, const planish_options *options,
                 planish_error *error) {
    pl_draft d = {.options = options};
    int status = pl_draft_begin(plan, mesh, &d, error);
    if (!status)
        status = pl_parts_begin(mesh->n_nodes, error);
    if (!status)
        status = prepare(plan, &d, error);
    pl_draft_destroy(&d);
    return status;
}

static void visits_destroy(pl_visits *visits) {
    pl_stars_destroy(&visits->stars);
    pl_free(visits->centre);
    pl_free(visits->colour_begin);
    pl_free(visits->inside_begin);
    pl_free(visits->follower);
}

/** The arrays that a plan makes for a view are its own to change. */
static void release_view(pl_view *view) {
    pl_free((void *)view->sign);
    pl_free((void *)view->min_volume);
    pl_free((void *)view->mobility);
}

void pl_plan_destroy(planish_plan *plan) {
    pl_ghosts_destroy(&plan->ghosts);
    pl_parts_end(plan->context);
    visits_destroy(&plan->interior);
    visits_destroy(&plan->sliding);
    pl_free(plan->slide);
    pl_placement_destroy(plan->placement);
    pl_free(plan->own_elements);
    pl_free(plan->node_of);
    pl_free(plan->element_of);
    pl_free(plan->own_whole_elements);
    pl_free(plan->is_movable);
    release_view(&plan->work);
    release_view(&plan->whole);
    pl_free(plan->start);
    pl_free(plan->wrapped);
    pl_free(plan->is_used);
    pl_free(plan->inner);
    pl_free(plan->coordinates);
    pl_free(plan->measured);
    pl_free(plan->changed);
    pl_free(plan->kept);
    pl_free(plan->scratch);
    pl_free(plan->tally);
    pl_free(plan);
}

/** A plan of nothing yet, in context. */
static planish_plan *begin(const planish_mesh *mesh, const planish_options *options,
                           pl_context *context) {
    planish_plan *plan = pl_alloc_zero(1, sizeof *plan);
    pl_placement *placement =
        pl_placement_create(pl_threads_for(mesh, options), options->bind && !options->parallel);
    if (!plan || !placement) {
        pl_placement_destroy(placement);
        pl_free(plan);
        return NULL;
    }
    pl_context_share_pages(context, mesh->n_elements, pl_placement_is_near(placement));
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    plan->context = context;
    plan->placement = placement;
    plan->threads = pl_placement_threads(placement);
    plan->kernel = pl_star_kernel_select(options->isa);
    plan->dim = mesh->dim;
    plan->all = &plan->work;
    plan->work = plan->whole = (pl_view){.dim = mesh->dim,
                                         .n_nodes = mesh->n_nodes,
                                         .n_elements = mesh->n_elements,
                                         .is_counted = mesh->part ? mesh->part->is_counted : NULL};
    plan->node_stride = points.step;
    plan->component_stride = points.apart;
    return plan;
}

planish_plan *pl_plan_make(const planish_mesh *mesh, const planish_options *options,
                           pl_context *context, int *status, planish_error *error) {
    planish_plan *plan = begin(mesh, options, context);
    if (!plan) {
        *status = pl_fail_memory(error, "a plan");
        return NULL;
    }
    pl_placement_enter(plan->placement);
    *status = build(plan, mesh, options, error);
    pl_placement_leave(plan->placement);
    if (*status) {
        pl_plan_destroy(plan);
        return NULL;
    }
    return plan;
}

/* See pl_star_problem.still. Where only bad elements are repaired, many of them stand at a boundary
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
    pl_parallel_for(plan->threads, plan->work.n_nodes, CHUNK_NODES, load_nodes, &w);
}

pl_points pl_plan_points(const planish_plan *plan, const double *coordinates) {
    return (pl_points){coordinates,       plan->work.n_nodes,     plan->dim,
                       plan->node_stride, plan->component_stride, plan->node_of};
}

pl_points pl_plan_all_points(const planish_plan *plan, const double *coordinates) {
    pl_points points = pl_plan_points(plan, coordinates);
    if (plan->all != &plan->work) {
        points.n = plan->all->n_nodes;
        points.node_of = NULL;
    }
    return points;
}

void pl_plan_number_stars(const planish_plan *plan, int32_t *star_of) {
    memset(star_of, -1, (size_t)plan->work.n_nodes * sizeof *star_of);
    for (int64_t s = 0; s < plan->interior.stars.n_stars; s++)
        star_of[plan->interior.centre[s]] = (int32_t)s;
}

const double *pl_plan_dense(const planish_plan *plan, const pl_points *points, double *room) {
    if (pl_points_are_dense(points))
        return points->x;
    pl_points_gather(points, plan->threads, room);
    return room;
}

int pl_plan_check_call(const planish_plan *plan, const double *coordinates,
                       const planish_options *options, planish_error *error) {
    int status = pl_options_check(options, error);
    if (status)
        return status;
    if (options->min_volume_fraction > 0 && plan->scope == PL_SUBSET_ALONE)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.min_volume_fraction is of the domain's volume, which a plan made "
                       "with options.around does not know; give min_volume");
    const pl_points points = pl_plan_all_points(plan, coordinates);
    return pl_points_check(&points, plan->threads, error);
}
