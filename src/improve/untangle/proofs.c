/* proofs: which elements below their minimum volumes stay so for ever. */
#include "improve/untangle/proofs.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"

/** The search for proofs. */
typedef struct proof_search {
    const planish_plan *plan;
    const pl_star_problem *problem;
    uint8_t *state;
    double *scratch;     /* of the kernels */
    int32_t *star_of;    /* [n] by inner numbers: the star of a free node; -1: of a ghost */
    int32_t *next_facet; /* [n_stars] link facets of the star seen so far */
    uint8_t *is_fixed;   /* [n] by inner numbers */
    uint8_t *is_wanted;  /* [n_stars] a proof at the star would decide about an element */
    uint8_t *part;       /* [link facets of all stars] pl_star_part */
} proof_search;

/** Return the only star that can prove something of an element; -1: it has no free node, -2: it has
 * several, or one that slides or is a ghost: of that nothing is proved. */
static int32_t only_star(const proof_search *s, int64_t element) {
    const planish_plan *plan = s->plan;
    int32_t node = -1;
    for (int j = 0; j <= plan->dim; j++) {
        const int32_t other = plan->work.elements[element * (plan->dim + 1) + j];
        if (plan->work.mobility[other])
            node = node == -1 && plan->work.mobility[other] == PL_INTERIOR ? other : -2;
    }
    if (node < 0)
        return node;
    return s->star_of[plan->inner[node]] < 0 ? -2 : s->star_of[plan->inner[node]];
}

/** Whether two fixed nodes of an element are at the same place: it has no volume then. */
static int has_coincident_nodes(const proof_search *s, int64_t element) {
    const planish_plan *plan = s->plan;
    const int dim = plan->dim;
    const int32_t *node = plan->work.elements + element * (dim + 1);
    for (int j = 0; j <= dim; j++)
        for (int k = 0; k < j; k++) {
            const double *x = s->problem->coordinates + (int64_t)plan->inner[node[j]] * dim;
            const double *y = s->problem->coordinates + (int64_t)plan->inner[node[k]] * dim;
            int same = !plan->work.mobility[node[j]] && !plan->work.mobility[node[k]];
            for (int d = 0; d < dim; d++)
                same &= x[d] == y[d];
            if (same)
                return 1;
        }
    return 0;
}

/** Look for proofs at the stars that could decide about elements, one after another. A limit that
 *  one process has reached is reached in all. */
static void look_for_proofs(proof_search *s, pl_limit *limit) {
    const planish_plan *plan = s->plan;
    const pl_stars *stars = &plan->interior.stars;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        if (s->state[i] != PLANISH_VOLUME_BELOW)
            continue;
        const int32_t star = only_star(s, i);
        if (star == -1 || has_coincident_nodes(s, i))
            s->state[i] = PLANISH_VOLUME_INFEASIBLE;
        else if (star >= 0)
            s->is_wanted[star] = 1;
    }
    for (int64_t i = 0; i < stars->n_stars && !pl_limit_is_reached(limit); i++)
        if (s->is_wanted[i]) {
            pl_star_infeasible(s->problem, i, plan->dim, s->is_fixed, s->scratch,
                               s->part + stars->link_offset[i], limit);
            s->is_wanted[i] = pl_limit_is_reached(limit) != 0; /* and else it is decided */
        }
    if (!limit)
        return;
    double answer = limit->answer;
    pl_parts_largest(&answer, 1);
    limit->answer = (int)answer;
}

/** Mark elements by the proofs of their stars, whose facets are in the order of their elements. If
 *  given_up only those that are, else all that are below and part of a proof. */
static int64_t mark_elements(proof_search *s, int given_up) {
    const planish_plan *plan = s->plan;
    int64_t n_infeasible = 0;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        for (int j = 0; j <= plan->dim; j++) {
            const int32_t node = plan->work.elements[i * (plan->dim + 1) + j];
            const int32_t star = s->star_of[plan->inner[node]];
            if (star < 0)
                continue;
            const uint8_t part =
                s->part[plan->interior.stars.link_offset[star] + s->next_facet[star]++];
            if (given_up ? part == PL_PROOF_GIVEN_UP
                         : part != PL_PROOF_NONE && s->state[i] == PLANISH_VOLUME_BELOW)
                s->state[i] = PLANISH_VOLUME_INFEASIBLE;
        }
        n_infeasible += s->state[i] == PLANISH_VOLUME_INFEASIBLE;
    }
    return n_infeasible;
}

int pl_mark_infeasible(const planish_plan *plan, const pl_star_problem *problem, uint8_t *state,
                       pl_limit *limit, pl_infeasible *found, uint8_t **part,
                       planish_error *error) {
    const int64_t n = plan->work.n_nodes, n_stars = plan->interior.stars.n_stars;
    proof_search s = {.plan = plan,
                      .problem = problem,
                      .state = state,
                      .scratch = pl_alloc(plan->scratch_stride, sizeof *s.scratch),
                      .star_of = pl_alloc(n, sizeof *s.star_of),
                      .next_facet = pl_alloc_zero(n_stars, sizeof *s.next_facet),
                      .is_fixed = pl_alloc(n, sizeof *s.is_fixed),
                      .is_wanted = pl_alloc_zero(n_stars, sizeof *s.is_wanted),
                      .part =
                          pl_alloc_zero(plan->interior.stars.link_offset[n_stars], sizeof *s.part)};
    const int done = s.scratch && s.star_of && s.next_facet && s.is_fixed && s.is_wanted && s.part;
    if (done) {
        for (int64_t i = 0; i < n; i++)
            s.is_fixed[plan->inner[i]] = !plan->work.mobility[i];
        pl_plan_number_stars(plan, s.star_of);
        look_for_proofs(&s, limit);
        found->n = mark_elements(&s, part != NULL);
        found->n_undecided = 0;
        /* Stars that were not searched to the end could tell more of their elements. */
        for (int64_t i = 0; limit && limit->answer && i < plan->work.n_elements; i++) {
            const int32_t star = state[i] == PLANISH_VOLUME_BELOW ? only_star(&s, i) : -1;
            found->n_undecided += star >= 0 && s.is_wanted[star];
        }
        if (part) {
            *part = s.part;
            s.part = NULL;
        }
    }
    pl_free(s.scratch);
    pl_free(s.star_of);
    pl_free(s.next_facet);
    pl_free(s.is_fixed);
    pl_free(s.is_wanted);
    pl_free(s.part);
    return done ? PLANISH_OK : pl_fail_memory(error, "the search for infeasible elements");
}
