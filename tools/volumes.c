/* volumes: which elements are below the least volume that the command line asks for, and which are
 * inverted for good. */
#include "volumes.h"

#include "message.h"
#include "signals.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

enum { MOST_NAMED = 10 };

/* Seconds for a search where there is no time any more: enough for most meshes. */
static const double NEXT_TO_NONE = 0.1;

static int ask_signals(const planish_progress *step, void *user) {
    (void)step;
    (void)user;
    return pl_signals_stop_asked();
}

planish_options pl_options_after(const planish_options *options, const planish_result *smooth) {
    planish_options after = *options;
    if (options->progress)
        after.progress = ask_signals;
    if (smooth->stop == PLANISH_STOP_INTERRUPTED)
        after.time_limit = NEXT_TO_NONE;
    else if (options->time_limit > 0)
        after.time_limit = fmax(options->time_limit - smooth->seconds, NEXT_TO_NONE);
    return after;
}

/** Below in state [mesh.n_elements] (may be NULL) and number; 0, or an exit status. */
static int check(const pl_job *job, const planish_options *options, uint8_t *state,
                 int64_t *n_below, int64_t *n_undecided) {
    planish_error error;
    if (job->engine->check_volumes(job, options, state, n_below, n_undecided, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    return 0;
}

/** Room for a state of each element; NULL after a message. */
static uint8_t *make_states(const pl_job *job) {
    uint8_t *state = malloc((size_t)job->mesh.n_elements);
    if (!state)
        pl_complain(PL_EXIT_FAILED, "%s: out of memory for the states of %" PRId64 " elements",
                    job->arguments->input, job->mesh.n_elements);
    return state;
}

int pl_volumes_count(const pl_job *job, int64_t *n_below) {
    int64_t n_undecided; /* nobody asks which they are */
    *n_below = 0;
    if (!pl_arguments_bound_volumes(job->arguments))
        return 0;
    return check(job, &job->options, NULL, n_below, &n_undecided);
}

int pl_volumes_find(const pl_job *job, double least, const planish_result *smooth,
                    pl_volumes *volumes) {
    *volumes = (pl_volumes){.least = least};
    if (!pl_arguments_bound_volumes(job->arguments))
        return 0;
    volumes->state = make_states(job);
    if (!volumes->state)
        return PL_EXIT_FAILED;
    planish_options options = smooth ? pl_options_after(&job->options, smooth) : job->options;
    /* The fraction was of the volume before. */
    options.min_volume = least;
    options.min_volume_fraction = 0;
    const int status =
        check(job, &options, volumes->state, &volumes->n_below, &volumes->n_undecided);
    for (int64_t i = 0; i < job->mesh.n_elements && !status; i++)
        volumes->n_infeasible += volumes->state[i] == PLANISH_VOLUME_INFEASIBLE;
    return status;
}

void pl_volumes_free(pl_volumes *volumes) {
    free(volumes->state);
    volumes->state = NULL;
}

void pl_elements_print(FILE *stream, const pl_job *job, const uint8_t *state, int least, int64_t n,
                       const char *text) {
    int64_t named = 0;
    fprintf(stream, "%s: element%s", text, n == 1 ? "" : "s");
    for (int64_t i = 0; i < job->mesh.n_elements && named < n && named < MOST_NAMED; i++)
        if (state[i] >= least)
            fprintf(stream, "%s %" PRId64, named++ ? "," : "", pl_job_element_number(job, i));
    fprintf(stream, "%s\n", named < n ? ", ..." : "");
}

void pl_volumes_print(FILE *stream, const pl_job *job, const pl_volumes *volumes) {
    if (volumes->state && volumes->n_below > 0)
        pl_elements_print(stream, job, volumes->state, PLANISH_VOLUME_BELOW, volumes->n_below,
                          "below their least volume");
    if (volumes->n_infeasible > 0)
        pl_elements_print(stream, job, volumes->state, PLANISH_VOLUME_INFEASIBLE,
                          volumes->n_infeasible, "cannot reach it wherever the free nodes are");
}

int pl_unfixable_find(const pl_job *job, int64_t n_inverted, const planish_result *smooth,
                      pl_unfixable *unfixable) {
    const planish_options options = pl_options_after(&job->options, smooth);
    planish_error error;
    *unfixable = (pl_unfixable){0};
    if (n_inverted == 0)
        return 0;
    unfixable->state = make_states(job);
    if (!unfixable->state)
        return PL_EXIT_FAILED;
    if (job->engine->find_unfixable(job, &options, unfixable->state, &unfixable->n,
                                    &unfixable->n_undecided, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    return 0;
}

void pl_unfixable_free(pl_unfixable *unfixable) {
    free(unfixable->state);
    unfixable->state = NULL;
}

void pl_unfixable_print(FILE *stream, const pl_job *job, const pl_unfixable *unfixable) {
    if (unfixable->n > 0)
        pl_elements_print(stream, job, unfixable->state, 1, unfixable->n,
                          "cannot be made valid wherever the free nodes are");
}
