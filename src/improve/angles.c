/* angles: no angle smaller than the smallest one the mesh had, and no element of order 2 that was
 * valid and is not.
 *
 * Sweeps look at radius ratios, which seldom leaves a smaller angle than there was. Where it did,
 * the nodes around go back, and are swept again with the angle as a limit. In all sweeps that limit
 * would be in the way: an element that is both flat and sharp could not become better in one
 * respect first.
 */
#include "improve/improve.h"

#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"
#include "plan/ghosts.h"

#include <math.h>
#include <string.h>

/* Rounds in which nodes go back; then all of them do. */
enum { ROUNDS = 50 };

/** Put the nodes of element, which is worse than it may be, to where they were; how many had moved.
 */
static int64_t put_back_nodes(const pl_run *r, int64_t element) {
    const planish_plan *plan = r->plan;
    const int is_broken =
        r->watch.mids.own && pl_watch_decide(&r->watch, pl_cell_with(plan, element)) != PL_VALID;
    const size_t size = (size_t)plan->dim * sizeof *plan->scratch.coordinates;
    int64_t n = 0;
    for (int j = 0; j <= plan->dim; j++) {
        const int64_t node = plan->work.elements[element * (plan->dim + 1) + j];
        double *now = plan->scratch.coordinates + (int64_t)plan->inner[node] * plan->dim;
        const double *start = r->given + node * plan->dim;
        n += pl_is_own(pl_part_here(), node) && memcmp(now, start, size) != 0;
        memcpy(now, start, size);
    }
    if (is_broken)
        n += pl_mids_put_back(&r->watch.mids, element);
    return n;
}

/** By how many more elements are invalid than at the start. Curved ones may be valid though corners are not
 *  positive, which sums count as inverted. */
static double invalid_more(const pl_run *r) {
    return r->sums.inverted - (double)r->watch.n_turned -
           (r->sums_at_start.inverted - (double)r->n_turned_at_start);
}

/** Whether every element that was valid must be: but where untangling may have invalidated some to
 *  repair more. */
static int keeps_valid(const pl_run *r) {
    const int is_untangled =
        r->plan->work.corner && r->result->untangling_sweeps > 0 && invalid_more(r) < 0;
    return pl_watch_is_on(&r->watch) && !is_untangled;
}

/** Mark in state the elements that are worse than the worst at the start, or of order 2 and not valid
 *  any more. */
static void find_bad(const pl_run *r, uint8_t *state) {
    const planish_plan *plan = r->plan;
    const pl_view all = pl_view_of_all_elements(&plan->work);
    memset(state, PL_FINE, (size_t)plan->work.n_elements);
    if (plan->work.corner && r->limits_at_start.rr2 < INFINITY)
        pl_find_worse_corners(&all, plan->scratch.to_measure, sqrt(r->limits_at_start.rr2),
                              r->limits_at_start.acuteness, sqrt(r->worst_at_start), plan->threads,
                              state);
    else if (r->limits_at_start.rr2 < INFINITY || pl_run_has_followers(r))
        pl_find_worse(&all, plan->scratch.to_measure, sqrt(r->limits_at_start.rr2),
                      r->limits_at_start.acuteness, plan->threads, state);
    if (keeps_valid(r))
        pl_watch_find_broken(&r->watch, 1, state);
}

/** Put back the nodes of elements that are worse than they may be; how many had moved. */
static int64_t put_back_bad(pl_run *r, uint8_t *state) {
    const planish_plan *plan = r->plan;
    const size_t size = (size_t)plan->dim * sizeof *plan->scratch.coordinates;
    int64_t n = 0;
    find_bad(r, state);
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        if (state[i] != PL_FINE)
            n += put_back_nodes(r, i);
    /* Nodes that move together go back together. */
    for (int64_t k = 0; k < plan->sliding.n_followers; k++) {
        const pl_follower *f = &plan->sliding.follower[k];
        const pl_follower_places *places = &plan->scratch.places[k];
        if (f->node < plan->work.n_nodes &&
            memcmp(plan->scratch.coordinates + (int64_t)f->node * plan->dim, places->start, size) ==
                0)
            memcpy(plan->scratch.coordinates + (int64_t)f->of * plan->dim, places->origin, size);
    }
    n += pl_skin_put_back(&r->skin, r->given);
    pl_follow(plan, &r->problem);
    pl_ghosts_update(plan, plan->scratch.coordinates, (int64_t)size);
    pl_run_measure(r);
    pl_parts_add(&n, 1);
    return n;
}

/** Whether F has risen, where it must not. */
static int has_risen(const pl_run *r) {
    return pl_tangled(&r->sums_at_start) == 0 && r->sums_at_start.below == 0 &&
           r->result->worst_sweeps == 0 && pl_run_objective(r) > r->result->objective_before;
}

/** Whether the mesh is worse than at the start. Sweeps see to it that only angles are, and to
 *  rounding others: nodes that move together have one star for all, next to one of them. */
static int is_worse(const pl_run *r) {
    const pl_star_limits now = pl_run_worst_limits(r, 1);
    return now.acuteness > r->limits_at_start.acuteness || now.rr2 > r->limits_at_start.rr2 ||
           (r->plan->work.corner && r->sums.radius_max > r->worst_at_start) ||
           invalid_more(r) > 0 ||
           (pl_run_has_followers(r) && (r->sums.below > r->sums_at_start.below || has_risen(r)));
}

/** Whether elements of order 2 were valid and are not, or of_all whether corners have turned; state is
 *  room. */
static int is_broken(const pl_run *r, int of_all, uint8_t *state) {
    return keeps_valid(r) && pl_watch_find_broken(&r->watch, of_all, state) > 0;
}

int pl_run_put_back_angles(pl_run *r, planish_error *error) {
    const int is_off = pl_skin_check(&r->skin) > 0;
    if (!is_worse(r) && !keeps_valid(r) && !is_off)
        return PLANISH_OK;
    uint8_t *state = pl_alloc(r->plan->work.n_elements, sizeof *state);
    if (!state)
        return pl_fail_memory(error, "the states of the elements");
    int64_t n = is_worse(r) || is_off || is_broken(r, 0, state);
    const int goes_back = n > 0;
    for (int64_t i = 0; i < ROUNDS && n > 0; i++) {
        n = put_back_bad(r, state);
        r->result->n_put_back += n;
    }
    const int is_left =
        goes_back && (is_worse(r) || is_broken(r, 1, state) || pl_skin_check(&r->skin) > 0 ||
                      pl_skin_check_bends(&r->skin, r->given) > 0 ||
                      r->sums.below > r->sums_at_start.below || has_risen(r));
    pl_free(state);
    if (is_left) {
        for (int64_t i = 0; i < r->plan->work.n_elements; i++) {
            n += put_back_nodes(r, i);
            if (r->watch.mids.own)
                n += pl_mids_put_back(&r->watch.mids, i);
        }
        pl_parts_add(&n, 1);
        r->result->n_put_back += n;
        pl_run_measure(r);
    }
    return PLANISH_OK;
}
