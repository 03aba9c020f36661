/* volumes: which elements are below their minimum volume, and which of these for ever. */
#include "improve/untangle/proofs.h"

#include "sweep/guard.h"

#include "base/clock.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"

#include <string.h>

/** The search for proofs. */
typedef struct search {
    const planish_plan *plan;
    pl_star_problem problem;
    uint8_t *state;
    double *scratch;     /* of the kernels */
    int32_t *star_of;    /* [n] by inner numbers: the star of a free node; -1: of a ghost */
    int32_t *next_facet; /* [n_stars] link facets of the star seen so far */
    uint8_t *is_fixed;   /* [n] by inner numbers */
    uint8_t *is_wanted;  /* [n_stars] a proof at the star would decide about an element */
    uint8_t *part;       /* [link facets of all stars] pl_star_part */
} search;

static int search_create(const planish_plan *plan, const pl_star_problem *problem, uint8_t *state,
                         search *s) {
    const int64_t n = plan->work.n_nodes, n_stars = plan->interior.stars.n_stars;
    *s = (search){.plan = plan, .problem = *problem, .state = state};
    s->scratch = pl_alloc(plan->scratch_stride, sizeof *s->scratch);
    s->star_of = pl_alloc(n, sizeof *s->star_of);
    s->next_facet = pl_alloc_zero(n_stars, sizeof *s->next_facet);
    s->is_fixed = pl_alloc(n, sizeof *s->is_fixed);
    s->is_wanted = pl_alloc_zero(n_stars, sizeof *s->is_wanted);
    s->part = pl_alloc_zero(plan->interior.stars.link_offset[n_stars], sizeof *s->part);
    return s->scratch && s->star_of && s->next_facet && s->is_fixed && s->is_wanted && s->part;
}

static void search_destroy(search *s) {
    pl_free(s->scratch);
    pl_free(s->star_of);
    pl_free(s->next_facet);
    pl_free(s->is_fixed);
    pl_free(s->is_wanted);
    pl_free(s->part);
}

static void note_fixed(search *s) {
    const planish_plan *plan = s->plan;
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        s->is_fixed[plan->inner[i]] = !plan->work.mobility[i];
}

/** The only free node of an element; -1: it has none, -2: it has several, or one that slides: of
 *  that nothing is proved. */
static int64_t only_free_node(const planish_plan *plan, int64_t element) {
    int64_t node = -1;
    for (int j = 0; j <= plan->dim; j++) {
        int32_t other = plan->work.elements[element * (plan->dim + 1) + j];
        if (plan->work.mobility[other])
            node = node == -1 && plan->work.mobility[other] == PL_INTERIOR ? other : -2;
    }
    return node;
}

static int32_t star_of_node(const search *s, int64_t node) {
    return s->star_of[s->plan->inner[node]];
}

/** Whether two fixed nodes of an element are at the same place: it has no volume then. */
static int has_coincident_nodes(const search *s, int64_t element) {
    const planish_plan *plan = s->plan;
    const int dim = plan->dim;
    const int32_t *node = plan->work.elements + element * (dim + 1);
    for (int j = 0; j <= dim; j++)
        for (int k = 0; k < j; k++) {
            const double *x = s->problem.coordinates + (int64_t)plan->inner[node[j]] * dim;
            const double *y = s->problem.coordinates + (int64_t)plan->inner[node[k]] * dim;
            int same = !plan->work.mobility[node[j]] && !plan->work.mobility[node[k]];
            for (int d = 0; d < dim; d++)
                same &= x[d] == y[d];
            if (same)
                return 1;
        }
    return 0;
}

/** Elements without a free node, or a volume, are infeasible; stars that could prove others so are
 * wanted. */
static void look_at_elements(search *s) {
    const planish_plan *plan = s->plan;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        if (s->state[i] != PLANISH_VOLUME_BELOW)
            continue;
        int64_t node = only_free_node(plan, i);
        if (node == -1 || has_coincident_nodes(s, i))
            s->state[i] = PLANISH_VOLUME_INFEASIBLE;
        else if (node >= 0 && star_of_node(s, node) >= 0)
            s->is_wanted[star_of_node(s, node)] = 1;
    }
}

/** The stars one after another; a limit that one process has reached is reached in all. */
static void look_for_proofs(search *s, pl_limit *limit) {
    const planish_plan *plan = s->plan;
    for (int64_t i = 0; i < plan->interior.stars.n_stars && !pl_limit_is_reached(limit); i++)
        if (s->is_wanted[i]) {
            pl_star_infeasible(&s->problem, i, plan->dim, s->is_fixed, s->scratch,
                               s->part + plan->interior.stars.link_offset[i], limit);
            s->is_wanted[i] = pl_limit_is_reached(limit) != 0; /* and else it is decided */
        }
    if (!limit)
        return;
    double answer = limit->answer;
    pl_parts_largest(&answer, 1);
    limit->answer = (int)answer;
}

/** Tell the elements: the facets of a star are in the order of its elements. If given_up only those
 * that are, else all that are below and part of a proof. */
static int64_t mark_elements(search *s, int given_up) {
    const planish_plan *plan = s->plan;
    int64_t n_infeasible = 0;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        for (int j = 0; j <= plan->dim; j++) {
            int32_t node = plan->work.elements[i * (plan->dim + 1) + j];
            if (plan->work.mobility[node] != PL_INTERIOR || star_of_node(s, node) < 0)
                continue;
            int32_t star = star_of_node(s, node);
            int64_t facet = plan->interior.stars.link_offset[star] + s->next_facet[star]++;
            int wanted =
                given_up ? s->part[facet] == PL_PROOF_GIVEN_UP
                         : s->part[facet] != PL_PROOF_NONE && s->state[i] == PLANISH_VOLUME_BELOW;
            if (wanted)
                s->state[i] = PLANISH_VOLUME_INFEASIBLE;
        }
        n_infeasible += s->state[i] == PLANISH_VOLUME_INFEASIBLE;
    }
    return n_infeasible;
}

/** The elements of which the stars that were not searched to the end could tell more. */
static int64_t count_undecided(const search *s) {
    const planish_plan *plan = s->plan;
    int64_t n = 0;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        const int64_t node = s->state[i] == PLANISH_VOLUME_BELOW ? only_free_node(plan, i) : -1;
        n += node >= 0 && star_of_node(s, node) >= 0 && s->is_wanted[star_of_node(s, node)];
    }
    return n;
}

int pl_mark_infeasible(const planish_plan *plan, const pl_star_problem *problem, uint8_t *state,
                       pl_limit *limit, pl_infeasible *found, uint8_t **part,
                       planish_error *error) {
    search s;
    int status = PLANISH_OK;
    if (search_create(plan, problem, state, &s)) {
        note_fixed(&s);
        pl_plan_number_stars(plan, s.star_of);
        look_at_elements(&s);
        look_for_proofs(&s, limit);
        found->n = mark_elements(&s, part != NULL);
        found->n_undecided = limit && limit->answer ? count_undecided(&s) : 0;
        if (part) {
            *part = s.part;
            s.part = NULL;
        }
    } else {
        status = pl_fail_memory(error, "the search for infeasible elements");
    }
    search_destroy(&s);
    return status;
}
