/* planish_volumes: elements below their minimum volumes, and those that nothing can repair. */
#include "improve/untangle/proofs.h"
#include "sweep/guard.h"

#include "base/clock.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"

/** Room for the coordinates and states of a call: the plan's own may be in use. */
typedef struct room {
    const planish_plan *plan;
    pl_points all_points, points;
    double *all;      /* [.][dim] of all_points, if these are not dense, */
    double *own;      /* [n][dim] of the plan's nodes, likewise */
    double *ordered;  /* [n][dim] the latter by inner numbers */
    uint8_t *state;   /* [elements of all], */
    uint8_t *of_part; /* and of the plan's; the same array if that is all */
    int64_t n_of_all;
} room;

static void room_destroy(room *r) {
    if (r->of_part != r->state)
        pl_free(r->of_part);
    pl_free(r->state);
    pl_free(r->ordered);
    pl_free(r->own);
    pl_free(r->all);
}

static int room_create(const planish_plan *plan, const double *coordinates, room *r,
                       planish_error *error) {
    const int is_part = plan->scope == PL_SUBSET_OF_ALL;
    *r = (room){.plan = plan,
                .all_points = pl_plan_all_points(plan, coordinates),
                .points = pl_plan_points(plan, coordinates),
                .n_of_all = plan->all->n_elements};
    const int all_dense = pl_points_are_dense(&r->all_points);
    const int own_dense = pl_points_are_dense(&r->points);
    r->all = all_dense ? NULL : pl_alloc(r->all_points.n * plan->dim, sizeof *r->all);
    r->own = own_dense ? NULL : pl_alloc(plan->work.n_nodes * plan->dim, sizeof *r->own);
    r->ordered = pl_alloc(plan->work.n_nodes * plan->dim, sizeof *r->ordered);
    r->state = pl_alloc(r->n_of_all, sizeof *r->state);
    r->of_part = is_part ? pl_alloc(plan->work.n_elements, sizeof *r->of_part) : r->state;
    if ((r->all || all_dense) && (r->own || own_dense) && r->ordered && r->state && r->of_part)
        return PLANISH_OK;
    room_destroy(r);
    return pl_fail_memory(error, "the states of elements");
}

/** Turn _BELOW into _INFEASIBLE where that is so: in the plan's part by pl_mark_infeasible, and
 *  outside of it, where no node is free. */
static int mark_states(room *r, const pl_star_guard *guard, pl_limit *limit, pl_infeasible *found,
                       planish_error *error) {
    const planish_plan *plan = r->plan;
    pl_star_problem problem = pl_plan_problem(plan);
    problem.coordinates = r->ordered;
    problem.guard = guard;
    const int is_all = r->of_part == r->state;
    int status = PLANISH_OK;
    pl_plan_order(plan, pl_plan_dense(plan, &r->points, r->own), r->ordered);
    for (int64_t i = 0; i < plan->work.n_elements && !is_all; i++)
        r->of_part[i] = r->state[plan->element_of[i]];
    if (!(guard->min_volume > 0) && !guard->link_min_volume)
        status = pl_mark_enclosed(plan, r->ordered, r->of_part, NULL, &found->n, error);
    if (status || is_all)
        return status ? status
                      : pl_mark_infeasible(plan, &problem, r->state, limit, found, NULL, error);
    status = pl_mark_infeasible(plan, &problem, r->of_part, limit, found, NULL, error);
    found->n = 0;
    for (int64_t i = 0; i < r->n_of_all; i++)
        if (r->state[i] == PLANISH_VOLUME_BELOW)
            r->state[i] = PLANISH_VOLUME_INFEASIBLE;
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        r->state[plan->element_of[i]] = r->of_part[i];
    for (int64_t i = 0; i < r->n_of_all; i++)
        found->n += r->state[i] == PLANISH_VOLUME_INFEASIBLE;
    return status;
}

/** The states as the caller wants them: of each element of the mesh. */
static void hand_out(const room *r, int only_infeasible, uint8_t *out) {
    const planish_plan *plan = r->plan;
    const int is_alone = plan->scope == PL_SUBSET_ALONE;
    if (out && is_alone)
        memset(out, PLANISH_VOLUME_MET, (size_t)plan->whole.n_elements);
    for (int64_t i = 0; out && i < r->n_of_all; i++)
        out[is_alone ? plan->element_of[i] : i] =
            only_infeasible ? r->state[i] == PLANISH_VOLUME_INFEASIBLE : r->state[i];
}

/** A call that the caller's options end. */
typedef struct patience {
    const planish_options *options;
    double start; /* clock */
} patience;

/** Ask the caller and the time limit; returns the planish_stop, or 0 to continue. */
static int ask_caller(void *context) {
    const patience *p = context;
    const planish_progress progress = {.elapsed = pl_seconds() - p->start};
    if (p->options->time_limit > 0 && progress.elapsed >= p->options->time_limit)
        return PLANISH_STOP_TIME_LIMIT;
    if (!p->options->progress)
        return 0;
    pl_context *before = pl_context_enter(NULL);
    const int stops = p->options->progress(&progress, p->options->progress_user);
    pl_context_enter(before);
    return stops ? PLANISH_STOP_INTERRUPTED : 0;
}

/** Input and outputs of a check of volumes. */
typedef struct wanted {
    const planish_options *options; /* minimum volumes; NULL: elements are to be positive */
    pl_limit *limit;                /* or NULL */
    int is_asked;                   /* which elements: there are proofs to look for */
} wanted;

static int check_volumes(room *r, const wanted *w, int64_t *n_below, pl_infeasible *found,
                         planish_error *error) {
    const planish_plan *plan = r->plan;
    const double *all = pl_plan_dense(plan, &r->all_points, r->all);
    const double delta = pl_minimum_volume(plan, w->options, all);
    int status = pl_check_delta(w->options, delta, error);
    if (status)
        return status;
    const pl_objective_problem volumes = pl_objective_problem_of(plan, w->options, all, delta);
    *n_below = pl_find_below(&volumes, r->state);
    if ((*n_below == 0 || !w->is_asked) && !w->limit)
        return PLANISH_OK;
    const pl_star_guard guard = {
        .min_volume = delta, .ratio_weight = 1, .link_min_volume = plan->interior.stars.min_volume};
    return mark_states(r, &guard, w->limit, found, error);
}

static int find_unfixable(room *r, const wanted *w, pl_infeasible *found, planish_error *error) {
    const planish_plan *plan = r->plan;
    planish_options defaults;
    planish_options_init(&defaults);
    pl_objective_problem positive =
        pl_objective_problem_of(plan, &defaults, pl_plan_dense(plan, &r->all_points, r->all), 0);
    const pl_star_guard guard = {.ratio_weight = 1};
    positive.mesh.min_volume = NULL;
    return pl_find_inverted(&positive, r->state) == 0 && !w->limit
               ? PLANISH_OK
               : mark_states(r, &guard, w->limit, found, error);
}

/** state and counts as the caller of either function wants them. */
typedef struct answers {
    uint8_t *state;
    int64_t n, n_undecided;
} answers;

static int look(const planish_plan *plan, const double *coordinates, const wanted *w, answers *out,
                planish_error *error) {
    pl_infeasible found = {0, 0};
    room r;
    int status = room_create(plan, coordinates, &r, error);
    if (status)
        return status;
    status = w->options ? check_volumes(&r, w, &out->n, &found, error)
                        : find_unfixable(&r, w, &found, error);
    if (!status)
        status = pl_parts_check(error);
    if (!status)
        hand_out(&r, !w->options, out->state);
    if (!w->options)
        out->n = found.n;
    out->n_undecided = found.n_undecided;
    room_destroy(&r);
    return status;
}

/** Minimum volumes with is_volumes, else positive elements; has_limit: until options say so. */
static int find(const planish_plan *plan, const double *coordinates, const planish_options *options,
                int is_volumes, int has_limit, answers *out, planish_error *error) {
    planish_options defaults;
    if (!plan || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "plan and coordinates must not be NULL");
    planish_options_init(&defaults);
    const pl_outside outside = pl_call_enter(plan->context);
    patience p = {options ? options : &defaults, pl_seconds()};
    pl_limit limit = pl_limit_of(ask_caller, &p);
    const wanted w = {is_volumes ? p.options : NULL, has_limit ? &limit : NULL, out->state != NULL};
    int status = pl_plan_check_call(plan, coordinates, p.options, error);
    if (!status)
        status = look(plan, coordinates, &w, out, error);
    pl_call_leave(&outside);
    return status;
}

int planish_check_volumes(const planish_plan *plan, const double *coordinates,
                          const planish_options *options, uint8_t *state, int64_t *n_below,
                          planish_error *error) {
    answers out = {.state = state};
    if (!n_below)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "n_below must not be NULL");
    const int status = find(plan, coordinates, options, 1, 0, &out, error);
    if (!status)
        *n_below = out.n;
    return status;
}

int planish_find_unfixable(const planish_plan *plan, const double *coordinates, uint8_t *unfixable,
                           int64_t *n, planish_error *error) {
    answers out = {.state = unfixable};
    if (!n)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "n must not be NULL");
    const int status = find(plan, coordinates, NULL, 0, 0, &out, error);
    if (!status)
        *n = out.n;
    return status;
}

int planish_check_volumes_until(const planish_plan *plan, const double *coordinates,
                                const planish_options *options, uint8_t *state, int64_t *n_below,
                                int64_t *n_undecided, planish_error *error) {
    answers out = {.state = state};
    if (!n_below || !n_undecided)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "n_below and n_undecided must not be NULL");
    const int status = find(plan, coordinates, options, 1, 1, &out, error);
    if (!status) {
        *n_below = out.n;
        *n_undecided = out.n_undecided;
    }
    return status;
}

int planish_find_unfixable_until(const planish_plan *plan, const double *coordinates,
                                 const planish_options *options, uint8_t *unfixable, int64_t *n,
                                 int64_t *n_undecided, planish_error *error) {
    answers out = {.state = unfixable};
    if (!n || !n_undecided)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "n and n_undecided must not be NULL");
    const int status = find(plan, coordinates, options, 0, 1, &out, error);
    if (!status) {
        *n = out.n;
        *n_undecided = out.n_undecided;
    }
    return status;
}
