/* states: which elements fall short: below their minimum volume, inverted for good, reversed.
 *
 *     pl_volumes_*      elements below their minimum volume, and which of them cannot reach it
 *     pl_unfixable_*    inverted elements that no position of the movable nodes makes valid
 *     pl_inside_print   elements that are inverted by their mid-side nodes
 *     pl_reversed_*     elements that are negative in the file's order of their nodes, while most
 *                       are positive (or the other way round)
 *
 * Functions that return an int return 0, or an exit status after a message.
 */
#ifndef PL_TOOLS_STATES_H
#define PL_TOOLS_STATES_H

#include "job/cells.h"
#include "job/job.h"

#include <stdio.h>

/** Elements below their minimum volume; all zero if no option asks for one. */
typedef struct pl_volumes {
    double least;         /* minimum volume of elements without one of their own; 0: none */
    int64_t n_below;      /* elements below 0.997 of theirs */
    int64_t n_infeasible; /* those of them that cannot reach it */
    int64_t n_undecided;  /* others that were not decided, as there was no time */
    uint8_t *state;       /* [mesh.n_elements] of planish_volume_state, owned, or NULL: all met */
} pl_volumes;

/** Count the elements below in the mesh as it is now. */
int pl_volumes_count(const pl_job *job, int64_t *n_below);

/** Find them, and those that cannot reach it; least: as in pl_volumes; smooth: the result of
 *  smoothing, whose time limit leaves the rest to this search, or NULL. */
int pl_volumes_find(const pl_job *job, double least, const planish_result *smooth,
                    pl_volumes *volumes);

void pl_volumes_free(pl_volumes *volumes);

/** Name the first of them, a line for those below and one for those that cannot reach it. */
void pl_volumes_print(FILE *stream, const pl_job *job, const pl_volumes *volumes);

/** Options that hold nodes which could move without them. */
typedef enum pl_holder {
    PL_HOLDER_LAYERS,
    PL_HOLDER_FIX,
    PL_HOLDER_REGIONS,
    PL_N_HOLDERS
} pl_holder;

/** Values of pl_unfixable.state. */
enum { PL_NOT_UNFIXABLE, PL_UNFIXABLE, PL_UNFIXABLE_HELD };

/** The inverted elements that cannot be made valid by moving the free nodes. */
typedef struct pl_unfixable {
    int64_t n;
    int64_t n_undecided;          /* others that were not decided, as there was no time */
    int64_t n_held[PL_N_HOLDERS]; /* those of them with a node that an option alone holds: each
                                     counts once, for the first such option */
    uint8_t *state; /* [mesh.n_elements] PL_UNFIXABLE, ...; owned, or NULL: there are none */
} pl_unfixable;

/** Name of the option of a holder, "--layers hold". */
const char *pl_holder_option(const pl_job *job, pl_holder holder);

/** Find them in the mesh as it is now, which has n_inverted inverted elements; smooth: as above. */
int pl_unfixable_find(const pl_job *job, int64_t n_inverted, const planish_result *smooth,
                      pl_unfixable *unfixable);

/** Add the elements that are inverted inside, if all of them are proved hopeless. */
int pl_unfixable_add_inside(const pl_job *job, const pl_cells_validity *validity,
                            int64_t n_infeasible_curved, pl_unfixable *unfixable);

/** Number of those that options hold. */
int64_t pl_unfixable_held(const pl_unfixable *unfixable);

void pl_unfixable_free(pl_unfixable *unfixable);

enum { PL_ELEMENTS_SIZE = 320 }; /* of a list of the first ten elements */

/** Fill text with a list of those that no option holds, "elements 1, 2, ..."; there is one. */
void pl_unfixable_name(const pl_job *job, const pl_unfixable *unfixable,
                       char text[PL_ELEMENTS_SIZE]);

/** Name the first of those that options hold. */
void pl_unfixable_print(FILE *stream, const pl_job *job, const pl_unfixable *unfixable);

/** Name the first of the elements that are inverted though their corners are positive, unless all of them
 *  are unfixable. */
void pl_inside_print(FILE *stream, const pl_job *job, const pl_cells_validity *validity,
                     const pl_unfixable *unfixable);

/** Values of pl_reversed.state. */
enum {
    PL_LISTED_AS_MOST = 0,
    PL_REVERSED = 1,    /* the other way round */
    PL_REVERSED_NEW = 2 /* so since smoothing, and valid but for the order of its nodes */
};

/** The reversed elements of a mesh. All zero: there are none. */
typedef struct pl_reversed {
    uint8_t *before; /* [mesh.n_elements] 0 or 1, owned, or NULL: none was reversed */
    uint8_t *state;  /* [mesh.n_elements] of the mesh as it is now, owned, or NULL: none is */
    int64_t n_new;   /* of PL_REVERSED_NEW */
} pl_reversed;

/** Find the reversed elements of the mesh as it is now; n: their number, which was measured.
 *  *state [mesh.n_elements] is to be freed, or NULL: none. */
int pl_reversed_find(const pl_job *job, int64_t n, uint8_t **state);

/** Find those of the result, and which of them are new; reversed->before is set. */
int pl_reversed_compare(const pl_job *job, const planish_quality *after, pl_reversed *reversed);

void pl_reversed_free(pl_reversed *reversed);

/** Name the first of the n_reversed elements of state. */
void pl_reversed_print(FILE *stream, const pl_job *job, const uint8_t *state, int64_t n_reversed);

#endif
