/* begin_end: begin and end of a run: the caller's coordinates into the plan, and back. */
#include "sweep/begin_end.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/simplex.h"

#include <math.h>
#include <string.h>

/* ---- the beginning ------------------------------------------------------------------------- */

/** Put planes and lines through their nodes as they are now. Followers keep their distance from
 *  their leaders. */
static void begin_sliding(planish_plan *plan) {
    double *x = plan->scratch.coordinates;
    const int dim = plan->dim;
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++)
        memcpy(plan->slide[s].point, x + (int64_t)plan->sliding.centre[s] * dim,
               (size_t)dim * sizeof *x);
    for (int64_t k = 0; k < plan->sliding.n_followers; k++) {
        const pl_follower *f = &plan->sliding.follower[k];
        pl_follower_places *places = &plan->scratch.places[k];
        for (int d = 0; d < dim; d++) {
            const double way = x[(int64_t)f->to * dim + d] - x[(int64_t)f->from * dim + d];
            places->origin[d] = x[(int64_t)f->of * dim + d];
            if (f->node >= plan->work.n_nodes)
                x[(int64_t)f->node * dim + d] = places->origin[d] + way;
            places->start[d] = x[(int64_t)f->node * dim + d];
        }
    }
}

/** Measure the mesh for the first time, with the rest of it where more than the plan's subset is
 *  known. all [.][dim]: coordinates of all that is known then, else NULL. */
static void measure_first(pl_run *r, double *all) {
    const planish_plan *plan = r->plan;
    for (int64_t i = 0; all && i < plan->all->n_nodes * plan->dim; i++)
        all[i] *= r->measure_scale;
    if (all)
        pl_run_measure_fixed(r, all);
    pl_run_measure(r);
    if (all) {
        r->sums_of_fixed.inverted -= pl_tangled(&r->sums);
        r->sums_of_fixed.below -= r->sums.below;
    }
}

/** Whether options.worst is a measure of the elements that the plan has. */
static int check_worst(const pl_run *r, planish_error *error) {
    const planish_worst worst = r->options->worst;
    const int is_of_corners =
        worst == PLANISH_WORST_ASPECT_RATIO || worst == PLANISH_WORST_SCALED_JACOBIAN;
    if (worst == PLANISH_WORST_NONE || is_of_corners == (r->plan->work.corner != NULL))
        return PLANISH_OK;
    if (is_of_corners)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.worst is PLANISH_WORST_%s, but all elements are simplices; give "
                       "PLANISH_WORST_RADIUS_RATIO or _ANGLE",
                       worst == PLANISH_WORST_ASPECT_RATIO ? "ASPECT_RATIO" : "SCALED_JACOBIAN");
    return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                   "options.worst is PLANISH_WORST_%s, but not all elements are simplices; give "
                   "PLANISH_WORST_ASPECT_RATIO or _SCALED_JACOBIAN",
                   worst == PLANISH_WORST_ANGLE ? "ANGLE" : "RADIUS_RATIO");
}

/** Whether options ask for nothing that is not made for targets. */
static int check_targets(const pl_run *r, planish_error *error) {
    const planish_options *o = r->options;
    if (!r->plan->work.target || (o->worst == PLANISH_WORST_NONE && pl_is_mean(o->objective)))
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                   "options.%s is not possible with mesh.reference, mesh.is_layer, mesh.size or "
                   "mesh.metric: only "
                   "mean ratios are measured against targets",
                   o->worst != PLANISH_WORST_NONE ? "worst" : "objective EDGE_RATIO");
}

/** Kinds of the corners of a view, as bits. */
static unsigned kinds_of(const pl_view *view) {
    unsigned kinds = 0;
    for (int64_t i = 0; view->corner && i < view->n_elements; i++)
        kinds |= 1U << pl_corner_kind(view->corner[i]);
    return kinds;
}

/** Take what is promised of the worst element from the mesh as it came. Sweeps guard neither the
 *  smallest angle of simplices, where that is promised, nor the elements of followers: the run
 *  compares them with these limits afterwards. */
static void begin_limits(pl_run *r) {
    const planish_options *o = r->options;
    const int has_corners = r->plan->work.corner != NULL;
    const int of_ratio =
        o->objective == PLANISH_OBJECTIVE_RADIUS_RATIO || (has_corners && pl_is_mean(o->objective));
    /* Shapes of another mesh may be sharp ones. Layers are none, but one that a wall was moved into becomes
     * what it was whatever its angles. */
    r->may_be_sharp = r->plan->work.target && (!r->plan->is_blunt || pl_tangled(&r->sums) > 0);
    r->limits_at_start = pl_star_no_limits();
    r->worst_at_start = INFINITY;
    if (o->method != PLANISH_METHOD_PLANISH || pl_tangled(&r->sums) > 0 || r->sums.below > 0)
        return;
    if (of_ratio && !(o->area_weight > 0))
        r->limits_at_start = pl_run_worst_limits(r, 1);
    else if (pl_run_has_followers(r))
        r->limits_at_start.rr2 = pl_run_worst_limits(r, 1).rr2;
    if (has_corners && r->limits_at_start.rr2 < INFINITY)
        r->worst_at_start = r->sums.radius_max;
}

/** Check that options fit the plan, and bring the coordinates into it. *all: copy of the coordinates
 *  [.][dim] of all that is known, where that is more than the plan's subset; owned, or NULL. */
static int take_coordinates(pl_run *r, double **all, planish_error *error) {
    planish_plan *plan = r->plan;
    const pl_points points = pl_plan_points(plan, r->coordinates);
    const pl_points all_points = pl_plan_all_points(plan, r->coordinates);
    int status = check_targets(r, error);
    *all = NULL;
    if (!status)
        status = check_worst(r, error);
    if (status)
        return status;
    r->kinds = kinds_of(&plan->work);
    r->given = pl_plan_dense(plan, &points, plan->scratch.given);
    if (plan->scope == PL_SUBSET_OF_ALL) {
        *all = pl_alloc(all_points.n * all_points.dim, sizeof **all);
        if (!*all)
            return pl_fail_memory(error, "the coordinates");
        pl_points_gather(&all_points, plan->threads, *all);
    }
    pl_plan_order(plan, r->given, plan->scratch.coordinates);
    begin_sliding(plan);
    return PLANISH_OK;
}

/** Make the guard, the watch and the skin. */
static int make_limits(pl_run *r, const double *all, planish_error *error) {
    planish_plan *plan = r->plan;
    const planish_options *o = r->options;
    double delta;
    /* delta may be a fraction of the volume of all of the mesh. */
    int status = pl_minimum_volume(plan, o, all ? all : r->given, &delta, error);
    if (!status)
        status = pl_guard_create(plan, o, r->given, delta, &r->guard, error);
    if (!status)
        status = pl_watch_create(plan, o, r->given, r->coordinates, delta, &r->watch, error);
    if (!status)
        status = pl_skin_create(plan, o, r->coordinates, &r->watch, &r->skin, error);
    return status;
}

int pl_run_begin_limits(pl_run *r, planish_error *error) {
    double *all;
    int status = take_coordinates(r, &all, error);
    if (!status)
        status = make_limits(r, all, error);
    pl_free(all);
    return status;
}

int pl_run_begin(pl_run *r, planish_error *error) {
    planish_plan *plan = r->plan;
    const planish_options *o = r->options;
    double *all;
    int status = take_coordinates(r, &all, error);
    if (status)
        return status;
    if (plan->sizes)
        pl_plan_begin_sizes(plan);
    status = make_limits(r, all, error);
    plan->scratch.watch = r->watch.n > 0 ? &r->watch : NULL;
    plan->scratch.skin = !status && r->skin.shape ? &r->skin : NULL;
    if (!status) {
        r->plain = !r->guard.wanted && o->method == PLANISH_METHOD_PLANISH;
        r->measure_scale =
            r->plain && plan->work.size_weight == 0 ? pl_box_of_fixed(plan).scale : 1;
        measure_first(r, all);
    }
    pl_free(all);
    if (status)
        return status;
    r->result->objective_before = pl_run_objective(r);
    r->sums_at_start = r->sums;
    r->n_turned_at_start = r->watch.n_turned;
    begin_limits(r);
    r->watch.worst_ar2 = r->worst_at_start * PL_LIMIT_MARGIN;
    pl_run_prepare(r);
    r->stop = PLANISH_STOP_CONVERGED;
    return PLANISH_OK;
}

/* ---- the end ------------------------------------------------------------------------------- */

enum { CHUNK_NODES = 1024 };

/** Nodes on the way to the caller: how many have moved, and how far. */
typedef struct transfer {
    const pl_run *run;
    pl_points points; /* of the caller */
    int writes;       /* 0: only look */
    int64_t moved;
    double farthest;
} transfer;

static void transfer_chunk(void *context, int64_t begin, int64_t end, int thread) {
    transfer *t = context;
    const planish_plan *plan = t->run->plan;
    const int dim = plan->dim;
    int64_t moved = 0;
    double farthest = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const double *start = t->run->given + i * dim;
        const double *inside = plan->scratch.coordinates + (int64_t)plan->inner[i] * dim;
        const double far = plan->work.mobility[i] ? pl_distance(dim, inside, start) : 0;
        if (!(far > 0))
            continue;
        moved += pl_is_own(pl_part_here(), i);
        farthest = fmax(farthest, far);
        for (int d = 0; d < dim && t->writes; d++)
            t->run->coordinates[pl_point_at(&t->points, i, d)] = inside[d];
    }
    pl_raise_double(&t->farthest, farthest);
    __atomic_fetch_add(&t->moved, moved, __ATOMIC_RELAXED);
}

/** Write the nodes that have moved to the caller's coordinates, and tell the result how many and
 *  how far. Write nothing if other processes are not reached any more: they would miss it. */
static int transfer_out(const pl_run *r, planish_error *error) {
    const planish_plan *plan = r->plan;
    const int is_part = pl_part_here() != NULL;
    transfer t = {.run = r, .points = pl_plan_points(plan, r->coordinates), .writes = !is_part};
    if (pl_watch_has_mids(&r->watch)) /* before their ends, which may be what they were given by */
        pl_mids_write(&r->watch.mids, t.writes, r->coordinates, &t.moved, &t.farthest);
    pl_parallel_for(plan->threads, plan->work.n_nodes, CHUNK_NODES, transfer_chunk, &t);
    r->result->max_displacement = t.farthest;
    pl_parts_add(&t.moved, 1);
    pl_parts_largest(&r->result->max_displacement, 1);
    r->result->n_moved_nodes = t.moved;
    const int status = pl_parts_check(error);
    t.writes = 1;
    if (!status && is_part)
        pl_parallel_for(plan->threads, plan->work.n_nodes, CHUNK_NODES, transfer_chunk, &t);
    return status;
}

int pl_run_end(pl_run *run, planish_error *error) {
    planish_result *r = run->result;
    int status = PLANISH_OK;
    /* Phases skip work that lacks memory, and the mesh would not be the one that it is with. */
    if (__atomic_load_n(&run->plan->context->failed, __ATOMIC_RELAXED))
        status = pl_fail_memory(error, "the smoothing of a mesh");
    if (!status)
        status = pl_parts_check(error);
    if (!status)
        status = transfer_out(run, error);
    r->stop = run->stop;
    r->sweeps = run->sweep;
    r->n_inverted =
        (int64_t)(run->sums.inverted + run->sums_of_fixed.inverted) - run->watch.n_turned;
    r->rms = pl_rms_of_all(&run->sums);
    r->rms_movable = pl_run_rms_of_movable(run, &run->sums);
    r->min_volume = run->guard.min_volume;
    r->n_below_min_volume = (int64_t)(run->sums.below + run->sums_of_fixed.below);
    r->n_held_outside = run->guard.held_outside;
    r->n_curved = run->watch.n_curved;
    r->n_inverted_inside = (int64_t)run->sums.inside;
    r->n_refused = run->watch.n_refused;
    r->n_off_shape = run->skin.n_off;
    r->objective = pl_run_objective(run);
    r->seconds = pl_seconds() - run->start_seconds;
    return status;
}

void pl_run_destroy(pl_run *r) {
    r->plan->scratch.watch = NULL;
    r->plan->scratch.skin = NULL;
    pl_marked_destroy(&r->refusers);
    pl_watch_destroy(&r->watch);
    pl_skin_destroy(&r->skin);
    pl_guard_destroy(&r->guard);
}
