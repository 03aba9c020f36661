/* planish_fit: bring the surface of a mesh onto another one. */
#include "fit/create.h"
#include "fit/distance.h"
#include "fit/move.h"
#include "fit/places.h"

#include "base/clock.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/positions.h"
#include "base/status.h"
#include "plan/plan.h"
#include "topology/topology.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* A node looks for its place so many mean edges around. */
static const double USUAL_REACH = 3;
/* How much larger one surface may be than the other one. */
static const double MOST_RATIO = 1e30;

/* ---- create ---------------------------------------------------------------------------------- */

/** Whether a facet of the outside has an area. */
static int has_area(const planish_shape *shape) {
    for (int32_t f = 0; f < shape->n_facets; f++)
        if (pl_fit_is_outer(shape, f) &&
            (shape->normal[f][0] != 0 || shape->normal[f][1] != 0 || shape->normal[f][2] != 0))
            return 1;
    return 0;
}

static int check_fit(const planish_mesh *mesh, const planish_shape *shape,
                     const planish_shape *onto, double reach, planish_error *error) {
    int status = pl_check_counts(mesh, error);
    if (status)
        return status;
    if (mesh->dim != 3)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.dim is 2; only meshes of solids are fitted to another surface");
    if (mesh->part)
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "a mesh is fitted to another surface as a whole, not a part of it");
    if (mesh->n_periodic > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "the mesh has %" PRId64 " periodic pairs: such meshes are not fitted to "
                       "another surface, which would move one side without the other",
                       mesh->n_periodic);
    if (shape->n_mesh != mesh->n_nodes)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "shape was made of a mesh of %" PRId64 " nodes, but this one has %" PRId64,
                       shape->n_mesh, mesh->n_nodes);
    if (onto->n_facets == 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "onto has no facets: give a surface");
    if (!has_area(onto))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "onto has no facet with an area: give a surface");
    return reach >= 0 ? PLANISH_OK
                      : pl_fail(error, PLANISH_ERROR_ARGUMENT,
                                "reach is %g mean edges; give a positive number, or 0", reach);
}

/** Count the nodes of a fit. */
static void describe(const planish_fit *fit, planish_fit_info *info) {
    *info = (planish_fit_info){.n_unused = fit->n_unused};
    for (int64_t i = 0; i < fit->n_nodes; i++) {
        const int is_placed = fit->state[i] == PL_FIT_PLACED;
        info->n_nodes += fit->state[i] != PL_FIT_INSIDE;
        info->n_held += fit->state[i] == PL_FIT_HELD;
        info->n_unclear += fit->state[i] == PL_FIT_UNCLEAR;
        info->n_out_of_reach += fit->state[i] == PL_FIT_FAR || fit->state[i] == PL_FIT_UNCLEAR;
        info->n_cut += is_placed && fit->is_cut[i];
        info->n_on_patch += is_placed && fit->kind[i] == PL_ON_PATCH;
        info->n_on_curve += is_placed && fit->kind[i] == PL_ON_CURVE;
        info->n_on_corner += is_placed && fit->kind[i] == PL_CORNER;
    }
}

/** Widen a box [2][3] to hold the nodes of a shape, in units of the coordinates. */
static void box_of(const planish_shape *shape, double box[2][3]) {
    for (int d = 0; d < 3; d++) {
        box[0][d] = INFINITY;
        box[1][d] = -INFINITY;
    }
    for (int64_t i = 0; i < shape->n_nodes; i++)
        for (int d = 0; d < 3; d++) {
            box[0][d] = fmin(box[0][d], shape->x[i][d] / shape->scale);
            box[1][d] = fmax(box[1][d], shape->x[i][d] / shape->scale);
        }
}

enum { BOX_SIZE = 128 };

/** Write the box of a shape. */
static const char *say_box(const planish_shape *shape, char text[BOX_SIZE]) {
    double box[2][3];
    box_of(shape, box);
    snprintf(text, BOX_SIZE, "(%.4g %.4g %.4g) to (%.4g %.4g %.4g)", box[0][0], box[0][1],
             box[0][2], box[1][0], box[1][1], box[1][2]);
    return text;
}

static int complain_of_reach(const planish_fit *fit, planish_error *error) {
    char own[BOX_SIZE], onto[BOX_SIZE];
    return pl_fail(error, PLANISH_ERROR_MESH,
                   "no node of the mesh's surface is within %g edges of the other surface, which "
                   "is in %s, the mesh in %s: give both the same unit and place",
                   fit->reach, say_box(fit->onto, onto), say_box(fit->own, own));
}

/** Refuse shapes that differ so much in size that one is a point beside the other. */
static int check_sizes(const planish_fit *fit, planish_error *error) {
    const double ratio = fit->own->scale / fit->onto->scale;
    char own[BOX_SIZE], onto[BOX_SIZE];
    if (ratio > 1 / MOST_RATIO && ratio < MOST_RATIO)
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_MESH,
                   "the other surface, in %s, and the mesh, in %s, differ in size by a factor of "
                   "more than %g: give both the same unit",
                   say_box(fit->onto, onto), say_box(fit->own, own), MOST_RATIO);
}

static int create(const planish_mesh *mesh, planish_fit *fit, planish_fit_info *info,
                  planish_error *error) {
    pl_dense dense = {0};
    int status = check_sizes(fit, error);
    if (!status)
        status = mesh->cells ? pl_dense_create_cells(mesh, fit->threads, &dense, error)
                             : pl_dense_create(mesh, fit->threads, &dense, error);
    if (!status)
        status = pl_fit_create(&dense.mesh, fit, error);
    if (!status) {
        const pl_points points = pl_points_of(&dense.mesh, dense.mesh.coordinates);
        status = pl_fit_find_places(fit, &points, error);
        describe(fit, info);
        if (!status && info->n_out_of_reach > 0 && info->n_unclear == 0 &&
            info->n_out_of_reach + info->n_held == info->n_nodes)
            status = complain_of_reach(fit, error);
        if (!status)
            info->n_off = pl_fit_arrive(fit, &points, &info->farthest);
    }
    pl_dense_destroy(&dense);
    return status;
}

int planish_fit_create(const planish_mesh *mesh, const planish_shape *shape,
                       const planish_shape *onto, double reach, const planish_options *options,
                       planish_fit **out, planish_fit_info *info, planish_error *error) {
    planish_options defaults;
    planish_fit_info found = {0};
    if (out)
        *out = NULL;
    if (!mesh || !shape || !onto || !out)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh, shape, onto and fit must not be NULL");
    planish_options_init(&defaults);
    options = options ? options : &defaults;
    int status = pl_options_check(options, error);
    if (!status)
        status = check_fit(mesh, shape, onto, reach, error);
    if (status)
        return status;
    const pl_outside outside = pl_call_enter(NULL);
    planish_fit *fit = pl_alloc_zero(1, sizeof *fit);
    status = fit ? PLANISH_OK : pl_fail_memory(error, "a fit");
    if (fit) {
        *fit = (planish_fit){.own = shape,
                             .onto = onto,
                             .threads = pl_thread_count(options->threads),
                             .reach = reach > 0 ? reach : USUAL_REACH,
                             .storage = pl_storage_of(options)};
        status = create(mesh, fit, &found, error);
    }
    pl_call_leave(&outside);
    if (status) {
        planish_fit_destroy(fit);
        return status;
    }
    *out = fit;
    if (info)
        *info = found;
    return PLANISH_OK;
}

void planish_fit_destroy(planish_fit *fit) {
    if (!fit)
        return;
    pl_fit_destroy(fit);
    pl_free(fit);
}

/* ---- on the way ------------------------------------------------------------------------------ */

planish_constraint planish_fit_project(int64_t node, double *point, double *direction, void *fit) {
    const planish_fit *f = fit;
    const int is_known = f && node >= 0 && node < f->own->n_mesh;
    return is_known ? pl_fit_project(f, f->own->number[node], point, direction)
                    : PLANISH_CONSTRAINT_FIXED;
}

/** Say how nodes move. is_early: while nodes are still on their way. */
static void constrain(const planish_fit *fit, int is_early, uint8_t *constraint) {
    for (int64_t i = 0; i < fit->n_nodes; i++) {
        const int slides =
            fit->state[i] == PL_FIT_PLACED && fit->slides[i] && (is_early || fit->is_there[i]);
        constraint[fit->own->node[i]] =
            slides ? PLANISH_CONSTRAINT_ON_SURFACE : PLANISH_CONSTRAINT_FIXED;
    }
}

void planish_fit_constrain(const planish_fit *fit, uint8_t *constraint) {
    if (fit && constraint)
        constrain(fit, 0, constraint);
}

/* ---- move ------------------------------------------------------------------------------------ */

/* Rounds of a stage; sweeps between two of them; a round that moves no node by more than this part of its way is
 * the last of its stage. */
enum { ROUNDS = 20, SWEEPS = 3 };
static const double LITTLE = 1. / 8;

/* What the least det J of an element may fall to at most, in its size: first so that smoothing can go on, then
 * as far as validity allows with something left. */
static const double FLOORS[] = {0.02, 2e-3};

/** A call of planish_fit_move. */
typedef struct moving {
    planish_fit *fit;
    planish_mesh mesh;             /* with constraint */
    planish_options options;       /* of the sweeps */
    planish_progress_fn *progress; /* the caller's */
    void *progress_user;
    const double *given; /* the caller's coordinates */
    planish_plan *plan;  /* made when it is needed */
    double *coordinates; /* copy of the caller's, as long as theirs */
    uint8_t *constraint;
    uint8_t *was_there; /* [n_nodes of fit] as fit->is_there was */
    double begin, time_limit;
    int is_over; /* stopped by the caller or the limit */
} moving;

/** Smooth the nodes that are free, and those on the other surface along it. */
static int smooth(moving *m, planish_error *error) {
    planish_result result = {0};
    int status = PLANISH_OK;
    const double left = m->time_limit - (pl_seconds() - m->begin);
    if (m->time_limit > 0 && left <= 0) {
        m->is_over = 1;
        return status;
    }
    m->options.time_limit = m->time_limit > 0 ? left : 0;
    if (!m->plan)
        status = planish_plan_create(&m->mesh, &m->options, &m->plan, error);
    if (!status)
        status = planish_smooth(m->plan, m->coordinates, &m->options, &result, error);
    m->is_over = result.stop == PLANISH_STOP_INTERRUPTED || result.stop == PLANISH_STOP_TIME_LIMIT;
    return status;
}

/** Move nodes until all are there, or none moves much. */
static int move_nodes(moving *m, planish_error *error) {
    planish_fit *fit = m->fit;
    const pl_points points = pl_points_of(&m->mesh, m->coordinates);
    int status = PLANISH_OK;
    for (int stage = 0; stage < 2 && !m->is_over; stage++)
        for (int round = 0; round < ROUNDS && !status && !m->is_over; round++) {
            const pl_outside outside = pl_call_enter(NULL);
            const double most = pl_fit_round(fit, &points, m->coordinates, FLOORS[stage]);
            const int64_t n_off = pl_fit_arrive(fit, &points, NULL);
            pl_call_leave(&outside);
            if (n_off == 0)
                return PLANISH_OK;
            status = smooth(m, error);
            if (most < LITTLE && round > 0)
                break;
        }
    return status;
}

/** Number of doubles that strides reach over. */
static int64_t length_of(const planish_mesh *mesh) {
    const pl_points p = pl_points_of(mesh, mesh->coordinates);
    return mesh->n_nodes > 0 ? pl_point_at(&p, mesh->n_nodes - 1, 2) + 1 : 0;
}

/** Ask the caller, to whom the coordinates of the call are its own. */
static int ask(const planish_progress *progress, void *user) {
    const moving *m = user;
    planish_progress shown = *progress;
    struct planish_positions positions;
    if (progress->positions) {
        positions = *progress->positions;
        positions.given = m->given;
        shown.positions = &positions;
    }
    return m->progress(&shown, m->progress_user);
}

/** Set the options of the sweeps, which are the caller's. */
static void set_options(moving *m) {
    planish_options *options = &m->options;
    m->time_limit = options->time_limit;
    m->progress = options->progress;
    m->progress_user = options->progress_user;
    options->progress = m->progress ? ask : NULL;
    options->progress_user = m;
    options->project = planish_fit_project;
    options->project_user = m->fit;
    options->shape = NULL;
    options->method = PLANISH_METHOD_PLANISH;
    options->worst = PLANISH_WORST_NONE;
    options->max_sweeps = SWEEPS;
    options->only_worse_than = 0;
    options->around = NULL;
    options->n_around = 0;
}

/** Copy what is moved. Errors: _MEMORY. */
static int take(moving *m, const double *coordinates, planish_error *error) {
    const planish_mesh *mesh = &m->mesh;
    const int64_t length = length_of(mesh);
    m->constraint = pl_alloc_zero(mesh->n_nodes, 1);
    m->coordinates = pl_alloc(length, sizeof *m->coordinates);
    m->was_there = pl_alloc(m->fit->n_nodes, sizeof *m->was_there);
    if (!m->constraint || !m->coordinates || !m->was_there)
        return pl_fail_memory(error, "the nodes of a fit");
    memcpy(m->coordinates, coordinates, (size_t)length * sizeof *coordinates);
    memcpy(m->was_there, m->fit->is_there, (size_t)m->fit->n_nodes);
    if (mesh->constraint)
        memcpy(m->constraint, mesh->constraint, (size_t)mesh->n_nodes);
    const pl_points points = pl_points_of(mesh, coordinates);
    pl_fit_stay(m->fit, &points);
    constrain(m->fit, 1, m->constraint);
    m->mesh.constraint = m->constraint;
    if (pl_has_targets(mesh) && !mesh->reference) /* the plan is made of nodes that have moved */
        m->mesh.reference = mesh->coordinates;
    m->mesh.coordinates = m->coordinates;
    return PLANISH_OK;
}

/** Give the caller what was moved; info may be NULL. */
static void hand_over(const moving *m, double *coordinates, planish_fit_info *info) {
    const pl_outside outside = pl_call_enter(NULL);
    const pl_points points = pl_points_of(&m->mesh, m->coordinates);
    planish_fit_info found;
    memcpy(coordinates, m->coordinates, (size_t)length_of(&m->mesh) * sizeof *coordinates);
    describe(m->fit, &found);
    found.n_off = pl_fit_arrive(m->fit, &points, &found.farthest);
    if (info)
        *info = found;
    pl_call_leave(&outside);
}

int planish_fit_move(planish_fit *fit, const planish_mesh *mesh, double *coordinates,
                     const planish_options *options, planish_fit_info *info, planish_error *error) {
    if (!fit || !mesh || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "fit, mesh and coordinates must not be NULL");
    moving m = {.fit = fit, .mesh = *mesh, .given = coordinates, .begin = pl_seconds()};
    planish_options_init(&m.options);
    m.options = options ? *options : m.options;
    set_options(&m);
    int status = pl_options_check(&m.options, error);
    if (!status)
        status = check_fit(mesh, fit->own, fit->onto, 0, error);
    if (status)
        return status;
    const pl_outside outside = pl_call_enter(NULL);
    const pl_points points = pl_points_of(mesh, coordinates);
    status = pl_points_check(&points, fit->threads, error);
    if (!status)
        status = take(&m, coordinates, error);
    pl_call_leave(&outside);
    if (!status) {
        status = move_nodes(&m, error);
        if (!status)
            hand_over(&m, coordinates, info);
        else
            memcpy(fit->is_there, m.was_there, (size_t)fit->n_nodes);
    }
    planish_plan_destroy(m.plan);
    pl_free(m.constraint);
    pl_free(m.coordinates);
    pl_free(m.was_there);
    return status;
}

/* ---- measure --------------------------------------------------------------------------------- */

int planish_fit_measure(const planish_fit *fit, const planish_mesh *mesh,
                        planish_shape_distance *distance, planish_error *error) {
    if (!fit || !mesh || !distance)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "fit, mesh and distance must not be NULL");
    int status = check_fit(mesh, fit->own, fit->onto, 0, error);
    if (status)
        return status;
    const pl_outside outside = pl_call_enter(NULL);
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    pl_fit_distance d = {0};
    status = pl_points_check(&points, fit->threads, error);
    if (!status)
        status = pl_fit_measure(fit, &points, &d, error);
    if (!status)
        *distance = (planish_shape_distance){.distance = d.there,
                                             .distance_back = d.back,
                                             .in_edges = d.there_h,
                                             .back_in_edges = d.back_h,
                                             .n_unproved = d.n_unproved};
    pl_call_leave(&outside);
    return status;
}
