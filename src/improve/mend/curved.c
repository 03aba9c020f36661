/* curved: mids of curved elements move by themselves.
 *
 * Sweeps move corners, and mids follow. Where a curved element is invalid, or its least Bezier
 * coefficient of det J is below options.curve_quality of their mean, the mids of its inner edges get
 * places of their own; where it is invalid its free corners move, too.
 *
 *   1. Elements that are invalid wherever their free nodes go are proved (proofs.c), and count no more.
 *   2. Other invalid elements are gathered in clusters that share free nodes (cluster.c). Each is
 *      untangled by the regularised energy of the rows of its stars (star.c): by mids alone, then with
 *      corners, then with the nodes around (stages.c).
 *   3. The sum of mean ratios over the rows is minimised, coefficients positive.
 *
 * A cluster's new places are taken if no element is invalid that was valid, and not more are. All of
 * it is serial, in the order of nodes: the same bits on any number of threads.
 */
#include "improve/mend/stages.h"
#include "improve/mend/proofs.h"
#include "improve/improve.h"

#include "base/memory.h"
#include "base/status.h"

#include <inttypes.h>

/** Watch all elements of mids that have moved by themselves, those of an earlier call are watched; the result
 *  counts the mids of both. */
static int watch_more(const pl_mend *c, planish_error *error) {
    int64_t n = 0, room = 0, n_mids = 0;
    int32_t *element = NULL;
    int has_memory = 1;
    for (int64_t node = 0; node < c->plan->whole.n_nodes; node++) {
        const int has_moved = pl_mid_has_moved(&c->watch->mids, (int32_t)node);
        n_mids += has_moved;
        for (int64_t k = c->begin[node];
             has_moved && c->kind[node] == PL_MEND_MID && k < c->begin[node + 1]; k++)
            has_memory &= pl_append(&element, &n, &room, &c->at[k], sizeof *element) != NULL;
    }
    c->run->result->n_released_mids = n_mids;
    const int status = has_memory ? pl_watch_add(c->watch, n, element, error)
                                  : pl_fail_memory(error, "curved elements");
    pl_free(element);
    return status;
}

/** Prove what is hopeless, mend invalid elements, and (improves: by mids alone) improve poor ones. */
static int prove_and_mend(pl_mend *c, int improves, planish_error *error) {
    pl_run *run = c->run;
    int64_t first = -1;
    int status = pl_mids_release(&c->watch->mids, error);
    if (!status)
        status = pl_mend_prove(c, &run->result->n_infeasible_curved, &first, error);
    if (!status && run->result->n_infeasible_curved > 0)
        pl_log(PLANISH_LOG_NOTE,
               "%" PRId64 " curved elements are invalid wherever their free nodes go, the first "
               "is element %" PRId64,
               run->result->n_infeasible_curved, pl_plan_element(run->plan, first));
    if (!status && run->options->untangle)
        status = pl_mend_invalid(c, !improves, error);
    if (!status && improves)
        status = pl_mend_poor(c, error);
    return status ? status : watch_more(c, error);
}

/** Repair the curved elements of a run, which is measured again. */
static int repair_curved(pl_run *run, int improves, planish_error *error) {
    pl_stop_check limit = pl_run_stop_check(run);
    pl_mend c = {.run = run,
                 .plan = run->plan,
                 .options = run->options,
                 .watch = &run->watch,
                 .mobility = run->guard.mobility ? run->guard.mobility : run->plan->work.mobility,
                 .limit = &limit};
    int status = pl_mend_create(&c, error);
    if (!status)
        status = prove_and_mend(&c, improves, error);
    if (!status) {
        pl_run_measure(run);
        if (limit.answer)
            run->stop = (planish_stop)limit.answer;
    }
    pl_mend_destroy(&c);
    return status;
}

int pl_run_mend_curved(pl_run *r, planish_error *error) {
    const pl_star_guard *guard = &r->guard.star;
    if (guard->lower || guard->upper || guard->radius) /* sweeps would take mids beyond */
        return PLANISH_OK;
    const int status = repair_curved(r, 0, error);
    if (!status)
        pl_run_prepare(r);
    return status;
}

int pl_run_improve_curved(pl_run *r, planish_error *error) {
    /* Where elements are to be what they are elsewhere, their edges are curved as they are. */
    if (r->plan->work.target || !pl_watch_has_poor(&r->watch, r->options->curve_quality))
        return PLANISH_OK;
    return repair_curved(r, 1, error);
}

/** Mark in state the invalid elements of coordinates that the watch has measured and that are proved. */
static int mark_proved(pl_mend *c, uint8_t *state, planish_error *error) {
    int64_t n, first = -1;
    int status = pl_mend_create(c, error);
    if (!status)
        status = pl_mend_prove(c, &n, &first, error);
    for (int64_t e = 0; !status && e < c->plan->work.n_elements; e++)
        if (c->is_given_up[e])
            state[e] = PLANISH_VOLUME_INFEASIBLE;
    pl_mend_destroy(c);
    return status;
}

int pl_mark_hopeless(const planish_plan *plan, const planish_options *options, const double *given,
                     const double *coordinates, pl_stop_check *limit, uint8_t *state,
                     planish_error *error) {
    pl_watch watch;
    pl_mend c = {.plan = plan,
                 .options = options,
                 .watch = &watch,
                 .mobility = plan->work.mobility,
                 .limit = limit};
    pl_plan_order(plan, given, plan->scratch.coordinates);
    int status = pl_watch_create(plan, options, given, coordinates, 0, &watch, error);
    if (!status && watch.n_curved > 0 && pl_watch_measure(&watch) > 0)
        status = mark_proved(&c, state, error);
    pl_watch_destroy(&watch);
    return status;
}
