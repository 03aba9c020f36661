/* feasibility: a proof that elements of a star cannot all have their minimum volume, or be
 * positive.
 *
 * By Farkas' lemma the elements of link facets whose nodes are fixed cannot have it, wherever their
 * free node x is, if there are weights lambda_j >= 0 with sum lambda_j n_j = 0 and
 * sum lambda_j (D_j - floor_j) < 0. The projection that looks for a feasible displacement finds
 * them (docs/algorithm.md). With free nodes in the link there is no such proof: they could move.
 * Of the elements of a proof one is given up, and the search goes on without it until the others
 * have a common place.
 *
 * A look at all elements for each one that is given up would take long around a node of thousands.
 * Such a star is searched in shares of few elements first, then in shares of twice as many, and so
 * on: what contradicts itself in a share does so in the star, and most is found in small ones.
 */
#define PL_PACK 1
#include "star/kernel_feasible.h"

/* The proof must hold within this many sizes of the star, whatever rounding did to it. */
#define PROOF_REACH 1e6
/* What an element without a minimum volume needs, by the mean measure of the star's elements; or,
 * with a small link facet or if all are flat, by that times the star's size. */
#define PART_LEAST 1e-9

/* Stars of more link facets are searched in shares of at most so many at first. */
enum { MANY_FACETS = 1024, FACETS_OF_SHARE = 128 };

/** State of a link facet during the search. */
enum { NOT_FIXED, CANDIDATE, MEMBER, GIVEN_UP };

/** Set the floors of elements without a minimum volume, with the node at x. */
static void set_floors(const star *s, const double *x, const int dim) {
    const double place[3] = {x[0], x[1], dim == 3 ? x[2] : 0};
    double mean = 0, size2 = 0;
    for (int64_t i = 0; i < s->n_facets; i++) {
        aspect a;
        measure_at(s, i, place, &a, dim);
        mean += fabs(a.D) / (double)s->n_facets;
        size2 += a.aa / (double)s->n_facets;
    }
    for (int64_t i = 0; i < s->n_facets; i++) {
        const double own = *entry(s, LENGTH, i) * sqrt(size2);
        if (*entry(s, FLOOR, i) > 0 || !(own > FLOOR_LEAST))
            continue;
        *entry(s, FLOOR, i) = PART_LEAST * (own < mean || !(mean > FLOOR_LEAST) ? own : mean);
        *entry(s, INVERSE_FLOOR, i) = 1 / *entry(s, FLOOR, i);
    }
}

/** Find the candidates: facets that have a row, and whose nodes are fixed; and with the node at x
 * the heights of all elements over their facets, in the column RATE. */
static void find_candidates(const local *here, const double *x, const uint8_t *is_fixed,
                            uint8_t *state, const int dim) {
    const star *s = &here->s;
    const lanes place[3] = {x[0], x[1], dim == 3 ? x[2] : 0};
    for (int64_t i = 0; i < s->n_facets; i++) {
        aspect a;
        int fixed = *entry(s, INVERSE_FLOOR, i) > 0 && *entry(s, LENGTH, i) > 0;
        for (int j = 0; j < dim; j++)
            fixed &= is_fixed[node_of_facet(s, i, j, dim)];
        state[i] = fixed ? CANDIDATE : NOT_FIXED;
        measure_at(s, i, place, &a, dim);
        *entry(s, RATE, i) = a.D / *entry(s, LENGTH, i);
    }
}

/** Whether an element of that state is still in question. */
static int is_wanted(uint8_t state) {
    return state == CANDIDATE || state == MEMBER;
}

/** Share of the link facets: first, first + step, first + 2 step, ... */
typedef struct share {
    int64_t first, step;
} share;

/** Mark the members of the proof, and give up the one that is lowest at its place. */
static void mark_members(const cone_point *point, const star *s, share part, uint8_t *state) {
    int64_t lowest = -1;
    for (int64_t i = part.first, row = 0; i < s->n_facets; i += part.step) {
        if (!is_wanted(state[i]))
            continue;
        for (int j = 0; j < point->n_active; j++)
            if (point->active[j] == row) {
                state[i] = MEMBER;
                lowest = lowest < 0 || *entry(s, RATE, i) < *entry(s, RATE, lowest) ? i : lowest;
            }
        row++;
    }
    state[lowest] = GIVEN_UP;
}

/** Give up elements of a share until the others have a common place; returns how many. */
static int64_t search_share(const local *here, share of, uint8_t *state, pl_stop_check *limit,
                            const int dim) {
    double displacement[3];
    cone_point point;
    int64_t n_given_up = 0;
    for (; !pl_limit_is_reached(limit); n_given_up++) {
        active a = active_none(here);
        for (int64_t i = of.first; i < here->s.n_facets; i += of.step)
            if (is_wanted(state[i])) /* its minimum volume is to be met, as it is counted */
                add_homogeneous_row(here, i, -VIOLATED_ABOVE, 0, &a, dim);
        if (a.m == 0 || shortest_displacement(&a, displacement, &point, dim))
            break;
        /* the weights are a proof if their sum of the gradients is as good as 0 */
        double sum[4] = {0, 0, 0, 0}, residual = 0;
        for (int i = 0; i < point.n_active; i++)
            for (int d = 0; d <= dim; d++)
                sum[d] += point.multiplier[i] * a.rows[point.active[i]][d];
        for (int d = 0; d < dim; d++)
            residual += fabs(sum[d]);
        if (!(point.n_active > 0 && sum[dim] > PROOF_REACH * residual))
            break;
        mark_members(&point, &here->s, of, state);
    }
    return n_given_up;
}

static int64_t infeasible(const pl_star_problem *problem, int64_t star_index,
                          const uint8_t *is_fixed, double *scratch, uint8_t *part,
                          pl_stop_check *limit, const int dim) {
    const double *place = problem->coordinates + (int64_t)problem->node[star_index] * dim;
    pl_star_problem of_facets = *problem; /* further rows are no part of a proof */
    of_facets.more = NULL;
    int64_t evaluations = 0, n_given_up = 0, step = 1;
    double at[3], x[3];
    derivatives derivative;
    local here;
    local_init(&here, &of_facets, star_index, place, NULL, scratch, &evaluations, 1, dim);
    const star *s = &here.s;
    to_star(&here, place, at, dim);
    /* the middle of the ring: a proof holds wherever the node is, and is clearest from there */
    for (int d = 0; d < dim; d++) {
        x[d] = 0;
        for (int64_t i = 0; i < s->n_ring; i++)
            x[d] +=
                problem->coordinates[(int64_t)s->ring[i] * dim + d] * s->scale / (double)s->n_ring;
    }
    set_floors(s, x, dim);
    here.b.any = 0; /* bounds are no part of the proof */
    guarded_at(s, &here.q, x, &derivative, 1, dim);
    find_candidates(&here, at, is_fixed, part, dim);
    /* all facets at once, or from small shares to large ones */
    while (s->n_facets > MANY_FACETS && s->n_facets > step * FACETS_OF_SHARE)
        step *= 2;
    for (; step > 0; step /= 2)
        for (int64_t first = 0; first < step; first++)
            n_given_up += search_share(&here, (share){first, step}, part, limit, dim);
    for (int64_t i = 0; i < s->n_facets; i++)
        part[i] = part[i] == MEMBER     ? PL_PROOF_MEMBER
                  : part[i] == GIVEN_UP ? PL_PROOF_GIVEN_UP
                                        : PL_PROOF_NONE;
    return n_given_up;
}

int64_t pl_star_infeasible(const pl_star_problem *problem, int64_t star_index, int dim,
                           const uint8_t *is_fixed, double *scratch, uint8_t *part,
                           pl_stop_check *limit) {
    return dim == 3 ? infeasible(problem, star_index, is_fixed, scratch, part, limit, 3)
                    : infeasible(problem, star_index, is_fixed, scratch, part, limit, 2);
}
