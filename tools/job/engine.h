/* engine: who works on the mesh of a job: this process, or (mpi/) several that share it. */
#ifndef PL_TOOLS_ENGINE_H
#define PL_TOOLS_ENGINE_H

#include <planish/planish.h>

struct pl_job;

/** What the functions of planish.h of these names do for the whole mesh of a job, at its present
 *  coordinates; of check_volumes and find_unfixable those that end in _until. Each returns a
 * planish_status, with *error filled in unless that is PLANISH_OK. */
typedef struct pl_engine {
    int (*plan_create)(struct pl_job *job, planish_error *error); /* and job->plan_info */
    void (*plan_destroy)(struct pl_job *job);
    int (*get_free)(const struct pl_job *job, uint8_t *is_free, planish_error *error);
    /* NULL: the reasons are not known. */
    int (*get_held)(const struct pl_job *job, uint8_t *reason, planish_error *error);
    int (*measure)(const struct pl_job *job, planish_quality *quality, planish_error *error);
    int (*measure_elements)(const struct pl_job *job, double *ratio, planish_error *error);
    int (*check_volumes)(const struct pl_job *job, const planish_options *options, uint8_t *state,
                         int64_t *n_below, int64_t *n_undecided, planish_error *error);
    int (*find_unfixable)(const struct pl_job *job, const planish_options *options, uint8_t *state,
                          int64_t *n, int64_t *n_undecided, planish_error *error);
    int (*find_reversed)(const struct pl_job *job, uint8_t *state, int64_t *n,
                         planish_error *error);
    int (*smooth)(struct pl_job *job, planish_result *result, planish_error *error);
    /* Files that the engine can write besides those of planish_io; NULL: none. */
    int (*can_write)(const char *path);
    int (*write)(const struct pl_job *job, const char *path, planish_error *error);
} pl_engine;

/** This process, with the job's plan. */
extern const pl_engine pl_engine_here;

#endif
