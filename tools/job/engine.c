/* engine: the work in this process. */
#include "job/engine.h"

#include "job/job.h"

#include "base/status.h"

#include <stdlib.h>

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
                                  .measure = measure,
                                  .measure_elements = measure_elements,
                                  .find_states = find_states,
                                  .smooth = smooth};
