/* watch_cell: one cell of the watch: its places, its coefficients, and the room of its corners. */
#include "sweep/watch_cell.h"

#include "base/memory.h"
#include "geometry/simplex.h"
#include "quality/measure_block.h"

#include <float.h>
#include <math.h>

enum { LANES = PL_JACOBIAN_LANES, NODES = PL_CELL_NODES };

/* Cells whose size is in this range are decided as they are, others scaled by a power of two. */
static const double SMALL = 0x1p-40, LARGE = 0x1p40;

/* ---- places --------------------------------------------------------------------------------- */

double pl_watch_sign(const pl_watch *w, int64_t cell) {
    return w->plan->work.sign ? w->plan->work.sign[pl_first_of_cell(&w->plan->work, cell)] : 1;
}

int64_t pl_plan_given_cell(const planish_plan *plan, int64_t cell) {
    return pl_plan_element(plan, pl_first_of_cell(&plan->work, cell));
}

const pl_cell_type *pl_plan_cell_type(const planish_plan *plan, int64_t cell) {
    const int simplex = plan->dim == 3 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TRIANGLE;
    return pl_cell_type_of(plan->cells.n > 0 ? plan->cells.type[pl_plan_given_cell(plan, cell)]
                                             : simplex);
}

const pl_cell_type *pl_linear_type(const pl_cell_shape *shape) {
    static const int type[][2] = {{3, PLANISH_CELL_TRIANGLE}, {4, PLANISH_CELL_QUADRILATERAL}};
    static const int solid[] = {[4] = PLANISH_CELL_TETRAHEDRON,
                                [5] = PLANISH_CELL_PYRAMID,
                                [6] = PLANISH_CELL_WEDGE,
                                [8] = PLANISH_CELL_HEXAHEDRON};
    return pl_cell_type_of(shape->dim == 3 ? solid[shape->n_corners]
                                           : type[shape->n_corners == 4][1]);
}

void pl_watch_find_places(const pl_watch *w, const pl_jacobian_rule *rule, int64_t cell,
                          int at_start, double *x, int32_t *node) {
    const planish_plan *plan = w->plan;
    const int dim = plan->dim;
    int32_t corner[PL_CELL_CORNERS];
    double way[PL_CELL_CORNERS][3];
    const int corners = pl_plan_cell_corners(plan, cell, corner);
    for (int j = 0; j < corners; j++) {
        const double *from = w->mids.given + (int64_t)corner[j] * dim;
        const double *to =
            at_start ? from : plan->scratch.coordinates + (int64_t)plan->inner[corner[j]] * dim;
        node[j] = j;
        for (int d = 0; d < dim; d++) {
            x[j * dim + d] = to[d];
            way[j][d] = to[d] - from[d];
        }
    }
    if (rule->n_nodes == corners)
        return;
    const int32_t *given = plan->cells.node + plan->cells.offset[pl_plan_given_cell(plan, cell)];
    for (int i = corners; i < rule->n_nodes; i++) {
        const int p = rule->type->between[i][0], q = rule->type->between[i][1];
        node[i] = given[i] >= 0 ? i : -1;
        if (given[i] >= 0 && !at_start && __builtin_popcount(rule->straight[i]) > 2) {
            pl_mid_place(&w->mids, given[i], x + i * dim);
            continue;
        }
        for (int d = 0; d < dim; d++)
            x[i * dim + d] = node[i] < 0    ? 0.5 * x[p * dim + d] + 0.5 * x[q * dim + d]
                             : at_start > 1 ? pl_mid_coordinate_by(&w->mids, given[i], d, 0, 0)
                                            : pl_mid_coordinate(&w->mids, given[i], d,
                                                                0.5 * (way[p][d] + way[q][d]));
    }
}

void pl_watch_take(const pl_watch *w, const pl_watch_rule *rule, int64_t cell, int at_start,
                   pl_watch_block *b) {
    const int dim = w->plan->dim, l = b->n++, n = rule->jacobian.n_nodes;
    double *x = b->x[l], size = 0;
    b->rule = rule;
    pl_watch_find_places(w, &rule->jacobian, cell, at_start, x, b->node[l]);
    b->sign[l] = pl_watch_sign(w, cell);
    for (int i = dim; i < n * dim; i++)
        size = fmax(size, fabs(x[i] - x[i % dim]));
    b->exponent[l] = 0;
    for (int i = 0; i < n; i++)
        for (int d = 0; d < dim; d++)
            b->jacobian.x[i][d][l] =
                x[i * dim + d] - (rule->jacobian.n_control_terms > 0 ? x[d] : 0);
    if (!(size > 0 && size <= DBL_MAX && (size < SMALL || size > LARGE)))
        return;
    frexp(size, &b->exponent[l]);
    for (int i = 0; i < n; i++)
        for (int d = 0; d < dim; d++)
            b->jacobian.x[i][d][l] = ldexp(b->jacobian.x[i][d][l], -b->exponent[l]);
}

void pl_watch_evaluate(const pl_watch *w, pl_watch_block *b) {
    const int dim = w->plan->dim;
    for (int l = b->n; l < LANES; l++) {
        b->sign[l] = b->sign[0];
        for (int i = 0; i < b->rule->jacobian.n_nodes; i++)
            for (int d = 0; d < dim; d++)
                b->jacobian.x[i][d][l] = b->jacobian.x[i][d][0];
    }
    pl_jacobian_evaluate(&b->rule->jacobian, b->sign, &b->jacobian);
}

int pl_watch_is_lane_valid(const pl_watch_block *b, int l) {
    return pl_validity_of_lane(&b->rule->jacobian, &b->jacobian, l, b->node[l], b->x[l],
                               b->sign[l]) == PL_VALID;
}

/* ---- rooms ---------------------------------------------------------------------------------- */

/* If a corner moves by d and the nodes that follow it by their rates, a control moves by
 * rate * d, and a derivative by change * d, change a difference of two rates. det of three
 * derivatives is linear in each, and takes d in one of them alone: it changes by at most |d| times
 * the sum, over its columns, of change * the lengths of the other two. A coefficient is a sum of
 * such det by weights: it changes by at most
 *     weight |d| L^2,    weight = sum over its products of weight * factor * (sum of changes)
 * with L the longest derivative before the move; in the plane by weight |d| L. All corners of a
 * shape are alike. In a triangle or tetrahedron det is the same along other edges, so we take edges
 * of which only one is at the corner, as if it were not the first one: L is that of all edges.
 *
 * Coefficients at corners of linear cells are values at corners, which visits themselves keep positive
 * and above floors: neither rooms nor floors are of these. For a hexahedron that leaves 2 |d| L^2 of 3.
 *
 * While corners go D in all, L grows to L + change D at most. So a coefficient b stays positive while
 * the integral of weight (L + change D)^2 is at most b:
 *     weight L^2 D (1 + x + x^2 / 3) <= b, x = change D / L,    or in the plane weight L D (1 + x / 2);
 *     D <= g(D) = a / (1 + x + x^2 / 3), a = b / (weight L^2).
 * As g falls, and D <= a, g(a) will do, g(g(a)) may be too much, and g(g(g(a))) will do. Nodes that follow may be off by rounding, stray, before and after, which moves all
 * columns: derivatives by strayed = 2 stray * (weights of a control), a coefficient by
 * common * dim * strayed * L^2. That is taken off D once. */

/** Rates of controls for a corner: times how much of its move they move. */
static void find_rates(const pl_jacobian_rule *rule, int corner, double rate[NODES]) {
    double of_node[NODES];
    for (int i = 0; i < rule->n_nodes; i++)
        of_node[i] =
            rule->straight[i] >> corner & 1 ? 1.0 / __builtin_popcount(rule->straight[i]) : 0;
    for (int c = 0; c < rule->n_controls; c++)
        rate[c] = rule->n_control_terms > 0 ? 0 : of_node[c];
    for (int t = 0; t < rule->n_control_terms; t++)
        rate[rule->control_term[t].to] +=
            rule->control_term[t].weight * of_node[rule->control_term[t].from];
}

static void find_weights(pl_watch_rule *r) {
    const pl_jacobian_rule *rule = &r->jacobian;
    const int dim = rule->type->shape->dim;
    double rate[NODES], change[3][PL_JACOBIAN_DERIVATIVES], sum[PL_JACOBIAN_COEFFICIENTS] = {0};
    for (int c = 0; c < rule->n_corners && rule->type->order == 1; c++)
        r->is_at_corner[rule->corner[c]] = 1;
    find_rates(rule, 1, rate); /* corner 1 is the first one of no triangle or tetrahedron */
    for (int m = 0; m < dim; m++)
        for (int i = 0; i < rule->n_derivatives[m]; i++) {
            const pl_jacobian_derivative *of = &rule->derivative[m][i];
            change[m][i] = fabs(rate[of->plus] - rate[of->minus]);
            r->change = fmax(change[m][i], r->change);
        }
    for (int p = 0; p < rule->n_products; p++) {
        const pl_jacobian_product *product = &rule->product[p];
        sum[product->coefficient] += product->weight * rule->factor[product->coefficient] *
                                     (change[0][product->i] + change[1][product->j] +
                                      (dim == 3 ? change[2][product->k] : 0));
    }
    for (int c = 0; c < rule->n_coefficients; c++)
        if (!r->is_at_corner[c])
            r->weight = fmax(sum[c], r->weight);
}

pl_watch_rule *pl_watch_rule_make(const pl_cell_type *type) {
    pl_watch_rule *rule = pl_alloc_zero(1, sizeof *rule);
    if (!rule)
        return NULL;
    pl_jacobian_rule_make(type, &rule->jacobian);
    find_weights(rule);
    return rule;
}

double pl_watch_longest(const pl_jacobian_rule *rule, const pl_watch_block *b, int l, int dim) {
    double control[NODES][3] = {{0}}, longest = 0;
    for (int i = 0; i < rule->n_nodes && rule->n_control_terms == 0; i++)
        for (int d = 0; d < dim; d++)
            control[i][d] = b->jacobian.x[i][d][l];
    for (int t = 0; t < rule->n_control_terms; t++) {
        const pl_jacobian_term *term = &rule->control_term[t];
        for (int d = 0; d < dim; d++)
            control[term->to][d] += term->weight * b->jacobian.x[term->from][d][l];
    }
    for (int k = 0; k < dim; k++)
        for (int i = 0; i < rule->n_derivatives[k]; i++) {
            const pl_jacobian_derivative *of = &rule->derivative[k][i];
            longest =
                pl_larger(longest, pl_watch_distance(dim, control[of->plus], control[of->minus]));
            for (int j = 0; j < k; j++) /* differences of two are derivatives along other edges */
                if (rule->turn[j] == rule->turn[k])
                    longest =
                        pl_larger(longest, pl_watch_distance(dim, control[of->plus],
                                                             control[rule->derivative[j][i].plus]));
        }
    return longest;
}

/** Least coefficient of lane l, of linear cells of those that are at no corner. */
static double least_of(const pl_watch_block *b, int l) {
    const pl_jacobian_rule *rule = &b->rule->jacobian;
    double least = INFINITY;
    for (int c = 0; c < rule->n_coefficients; c++)
        if (!b->rule->is_at_corner[c])
            least = fmin(b->jacobian.coefficient[c][l], least);
    return least;
}

double pl_watch_room(const pl_watch *w, const pl_watch_rule *rule, double least, double longest) {
    const pl_jacobian_rule *jacobian = &rule->jacobian;
    const int dim = w->plan->dim;
    const double strayed = w->mids.end ? 2 * jacobian->control_weight * w->stray : 0;
    const double length = longest + strayed;
    const double a = least / (1.0001 * rule->weight * length * (dim == 3 ? length : 1));
    const double growth = rule->change / length;
    double room = a;
    for (int k = 0; k < 3; k++) { /* below the largest D, above it, below it */
        const double x = growth * room;
        room = a / (dim == 3 ? 1 + x * (1 + x * (1.0 / 3)) : 1 + 0.5 * x);
    }
    room -= 1.0001 * jacobian->common * dim * strayed / rule->weight;
    return room > 0 ? 0.9999 * room : 0;
}

void pl_watch_keep_state(pl_watch *w, const pl_watch_block *b, int l, int valid) {
    const pl_jacobian_rule *rule = &b->rule->jacobian;
    const int dim = w->plan->dim;
    const int32_t i = b->of[l];
    const double all = b->jacobian.least[l] - b->jacobian.error[l];
    const double inner = least_of(b, l) - b->jacobian.error[l];
    const double floor = w->floor ? w->floor[i] : 0;
    const int is_above = floor > 0 && ldexp(inner, dim * b->exponent[l]) > floor;
    w->state[i] = (uint8_t)((valid ? PL_WATCH_VALID : 0) | (is_above ? PL_WATCH_ABOVE : 0));
    w->room[i] = 0;
    if (!(valid && all > 0 && b->exponent[l] == 0) || (floor > 0 && !is_above))
        return;
    w->room[i] = pl_watch_room_below(pl_watch_room(w, b->rule, inner - (is_above ? floor : 0),
                                                   pl_watch_longest(rule, b, l, dim)));
}
