/* plan: what the other folders ask of a plan, and its end; make.c makes it. */
#include "plan/plan.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/simplex.h"
#include "plan/ghosts.h"
#include "shape/size_field.h"

#include <math.h>
#include <string.h>

enum { CHUNK_NODES = 1024 };

static void visits_destroy(pl_visits *visits) {
    pl_stars_destroy(&visits->stars);
    pl_free(visits->centre);
    pl_free(visits->colour_begin);
    pl_free(visits->inside_begin);
    pl_free(visits->follower);
}

/** Free the arrays that a plan has made for a view. */
static void release_view(pl_view *view) {
    pl_free((void *)view->sign);
    pl_free((void *)view->corner);
    pl_free((void *)view->cell_begin);
    pl_free((void *)view->target);
    pl_free((void *)view->metric);
    pl_free((void *)view->min_volume);
    pl_free((void *)view->mobility);
}

static void release_scratch(pl_plan_scratch *scratch) {
    pl_free(scratch->given);
    pl_free(scratch->coordinates);
    pl_free(scratch->to_measure);
    pl_free(scratch->changed);
    pl_free(scratch->sizes);
    pl_free(scratch->kept);
    pl_free(scratch->is_movable);
    pl_free(scratch->places);
    pl_free(scratch->kernels);
    pl_free(scratch->tally);
    pl_free(scratch->before);
    pl_free(scratch->moved);
    pl_free(scratch->message);
}

void pl_plan_destroy(planish_plan *plan) {
    pl_ghosts_destroy(&plan->ghosts);
    pl_parts_end(plan->context);
    visits_destroy(&plan->interior);
    visits_destroy(&plan->sliding);
    pl_free(plan->slide);
    pl_free(plan->slides_by);
    pl_placement_destroy(plan->placement);
    pl_free(plan->own_elements);
    pl_free(plan->node_of);
    pl_free(plan->element_of);
    pl_free(plan->cell_of);
    pl_free(plan->role);
    pl_free(plan->own_cells.type);
    pl_free(plan->own_cells.offset);
    pl_free(plan->own_cells.node);
    pl_free(plan->own_whole_elements);
    if (plan->sizes)
        pl_size_field_destroy(plan->sizes);
    pl_free(plan->sizes);
    release_view(&plan->work);
    release_view(&plan->whole);
    pl_free(plan->wrapped);
    pl_free(plan->is_used);
    pl_free(plan->inner);
    release_scratch(&plan->scratch);
    pl_free(plan);
}

/* See pl_star_problem.still. Where only bad elements are repaired, many of them stand at a boundary
 * that cannot be: they are not looked at again for every tremor around. */
#define STILL        1e-4
#define STILL_OF_FEW 1e-2
/* With targets all nodes may come to rest together, where F is flat. */
#define STILL_WITH_TARGETS 1e-5

/** pl_star_problem.still. */
static double still_of(const planish_plan *plan) {
    return plan->is_selective ? STILL_OF_FEW : plan->work.target ? STILL_WITH_TARGETS : STILL;
}

pl_star_problem pl_plan_problem(const planish_plan *plan, const pl_visits *visits) {
    return (pl_star_problem){.coordinates = plan->scratch.coordinates,
                             .node = visits->centre,
                             .ring_offset = visits->stars.ring_offset,
                             .ring = visits->stars.ring,
                             .link_offset = visits->stars.link_offset,
                             .link = visits->stars.link,
                             .link_form = visits->stars.form,
                             .form = plan->form,
                             .target = plan->work.target,
                             .metric = plan->work.metric,
                             .size_weight = plan->work.size_weight,
                             .link_element = visits->stars.element,
                             .scratch = plan->scratch.kernels,
                             .scratch_stride = plan->scratch.kernel_stride,
                             .changed = plan->scratch.changed,
                             .limits = pl_star_no_limits(),
                             .still = still_of(plan),
                             .slide = visits == &plan->sliding ? plan->slide : NULL};
}

int pl_plan_colours(const planish_plan *plan) {
    return plan->interior.n_colours + plan->sliding.n_colours;
}

/** Coordinates and where they go. */
typedef struct loading {
    const planish_plan *plan;
    const double *coordinates;
    double *inside;
} loading;

static void load_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const loading *w = context;
    const int dim = w->plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < dim; d++)
            w->inside[(int64_t)w->plan->inner[i] * dim + d] = w->coordinates[i * dim + d];
}

void pl_plan_order(const planish_plan *plan, const double *coordinates, double *inside) {
    loading w = {plan, coordinates, inside};
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

pl_box pl_box_of_fixed(const planish_plan *plan) {
    const int dim = plan->dim;
    pl_box b;
    double width = 0;
    int exponent;
    for (int d = 0; d < dim; d++) {
        b.lower[d] = INFINITY;
        b.upper[d] = -INFINITY;
    }
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        for (int d = 0; d < dim && plan->is_used[i] && plan->work.mobility[i] != PL_INTERIOR; d++) {
            const double x = plan->scratch.coordinates[(int64_t)plan->inner[i] * dim + d];
            b.lower[d] = fmin(b.lower[d], x);
            b.upper[d] = fmax(b.upper[d], x);
        }
    pl_parts_smallest(b.lower, dim);
    pl_parts_largest(b.upper, dim);
    for (int d = 0; d < dim; d++)
        width = fmax(width, 0.5 * b.upper[d] - 0.5 * b.lower[d]);
    frexp(width, &exponent);
    b.scale = ldexp(1, -pl_scale_exponent(exponent));
    return b;
}

void pl_plan_put(const planish_plan *plan, const void *from, size_t size, void *to) {
    const pl_view *all = plan->all;
    if (!all->corner) {
        pl_rows_put(from, pl_plan_rows(plan), all->n_elements, size, plan->threads, to);
        return;
    }
    for (int64_t i = 0; i < all->n_cells; i++) {
        const int64_t first = all->cell_begin[i];
        memcpy((char *)to + (size_t)plan->cell_of[first] * size,
               (const char *)from + (size_t)first * size, size);
    }
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
    if (options->shape && options->shape != plan->shape)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.shape is not the one that the plan was made with; give the same "
                       "shape to planish_plan_create");
    if (plan->cells.n > 0 && options->rounding != plan->rounding)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.rounding is %g, but the plan was made with %g; give both the same",
                       options->rounding, plan->rounding);
    const pl_points points = pl_plan_all_points(plan, coordinates);
    return pl_points_check(&points, plan->threads, error);
}

void pl_plan_begin_sizes(planish_plan *plan) {
    pl_size_field_begin(plan->sizes);
    pl_plan_fit_sizes(plan, plan->scratch.coordinates, plan->inner);
}

void pl_plan_fit_sizes(planish_plan *plan, const double *x, const int32_t *place) {
    const pl_view *work = &plan->work;
    const pl_sized_corners corners = {.dim = plan->dim,
                                      .n = work->n_elements,
                                      .node = work->elements,
                                      .corner = work->corner,
                                      .n_numbers = plan->sizes->n_numbers,
                                      .size = plan->scratch.sizes,
                                      .x = x,
                                      .place = place};
    pl_size_field_find(plan->sizes, x, place, plan->threads, plan->scratch.sizes);
    plan->size_factor = pl_sizes_fit(&corners, plan->size_factor, plan->threads,
                                     (pl_target *)work->target, (pl_metric *)work->metric);
}
