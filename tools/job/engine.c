/* engine: the work in this process: by a plan, and on a surface in space by its shape. */
#include "job/engine.h"

#include "job/job_state.h"

#include "base/parallel.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

/** Mark the elements without a radius ratio. */
static int find_inverted(const planish_plan *plan, const planish_mesh *mesh, uint8_t *state,
                         int64_t *n, planish_error *error) {
    double *ratio = malloc(((size_t)mesh->n_elements + 1) * sizeof *ratio);
    if (!ratio)
        return pl_fail_memory(error, "states of elements");
    const int code = planish_measure_elements(plan, mesh->coordinates, ratio, error);
    *n = 0;
    for (int64_t i = 0; !code && i < mesh->n_elements; i++) {
        state[i] = ratio[i] == 0;
        *n += state[i];
    }
    free(ratio);
    return code;
}

int pl_states_find(const planish_plan *plan, const planish_mesh *mesh, pl_state_kind kind,
                   const planish_options *options, uint8_t *state, pl_states *found,
                   planish_error *error) {
    const double *x = mesh->coordinates;
    found->n = found->n_undecided = 0;
    switch (kind) {
    case PL_STATE_VOLUME:
        return planish_check_volumes(plan, x, options, state, &found->n, &found->n_undecided,
                                     error);
    case PL_STATE_UNFIXABLE:
        return planish_find_infeasible(plan, x, options, state, &found->n, &found->n_undecided,
                                       error);
    case PL_STATE_REVERSED:
        return planish_find_reversed(plan, x, state, &found->n, error);
    case PL_STATE_INVERTED:
        break;
    }
    return find_inverted(plan, mesh, state, &found->n, error);
}

static int plan_create(pl_job *job, planish_error *error) {
    const int code = planish_plan_create(&job->mesh, &job->options, &job->plan, error);
    if (!code)
        planish_plan_get_info(job->plan, &job->plan_info);
    return code;
}

static void plan_destroy(pl_job *job) {
    planish_plan_destroy(job->plan);
    job->plan = NULL;
}

static int get_free(const pl_job *job, uint8_t *is_free, planish_error *error) {
    (void)error;
    planish_plan_get_free(job->plan, is_free);
    return PLANISH_OK;
}

static int get_held(const pl_job *job, uint8_t *reason, planish_error *error) {
    return planish_plan_get_held(job->plan, job->mesh.coordinates, reason, error);
}

static int find_held(const pl_job *job, uint8_t *held, planish_error *error) {
    return planish_find_held(job->plan, job->mesh.coordinates, &job->options, held, error);
}

static int measure(const pl_job *job, planish_quality *quality, planish_error *error) {
    return planish_measure(job->plan, job->mesh.coordinates, quality, error);
}

static int measure_elements(const pl_job *job, double *ratio, planish_error *error) {
    return planish_measure_elements(job->plan, job->mesh.coordinates, ratio, error);
}

static int find_states(const pl_job *job, pl_state_kind kind, const planish_options *options,
                       int with_state, pl_states *found, planish_error *error) {
    uint8_t *state = with_state ? malloc((size_t)job->mesh.n_elements + 1) : NULL;
    *found = (pl_states){.state = NULL};
    if (with_state && !state)
        return pl_fail_memory(error, "states of elements");
    const int code = pl_states_find(job->plan, &job->mesh, kind, options, state, found, error);
    if (!code && found->n > 0)
        found->state = state;
    else
        free(state);
    return code;
}

static int smooth(pl_job *job, planish_result *result, planish_error *error) {
    return planish_smooth(job->plan, planish_file_coordinates(job->file), &job->options, result,
                          error);
}

const pl_engine pl_engine_here = {.plan_create = plan_create,
                                  .plan_destroy = plan_destroy,
                                  .get_free = get_free,
                                  .get_held = get_held,
                                  .find_held = find_held,
                                  .measure = measure,
                                  .measure_elements = measure_elements,
                                  .find_states = find_states,
                                  .smooth = smooth};

/* ---- on a surface in space --------------------------------------------------------------------- */

/** Mark the nodes that move: moves [n_nodes]. Those that nobody holds do as the shape says. */
static int find_moving(const pl_job *job, uint8_t *moves, int64_t *n) {
    planish_shape_get_classes(job->curved.shape, moves);
    *n = 0;
    for (int64_t i = 0; i < job->mesh.n_nodes; i++) {
        const uint8_t by = job->constraint[i], of = moves[i];
        moves[i] = by == PLANISH_CONSTRAINT_FREE
                       ? of == PLANISH_SHAPE_PATCH || of == PLANISH_SHAPE_CURVE
                       : by > PLANISH_CONSTRAINT_FIXED && of != PLANISH_SHAPE_NONE;
        *n += moves[i];
    }
    return 0;
}

static int plan_create_on_surface(pl_job *job, planish_error *error) {
    uint8_t *moves = malloc((size_t)job->mesh.n_nodes + 1);
    planish_quality quality;
    if (!moves)
        return pl_fail_memory(error, "values of nodes");
    job->plan_info =
        (planish_plan_info){.n_components = -1,
                            .n_boundary_facets = job->curved.info.n_open_edges,
                            .n_nonmanifold_facets = job->curved.info.n_nonmanifold_edges,
                            .threads = pl_thread_count(job->options.threads),
                            .isa = "surface",
                            .binding = "where the system puts them"};
    find_moving(job, moves, &job->plan_info.n_sliding);
    free(moves);
    const int code = planish_measure_surface(job->curved.shape, &job->mesh, job->options.threads,
                                             &quality, NULL, NULL, NULL, error);
    job->plan_info.n_fixed_elements = code ? 0 : quality.n_fixed_elements;
    return code;
}

static void plan_destroy_on_surface(pl_job *job) {
    (void)job; /* the shape is asked for distances yet */
}

static int get_free_on_surface(const pl_job *job, uint8_t *is_free, planish_error *error) {
    int64_t n;
    (void)error;
    find_moving(job, is_free, &n);
    for (int64_t i = 0; i < job->mesh.n_nodes; i++)
        is_free[i] &= job->constraint[i] == PLANISH_CONSTRAINT_FREE;
    return PLANISH_OK;
}

/** Mark the nodes of elements. */
static void mark_used(const pl_job *job, uint8_t *is_used) {
    const planish_cells *cells = planish_file_mesh(job->file).cells;
    memset(is_used, 0, (size_t)job->mesh.n_nodes);
    for (int64_t i = 0; i < cells->offset[cells->n]; i++)
        if (cells->node[i] >= 0)
            is_used[cells->node[i]] = 1;
}

/** The reasons of planish_plan_get_held: corners stay as a boundary does. */
static int get_held_on_surface(const pl_job *job, uint8_t *reason, planish_error *error) {
    const size_t n = (size_t)job->mesh.n_nodes + 1;
    uint8_t *moves = malloc(n), *is_used = malloc(n);
    int64_t n_moving;
    const int failed = !moves || !is_used;
    if (!failed) {
        find_moving(job, moves, &n_moving);
        mark_used(job, is_used);
        planish_shape_get_classes(job->curved.shape, reason);
    }
    for (int64_t i = 0; i < job->mesh.n_nodes && !failed; i++)
        reason[i] = !is_used[i]                         ? PLANISH_HELD_UNUSED
                    : moves[i]                          ? 0
                    : reason[i] == PLANISH_SHAPE_CORNER ? PLANISH_HELD_BOUNDARY
                    : reason[i] == PLANISH_SHAPE_NONE   ? 0
                                                        : PLANISH_HELD_FIXED;
    free(moves);
    free(is_used);
    return failed ? pl_fail_memory(error, "values of nodes") : PLANISH_OK;
}

static int find_held_on_surface(const pl_job *job, uint8_t *held, planish_error *error) {
    return planish_find_held_on_surface(&job->mesh, &job->options, held, error);
}

static int measure_on_surface(const pl_job *job, planish_quality *quality, planish_error *error) {
    return planish_measure_surface(job->curved.shape, &job->mesh, job->options.threads, quality,
                                   NULL, NULL, NULL, error);
}

static int measure_elements_on_surface(const pl_job *job, double *ratio, planish_error *error) {
    planish_quality quality;
    return planish_measure_surface(job->curved.shape, &job->mesh, job->options.threads, &quality,
                                   ratio, NULL, NULL, error);
}

/** No element can be repaired, none is too small, or reversed: orientation is that of neighbours. */
static int find_states_on_surface(const pl_job *job, pl_state_kind kind,
                                  const planish_options *options, int with_state, pl_states *found,
                                  planish_error *error) {
    (void)kind;
    (void)options;
    *found = (pl_states){.state = NULL};
    if (with_state && !(found->state = calloc((size_t)job->mesh.n_elements + 1, 1)))
        return pl_fail_memory(error, "states of elements");
    return PLANISH_OK;
}

static int smooth_on_surface(pl_job *job, planish_result *result, planish_error *error) {
    return planish_smooth_surface(&job->mesh, planish_file_coordinates(job->file), &job->options,
                                  result, error);
}

const pl_engine pl_engine_of_surface = {.plan_create = plan_create_on_surface,
                                        .plan_destroy = plan_destroy_on_surface,
                                        .get_free = get_free_on_surface,
                                        .get_held = get_held_on_surface,
                                        .find_held = find_held_on_surface,
                                        .measure = measure_on_surface,
                                        .measure_elements = measure_elements_on_surface,
                                        .find_states = find_states_on_surface,
                                        .smooth = smooth_on_surface};
