/* states: which elements fall short: below their minimum volume, inverted for good, reversed. */
#include "job/states.h"
#include "options/combinations.h"

#include "job/held.h"
#include "terminal/message.h"
#include "terminal/signals.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static int ask_signals(const planish_progress *step, void *user) {
    (void)step;
    (void)user;
    return pl_signals_stop_asked();
}

/** Options for a search after smooth: with the rest of the time limit, and next to no time after a
 *  limit or signal. */
static planish_options options_after(const planish_options *options, const planish_result *smooth) {
    static const double NEXT_TO_NONE = 0.1; /* seconds: enough for most meshes */
    planish_options after = *options;
    if (options->progress)
        after.progress = ask_signals;
    if (smooth->stop == PLANISH_STOP_INTERRUPTED)
        after.time_limit = NEXT_TO_NONE;
    else if (options->time_limit > 0)
        after.time_limit = fmax(options->time_limit - smooth->seconds, NEXT_TO_NONE);
    return after;
}

static int find(const pl_job *job, pl_state_kind kind, const planish_options *options,
                int with_state, pl_states *found) {
    planish_error error;
    if (job->engine->find_states(job, kind, options, with_state, found, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    return 0;
}

/** Fill text with "elements 1, 2, 3, ...": the first few of the n elements whose state is least to most. */
static void list_elements(const pl_job *job, const uint8_t *state, int least, int most, int64_t n,
                          char text[PL_ELEMENTS_SIZE]) {
    enum { MOST_NAMED = 10 };
    int64_t named = 0;
    size_t used = (size_t)snprintf(text, PL_ELEMENTS_SIZE, "element%s", n == 1 ? "" : "s");
    for (int64_t i = 0; i < job->mesh.n_elements && named < n && named < MOST_NAMED; i++)
        if (state[i] >= least && state[i] <= most)
            used += (size_t)snprintf(text + used, PL_ELEMENTS_SIZE - used, "%s %" PRId64,
                                     named++ ? "," : "", pl_job_element_number(job, i));
    snprintf(text + used, PL_ELEMENTS_SIZE - used, "%s", named < n ? ", ..." : "");
}

/** Print "TEXT: elements 1, 2, 3, ..." of the n elements whose state is at least least, on one line. */
static void print_elements(FILE *stream, const pl_job *job, const uint8_t *state, int least,
                           int64_t n, const char *text) {
    char list[PL_ELEMENTS_SIZE];
    list_elements(job, state, least, UINT8_MAX, n, list);
    fprintf(stream, "%s: %s\n", text, list);
}

/* ---- minimum volumes ------------------------------------------------------------------------ */

int pl_volumes_count(const pl_job *job, int64_t *n_below) {
    pl_states found = {0};
    const int status = pl_arguments_bound_volumes(job->arguments)
                           ? find(job, PL_STATE_VOLUME, &job->options, 0, &found)
                           : 0;
    *n_below = found.n;
    return status;
}

int pl_volumes_find(const pl_job *job, double least, const planish_result *smooth,
                    pl_volumes *volumes) {
    pl_states found;
    *volumes = (pl_volumes){.least = least};
    if (!pl_arguments_bound_volumes(job->arguments))
        return 0;
    planish_options options = smooth ? options_after(&job->options, smooth) : job->options;
    options.min_volume = least; /* the fraction was of the volume before */
    options.min_volume_fraction = 0;
    const int status = find(job, PL_STATE_VOLUME, &options, 1, &found);
    volumes->state = found.state;
    volumes->n_below = found.n;
    volumes->n_undecided = found.n_undecided;
    for (int64_t i = 0; found.state && i < job->mesh.n_elements; i++)
        volumes->n_infeasible += found.state[i] == PLANISH_VOLUME_INFEASIBLE;
    return status;
}

void pl_volumes_free(pl_volumes *volumes) {
    free(volumes->state);
    volumes->state = NULL;
}

void pl_volumes_print(FILE *stream, const pl_job *job, const pl_volumes *volumes) {
    if (volumes->n_below > 0)
        print_elements(stream, job, volumes->state, PLANISH_VOLUME_BELOW, volumes->n_below,
                       "below their minimum volume");
    if (volumes->n_infeasible > 0)
        print_elements(stream, job, volumes->state, PLANISH_VOLUME_INFEASIBLE,
                       volumes->n_infeasible, "cannot reach it by moving free nodes");
}

/* ---- inverted for good ---------------------------------------------------------------------- */

const char *pl_holder_option(const pl_job *job, pl_holder holder) {
    static const char *const options[PL_N_HOLDERS] = {"--layers hold", "--fix", "regions"};
    return holder == PL_HOLDER_LAYERS && job->arguments->fix_layers ? "--fix-layers"
                                                                    : options[holder];
}

/** What options hold a node by, as bits. What holds its height is none: it holds no node that an inverted
 *  element needs. */
static unsigned held_by_options(const pl_job *job, const uint16_t *bits, int32_t node) {
    const uint8_t *asked = job->wanted.constraint;
    const int is_height = asked && asked[node] != PLANISH_CONSTRAINT_FIXED;
    return bits[node] & ~(is_height ? 1U << PL_CAUSE_LAYERS : 0);
}

/** The first option that alone holds a node of an element; -1: none does. bits [n_nodes] as
 *  pl_held_find. */
static int holder_of(const pl_job *job, const uint16_t *bits, int64_t element) {
    static const unsigned of[PL_N_HOLDERS] = {1 << PL_CAUSE_LAYERS, 1 << PL_CAUSE_FIX,
                                              1 << PL_CAUSE_INTERFACE};
    int corners;
    const int32_t *corner = pl_job_corners(job, element, &corners);
    unsigned all = 0, found = 0;
    for (int i = 0; i < PL_N_HOLDERS; i++)
        all |= of[i];
    for (int j = 0; j < corners; j++) {
        const unsigned here = held_by_options(job, bits, corner[j]);
        found |= here & ~all ? 0 : here;
    }
    for (int i = 0; i < PL_N_HOLDERS; i++)
        if (found & of[i])
            return i;
    return -1;
}

int pl_unfixable_find(const pl_job *job, int64_t n_inverted, const planish_result *smooth,
                      pl_unfixable *unfixable) {
    const planish_options options = options_after(&job->options, smooth);
    pl_states found;
    uint16_t *bits = NULL;
    *unfixable = (pl_unfixable){0};
    if (n_inverted == 0)
        return 0;
    int status = find(job, PL_STATE_UNFIXABLE, &options, 1, &found);
    unfixable->state = found.state;
    unfixable->n = found.n;
    unfixable->n_undecided = found.n_undecided;
    /* Those that options hold are told apart. */
    if (!status && found.n > 0)
        status = pl_held_find(job, &bits);
    for (int64_t i = 0; bits && i < job->mesh.n_elements; i++) {
        const int holder = found.state[i] ? holder_of(job, bits, i) : -1;
        if (holder >= 0) {
            unfixable->n_held[holder]++;
            found.state[i] = PL_UNFIXABLE_HELD;
        }
    }
    free(bits);
    return status;
}

int pl_unfixable_add_inside(const pl_job *job, const pl_cells_validity *validity,
                            int64_t n_infeasible_curved, pl_unfixable *unfixable) {
    if (validity->n_inside == 0 || n_infeasible_curved < validity->n_inside)
        return 0;
    if (!unfixable->state)
        unfixable->state = calloc((size_t)job->mesh.n_elements + 1, 1);
    if (!unfixable->state)
        return pl_job_complain_memory(job, "states of elements");
    for (int64_t i = 0; i < job->mesh.n_elements; i++)
        if (validity->state[i] == PL_INVERTED_INSIDE && !unfixable->state[i]) {
            unfixable->state[i] = PL_UNFIXABLE;
            unfixable->n++;
        }
    return 0;
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

void pl_unfixable_name(const pl_job *job, const pl_unfixable *unfixable,
                       char text[PL_ELEMENTS_SIZE]) {
    list_elements(job, unfixable->state, PL_UNFIXABLE, PL_UNFIXABLE,
                  unfixable->n - pl_unfixable_held(unfixable), text);
}

void pl_unfixable_print(FILE *stream, const pl_job *job, const pl_unfixable *unfixable) {
    const int64_t n_held = pl_unfixable_held(unfixable);
    if (n_held > 0)
        print_elements(stream, job, unfixable->state, PL_UNFIXABLE_HELD, n_held,
                       "inverted, and held by an option");
}

void pl_inside_print(FILE *stream, const pl_job *job, const pl_cells_validity *validity,
                     const pl_unfixable *unfixable) {
    int64_t n_told = 0;
    for (int64_t i = 0; unfixable->state && validity->state && i < job->mesh.n_elements; i++)
        n_told += unfixable->state[i] && validity->state[i] == PL_INVERTED_INSIDE;
    if (n_told < validity->n_inside)
        print_elements(stream, job, validity->state, PL_INVERTED_INSIDE, validity->n_inside,
                       "inverted inside, though their corners are right");
}

/* ---- reversed ------------------------------------------------------------------------------- */

int pl_reversed_find(const pl_job *job, int64_t n, uint8_t **state) {
    pl_states found = {0};
    const int status = n > 0 ? find(job, PL_STATE_REVERSED, &job->options, 1, &found) : 0;
    *state = found.state;
    return status;
}

int pl_reversed_compare(const pl_job *job, const planish_quality *after, pl_reversed *reversed) {
    const uint8_t *before = reversed->before;
    pl_states inverted = {0}; /* these are not new: they are told of as inverted */
    int status = pl_reversed_find(job, after->n_reversed, &reversed->state);
    if (!status && reversed->state && after->n_inverted > 0)
        status = find(job, PL_STATE_INVERTED, &job->options, 1, &inverted);
    for (int64_t i = 0; !status && reversed->state && i < job->mesh.n_elements; i++)
        if (reversed->state[i] && !(before && before[i]) &&
            !(inverted.state && inverted.state[i])) {
            reversed->state[i] = PL_REVERSED_NEW;
            reversed->n_new++;
        }
    free(inverted.state);
    return status;
}

void pl_reversed_free(pl_reversed *reversed) {
    free(reversed->before);
    free(reversed->state);
    *reversed = (pl_reversed){0};
}

void pl_reversed_print(FILE *stream, const pl_job *job, const uint8_t *state, int64_t n_reversed) {
    if (state && n_reversed > 0)
        print_elements(stream, job, state, PL_REVERSED, n_reversed,
                       "reversed in the file's order of nodes");
}
