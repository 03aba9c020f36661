/* make: make a plan: its mesh, its free nodes and their stars, working space, and what it tells. */
#include "plan/draft.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "plan/ghosts.h"
#include "plan/make.h"

#include <math.h>

enum { CHUNK_ELEMENTS = 4096 };

/** Count the elements of this process that have no free node. */
static inline int64_t count_fixed(const planish_plan *plan, int dim, int64_t begin, int64_t end) {
    const int32_t *elements = plan->work.elements;
    const uint8_t *mobility = plan->work.mobility, *is_counted = plan->work.is_counted;
    int64_t n = 0;
    for (int64_t i = begin; i < end; i++)
        n += !pl_any_moves(mobility, elements + i * (dim + 1), dim + 1) &&
             (!is_counted || is_counted[i]);
    return n;
}

/** Count the cells without a free node, of a plan whose elements are their corners. */
static void count_fixed_cells(void *context, int64_t begin, int64_t end, int thread) {
    planish_plan *plan = context;
    const pl_view *v = &plan->work;
    const int k = plan->dim + 1;
    int64_t n = 0;
    (void)thread;
    for (int64_t c = begin; c < end; c++) {
        int moves = 0;
        for (int64_t e = v->cell_begin[c]; e < v->cell_begin[c + 1] && !moves; e++)
            moves = pl_any_moves(v->mobility, v->elements + e * k, k);
        n += !moves;
    }
    __atomic_fetch_add(&plan->info.n_fixed_elements, n, __ATOMIC_RELAXED);
}

/** Count the elements without a free node. Mark nodes as used whose elements a partial incidence
 * does not list. */
static void count_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const pl_draft *d = context;
    planish_plan *plan = d->plan;
    const int64_t k = plan->dim + 1;
    (void)thread;
    const int64_t n =
        plan->dim == 3 ? count_fixed(plan, 3, begin, end) : count_fixed(plan, 2, begin, end);
    __atomic_fetch_add(&plan->info.n_fixed_elements, n, __ATOMIC_RELAXED);
    for (int64_t i = begin * k; d->is_partial && i < end * k; i++)
        if (!__atomic_load_n(&plan->is_used[plan->work.elements[i]], __ATOMIC_RELAXED))
            __atomic_store_n(&plan->is_used[plan->work.elements[i]], PL_USED | PL_NOT_CHOSEN,
                             __ATOMIC_RELAXED);
}

/** Fill the plan's figures: those of all processes. */
static void fill_info(planish_plan *plan, pl_draft *d) {
    planish_plan_info *info = &plan->info;
    info->n_free = plan->interior.stars.n_stars;
    info->n_sliding = 0;
    for (int64_t i = 0; i < plan->work.n_nodes; i++) /* with those that move with others */
        info->n_sliding += plan->work.mobility[i] == PL_SLIDES && pl_is_own(pl_part_here(), i);
    info->n_fixed_elements = 0;
    if (plan->work.corner)
        pl_parallel_for(plan->threads, plan->work.n_cells, CHUNK_ELEMENTS, count_fixed_cells, plan);
    else
        pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK_ELEMENTS, count_chunk, d);
    if (plan->scope == PL_SUBSET_OF_ALL)
        info->n_fixed_elements += plan->whole.n_elements - plan->work.n_elements;
    if (plan->scope != PL_SUBSET_OF_ALL)
        info->n_negative_order = d->boundary.n_reversed;
    info->n_boundary_facets = d->boundary.n_boundary_facets;
    info->n_nonmanifold_facets = d->boundary.n_nonmanifold_facets;
    info->n_duplicate_elements = d->boundary.n_duplicate_elements;
    info->n_wrapped = plan->n_wrapped;
    info->n_colours = pl_plan_colours(plan);
    info->threads = plan->threads;
    info->isa = plan->kernel->name;
    info->binding = plan->placement->text;
    int64_t *const count[] = {&info->n_free,
                              &info->n_sliding,
                              &info->n_fixed_elements,
                              &info->n_negative_order,
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
    /* Figures that were not counted: draft.c says when the facets were not looked at. */
    info->n_components = d->boundary.n_components > 0 ? d->boundary.n_components : -1;
    if (plan->is_selective || plan->scope == PL_SUBSET_ALONE) /* in a subset nobody knows of them */
        info->n_unused = -1;
    if (d->boundary.is_guess && d->is_selected)
        info->n_boundary_facets = info->n_nonmanifold_facets = info->n_duplicate_elements = -1;
}

static int64_t larger(int64_t a, int64_t b) {
    return a > b ? a : b;
}

/** Make the working space, but for that of ghosts. */
static int prepare_scratch(planish_plan *plan, planish_error *error) {
    const int64_t values = plan->work.n_nodes * plan->dim;
    const pl_stars *interior = &plan->interior.stars, *sliding = &plan->sliding.stars;
    const int64_t bytes =
        pl_star_scratch_size(plan->dim, larger(interior->max_ring, sliding->max_ring),
                             larger(interior->max_link, sliding->max_link), 0);
    pl_plan_scratch *s = &plan->scratch;
    s->kernel_stride = bytes / (int64_t)sizeof(double);
    s->coordinates = pl_alloc(values + plan->n_images * plan->dim, sizeof *s->coordinates);
    s->to_measure = pl_alloc(values, sizeof *s->to_measure);
    s->changed = pl_alloc_zero(plan->work.n_nodes + plan->n_images, 1);
    s->kernels = pl_alloc(s->kernel_stride * plan->threads, sizeof *s->kernels);
    s->tally = pl_alloc(plan->threads, sizeof *s->tally);
    s->places = pl_alloc(plan->sliding.n_followers, sizeof *s->places);
    s->kept =
        plan->dim == 3 ? pl_alloc(interior->n_stars + sliding->n_stars, sizeof *s->kept) : NULL;
    const pl_points points = pl_plan_points(plan, s->coordinates);
    const int is_dense = pl_points_are_dense(&points);
    s->given = is_dense ? NULL : pl_alloc(values, sizeof *s->given);
    return s->coordinates && s->to_measure && s->changed && s->kernels && s->tally && s->places &&
                   (s->kept || plan->dim == 2) && (s->given || is_dense)
               ? PLANISH_OK
               : pl_fail_memory(error, "the working space of a plan");
}

static int fill_plan(planish_plan *plan, const planish_mesh *mesh, pl_draft *d,
                     planish_error *error) {
    int status = pl_draft_begin(mesh, d, error);
    if (!status)
        status = pl_parts_begin(mesh->n_nodes, error);
    if (!status)
        status = pl_draft_finish(d, error);
    if (!status)
        status = pl_ghosts_create(plan, d->mesh, d->order, error);
    plan->work.is_movable = plan->ghosts.is_movable;
    if (!status)
        status = prepare_scratch(plan, error);
    if (status)
        return status;
    fill_info(plan, d);
    /* What planish_measure tells of all of the mesh. */
    for (int64_t i = 0; d->whole_mobility && i < plan->work.n_nodes; i++)
        d->whole_mobility[plan->node_of[i]] = plan->work.mobility[i];
    return pl_parts_check(error);
}

/** Number of threads: options->threads; instead of 0 fewer than OpenMP would use, if the mesh is
 * too small for these. */
static int threads_for(const planish_mesh *mesh, const planish_options *options) {
    enum { ELEMENTS_OF_A_NODE = 24, ELEMENTS_PER_THREAD = 2000 };
    const int walks = options->around_elements && (mesh->neighbours || mesh->neighbours64);
    const double wide = options->rings + 1.0; /* its cube may be beyond 64 bits */
    double n = (double)mesh->n_elements;      /* that the plan will be for, about */
    if (options->threads != 0)
        return options->threads;
    if (options->around && walks && options->n_around >= 1)
        n = fmin(n, (double)options->n_around * ELEMENTS_OF_A_NODE * wide * wide * wide);
    const int64_t enough = (int64_t)n / ELEMENTS_PER_THREAD + 1;
    return enough < pl_thread_count(0) ? (int)enough : 0;
}

planish_plan *pl_plan_make(const planish_mesh *mesh, const planish_options *options,
                           pl_context *context, int *status, planish_error *error) {
    planish_plan *plan = pl_alloc_zero(1, sizeof *plan);
    pl_placement *placement =
        pl_placement_create(threads_for(mesh, options), options->bind && !options->parallel);
    if (!plan || !placement) {
        pl_placement_destroy(placement);
        pl_free(plan);
        *status = pl_fail_memory(error, "a plan");
        return NULL;
    }
    pl_context_pool_pages(context, mesh->n_elements, placement->is_near);
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    plan->context = context;
    plan->placement = placement;
    plan->threads = placement->threads;
    plan->kernel = pl_star_kernel_select(options->isa);
    plan->dim = mesh->dim;
    plan->shape = options->shape;
    plan->rounding = options->rounding;
    plan->all = &plan->work;
    plan->work = plan->whole = (pl_view){.dim = mesh->dim,
                                         .n_nodes = mesh->n_nodes,
                                         .n_elements = mesh->n_elements,
                                         .is_counted = mesh->part ? mesh->part->is_counted : NULL};
    plan->node_stride = points.step;
    plan->component_stride = points.apart;
    pl_draft d = {.plan = plan, .options = options};
    pl_placement_enter(placement);
    *status = fill_plan(plan, mesh, &d, error);
    pl_draft_destroy(&d);
    pl_placement_leave(placement);
    if (!*status)
        return plan;
    pl_plan_destroy(plan);
    return NULL;
}
