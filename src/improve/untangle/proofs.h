/* proofs: elements that no position of the free nodes can bring above their minimum volume.
 *
 *   pl_mark_enclosed       elements inside a boundary of non-positive volume
 *   pl_mark_infeasible     elements of a star that contradict one another
 */
#ifndef PL_IMPROVE_UNTANGLE_PROOFS_H
#define PL_IMPROVE_UNTANGLE_PROOFS_H

#include "plan/plan.h"

/** Result of a search for proofs. */
typedef struct pl_infeasible {
    int64_t n;           /* elements _INFEASIBLE */
    int64_t n_undecided; /* elements _BELOW of stars that the limit has kept from being searched */
} pl_infeasible;

/** Turn PLANISH_VOLUME_BELOW into _INFEASIBLE in state [n_elements] for elements that are not
 *  positive, in components of elements joined by free nodes, if the held nodes around the component
 *  enclose no positive volume: not all of them can be, wherever the free nodes are. x: coordinates
 *  by inner numbers. given_up [n_nodes] by inner numbers (may be NULL) becomes 1 at their free
 *  nodes. *n: how many elements it were; none in a mesh in parts. Errors: _MEMORY. */
int pl_mark_enclosed(const planish_plan *plan, const double *x, uint8_t *state, uint8_t *given_up,
                     int64_t *n, planish_error *error);

/** Turn _BELOW into _INFEASIBLE in state [m] where the element cannot reach its minimum volume: it
 * has no free node, or it is part of a proof (pl_star_infeasible) at its only one. The coordinates,
 * and the guard, are the problem's. If part is not NULL, mark only elements that have no free node
 * or are given up; the latter whatever their state was. *part then becomes [link facets of all
 * stars] of pl_proof_role, to be released by pl_free. limit (may be NULL) ends the search; its
 * answer is then the largest of the processes. Errors: _MEMORY. */
int pl_mark_infeasible(const planish_plan *plan, const pl_star_problem *problem, uint8_t *state,
                       pl_stop_check *limit, pl_infeasible *found, uint8_t **part,
                       planish_error *error);

#endif
