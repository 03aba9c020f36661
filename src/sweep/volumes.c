/* volumes: which elements are below their least volume, and which of these for ever. */
#include "sweep/guard.h"
#include "sweep/sweep.h"

#include "base/clock.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"

#include <string.h>

/** The search for proofs. */
typedef struct search {
    const planish_plan *plan;
    pl_star_problem problem;
    uint8_t *state;
    double *scratch;     /* of the kernels */
    int32_t *star_of;    /* [n] by inner numbers: the star of a free node; -1: of a ghost */
    int32_t *next_facet; /* [n_stars] link facets of the star seen so far */
    uint8_t *is_fixed;   /* [n] by inner numbers */
    uint8_t *is_wanted;  /* [n_stars] a proof at the star would tell of an element */
    uint8_t *part;       /* [link facets of all stars] pl_star_part */
} search;

static int search_create(const planish_plan *plan, const pl_star_problem *problem, uint8_t *state,
                         search *s) {
    const int64_t n = plan->n_nodes, n_stars = plan->interior.stars.n_stars;
    *s = (search){.plan = plan, .problem = *problem, .state = state};
    s->scratch = pl_alloc(plan->scratch_stride, sizeof *s->scratch);
    s->star_of = pl_alloc(n, sizeof *s->star_of);
    s->next_facet = pl_alloc_zero(n_stars, sizeof *s->next_facet);
    s->is_fixed = pl_alloc(n, sizeof *s->is_fixed);
    s->is_wanted = pl_alloc_zero(n_stars, sizeof *s->is_wanted);
    s->part = pl_alloc_zero(plan->interior.stars.link_offset[n_stars], sizeof *s->part);
    return s->scratch && s->star_of && s->next_facet && s->is_fixed && s->is_wanted && s->part;
}

static void search_destroy(search *s) {
    pl_free(s->scratch);
    pl_free(s->star_of);
    pl_free(s->next_facet);
    pl_free(s->is_fixed);
    pl_free(s->is_wanted);
    pl_free(s->part);
}

static void note_fixed(search *s) {
    const planish_plan *plan = s->plan;
    for (int64_t i = 0; i < plan->n_nodes; i++)
        s->is_fixed[plan->inner[i]] = !plan->is_free[i];
}

/** The only free node of an element; -1: it has none, -2: it has several, or one that slides: of
 *  that nothing is proved. */
static int64_t only_free_node(const planish_plan *plan, int64_t element) {
    int64_t node = -1;
    for (int j = 0; j <= plan->dim; j++) {
        int32_t other = plan->elements[element * (plan->dim + 1) + j];
        if (plan->is_free[other])
            node = node == -1 && plan->is_free[other] == PL_INTERIOR ? other : -2;
    }
    return node;
}

static int32_t star_of_node(const search *s, int64_t node) {
    return s->star_of[s->plan->inner[node]];
}

/** Whether two fixed nodes of an element are at the same place: it has no volume then. */
static int has_coincident_nodes(const search *s, int64_t element) {
    const planish_plan *plan = s->plan;
    const int dim = plan->dim;
    const int32_t *node = plan->elements + element * (dim + 1);
    for (int j = 0; j <= dim; j++)
        for (int k = 0; k < j; k++) {
            const double *x = s->problem.coordinates + (int64_t)plan->inner[node[j]] * dim;
            const double *y = s->problem.coordinates + (int64_t)plan->inner[node[k]] * dim;
            int same = !plan->is_free[node[j]] && !plan->is_free[node[k]];
            for (int d = 0; d < dim; d++)
                same &= x[d] == y[d];
            if (same)
                return 1;
        }
    return 0;
}

/** Elements without a free node, or a volume, are infeasible; stars that could prove others so are
 * wanted. */
static void look_at_elements(search *s) {
    const planish_plan *plan = s->plan;
    for (int64_t i = 0; i < plan->n_elements; i++) {
        if (s->state[i] != PLANISH_VOLUME_BELOW)
            continue;
        int64_t node = only_free_node(plan, i);
        if (node == -1 || has_coincident_nodes(s, i))
            s->state[i] = PLANISH_VOLUME_INFEASIBLE;
        else if (node >= 0 && star_of_node(s, node) >= 0)
            s->is_wanted[star_of_node(s, node)] = 1;
    }
}

/** The stars one after another; a limit that one process has reached is reached in all. */
static void look_for_proofs(search *s, pl_limit *limit) {
    const planish_plan *plan = s->plan;
    for (int64_t i = 0; i < plan->interior.stars.n_stars && !pl_limit_is_reached(limit); i++)
        if (s->is_wanted[i]) {
            pl_star_infeasible(&s->problem, i, plan->dim, s->is_fixed, s->scratch,
                               s->part + plan->interior.stars.link_offset[i], limit);
            s->is_wanted[i] = pl_limit_is_reached(limit) != 0; /* and else it is decided */
        }
    if (!limit)
        return;
    double answer = limit->answer;
    pl_parts_largest(&answer, 1);
    limit->answer = (int)answer;
}

/** Tell the elements: the facets of a star are in the order of its elements. If given_up only those
 * that are, else all that are below and part of a proof. */
static int64_t mark_elements(search *s, int given_up) {
    const planish_plan *plan = s->plan;
    int64_t n_infeasible = 0;
    for (int64_t i = 0; i < plan->n_elements; i++) {
        for (int j = 0; j <= plan->dim; j++) {
            int32_t node = plan->elements[i * (plan->dim + 1) + j];
            if (plan->is_free[node] != PL_INTERIOR || star_of_node(s, node) < 0)
                continue;
            int32_t star = star_of_node(s, node);
            int64_t facet = plan->interior.stars.link_offset[star] + s->next_facet[star]++;
            int wanted =
                given_up ? s->part[facet] == PL_PART_GIVEN_UP
                         : s->part[facet] != PL_PART_NONE && s->state[i] == PLANISH_VOLUME_BELOW;
            if (wanted)
                s->state[i] = PLANISH_VOLUME_INFEASIBLE;
        }
        n_infeasible += s->state[i] == PLANISH_VOLUME_INFEASIBLE;
    }
    return n_infeasible;
}

/** The elements of which the stars that were not searched to the end could tell more. */
static int64_t count_undecided(const search *s) {
    const planish_plan *plan = s->plan;
    int64_t n = 0;
    for (int64_t i = 0; i < plan->n_elements; i++) {
        const int64_t node = s->state[i] == PLANISH_VOLUME_BELOW ? only_free_node(plan, i) : -1;
        n += node >= 0 && star_of_node(s, node) >= 0 && s->is_wanted[star_of_node(s, node)];
    }
    return n;
}

int pl_mark_infeasible(const planish_plan *plan, const pl_star_problem *problem, uint8_t *state,
                       pl_limit *limit, pl_infeasible *found, uint8_t **part,
                       planish_error *error) {
    search s;
    int status = PLANISH_OK;
    if (search_create(plan, problem, state, &s)) {
        note_fixed(&s);
        pl_plan_number_stars(plan, s.star_of);
        look_at_elements(&s);
        look_for_proofs(&s, limit);
        found->n = mark_elements(&s, part != NULL);
        found->n_undecided = limit && limit->answer ? count_undecided(&s) : 0;
        if (part) {
            *part = s.part;
            s.part = NULL;
        }
    } else {
        status = pl_fail_memory(error, "the search for infeasible elements");
    }
    search_destroy(&s);
    return status;
}

/* ---- asked by the caller -------------------------------------------------------------------- */

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
    const int is_part = plan->scope == PL_PART_OF_ALL;
    *r = (room){.plan = plan,
                .all_points = pl_plan_all_points(plan, coordinates),
                .points = pl_plan_points(plan, coordinates),
                .n_of_all = is_part ? plan->whole.n_elements : plan->n_elements};
    const int all_dense = pl_points_are_dense(&r->all_points);
    const int own_dense = pl_points_are_dense(&r->points);
    r->all = all_dense ? NULL : pl_alloc(r->all_points.n * plan->dim, sizeof *r->all);
    r->own = own_dense ? NULL : pl_alloc(plan->n_nodes * plan->dim, sizeof *r->own);
    r->ordered = pl_alloc(plan->n_nodes * plan->dim, sizeof *r->ordered);
    r->state = pl_alloc(r->n_of_all, sizeof *r->state);
    r->of_part = is_part ? pl_alloc(plan->n_elements, sizeof *r->of_part) : r->state;
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
    for (int64_t i = 0; i < plan->n_elements && !is_all; i++)
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
    for (int64_t i = 0; i < plan->n_elements; i++)
        r->state[plan->element_of[i]] = r->of_part[i];
    for (int64_t i = 0; i < r->n_of_all; i++)
        found->n += r->state[i] == PLANISH_VOLUME_INFEASIBLE;
    return status;
}

/** The states as the caller wants them: of each element of the mesh. */
static void hand_out(const room *r, int only_infeasible, uint8_t *out) {
    const planish_plan *plan = r->plan;
    const int is_alone = plan->scope == PL_PART_ALONE;
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

/** What the caller says, or the time limit. */
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

/** What is asked for. */
typedef struct wanted {
    const planish_options *options; /* least volumes; NULL: elements are to be positive */
    pl_limit *limit;                /* or NULL */
    int is_asked;                   /* which elements: there are proofs to look for */
} wanted;

static int check_volumes(room *r, const wanted *w, int64_t *n_below, pl_infeasible *found,
                         planish_error *error) {
    const planish_plan *plan = r->plan;
    const double *all = pl_plan_dense(plan, &r->all_points, r->all);
    const double delta = pl_least_volume(plan, w->options, all);
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
    positive.own_min_volume = NULL;
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

/** Least volumes with is_volumes, else positive elements; has_limit: until options say so. */
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
    int status = pl_call_check(plan, coordinates, p.options, error);
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
