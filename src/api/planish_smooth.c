/* planish_smooth: begin a run, its phases, end it, and tell the log. */
#include "sweep/begin_end.h"
#include "improve/improve.h"

#include "base/clock.h"
#include "base/context.h"
#include "base/status.h"

#include <inttypes.h>

/** Tell the result to the caller's log. */
static void say_result(const planish_result *r) {
    static const char *const stops[] = {"converged", "reached max_sweeps", "reached time_limit",
                                        "was interrupted",
                                        "converged, with minimum volumes that cannot be met"};
    pl_log(PLANISH_LOG_DETAIL,
           "%s after %d sweeps, %d of them untangling: F %.6g -> %.6g, %" PRId64
           " nodes moved, %.3g s",
           stops[r->stop], r->sweeps, r->untangling_sweeps, r->objective_before, r->objective,
           r->n_moved_nodes, r->seconds);
    if (r->n_inverted > 0)
        pl_log(PLANISH_LOG_NOTE, "%" PRId64 " elements are not positive", r->n_inverted);
    if (r->n_inverted_inside > 0)
        pl_log(PLANISH_LOG_NOTE,
               "%" PRId64 " of these are inverted inside, with positive corners, and were not "
               "repaired",
               r->n_inverted_inside);
    if (r->n_below_min_volume > 0)
        pl_log(PLANISH_LOG_NOTE, "%" PRId64 " elements are below their minimum volume",
               r->n_below_min_volume);
    if (r->n_held_outside > 0)
        pl_log(PLANISH_LOG_NOTE, "%" PRId64 " nodes started outside of their bounds and stay",
               r->n_held_outside);
    if (r->n_put_back > 0)
        pl_log(PLANISH_LOG_NOTE,
               "nodes were put back %" PRId64 " times, where angles had become too small",
               r->n_put_back);
}

int planish_smooth(planish_plan *plan, double *coordinates, const planish_options *options,
                   planish_result *result, planish_error *error) {
    planish_options defaults;
    planish_result found = {0};
    if (!plan || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "plan and coordinates must not be NULL");
    planish_options_init(&defaults);
    defaults.rounding = plan->rounding;
    const pl_outside outside = pl_call_enter(plan->context);
    pl_context_begin(plan->context);
    pl_run r = {.plan = plan,
                .coordinates = coordinates,
                .options = options ? options : &defaults,
                .accelerate = pl_run_accelerate,
                .start_seconds = pl_seconds(),
                .result = &found};
    int status = pl_plan_check_call(plan, coordinates, r.options, error);
    if (!status) {
        pl_placement_enter(plan->placement);
        status = pl_run_begin(&r, error);
        if (!status)
            status = pl_run_phases(&r, error);
        if (!status)
            status = pl_run_end(&r, error);
        pl_placement_leave(plan->placement);
    }
    if (!status)
        say_result(&found);
    pl_run_destroy(&r);
    pl_context_end(plan->context);
    pl_call_leave(&outside);
    if (!status && result)
        *result = found;
    return status;
}
