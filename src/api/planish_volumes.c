/* planish_volumes: elements below their minimum volumes, and those that nothing can repair. */
#include "improve/improve.h"
#include "improve/untangle/proofs.h"

#include "base/clock.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"
#include "topology/points.h"

#include <string.h>

/** A look at the elements. Arrays are owned: the plan's own may be in use. */
typedef struct volume_check {
    const planish_plan *plan;
    const planish_options *options;
    int by_volume;        /* minimum volumes count, else elements are to be positive */
    pl_stop_check *limit; /* of the search for proofs, or NULL */
    double start;         /* clock */
    double *all;          /* [.][dim] of all nodes that are known, if they are not dense, */
    double *own;          /* [n][dim] of the plan's nodes, likewise */
    double *ordered;      /* [n][dim] the latter by inner numbers */
    uint8_t *state;       /* [elements of all]; once proofs have been looked for, a cell's worst */
    uint8_t *of_work;     /* and of the plan's; the same array if that is all */
} volume_check;

/** Ask the caller and the time limit; returns the planish_stop, or 0 to continue. */
static int ask_caller(void *context) {
    const volume_check *c = context;
    const planish_progress progress = {.n_colours = pl_plan_colours(c->plan),
                                       .elapsed = pl_seconds() - c->start};
    if (c->options->time_limit > 0 && progress.elapsed >= c->options->time_limit)
        return PLANISH_STOP_TIME_LIMIT;
    return pl_ask_caller(c->options, &progress) ? PLANISH_STOP_INTERRUPTED : 0;
}

/** Give the corners of each cell the worst state that one of them has; return how many cells have one
 *  of at least that state. */
static int64_t join_corners(const pl_view *mesh, uint8_t least, uint8_t *state) {
    int64_t n = 0;
    for (int64_t i = 0; i < pl_view_cells(mesh); i++) {
        const int64_t first = pl_first_of_cell(mesh, i), end = pl_first_of_cell(mesh, i + 1);
        uint8_t worst = 0;
        for (int64_t k = first; k < end; k++)
            worst = state[k] > worst ? state[k] : worst;
        if (mesh->corner)
            memset(state + first, worst, (size_t)(end - first));
        n += worst >= least;
    }
    return n;
}

/** Turn _BELOW into _INFEASIBLE where that is so: in the plan's subset by proofs, and outside of
 *  it, where no node is free. */
static int mark_infeasible(const volume_check *c, const double *coordinates,
                           const pl_star_guard *guard, pl_infeasible *found, planish_error *error) {
    const planish_plan *plan = c->plan;
    const int is_subset = c->of_work != c->state;
    const pl_points points = pl_plan_points(plan, coordinates);
    pl_star_problem problem = pl_plan_problem(plan, &plan->interior);
    int status = PLANISH_OK;
    problem.coordinates = c->ordered;
    problem.guard = guard;
    const double *given = pl_plan_dense(plan, &points, c->own);
    pl_plan_order(plan, given, c->ordered);
    for (int64_t i = 0; is_subset && i < plan->work.n_elements; i++)
        c->of_work[i] = c->state[plan->element_of[i]];
    if (!(guard->min_volume > 0) && !guard->link_min_volume)
        status = pl_mark_enclosed(plan, c->ordered, c->of_work, NULL, &found->n, error);
    if (!status)
        status = pl_mark_infeasible(plan, &problem, c->of_work, c->limit, found, NULL, error);
    if (!status && !c->by_volume && c->options->curve_quality > 0)
        status =
            pl_mark_hopeless(plan, c->options, given, coordinates, c->limit, c->of_work, error);
    for (int64_t i = 0; is_subset && i < plan->all->n_elements; i++)
        if (c->state[i] == PLANISH_VOLUME_BELOW)
            c->state[i] = PLANISH_VOLUME_INFEASIBLE;
    for (int64_t i = 0; is_subset && i < plan->work.n_elements; i++)
        c->state[plan->element_of[i]] = c->of_work[i];
    found->n = join_corners(plan->all, PLANISH_VOLUME_INFEASIBLE, c->state);
    return status;
}

/** Find the states. is_asked: proofs are wanted of elements below their minimum volume. *n: those
 *  below their minimum volume, or the infeasible ones. *n_undecided: those that the limit has left.
 *  In a mesh in parts all processes search with a limit, whatever they have and are asked for: one
 *  of them may end the search of all, and perhaps only that one has a callback. */
static int find_states(const volume_check *c, const double *coordinates, int is_asked, int64_t *n,
                       int64_t *n_undecided, planish_error *error) {
    const planish_plan *plan = c->plan;
    const pl_points points = pl_plan_all_points(plan, coordinates);
    const double *all = pl_plan_dense(plan, &points, c->all);
    pl_star_guard guard = {.ratio_weight = 1};
    pl_infeasible found = {0, 0};
    int status = PLANISH_OK;
    if (c->by_volume) {
        guard.link_min_volume = plan->interior.stars.min_volume;
        status = pl_minimum_volume(plan, c->options, all, &guard.min_volume, error);
        if (status)
            return status;
    }
    const pl_view mesh = pl_view_of_all_elements(plan->all);
    pl_objective_problem problem =
        pl_objective_problem_of(&mesh, all, c->options, guard.min_volume, plan->threads);
    if (c->by_volume) {
        *n = pl_find_below(&problem, c->state);
    } else {
        problem.mesh.min_volume = NULL;
        *n = pl_find_inverted(&problem, c->state);
    }
    const int is_curved = !c->by_volume && plan->cells.n > 0; /* perhaps */
    if (pl_part_here() || is_curved || (*n > 0 && (is_asked || !c->by_volume)))
        status = mark_infeasible(c, coordinates, &guard, &found, error);
    if (mesh.corner && c->by_volume)
        *n = join_corners(&mesh, PLANISH_VOLUME_BELOW, c->state);
    if (!c->by_volume)
        *n = found.n;
    *n_undecided = found.n_undecided;
    return status;
}

/** Serve both calls: minimum volumes with by_volume, else positive elements. *n and *n_undecided (may
 *  be NULL) change with success alone. */
static int find_elements(const planish_plan *plan, const double *coordinates,
                         const planish_options *options, int by_volume, uint8_t *out, int64_t *n,
                         int64_t *n_undecided, planish_error *error) {
    planish_options defaults;
    int64_t n_found = 0, n_left = 0;
    if (!plan || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "plan and coordinates must not be NULL");
    planish_options_init(&defaults);
    defaults.rounding = plan->rounding;
    const pl_outside outside = pl_call_enter(plan->context);
    volume_check c = {.plan = plan,
                      .options = options ? options : &defaults,
                      .by_volume = by_volume,
                      .start = pl_seconds()};
    pl_stop_check limit = pl_limit_of(ask_caller, &c);
    if (pl_part_here() || c.options->time_limit > 0 || c.options->progress)
        c.limit = &limit;
    int status = pl_plan_check_call(plan, coordinates, c.options, error);
    if (!status) {
        const pl_points all = pl_plan_all_points(plan, coordinates);
        const pl_points own = pl_plan_points(plan, coordinates);
        c.all = pl_alloc(pl_points_are_dense(&all) ? 0 : all.n * all.dim, sizeof *c.all);
        c.own = pl_alloc(pl_points_are_dense(&own) ? 0 : own.n * own.dim, sizeof *c.own);
        c.ordered = pl_alloc(own.n * own.dim, sizeof *c.ordered);
        c.state = pl_alloc(plan->all->n_elements, sizeof *c.state);
        c.of_work =
            plan->all == &plan->work ? c.state : pl_alloc(plan->work.n_elements, sizeof *c.of_work);
        status = c.all && c.own && c.ordered && c.state && c.of_work
                     ? find_states(&c, coordinates, out || n_undecided, &n_found, &n_left, error)
                     : pl_fail_memory(error, "the states of elements");
        if (!status)
            status = pl_parts_check(error);
    }
    for (int64_t i = 0; !status && !by_volume && i < plan->all->n_elements; i++)
        c.state[i] = c.state[i] == PLANISH_VOLUME_INFEASIBLE;
    if (!status && out) {
        memset(out, 0, (size_t)pl_plan_given(plan)); /* or PLANISH_VOLUME_MET */
        pl_plan_put(plan, c.state, sizeof *out, out);
    }
    if (!status)
        *n = n_found;
    if (!status && n_undecided)
        *n_undecided = n_left;
    if (c.of_work != c.state)
        pl_free(c.of_work);
    pl_free(c.state);
    pl_free(c.ordered);
    pl_free(c.own);
    pl_free(c.all);
    pl_call_leave(&outside);
    return status;
}

int planish_check_volumes(const planish_plan *plan, const double *coordinates,
                          const planish_options *options, uint8_t *state, int64_t *n_below,
                          int64_t *n_undecided, planish_error *error) {
    if (!n_below)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "n_below must not be NULL");
    return find_elements(plan, coordinates, options, 1, state, n_below, n_undecided, error);
}

int planish_find_infeasible(const planish_plan *plan, const double *coordinates,
                            const planish_options *options, uint8_t *infeasible, int64_t *n,
                            int64_t *n_undecided, planish_error *error) {
    if (!n)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "n must not be NULL");
    return find_elements(plan, coordinates, options, 0, infeasible, n, n_undecided, error);
}
