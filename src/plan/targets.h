/* targets: elements of a plan that are to have the shapes that mesh.reference has. Internal to plan.
 *
 *   pl_own_cells_make      simplices as cells
 *   pl_targets_make        the targets of the corners, from a reference
 *   pl_layer_targets_make  from layers
 *   pl_size_targets_make   from a field of sizes
 */
#ifndef PL_PLAN_TARGETS_H
#define PL_PLAN_TARGETS_H

#include "plan/plan.h"

/** Make cells of the simplices of mesh: own, which cells shows; *with is mesh with them. Errors: as of
 *  pl_dense_create. */
int pl_own_cells_make(const planish_mesh *mesh, int threads, pl_own_cells *own,
                      planish_cells *cells, planish_mesh *with, planish_error *error);

/** Make the targets of the plan's elements, which are corners: the values at reference, in the
 *  order of the caller's nodes. sign [n_elements] of those that are valid, NULL: all +1. Errors:
 *  _MESH, _MEMORY. */
int pl_targets_make(planish_plan *plan, pl_points reference, const int8_t *sign,
                    planish_error *error);

/** Make the targets of the plan's elements, which are corners of given, from its layers. Errors:
 *  _MEMORY. */
int pl_layer_targets_make(planish_plan *plan, const planish_mesh *given, planish_error *error);

/** Make the targets of the plan's elements, which are corners of given, from its sizes; x [n_nodes][dim]
 *  is where its nodes are. Errors: _MESH, _MEMORY. */
int pl_size_targets_make(planish_plan *plan, const planish_mesh *given, const double *x,
                         planish_error *error);

#endif
