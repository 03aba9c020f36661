/* planish_find_held: the movable nodes that one call of planish_smooth holds. */
#include "sweep/begin_end.h"

#include "base/context.h"
#include "base/parts.h"
#include "base/status.h"

#include <string.h>

/** Return why a run holds node i of the plan's mesh. */
static planish_held_by held_by(const pl_run *r, int64_t i) {
    const planish_plan *plan = r->plan;
    if (!plan->work.mobility[i])
        return PLANISH_HELD_BY_NONE;
    if (r->guard.mobility && !r->guard.mobility[i])
        return PLANISH_HELD_BY_BOUNDS;
    const int32_t node = r->skin.shape ? r->skin.shape->number[pl_plan_node(plan, i)] : -1;
    return node >= 0 ? pl_skin_held_by(&r->skin, node) : PLANISH_HELD_BY_NONE;
}

/** Return whether nobody says where the node of a sliding star may go. */
static int lacks_surface(const pl_run *r, int64_t star) {
    const planish_plan *plan = r->plan;
    const planish_shape *shape = r->skin.shape;
    const uint8_t by = plan->slides_by[star];
    if (by == PLANISH_CONSTRAINT_ON_SURFACE)
        return r->options->project == NULL;
    return by > PLANISH_CONSTRAINT_ON_SURFACE &&
           !(shape && shape->number[plan->slide[star].node] >= 0);
}

/** Fill held [n_nodes of the mesh]. */
static void fill(const pl_run *r, uint8_t *held) {
    const planish_plan *plan = r->plan;
    memset(held, PLANISH_HELD_BY_NONE, (size_t)plan->whole.n_nodes);
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        held[pl_plan_node(plan, i)] = (uint8_t)held_by(r, i);
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++) {
        uint8_t *of = &held[plan->slide[s].node];
        if (*of == PLANISH_HELD_BY_NONE && lacks_surface(r, s))
            *of = PLANISH_HELD_BY_SURFACE;
    }
}

int planish_find_held(planish_plan *plan, const double *coordinates, const planish_options *options,
                      uint8_t *held, planish_error *error) {
    planish_options defaults;
    planish_result unused = {0};
    if (!plan || !coordinates || !held)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "plan, coordinates and held must not be NULL");
    planish_options_init(&defaults);
    defaults.rounding = plan->rounding;
    const pl_outside outside = pl_call_enter(plan->context);
    pl_context_begin(plan->context);
    pl_run r = {.plan = plan,
                .coordinates = (double *)coordinates, /* a run writes them at its end */
                .options = options ? options : &defaults,
                .result = &unused};
    int status = pl_plan_check_call(plan, coordinates, r.options, error);
    if (!status) {
        pl_placement_enter(plan->placement);
        status = pl_run_begin_limits(&r, error);
        pl_placement_leave(plan->placement);
    }
    if (!status)
        status = pl_parts_check(error);
    if (!status)
        fill(&r, held);
    pl_run_destroy(&r);
    pl_context_end(plan->context);
    pl_call_leave(&outside);
    return status;
}
