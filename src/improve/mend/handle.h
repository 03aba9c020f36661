/* handle: a mid or corner of a curved element that moves by itself.
 *
 * A corner has a place in the plan's coordinates. A mid follows its ends, and has a way of its own
 * from there (pl_mids.own).
 */
#ifndef PL_IMPROVE_MEND_HANDLE_H
#define PL_IMPROVE_MEND_HANDLE_H

#include "improve/mend/elements.h"

/** Node that moves. */
typedef struct pl_handle {
    int32_t node;    /* the caller's number, */
    int32_t inner;   /* and that of the plan's coordinates; -1: a mid */
    int is_active;   /* to be visited in the next sweep */
    double saved[3]; /* coordinates, or a mid's own way */
} pl_handle;

/** Return the handle of a node, which is a mid or a free corner, saved and active. */
pl_handle pl_handle_of(pl_mend *c, int32_t node);

/** Set x [dim] to the node's place. */
void pl_handle_place(const pl_mend *c, const pl_handle *h, double *x);

/** Keep the node's place in h. */
void pl_handle_save(const pl_mend *c, pl_handle *h);

/** Return the node to the place that h has kept. */
void pl_handle_restore(const pl_mend *c, const pl_handle *h);

/** Move the node to x [dim], or as near as it can be stored. Return 0 if it may not be there: a
 *  corner has not moved then, a mid has. */
int pl_handle_put(const pl_mend *c, const pl_handle *h, double *x);

#endif
