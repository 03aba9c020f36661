/* guard: what options and plan ask of the guarded kernel: objective, minimum volumes, bounds. */
#include "sweep/guard.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/round.h"
#include "base/status.h"
#include "geometry/simplex.h"
#include "quality/certificate.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { CHUNK_NODES = 4096 };

/* f1 and f2 count as at least this where one divides by them. */
#define LEAST_RMS 1e-100

/* ---- objective ----------------------------------------------------------------------------- */

int pl_minimum_volume(const planish_plan *plan, const planish_options *options, const double *all,
                      double *delta, planish_error *error) {
    const pl_view mesh = pl_view_of_all_elements(plan->all);
    const pl_objective_problem problem =
        pl_objective_problem_of(&mesh, all, options, options->min_volume, plan->threads);
    *delta = pl_minimum_volume_of(options, &problem);
    if (!(options->min_volume_fraction > 0) || (*delta >= DBL_MIN && isfinite(*delta)))
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                   "options.min_volume_fraction is %g, but the domain's volume times that is %g; "
                   "scale the mesh to a size whose volumes are numbers",
                   options->min_volume_fraction, *delta);
}

double pl_guard_weigh(pl_guard *guard, const planish_options *options,
                      const pl_objective_sums *sums) {
    double n = sums->n[0] + sums->n[1], mu2 = options->area_weight, mu1 = 1 - mu2;
    double of_ratio = mu1 / fmax(pl_rms_of_all(sums), LEAST_RMS);
    double of_volume =
        mu2 > 0 ? mu2 / fmax(pl_rms(sums->volume[0] + sums->volume[1], n), LEAST_RMS) : 0;
    double unit = mu1 > 0 ? of_ratio : of_volume;
    guard->star.ratio_weight = of_ratio / unit;
    guard->star.volume_weight = of_volume / unit;
    return n > 0 ? unit / (2 * n) : 0;
}

/* ---- bounds -------------------------------------------------------------------------------- */

/** Bounds under way. */
typedef struct bounding {
    const planish_plan *plan;
    const pl_visits *visits; /* of limit_stars */
    const planish_options *options;
    const double *coordinates;
    double *lower, *upper, *start, *radius; /* by inner numbers */
    uint8_t *is_edge; /* [ring] of visits 1: an edge of a cell leads there; NULL: one always does */
    uint8_t *group;   /* likewise: of nodes that move together, and LEFT_ALONE */
    uint8_t *mobility, *is_held; /* of pl_guard */
    int64_t held, left_alone;    /* shared */
} bounding;

enum { GROUPED = 1, LEFT_ALONE = 2 }; /* bits */

/** x, or where less than doubles can be stored the next such value that is not below (above) it:
 *  looked for in growing steps. */
static double storable(const planish_options *options, double x, double towards) {
    const pl_storage storage = pl_storage_of(options);
    double rounded = isfinite(x) ? pl_store(&storage, x) : x;
    double step = fabs(nextafter(x, INFINITY) - x);
    while (isfinite(step) && (towards > 0 ? rounded < x : rounded > x)) {
        rounded = pl_store(&storage, towards > 0 ? x + step : x - step);
        step *= 2;
    }
    return rounded;
}

static void bound_nodes(void *context, int64_t begin, int64_t end, int thread) {
    bounding *w = context;
    const planish_options *options = w->options;
    const int dim = w->plan->dim;
    int64_t held = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t inner = w->plan->inner[i], node = pl_plan_node(w->plan, i);
        const double *x = w->coordinates + i * dim;
        double *lower = w->lower + inner * dim, *upper = w->upper + inner * dim;
        int outside = 0;
        for (int d = 0; d < dim; d++) {
            double low = options->box_lower[d], high = options->box_upper[d];
            if (options->lower && options->lower[node * dim + d] > low)
                low = options->lower[node * dim + d];
            if (options->upper && options->upper[node * dim + d] < high)
                high = options->upper[node * dim + d];
            lower[d] = storable(options, low, 1);
            upper[d] = storable(options, high, -1);
            outside |= !(lower[d] <= x[d] && x[d] <= upper[d]);
        }
        const int stays = outside || (w->group && w->group[inner] & LEFT_ALONE);
        for (int d = 0; stays && d < dim; d++)
            lower[d] = upper[d] = x[d];
        w->mobility[i] = w->plan->work.mobility[i] && !stays;
        held += outside && w->plan->work.mobility[i] && pl_is_own(pl_part_here(), i);
    }
    __atomic_fetch_add(&w->held, held, __ATOMIC_RELAXED);
}

/** Mark to which nodes of its ring edges of cells lead from the node of star s. Return how many. */
static int64_t mark_edges(const bounding *w, int64_t s) {
    const pl_stars *stars = &w->visits->stars;
    const int dim = w->plan->dim;
    const int64_t first = stars->ring_offset[s], n = stars->ring_offset[s + 1] - first;
    const int64_t facet = stars->link_offset[s], n_facets = stars->link_offset[s + 1] - facet;
    const pl_link link =
        pl_link_at(&stars->link, pl_link_positions(dim, stars->form != NULL), facet);
    int64_t n_edges = 0;
    if (!w->is_edge || !stars->form)
        return n;
    for (int64_t i = 0; i < n_facets; i++) {
        const uint8_t code = stars->form[facet + i];
        const int corner = w->plan->form[code].corner;
        for (int j = 0; j < dim; j++)
            if (corner < 0 || j == corner || pl_corner_kind(code) == PL_KIND_SIMPLEX)
                w->is_edge[first + pl_link_get(&link, i * dim + j)] = 1;
    }
    for (int64_t i = 0; i < n; i++)
        n_edges += w->is_edge[first + i];
    return n_edges;
}

static void limit_stars(void *context, int64_t begin, int64_t end, int thread) {
    const bounding *w = context;
    const pl_visits *visits = w->visits;
    const int dim = w->plan->dim, by_edge = w->options->displacement_unit == PLANISH_UNIT_EDGE;
    (void)thread;
    for (int64_t s = begin; s < end; s++) {
        const int64_t node = visits->centre[s];
        const int64_t first = visits->stars.ring_offset[s], last = visits->stars.ring_offset[s + 1];
        const double *x = w->plan->scratch.coordinates + node * dim;
        double unit = by_edge ? 0 : 1; /* or the mean length of the node's edges */
        const int64_t n_edges = by_edge ? mark_edges(w, s) : 0;
        for (int64_t i = first; by_edge && i < last; i++) {
            const double *y = w->plan->scratch.coordinates + (int64_t)visits->stars.ring[i] * dim;
            if (!w->is_edge || w->is_edge[i])
                unit += pl_distance(dim, x, y) / (double)n_edges;
        }
        w->radius[node] = w->options->max_displacement * unit;
        for (int d = 0; d < dim; d++)
            w->start[node * dim + d] = x[d];
    }
}

static void leave_alone(void *context, int64_t begin, int64_t end, int thread) {
    bounding *w = context;
    const planish_plan *plan = w->plan;
    int64_t left_alone = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t *node = plan->work.elements + i * (plan->dim + 1);
        const double *vertex[4];
        int grouped = 0;
        for (int j = 0; j <= plan->dim; j++) {
            vertex[j] = w->coordinates + (int64_t)node[j] * plan->dim;
            grouped |= __atomic_load_n(&w->group[plan->inner[node[j]]], __ATOMIC_RELAXED) & GROUPED;
        }
        if (!grouped ||
            pl_measure_sign(plan->dim, vertex) * (plan->work.sign ? plan->work.sign[i] : 1) > 0)
            continue;
        left_alone++;
        for (int j = 0; j <= plan->dim; j++)
            __atomic_fetch_or(&w->group[plan->inner[node[j]]], LEFT_ALONE, __ATOMIC_RELAXED);
    }
    __atomic_fetch_add(&w->left_alone, left_alone, __ATOMIC_RELAXED);
}

/** Find the nodes at elements that are not positive and shall stay as they are, where some of them
 * move with others: the copy that the leader sees may be positive, by the rounding of its place.
 * 0 without memory. */
static int find_left_alone(bounding *w) {
    const planish_plan *plan = w->plan;
    const pl_visits *visits = &plan->sliding;
    if (w->options->untangle || w->options->method != PLANISH_METHOD_PLANISH ||
        visits->n_followers == 0)
        return 1;
    w->group = pl_alloc_zero(plan->work.n_nodes, sizeof *w->group);
    if (!w->group)
        return 0;
    for (int64_t k = 0; k < visits->n_followers; k++)
        if (visits->follower[k].node < plan->work.n_nodes)
            w->group[visits->follower[k].node] = w->group[visits->follower[k].of] = GROUPED;
    pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK_NODES, leave_alone, w);
    return 1;
}

/** Bounds that are numbers, or infinite. */
static int check_bounds(const planish_plan *plan, const planish_options *options,
                        planish_error *error) {
    const double *bounds[] = {options->lower, options->upper};
    for (int which = 0; which < 2; which++)
        for (int64_t i = 0; bounds[which] && i < plan->work.n_nodes * plan->dim; i++) {
            const int64_t node = pl_plan_node(plan, i / plan->dim);
            if (isnan(bounds[which][node * plan->dim + i % plan->dim]))
                return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, node,
                                  "options.%s of node %" PRId64
                                  " is not a number; give a bound, or "
                                  "an infinite one for none",
                                  which ? "upper" : "lower", node);
        }
    return PLANISH_OK;
}

/** Translate the bound (sign 1: the lower one, -1: the upper) of a follower to the node that it
 *  follows. The follower's place, rounded as pl_follow does, is then never beyond its bound, and
 *  exact at the bound. */
static double bound_of_leader(const pl_follower_places *places, int d, double bound, int sign) {
    enum { TRIES = 8 };
    double limit = places->origin[d] + (bound - places->start[d]);
    for (int i = 0; i < TRIES; i++) {
        const double place = places->start[d] + (limit - places->origin[d]),
                     beyond = sign * (bound - place);
        if (!(beyond > 0))
            return limit;
        limit = nextafter(limit + sign * beyond, sign > 0 ? INFINITY : -INFINITY);
    }
    return places->origin[d];
}

/** Bound nodes that others follow by what bounds these, too; all are held if one is. */
static void bound_leaders(const bounding *w) {
    const planish_plan *plan = w->plan;
    const int dim = plan->dim;
    for (int64_t k = 0; w->lower && k < plan->sliding.n_followers; k++) {
        const pl_follower *f = &plan->sliding.follower[k];
        if (f->node >= plan->work.n_nodes)
            continue;
        double *lower = w->lower + (int64_t)f->of * dim, *upper = w->upper + (int64_t)f->of * dim;
        const pl_follower_places *places = &plan->scratch.places[k];
        const double *low = w->lower + (int64_t)f->node * dim;
        const double *high = w->upper + (int64_t)f->node * dim;
        for (int d = 0; d < dim; d++) {
            lower[d] = fmax(lower[d], bound_of_leader(places, d, low[d], 1));
            upper[d] = fmin(upper[d], bound_of_leader(places, d, high[d], -1));
        }
    }
}

static void mark_held_cells(void *context, int64_t begin, int64_t end, int thread) {
    const bounding *w = context;
    const pl_view *mesh = &w->plan->work;
    const int n = mesh->dim + 1;
    (void)thread;
    for (int64_t cell = begin; cell < end; cell++) {
        const int64_t first = pl_first_of_cell(mesh, cell), last = pl_first_of_cell(mesh, cell + 1);
        int moves = 0, is_movable = 0;
        for (int64_t i = first; i < last; i++) {
            moves |= pl_any_moves(w->mobility, mesh->elements + i * n, n);
            is_movable |= pl_any_moves(mesh->mobility, mesh->elements + i * n, n);
        }
        memset(w->is_held + first, is_movable && !moves, (size_t)(last - first));
    }
}

/** Mark the elements whose movable nodes are all held, if a node is held in any process. 0 without
 *  memory. */
static int find_held_elements(bounding *w, pl_guard *guard) {
    const pl_view *mesh = &w->plan->work;
    int is_held = 0;
    for (int64_t i = 0; w->mobility && i < mesh->n_nodes; i++)
        is_held |= mesh->mobility[i] && !w->mobility[i];
    if (!pl_parts_any(is_held))
        return 1;
    guard->is_held = w->is_held = pl_alloc_zero(mesh->n_elements, sizeof *w->is_held);
    if (w->is_held && w->mobility)
        pl_parallel_for(w->plan->threads, pl_view_cells(mesh), CHUNK_NODES, mark_held_cells, w);
    return w->is_held != NULL;
}

static int make_bounds(const planish_plan *plan, const planish_options *options,
                       const double *coordinates, pl_guard *guard, planish_error *error) {
    const int64_t values = plan->work.n_nodes * plan->dim;
    bounding w = {.plan = plan, .options = options, .coordinates = coordinates};
    int memory = find_left_alone(&w);
    int is_bounded = options->lower || options->upper || w.left_alone > 0;
    for (int d = 0; d < plan->dim; d++)
        is_bounded |= options->box_lower[d] > -INFINITY || options->box_upper[d] < INFINITY;
    if (memory && is_bounded) {
        guard->star.lower = w.lower = pl_alloc(values, sizeof *w.lower);
        guard->star.upper = w.upper = pl_alloc(values, sizeof *w.upper);
        guard->mobility = w.mobility = pl_alloc(plan->work.n_nodes, sizeof *w.mobility);
        memory = w.lower && w.upper && w.mobility;
    }
    if (options->max_displacement > 0) {
        guard->star.start = w.start = pl_alloc(values, sizeof *w.start);
        guard->star.radius = w.radius = pl_alloc(plan->work.n_nodes, sizeof *w.radius);
        memory = memory && w.start && w.radius;
        /* Mids are bound by both of their ends (improve/mend/handle.c), of which one may have no star. */
        const int by_edge = options->displacement_unit == PLANISH_UNIT_EDGE;
        for (int64_t i = 0; memory && i < plan->work.n_nodes; i++)
            w.radius[i] = by_edge ? 0 : options->max_displacement;
    }
    if (!memory) {
        pl_free(w.group);
        return pl_fail_memory(error, "the bounds of the nodes");
    }
    if (w.lower)
        pl_parallel_for(plan->threads, plan->work.n_nodes, CHUNK_NODES, bound_nodes, &w);
    const pl_visits *visits[] = {&plan->interior, &plan->sliding};
    for (int i = 0; w.radius && memory && i < 2; i++) {
        const pl_stars *stars = &visits[i]->stars;
        w.visits = visits[i];
        w.is_edge = stars->form ? pl_alloc_zero(stars->ring_offset[stars->n_stars], 1) : NULL;
        memory = w.is_edge || !stars->form;
        if (memory)
            pl_parallel_for(plan->threads, stars->n_stars, CHUNK_NODES, limit_stars, &w);
        pl_free(w.is_edge);
    }
    pl_parts_add(&w.held, 1);
    guard->held_outside = w.held;
    bound_leaders(&w);
    pl_free(w.group);
    memory = find_held_elements(&w, guard) && memory;
    return memory ? PLANISH_OK : pl_fail_memory(error, "the bounds of the nodes");
}

/* ---- the guard ----------------------------------------------------------------------------- */

/** With an area weight g must be a number that elements can differ by: V / delta below this. */
#define LARGEST_MULTIPLE 1e12

static int check_area_weight(const planish_plan *plan, const planish_options *options,
                             const double *coordinates, double delta, planish_error *error) {
    if (!(options->area_weight > 0))
        return PLANISH_OK;
    const double *min_volume = plan->all->min_volume;
    for (int64_t i = 0; i < plan->all->n_elements && !(delta > 0); i++) {
        const int32_t *row = pl_plan_rows(plan);
        const int64_t element = row ? row[i] : i;
        if (!min_volume || !(min_volume[i] > 0))
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, element, -1,
                              "options.area_weight is %g, but element %" PRId64
                              " has no minimum volume; give min_volume or min_volume_fraction",
                              options->area_weight, element);
    }
    const pl_view mesh = pl_view_of_all_elements(&plan->work);
    const pl_objective_problem problem =
        pl_objective_problem_of(&mesh, coordinates, options, delta, plan->threads);
    pl_objective_sums sums;
    pl_sum_objective(&problem, &sums);
    double g2 = (sums.volume[0] + sums.volume[1]) / fmax(sums.n[0] + sums.n[1], 1);
    if (!(g2 < LARGEST_MULTIPLE * LARGEST_MULTIPLE))
        return pl_fail(
            error, PLANISH_ERROR_ARGUMENT,
            "options.area_weight is %g, but volumes are %g times their minimum volume; give "
            "one that is nearer to them",
            options->area_weight, sqrt(g2));
    return PLANISH_OK;
}

int pl_guard_create(const planish_plan *plan, const planish_options *options,
                    const double *coordinates, double delta, pl_guard *guard,
                    planish_error *error) {
    *guard = (pl_guard){.min_volume = delta,
                        .star = {.objective = (int)options->objective,
                                 .ratio_weight = 1,
                                 .min_volume = delta,
                                 .link_min_volume = plan->interior.stars.min_volume}};
    int status = check_area_weight(plan, options, coordinates, delta, error);
    if (!status)
        status = check_bounds(plan, options, error);
    if (!status)
        status = make_bounds(plan, options, coordinates, guard, error);
    if (status)
        pl_guard_destroy(guard);
    const int is_constrained = options->area_weight > 0 || delta > 0 || plan->work.min_volume ||
                               guard->star.lower || guard->star.radius;
    const int has_kernel = plan->work.corner || !(options->only_worse_than > 0)
                               ? pl_is_mean(options->objective)
                               : options->objective == PLANISH_OBJECTIVE_RADIUS_RATIO;
    guard->in_visits = is_constrained || !has_kernel;
    guard->wanted = guard->in_visits ||
                    (!plan->work.corner && options->objective == PLANISH_OBJECTIVE_MEAN_RATIO);
    return status;
}

void pl_guard_destroy(pl_guard *guard) {
    pl_free((void *)guard->star.lower);
    pl_free((void *)guard->star.upper);
    pl_free((void *)guard->star.start);
    pl_free((void *)guard->star.radius);
    pl_free(guard->mobility);
    pl_free(guard->is_held);
    guard->mobility = guard->is_held = NULL;
    guard->star.lower = guard->star.upper = guard->star.start = guard->star.radius = NULL;
}
