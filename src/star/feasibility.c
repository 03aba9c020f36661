/* feasibility: a proof that elements of a star cannot all have their least volume.
 *
 * By Farkas' lemma the elements of link facets whose nodes are fixed cannot have it, wherever their
 * free node x is, if there are weights lambda_j >= 0 with sum lambda_j n_j = 0 and
 * sum lambda_j (D_j - floor_j) < 0. The projection that looks for a feasible displacement finds
 * them (docs/algorithm.md). With free nodes in the link there is no such proof: they could move.
 */
#define PL_PACK 1
#include "star/feasible.h"

/* The proof must hold within this many sizes of the star, whatever rounding did to it. */
#define PROOF_REACH 1e6

/** Rows of the facets whose nodes are fixed; these get a 1 in of_fixed, the others a 0. */
static active fixed_rows(const local *here, const pl_star_problem *problem, int64_t star_index,
                         const uint8_t *is_fixed, const double *x, uint8_t *of_fixed, int dim) {
    const star *s = &here->s;
    const uint16_t *link = problem->link + problem->link_offset[star_index] * dim;
    active all = homogeneous(here, x, -VIOLATED_ABOVE, 0, dim); /* to be met, as it is counted */
    active kept = {all.rows, 0};
    for (int64_t i = 0, row = 0; i < s->n_facets; i++) {
        int exists =
            s->column[INVERSE_FLOOR * s->padded + i] > 0 && s->column[LENGTH * s->padded + i] > 0;
        int fixed = 1;
        for (int j = 0; j < dim; j++)
            fixed &= is_fixed[s->ring[link[i * dim + j]]];
        of_fixed[i] = exists && fixed;
        if (of_fixed[i])
            memmove(kept.rows[kept.m++], all.rows[row], sizeof all.rows[row]);
        row += exists;
    }
    return kept;
}

/** Whether the weights are a proof: their sum of the gradients must be as good as 0. */
static int proves(const active *a, const cone_point *point, int dim) {
    double sum[4] = {0, 0, 0, 0}, residual = 0;
    for (int i = 0; i < point->n_active; i++)
        for (int d = 0; d <= dim; d++)
            sum[d] += point->multiplier[i] * a->rows[point->active[i]][d];
    for (int d = 0; d < dim; d++)
        residual += fabs(sum[d]);
    return point->n_active > 0 && sum[dim] > PROOF_REACH * residual;
}

static int infeasible(const pl_star_problem *problem, int64_t star_index, const uint8_t *is_fixed,
                      double *scratch, uint8_t *taking_part, const int dim) {
    const double *place = problem->coordinates + (int64_t)problem->node[star_index] * dim;
    int64_t evaluations = 0;
    double x[3], displacement[3];
    derivatives derivative;
    cone_point point;
    local here = local_of(problem, star_index, place, scratch, &evaluations, 1, dim);
    for (int d = 0; d < dim; d++)
        x[d] = place[d] * here.s.scale;
    guarded_at(&here.s, &here.q, x, &derivative, 1, dim);
    here.b.any = 0; /* bounds are no part of the proof */
    active a = fixed_rows(&here, problem, star_index, is_fixed, x, taking_part, dim);
    int proof =
        a.m > 0 && !shortest_displacement(&a, displacement, &point, dim) && proves(&a, &point, dim);
    for (int64_t i = 0, row = 0; i < here.s.n_facets; i++) {
        int has_row = taking_part[i], weighs = 0;
        for (int j = 0; proof && has_row && j < point.n_active; j++)
            weighs |= point.active[j] == row;
        taking_part[i] = (uint8_t)weighs;
        row += has_row;
    }
    return proof;
}

int pl_star_infeasible(const pl_star_problem *problem, int64_t star_index, int dim,
                       const uint8_t *is_fixed, double *scratch, uint8_t *taking_part) {
    return dim == 3 ? infeasible(problem, star_index, is_fixed, scratch, taking_part, 3)
                    : infeasible(problem, star_index, is_fixed, scratch, taking_part, 2);
}
