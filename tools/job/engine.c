/* engine: the work in this process. */
#include "job/engine.h"

#include "job/job.h"

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

static int check_volumes(const pl_job *job, const planish_options *options, uint8_t *state,
                         int64_t *n_below, int64_t *n_undecided, planish_error *error) {
    return planish_check_volumes_until(job->plan, job->mesh.coordinates, options, state, n_below,
                                       n_undecided, error);
}

static int find_unfixable(const pl_job *job, const planish_options *options, uint8_t *state,
                          int64_t *n, int64_t *n_undecided, planish_error *error) {
    return planish_find_unfixable_until(job->plan, job->mesh.coordinates, options, state, n,
                                        n_undecided, error);
}

static int find_reversed(const pl_job *job, uint8_t *state, int64_t *n, planish_error *error) {
    return planish_find_reversed(job->plan, job->mesh.coordinates, state, n, error);
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
                                  .check_volumes = check_volumes,
                                  .find_unfixable = find_unfixable,
                                  .find_reversed = find_reversed,
                                  .smooth = smooth};
