/* volumes: which elements are below the minimum volume that the command line asks for, and which
 * are inverted for good. */
#include "job/volumes.h"

#include "job/held.h"
#include "terminal/message.h"
#include "terminal/signals.h"

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
                          "below their minimum volume");
    if (volumes->n_infeasible > 0)
        pl_elements_print(stream, job, volumes->state, PLANISH_VOLUME_INFEASIBLE,
                          volumes->n_infeasible, "cannot reach it wherever the free nodes are");
}

const char *pl_holder_option(pl_holder holder) {
    static const char *const options[PL_N_HOLDERS] = {"--fix-layers", "--fix", "regions"};
    return options[holder];
}

/** The first option that alone holds a node of an element; -1: none does. bits [n_nodes] as
 *  pl_held_find. */
static int holder_of(const pl_job *job, const uint16_t *bits, int64_t element) {
    static const unsigned of[PL_N_HOLDERS] = {1 << PL_HELD_BY_LAYERS, 1 << PL_HELD_BY_FIX,
                                              1 << PL_HELD_BY_INTERFACE};
    const int corners = job->mesh.dim + 1;
    unsigned all = 0, found = 0;
    for (int i = 0; i < PL_N_HOLDERS; i++)
        all |= of[i];
    for (int j = 0; j < corners; j++) {
        const unsigned here = bits[job->mesh.elements[element * corners + j]];
        found |= here & ~all ? 0 : here;
    }
    for (int i = 0; i < PL_N_HOLDERS; i++)
        if (found & of[i])
            return i;
    return -1;
}

/** Tell the elements that options hold from the others. */
static int find_holders(const pl_job *job, pl_unfixable *unfixable) {
    uint16_t *bits = NULL;
    const int status = unfixable->n > 0 ? pl_held_find(job, &bits) : 0;
    for (int64_t i = 0; bits && i < job->mesh.n_elements; i++) {
        const int holder = unfixable->state[i] ? holder_of(job, bits, i) : -1;
        if (holder >= 0) {
            unfixable->n_held[holder]++;
            unfixable->state[i] = PL_UNFIXABLE_HELD;
        }
    }
    free(bits);
    return status;
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
    return find_holders(job, unfixable);
}

void pl_unfixable_free(pl_unfixable *unfixable) {
    free(unfixable->state);
    unfixable->state = NULL;
}

int64_t pl_unfixable_held(const pl_unfixable *unfixable) {
    int64_t n = 0;
    for (int i = 0; i < PL_N_HOLDERS; i++)
        n += unfixable->n_held[i];
    return n;
}

void pl_unfixable_print(FILE *stream, const pl_job *job, const pl_unfixable *unfixable) {
    const int64_t n_held = pl_unfixable_held(unfixable), m = job->mesh.n_elements;
    uint8_t *others = n_held < unfixable->n ? malloc((size_t)m + 1) : NULL;
    for (int64_t i = 0; others && i < m; i++)
        others[i] = unfixable->state[i] == PL_UNFIXABLE;
    if (others)
        pl_elements_print(stream, job, others, 1, unfixable->n - n_held,
                          "cannot be made valid wherever the free nodes are");
    if (n_held > 0)
        pl_elements_print(stream, job, unfixable->state, PL_UNFIXABLE_HELD, n_held,
                          "inverted, and held by an option");
    free(others);
}
