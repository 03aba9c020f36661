/* ghosts: nodes that other processes move; all empty where the whole mesh is in one process.
 *
 *   pl_ghosts_create, _destroy          the ghosts of a plan
 *   pl_ghosts_note, _send, _receive     before and after the visits of a colour
 *   pl_ghosts_wake, _update             stars around ghosts that have moved; their values
 */
#ifndef PL_PLAN_GHOSTS_H
#define PL_PLAN_GHOSTS_H

#include "plan/plan.h"

/** Find the ghosts of the plan, if the mesh is in parts. order [n_nodes]: the mesh's numbers by
 *  inner ones. Destroy them in any case. Errors: _MEMORY. */
int pl_ghosts_create(planish_plan *plan, const planish_mesh *mesh, const int32_t *order,
                     planish_error *error);

/** Free the arrays of ghosts. */
void pl_ghosts_destroy(pl_ghosts *ghosts);

/** Note where the nodes of the SHARED stars begin .. end - 1 are, before their visits. */
void pl_ghosts_note(const planish_plan *plan, const pl_visits *visits, int64_t begin, int64_t end);

/** Tell the other processes which of these nodes have moved, after their visits. */
void pl_ghosts_send(const planish_plan *plan, const pl_visits *visits, int64_t begin, int64_t end);

/** Take the places of ghosts that the other processes have sent. */
void pl_ghosts_receive(const planish_plan *plan);

/** Wake the stars around ghosts that are not where they were before: [n_nodes][dim] by inner
 * numbers.
 */
void pl_ghosts_wake(const planish_plan *plan, const double *before);

/** Fetch a value of size bytes for each ghost, by inner numbers. */
void pl_ghosts_update(const planish_plan *plan, void *values, int64_t size);

#endif
