/* volumes: which elements are below the minimum volume that the command line asks for, and which
 * are inverted for good. */
#ifndef PL_TOOLS_VOLUMES_H
#define PL_TOOLS_VOLUMES_H

#include "job/job.h"

#include <stdio.h>

/** Print "TEXT: elements 1, 2, 3, ...", the first few of the n elements whose state is at least
 * least, on one line. state [mesh.n_elements]. */
void pl_elements_print(FILE *stream, const pl_job *job, const uint8_t *state, int least, int64_t n,
                       const char *text);

/** What there is to say of the volumes of a mesh; all zero where no minimum volume is asked for. */
typedef struct pl_volumes {
    double least;         /* the minimum volume of elements without one of their own; 0: none */
    int64_t n_below;      /* elements below 0.997 of theirs */
    int64_t n_infeasible; /* those of them that cannot reach it */
    int64_t n_undecided;  /* others that were not decided, as there was no time */
    uint8_t *state;       /* [mesh.n_elements] of planish_volume_state, owned, or NULL: all met */
} pl_volumes;

/** Count the elements below in the mesh as it is now. */
int pl_volumes_count(const pl_job *job, int64_t *n_below);

/** Options with the time that searches after smooth may take: what is left of the time limit, and
 *  next to none after a limit or signal. */
planish_options pl_options_after(const planish_options *options, const planish_result *smooth);

/** Find them, and those that cannot be helped; least: as in pl_volumes; smooth: what it has come to
 *  before, or NULL. */
int pl_volumes_find(const pl_job *job, double least, const planish_result *smooth,
                    pl_volumes *volumes);

void pl_volumes_free(pl_volumes *volumes);

/** Name the first of them, a line for those below and one for those that cannot be helped. */
void pl_volumes_print(FILE *stream, const pl_job *job, const pl_volumes *volumes);

/** Options that hold nodes which could move without them. */
typedef enum pl_holder {
    PL_HOLDER_LAYERS,
    PL_HOLDER_FIX,
    PL_HOLDER_REGIONS,
    PL_N_HOLDERS
} pl_holder;

/** What pl_unfixable.state says of an element. */
enum { PL_NOT_UNFIXABLE, PL_UNFIXABLE, PL_UNFIXABLE_HELD };

/** The inverted elements that cannot be made valid by moving the free nodes. */
typedef struct pl_unfixable {
    int64_t n;
    int64_t n_undecided;          /* others that were not decided, as there was no time */
    int64_t n_held[PL_N_HOLDERS]; /* those of them with a node that an option alone holds: each
                                     counts once, for the first such option */
    uint8_t *state; /* [mesh.n_elements] PL_UNFIXABLE, ...; owned, or NULL: there are none */
} pl_unfixable;

/** The option that a holder is, "--fix-layers". */
const char *pl_holder_option(pl_holder holder);

/** Find them in the mesh as it is now, of whose elements n_inverted are inverted; smooth: as above.
 */
int pl_unfixable_find(const pl_job *job, int64_t n_inverted, const planish_result *smooth,
                      pl_unfixable *unfixable);

/** How many of them options hold. */
int64_t pl_unfixable_held(const pl_unfixable *unfixable);

void pl_unfixable_free(pl_unfixable *unfixable);

/** Name the first of them. */
void pl_unfixable_print(FILE *stream, const pl_job *job, const pl_unfixable *unfixable);

#endif
