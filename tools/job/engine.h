/* engine: who works on the mesh of a job: this process, or (mpi/) several that share the mesh. */
#ifndef PL_TOOLS_ENGINE_H
#define PL_TOOLS_ENGINE_H

#include <planish/planish.h>

struct pl_job;

/** Which state of an element is asked for, and the values of that state: 0 is the plain one. */
typedef enum pl_state_kind {
    PL_STATE_VOLUME,    /* planish_volume_state, by planish_check_volumes */
    PL_STATE_UNFIXABLE, /* 1: planish_find_infeasible found it */
    PL_STATE_REVERSED,  /* 1: planish_find_reversed found it */
    PL_STATE_INVERTED   /* 1: it has no radius ratio */
} pl_state_kind;

/** Elements whose state is not 0. */
typedef struct pl_states {
    uint8_t *state; /* [mesh.n_elements] owned, or NULL: not asked for, or all are 0 */
    int64_t n;
    int64_t n_undecided; /* others that were not decided, as there was no time */
} pl_states;

/** Steps on the whole mesh of a job, at its present coordinates, as the functions of planish.h of
 * these names do them. Each returns a planish_status, with *error filled in unless that is
 * PLANISH_OK. */
typedef struct pl_engine {
    /* Read the mesh, of which the program then has no copy: job->file stays NULL, job->mesh has no
     * arrays. NULL: the job reads the file by planish_io. */
    int (*read)(struct pl_job *job, planish_error *error);
    /* Choose who works on the mesh, which the job has read; NULL: there is no choice. */
    void (*choose)(struct pl_job *job);
    int (*plan_create)(struct pl_job *job, planish_error *error); /* and job->plan_info */
    void (*plan_destroy)(struct pl_job *job);
    int (*get_free)(const struct pl_job *job, uint8_t *is_free, planish_error *error);
    /* NULL: the reasons are not known. */
    int (*get_held)(const struct pl_job *job, uint8_t *reason, planish_error *error);
    /* As planish_find_held; NULL: not known. */
    int (*find_held)(const struct pl_job *job, uint8_t *held, planish_error *error);
    int (*measure)(const struct pl_job *job, planish_quality *quality, planish_error *error);
    int (*measure_elements)(const struct pl_job *job, double *ratio, planish_error *error);
    /* with_state: whether found->state is asked for. */
    int (*find_states)(const struct pl_job *job, pl_state_kind kind, const planish_options *options,
                       int with_state, pl_states *found, planish_error *error);
    int (*smooth)(struct pl_job *job, planish_result *result, planish_error *error);
    /* Files that the engine can write besides those of planish_io; NULL: none. checksums [2]: what
     * planish_checksum says of the mesh as read and as written, where the program has no copy of
     * the mesh; else untouched. */
    int (*can_write)(const char *path);
    int (*write)(const struct pl_job *job, const char *path, uint64_t *checksums,
                 planish_error *error);
} pl_engine;

/** This process, with the job's plan. */
extern const pl_engine pl_engine_here;

/** An engine for a surface in space, by job->curved.shape. */
extern const pl_engine pl_engine_of_surface;

/** Find the states of all elements of mesh: state [mesh->n_elements], or NULL for their number
 *  alone; n and n_undecided of *found. Returns a planish_status with *error. */
int pl_states_find(const planish_plan *plan, const planish_mesh *mesh, pl_state_kind kind,
                   const planish_options *options, uint8_t *state, pl_states *found,
                   planish_error *error);

#endif
