/* reversed: the elements that are negative in the order in which the file lists their nodes, while
 * most are positive (or the other way round), before and after smoothing. */
#include "job/reversed.h"

#include "terminal/message.h"
#include "job/volumes.h"

#include <inttypes.h>
#include <stdlib.h>

static int complain_memory(const pl_job *job) {
    return pl_complain(PL_EXIT_FAILED, "%s: out of memory for the order of %" PRId64 " elements",
                       job->arguments->input, job->mesh.n_elements);
}

int pl_reversed_find(const pl_job *job, int64_t n, uint8_t **state) {
    planish_error error;
    int64_t found;
    *state = NULL;
    if (n == 0)
        return 0;
    *state = malloc((size_t)job->mesh.n_elements);
    if (!*state)
        return complain_memory(job);
    if (job->engine->find_reversed(job, *state, &found, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    return 0;
}

void pl_reversed_mark_new(int64_t n, const uint8_t *before, const double *ratio, uint8_t *state) {
    for (int64_t i = 0; i < n; i++)
        if (state[i] && !(before && before[i]) && !(ratio && ratio[i] == 0))
            state[i] = PL_REVERSED_NEW;
}

/** The elements that smoothing has left inverted are no new ones: they are told of as such. */
static int mark_new(const pl_job *job, const planish_quality *after, pl_reversed *reversed) {
    const int64_t n = job->mesh.n_elements;
    planish_error error;
    double *ratio = NULL;
    int code = PLANISH_OK;
    if (after->inverted > 0) {
        ratio = malloc((size_t)n * sizeof *ratio);
        if (!ratio)
            return complain_memory(job);
        code = job->engine->measure_elements(job, ratio, &error);
    }
    if (!code)
        pl_reversed_mark_new(n, reversed->before, ratio, reversed->state);
    free(ratio);
    return code ? pl_job_complain(job, PL_EXIT_FAILED, &error) : 0;
}

int pl_reversed_compare(const pl_job *job, const planish_quality *after, pl_reversed *reversed) {
    int status = pl_reversed_find(job, after->reversed, &reversed->state);
    if (!status && reversed->state)
        status = mark_new(job, after, reversed);
    for (int64_t i = 0; !status && reversed->state && i < job->mesh.n_elements; i++)
        reversed->n_new += reversed->state[i] == PL_REVERSED_NEW;
    return status;
}

void pl_reversed_free(pl_reversed *reversed) {
    free(reversed->before);
    free(reversed->state);
    *reversed = (pl_reversed){0};
}

void pl_reversed_print(FILE *stream, const pl_job *job, const uint8_t *state, int64_t n_reversed) {
    if (state && n_reversed > 0)
        pl_elements_print(stream, job, state, PL_REVERSED, n_reversed,
                          "reversed in the order in which the file lists their nodes");
}
