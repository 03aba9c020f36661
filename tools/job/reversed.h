/* reversed: the elements that are negative in the order in which the file lists their nodes, while
 * most are positive (or the other way round), before and after smoothing. */
#ifndef PL_TOOLS_REVERSED_H
#define PL_TOOLS_REVERSED_H

#include "job/job.h"

#include <stdio.h>

/** What state says of an element. */
enum {
    PL_LISTED_AS_MOST = 0,
    PL_REVERSED = 1,    /* the other way round */
    PL_REVERSED_NEW = 2 /* so since it was smoothed, and valid but for the order of its nodes */
};

/** The reversed elements of a mesh. All zero: there are none. */
typedef struct pl_reversed {
    uint8_t *before; /* [mesh.n_elements] 0 or 1, owned, or NULL: none was reversed */
    uint8_t *state;  /* [mesh.n_elements] of the mesh as it is now, owned, or NULL: none is */
    int64_t n_new;   /* of PL_REVERSED_NEW */
} pl_reversed;

/** Find the reversed elements of the mesh as it is now; n: their number, which was measured.
 *  *state [mesh.n_elements] is to be freed, or NULL: none. Returns 0, or an exit status. */
int pl_reversed_find(const pl_job *job, int64_t n, uint8_t **state);

/** Find those of the result, and which of them are new; reversed->before is set. */
int pl_reversed_compare(const pl_job *job, const planish_quality *after, pl_reversed *reversed);

/** Mark the new ones in state [n]: before (NULL: none) is the state of the input; ratio (NULL: all
 *  are valid) is 0 for inverted elements. */
void pl_reversed_mark_new(int64_t n, const uint8_t *before, const double *ratio, uint8_t *state);

void pl_reversed_free(pl_reversed *reversed);

/** Name the first of the n_reversed elements of state. */
void pl_reversed_print(FILE *stream, const pl_job *job, const uint8_t *state, int64_t n_reversed);

#endif
