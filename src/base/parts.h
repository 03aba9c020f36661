/* parts: requests to the other processes that have parts of the mesh (planish_part).
 *
 * A call on a plan enters its context, which knows the part. Where the whole mesh is in one
 * process these functions do nothing. With parts every process calls them in the same order:
 * facts that all processes know must decide whether a function is called.
 *
 *   pl_part_here, pl_is_own                          the part of this process
 *   pl_parts_begin, _end, _check                     frame, and failures
 *   pl_parts_add, _add_sums, _largest, _smallest, _smallest_integers, _any    combine numbers
 *   pl_parts_ghosts, _update, _send, _receive        values of ghosts
 */
#ifndef PL_BASE_PARTS_H
#define PL_BASE_PARTS_H

#include "base/context.h"
#include "base/sum.h"

#include <planish/planish.h>

/** Return the part that this process has, or NULL: the whole mesh. */
const planish_part *pl_part_here(void);

/** Set values [n] to their sums over the processes. */
void pl_parts_add(int64_t *values, int n);

/** Add sums [n] over the processes, in place, exactly. */
void pl_parts_add_sums(pl_sum *sums, int n);

/** Set values [n] to the largest of the processes; no NaN. */
void pl_parts_largest(double *values, int n);

/** Set values [n] to the smallest of the processes; no NaN. */
void pl_parts_smallest(double *values, int n);

/** Set values [n] to the smallest of the processes; no INT64_MIN. */
void pl_parts_smallest_integers(int64_t *values, int n);

/** Return 1 if value is not 0 in any process; 0 if they are not reached. */
int pl_parts_any(int value);

/** Whether this process is the one whose say counts for node: it is no ghost. */
static inline int pl_is_own(const planish_part *part, int64_t node) {
    return !part || part->node_role[node] != PLANISH_ROLE_GHOST;
}

enum { PL_LARGEST_VALUE = 3 * sizeof(double) + 1 };

/** Prepare pl_parts_update in the context of this thread, whose part is set. n_nodes: nodes of the
 *  part. pl_parts_end must follow in any case. Errors: _MEMORY. */
int pl_parts_begin(int64_t n_nodes, planish_error *error);

/** Undo pl_parts_begin. */
void pl_parts_end(pl_context *context);

/** Return the number of ghosts of the part, 0 without a part. n_nodes: nodes of the part. */
int64_t pl_parts_ghosts(int64_t n_nodes);

/** Set the ghosts in values [n_nodes][size] to the values of their processes: node i is at inner[i]
 *  (NULL: at i). size: at most PL_LARGEST_VALUE. */
void pl_parts_update(const int32_t *inner, void *values, int64_t size);

/** Call planish_part.send, if the processes are reached. */
void pl_parts_send(const int32_t *node, int64_t n, const void *values, int64_t size);

/** Call planish_part.receive, if the processes are reached. */
void pl_parts_receive(planish_take_fn *take, void *taker);

/** Return PLANISH_ERROR_PROCESS if another process was not reached since the context was made. */
int pl_parts_check(planish_error *error);

#endif
