/* make: pl_plan_make, which makes a plan. draft.h has its steps. */
#ifndef PL_PLAN_MAKE_H
#define PL_PLAN_MAKE_H

#include "plan/plan.h"

/** Make a plan in context, which the caller has entered. options are checked. NULL: *status and
 * error say why. The caller destroys the plan. */
planish_plan *pl_plan_make(const planish_mesh *mesh, const planish_options *options,
                           pl_context *context, int *status, planish_error *error);

#endif
