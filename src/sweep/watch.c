/* watch: which cells are watched, and whether they are valid. */
#include "sweep/watch.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/simplex.h"
#include "quality/certificate.h"
#include "quality/measure_block.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

enum {
    LANES = PL_JACOBIAN_LANES,
    NODES = PL_CELL_NODES,
    CHUNK = 256,       /* cells that one thread takes at a time, */
    CHUNK_NODES = 4096 /* or nodes */
};

/* An edge is straight if its mid is no farther off than this, in longest edges (cell_measure.c). */
static const double STRAIGHT = 1e-6;

/* Cells whose size is in this range are decided as they are, others scaled by a power of two. */
static const double SMALL = 0x1p-40, LARGE = 0x1p40;

/** Cells of one type whose validity is asked for, one per lane. */
typedef struct block {
    const pl_watch_rule *rule; /* with n above 0 */
    int n;
    int32_t of[LANES];          /* watched cells; or what the caller likes */
    double x[LANES][NODES * 3]; /* [n_nodes][dim] */
    int32_t node[LANES][NODES]; /* places in x; -1: a missing mid */
    double sign[LANES];
    int exponent[LANES]; /* of the scale */
    pl_jacobian_block jacobian;
} block;

/* ---- places --------------------------------------------------------------------------------- */

static double sign_of(const pl_watch *w, int64_t cell) {
    return w->plan->work.sign ? w->plan->work.sign[pl_first_of_cell(&w->plan->work, cell)] : 1;
}

/** Caller's number of a cell. */
static int64_t given_of(const planish_plan *plan, int64_t cell) {
    return pl_plan_element(plan, pl_first_of_cell(&plan->work, cell));
}

static const pl_cell_type *type_of(const planish_plan *plan, int64_t cell) {
    const int simplex = plan->dim == 3 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TRIANGLE;
    return pl_cell_type_of(plan->cells.n > 0 ? plan->cells.type[given_of(plan, cell)] : simplex);
}

/** The linear type of a shape. */
static const pl_cell_type *linear_type(const pl_cell_shape *shape) {
    static const int type[][2] = {{3, PLANISH_CELL_TRIANGLE}, {4, PLANISH_CELL_QUADRILATERAL}};
    static const int solid[] = {[4] = PLANISH_CELL_TETRAHEDRON,
                                [5] = PLANISH_CELL_PYRAMID,
                                [6] = PLANISH_CELL_WEDGE,
                                [8] = PLANISH_CELL_HEXAHEDRON};
    return pl_cell_type_of(shape->dim == 3 ? solid[shape->n_corners]
                                           : type[shape->n_corners == 4][1]);
}

/** Find the places of the nodes of a cell that a rule looks at, as they are or (at_start) were when
 *  the run began: x [n_nodes][dim]. node: see block. */
static void find_places(const pl_watch *w, const pl_jacobian_rule *rule, int64_t cell, int at_start,
                        double *x, int32_t *node) {
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
    const int32_t *given = plan->cells.node + plan->cells.offset[given_of(plan, cell)];
    for (int i = corners; i < rule->n_nodes; i++) {
        const int p = rule->type->between[i][0], q = rule->type->between[i][1];
        node[i] = given[i] >= 0 ? i : -1;
        if (given[i] >= 0 && !at_start && __builtin_popcount(rule->straight[i]) > 2) {
            pl_mid_place(&w->mids, given[i], x + i * dim);
            continue;
        }
        for (int d = 0; d < dim; d++)
            x[i * dim + d] = node[i] < 0 ? 0.5 * x[p * dim + d] + 0.5 * x[q * dim + d]
                                         : pl_mid_coordinate(&w->mids, given[i], d,
                                                             0.5 * (way[p][d] + way[q][d]));
    }
}

/** Add a cell to the block. */
static void add(const pl_watch *w, const pl_watch_rule *rule, int64_t cell, int at_start,
                block *b) {
    const int dim = w->plan->dim, l = b->n++, n = rule->jacobian.n_nodes;
    double *x = b->x[l], size = 0;
    b->rule = rule;
    find_places(w, &rule->jacobian, cell, at_start, x, b->node[l]);
    b->sign[l] = sign_of(w, cell);
    for (int i = dim; i < n * dim; i++)
        size = fmax(size, fabs(x[i] - x[i % dim]));
    b->exponent[l] = 0;
    for (int i = 0; i < n; i++)
        for (int d = 0; d < dim; d++)
            b->jacobian.x[i][d][l] = x[i * dim + d] - x[d];
    if (!(size > 0 && size <= DBL_MAX && (size < SMALL || size > LARGE)))
        return;
    frexp(size, &b->exponent[l]);
    for (int i = 0; i < n; i++)
        for (int d = 0; d < dim; d++)
            b->jacobian.x[i][d][l] = ldexp(b->jacobian.x[i][d][l], -b->exponent[l]);
}

/** Evaluate the block. Lanes past the last cell repeat the first. */
static void evaluate(const pl_watch *w, block *b) {
    const int dim = w->plan->dim;
    for (int l = b->n; l < LANES; l++) {
        b->sign[l] = b->sign[0];
        for (int i = 0; i < b->rule->jacobian.n_nodes; i++)
            for (int d = 0; d < dim; d++)
                b->jacobian.x[i][d][l] = b->jacobian.x[i][d][0];
    }
    pl_jacobian_evaluate(&b->rule->jacobian, b->sign, &b->jacobian);
}

static int is_valid(const block *b, int l) {
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
 * Coefficients at corners of linear cells are values at corners, which visits keep positive
 * themselves: they need not be counted. For a hexahedron that leaves 2 |d| L^2 of 3.
 *
 * While corners go D in all, L grows to L + change D at most. So a coefficient b stays positive while
 *     weight D (L + change D)^2 <= b;    a = b / (weight L^2) and D = a / (1 + change a / L)^2 do
 * as D <= a. Nodes that follow may be off by rounding, stray, before and after, which moves all
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

/** Whether a coefficient is one at a corner of a linear cell. */
static int is_at_corner(const pl_jacobian_rule *rule, int coefficient) {
    int found = 0;
    for (int c = 0; c < rule->n_corners && rule->type->order == 1; c++)
        found |= rule->corner[c] == coefficient;
    return found;
}

static void find_weights(pl_watch_rule *r) {
    const pl_jacobian_rule *rule = &r->jacobian;
    const int dim = rule->type->shape->dim;
    double rate[NODES], change[3][PL_JACOBIAN_DERIVATIVES], sum[PL_JACOBIAN_COEFFICIENTS] = {0};
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
        if (!is_at_corner(rule, c))
            r->weight = fmax(sum[c], r->weight);
}

/** Longest derivative of lane l along any edge. */
static double longest_of(const pl_jacobian_rule *rule, const block *b, int l, int dim) {
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
            longest = fmax(longest, pl_distance(dim, control[of->plus], control[of->minus]));
            for (int j = 0; j < k; j++) /* differences of two are derivatives along other edges */
                if (rule->turn[j] == rule->turn[k])
                    longest = fmax(longest, pl_distance(dim, control[of->plus],
                                                        control[rule->derivative[j][i].plus]));
        }
    return longest;
}

/** Least coefficient of lane l, of linear cells of those that are at no corner. */
static double least_of(const block *b, int l) {
    const pl_jacobian_rule *rule = &b->rule->jacobian;
    double least = INFINITY;
    if (rule->type->order > 1)
        return b->jacobian.least[l];
    for (int c = 0; c < rule->n_coefficients; c++)
        if (!is_at_corner(rule, c))
            least = fmin(b->jacobian.coefficient[c][l], least);
    return least;
}

/** Keep what there is to know of a watched cell, which is in lane l and valid or not. Bounds tell
 *  nothing of one that was scaled, or that bisections have decided. */
static void keep_state(pl_watch *w, const block *b, int l, int valid) {
    const pl_jacobian_rule *rule = &b->rule->jacobian;
    const int dim = w->plan->dim;
    const int32_t i = b->of[l];
    const double all = b->jacobian.least[l] - b->jacobian.error[l];
    const double floor = w->floor ? w->floor[i] : 0;
    const int is_above = floor > 0 && ldexp(all, dim * b->exponent[l]) > floor;
    w->state[i] = (uint8_t)((valid ? PL_WATCH_VALID : 0) | (is_above ? PL_WATCH_ABOVE : 0));
    w->room[i] = 0;
    if (!(valid && all > 0 && b->exponent[l] == 0) || (floor > 0 && !is_above))
        return;
    const double strayed = w->mids.end ? 2 * rule->control_weight * w->stray : 0;
    const double longest = longest_of(rule, b, l, dim) + strayed;
    const double slope = b->rule->weight * longest * (dim == 3 ? longest : 1);
    const double a =
        (least_of(b, l) - b->jacobian.error[l] - (is_above ? floor : 0)) / (1.0001 * slope);
    const double more = 1 + b->rule->change * a / longest;
    const double room = a / (more * (dim == 3 ? more : 1)) -
                        1.0001 * rule->common * dim * strayed / b->rule->weight;
    w->room[i] = room > 0 ? 0.9999 * room : 0;
}

/* ---- after a move --------------------------------------------------------------------------- */

/** Decide the cells of b, which were valid, and perhaps above their floor; 0 if one is not any more.
 */
static int keep_valid(pl_watch *w, block *b) {
    if (b->n > 0)
        evaluate(w, b);
    for (int l = 0; l < b->n; l++) {
        const int32_t i = b->of[l];
        const int was = w->state[i], valid = is_valid(b, l);
        keep_state(w, b, l, valid);
        const int is_kept = valid && w->state[i] >= was;
        w->state[i] = (uint8_t)was; /* what is better than it was is noted where the node stays */
        if (!is_kept) {
            if (w->n_refused_of[i] < UINT8_MAX)
                w->n_refused_of[i]++;
            return 0;
        }
    }
    b->n = 0;
    return 1;
}

/** Note which of the cells of b, which were not valid or below their floor, are so no more beyond
 *  doubt. */
static void note_valid(pl_watch *w, block *b) {
    if (b->n > 0)
        evaluate(w, b);
    for (int l = 0; l < b->n; l++)
        keep_state(w, b, l,
                   w->state[b->of[l]] & PL_WATCH_VALID ||
                       b->jacobian.least[l] > b->jacobian.error[l]);
    b->n = 0;
}

/** Whether the block has no room for a cell of this rule. */
static int is_full(const block *b, const pl_watch_rule *rule) {
    return b->n == LANES || (b->n > 0 && b->rule != rule);
}

/** Whether a watched cell is below a floor. */
static int is_below(const pl_watch *w, int32_t i) {
    return w->floor && w->floor[i] > 0 && !(w->state[i] & PL_WATCH_ABOVE);
}

/** Look again at the cells at node that were not valid, or below their floor. */
static void look_again(pl_watch *w, int32_t node, block *b) {
    b->n = 0;
    for (int64_t k = w->begin[node]; k < w->begin[node + 1]; k++) {
        const int32_t i = w->watched[k];
        const pl_watch_rule *rule = w->rule[w->type[i]];
        if (!rule || (w->state[i] & PL_WATCH_VALID && !is_below(w, i)))
            continue;
        if (is_full(b, rule))
            note_valid(w, b);
        b->of[b->n] = i;
        add(w, rule, pl_watch_cell(w, i), 0, b);
    }
    note_valid(w, b);
}

int64_t pl_watch_find_refusers(const pl_watch *w, uint8_t *state) {
    enum { REFUSALS = 3 };
    int64_t n = 0;
    block b;
    for (int64_t i = 0; w->plan->work.corner && i < w->n; i++) {
        if (w->n_refused_of[i] < REFUSALS || !w->rule[w->type[i]])
            continue;
        b.n = 0;
        add(w, w->rule[w->type[i]], pl_watch_cell(w, i), 0, &b);
        evaluate(w, &b);
        if (!(b.jacobian.least[0] > b.jacobian.error[0]))
            continue;
        if (state)
            state[w->plan->work.cell_begin[pl_watch_cell(w, i)]] = 1;
        n++;
    }
    return n;
}

/** Hexahedra in a block of floats. */
typedef struct bricks {
    int n,
        n_asked; /* lanes in use; the first ones are asked for, others have room, for more of it */
    int32_t of[LANES];
    pl_brick_block block;
} bricks;

/** Add a watched hexahedron, relative to a place; 0: its size is not for floats. */
PL_INLINE int add_brick(const pl_watch *w, int32_t i, const double *origin, bricks *b) {
    const double *coordinates = w->plan->scratch.coordinates;
    const int32_t *node = w->node[i];
    const int l = b->n;
    float size = 0;
    for (int j = 0; j < 8; j++) {
        const double *x = coordinates + (int64_t)node[j] * 3;
        for (int d = 0; d < 3; d++) {
            const float a = (float)(x[d] - origin[d]), length = fabsf(a);
            b->block.x[j][d][l] = a;
            size = length > size ? length : size;
        }
    }
    b->block.floor[l] = w->floor && w->state[i] & PL_WATCH_ABOVE
                            ? nextafterf((float)(w->floor[i] * 0.125), INFINITY)
                            : 0;
    b->of[l] = i;
    if (!(size >= PL_BRICK_SMALL && size <= PL_BRICK_LARGE))
        return 0;
    b->n++;
    return 1;
}

/** Certify bricks: those that floats certify get their rooms. left [LANES]: the others that are asked
 *  for; returns their number. */
static int certify_bricks(pl_watch *w, bricks *b, int32_t left[LANES]) {
    int n = 0;
    for (int l = b->n; l < LANES; l++) {
        for (int j = 0; j < 8; j++)
            for (int d = 0; d < 3; d++)
                b->block.x[j][d][l] = b->block.x[j][d][0];
        b->block.floor[l] = 0;
    }
    pl_bricks_certify(&b->block);
    for (int l = 0; l < b->n; l++) {
        const double room = b->block.room[l];
        double *own = &w->room[b->of[l]];
        if (l >= b->n_asked)
            *own = room > *own ? room : *own;
        else if (room > 0)
            *own = room;
        else
            left[n++] = b->of[l];
    }
    b->n = b->n_asked = 0;
    return n;
}

/** Decide the bricks, which were valid; those that floats do not certify with b. 0 if one is not
 *  valid any more. */
static int keep_bricks_valid(pl_watch *w, bricks *h, block *b) {
    int32_t left[LANES];
    const int n = h->n > 0 ? certify_bricks(w, h, left) : 0;
    for (int l = 0; l < n; l++) {
        const pl_watch_rule *rule = w->rule[PLANISH_CELL_HEXAHEDRON];
        if (is_full(b, rule) && !keep_valid(w, b))
            return 0;
        b->of[b->n] = left[l];
        add(w, rule, pl_watch_cell(w, left[l]), 0, b);
    }
    return 1;
}

/** Decide a watched cell that was valid, at once or in a block that fills. 0 if one is not any more.
 */
static int keep_one_valid(pl_watch *w, int32_t i, const double *origin, bricks *h, block *b) {
    const pl_watch_rule *rule = w->rule[w->type[i]];
    if (w->type[i] == PLANISH_CELL_HEXAHEDRON && !is_below(w, i) && add_brick(w, i, origin, h)) {
        h->n_asked = h->n;
        return h->n < LANES || keep_bricks_valid(w, h, b);
    }
    if (is_full(b, rule) && !keep_valid(w, b))
        return 0;
    b->of[b->n] = i;
    add(w, rule, pl_watch_cell(w, i), 0, b);
    return 1;
}

void pl_watch_forget(pl_watch *w, int32_t node) {
    for (int64_t k = w->begin[node]; k < w->begin[node + 1]; k++)
        w->room[w->watched[k]] = w->type[w->watched[k]] ? 0 : INFINITY;
}

/** Let those hexahedra at node that have not much room left have the lanes that are free: they would
 *  ask for a block soon, and in other visits. */
static void fill_bricks(const pl_watch *w, int32_t node, double length, bricks *h) {
    enum { SOON = 16 }; /* moves as long as this one: twice of 8 corners */
    const double *x = w->plan->scratch.coordinates + (int64_t)node * 3;
    for (int64_t k = w->begin[node]; k < w->begin[node + 1] && h->n < LANES; k++) {
        const int32_t i = w->watched[k];
        int is_in = w->type[i] != PLANISH_CELL_HEXAHEDRON || !(w->room[i] > 0) ||
                    w->room[i] > SOON * length;
        for (int l = 0; l < h->n; l++)
            is_in |= h->of[l] == i;
        if (!is_in)
            add_brick(w, i, x, h);
    }
}

int pl_watch_admit(pl_watch *w, int32_t node, const double *way) {
    static const double origin[3] = {0, 0, 0};
    const int dim = w->plan->dim;
    const double length = pl_distance(dim, way, origin);
    const double *x = w->plan->scratch.coordinates + (int64_t)node * dim;
    const int64_t end = w->begin[node + 1];
    int is_fine = 1, any_bad = 0;
    bricks h;
    block b;
    h.n = h.n_asked = b.n = 0;
    for (int64_t k = w->begin[node]; k < end && is_fine; k++) {
        const int32_t i = w->watched[k];
        const double room = w->room[i] - length;
        if (room > 0) {
            w->room[i] = room;
            continue;
        }
        any_bad |= !(w->state[i] & PL_WATCH_VALID) || is_below(w, i);
        if (w->state[i] & PL_WATCH_VALID)
            is_fine = keep_one_valid(w, i, x, &h, &b);
    }
    if (is_fine && h.n > 0)
        fill_bricks(w, node, length, &h);
    is_fine = is_fine && keep_bricks_valid(w, &h, &b) && keep_valid(w, &b);
    if (!is_fine) /* the node goes back */
        pl_watch_forget(w, node);
    if (is_fine && any_bad)
        look_again(w, node, &b);
    return is_fine;
}

/* ---- measures ------------------------------------------------------------------------------- */

/** Shape of a watched cell of a plan with corners. */
static const pl_cell_shape *shape_of(const pl_watch *w, int32_t i) {
    static const int solid[] = {[PL_KIND_SIMPLEX] = PLANISH_CELL_TETRAHEDRON,
                                [PL_KIND_BRICK] = PLANISH_CELL_HEXAHEDRON,
                                [PL_KIND_WEDGE] = PLANISH_CELL_WEDGE,
                                [PL_KIND_PYRAMID] = PLANISH_CELL_PYRAMID};
    const planish_plan *plan = w->plan;
    const int kind =
        pl_corner_kind(plan->work.corner[pl_first_of_cell(&plan->work, pl_watch_cell(w, i))]);
    return pl_cell_type_of(plan->dim == 3            ? solid[kind]
                           : kind == PL_KIND_SIMPLEX ? PLANISH_CELL_TRIANGLE
                                                     : PLANISH_CELL_QUADRILATERAL)
        ->shape;
}

/** Find the edges of corner c of a cell with corners x, in a size of about 1. */
static void edges_of_corner(const pl_cell_shape *shape, const double *const x[], int c,
                            double edge[3][3]) {
    const int dim = shape->dim;
    double size = 0;
    int exponent;
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++) {
            edge[j][d] = x[shape->neighbour[c][j]][d] - x[c][d];
            size = fmax(size, fabs(edge[j][d]));
        }
    frexp(size, &exponent);
    const double scale = ldexp(1, -pl_scale_exponent(exponent));
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edge[j][d] *= scale;
}

/** Find mu^2 of corner c of a cell with corners x, and the square of its scaled Jacobian; infinite
 *  and 0 where it is not positive. The same bits at every scale that is a power of two. */
static void measure_corner(const pl_cell_shape *shape, const double *const x[], int c, double sign,
                           double *mu2, double *jacobian2) {
    const int dim = shape->dim;
    double edge[3][3], e = 0, squares = 1;
    edges_of_corner(shape, x, c, edge);
    for (int j = 0; j < dim; j++) {
        const double square = pl_dot(dim, edge[j], edge[j]);
        e += shape->to_corner[j] * square;
        squares *= square;
    }
    for (int i = 0, pair = 0; i < dim; i++)
        for (int j = i + 1; j < dim; j++, pair++) {
            double apart[3];
            pl_subtract(dim, edge[j], edge[i], apart);
            e += shape->between[pair] * pl_dot(dim, apart, apart);
        }
    const double ideal = sign * pl_determinant_of_edges(dim, edge) / shape->determinant;
    *mu2 = INFINITY;
    *jacobian2 = 0;
    if (!(ideal > 0 && squares > 0))
        return;
    *mu2 = pl_mean_square(dim, e, ideal);
    *jacobian2 = ideal * ideal / squares;
}

/** Raise worst to the measures of a watched cell. */
static void raise_worst(const pl_watch *w, int32_t i, pl_worst_cell *worst) {
    const pl_cell_shape *shape = shape_of(w, i);
    const double *x[PL_CELL_CORNERS];
    const double sign = shape->n_corners == 8 ? 1 : sign_of(w, pl_watch_cell(w, i));
    double sum = 0;
    for (int j = 0; j < shape->n_corners; j++)
        x[j] = w->plan->scratch.coordinates + (int64_t)w->node[i][j] * shape->dim;
    for (int c = 0; c < shape->n_measured; c++) {
        double mu2, jacobian2;
        measure_corner(shape, x, c, sign, &mu2, &jacobian2);
        sum += mu2;
        worst->acuteness = fmax(1 / jacobian2, worst->acuteness);
    }
    worst->ar2 = fmax(sum / shape->n_measured, worst->ar2);
}

pl_worst_cell pl_watch_worst(const pl_watch *w, int32_t node) {
    pl_worst_cell worst = {0, 0};
    for (int64_t k = w->begin[node]; k < w->begin[node + 1]; k++)
        raise_worst(w, w->watched[k], &worst);
    return worst;
}

/* ---- all of them ---------------------------------------------------------------------------- */

/** A look at all watched cells, or at all cells. */
typedef struct look {
    pl_watch *watch;
    uint8_t *state;
    int64_t n;  /* found; shared */
    int of_all; /* cells that corners decide, too, and corners that have turned */
} look;

/** Exact sign of the corners of a cell. */
static int has_positive_corners(const pl_watch *w, int64_t cell, int at_start) {
    const planish_plan *plan = w->plan;
    const int64_t begin = pl_first_of_cell(&plan->work, cell);
    const int64_t end = plan->work.corner ? plan->work.cell_begin[cell + 1] : begin + 1;
    const double *vertex[4];
    int positive = 1;
    for (int64_t e = begin; e < end && positive; e++) {
        for (int j = 0; j <= plan->dim; j++) {
            const int64_t node = plan->work.elements[e * (plan->dim + 1) + j];
            vertex[j] = at_start
                            ? w->mids.given + node * plan->dim
                            : plan->scratch.coordinates + (int64_t)plan->inner[node] * plan->dim;
        }
        positive = pl_measure_sign(plan->dim, vertex) * sign_of(w, cell) > 0;
    }
    return positive;
}

/** What a chunk of cells has: invalid ones with positive corners; valid ones without. */
typedef struct measured {
    int64_t n, n_turned;
} measured;

/** Least coefficient over the mean of lane l, of simplices of order 2; of others infinite. */
static float quality_of(const block *b, int l) {
    const pl_cell_type *type = b->rule->jacobian.type;
    if (type->order == 1 || type->shape->n_simplices > 1)
        return INFINITY;
    const double mean = b->jacobian.mean[l];
    return mean > 0 ? (float)(b->jacobian.least[l] / mean) : -INFINITY;
}

/** Keep the states of the block's cells. */
static void measure_block(pl_watch *w, block *b, measured *m) {
    if (b->n > 0)
        evaluate(w, b);
    for (int l = 0; l < b->n; l++) {
        const int valid = is_valid(b, l);
        keep_state(w, b, l, valid);
        if (w->quality)
            w->quality[b->of[l]] = quality_of(b, l);
        if (valid && b->rule->jacobian.type->order == 1)
            continue;
        const int is_positive = has_positive_corners(w, pl_watch_cell(w, b->of[l]), 0);
        m->n += !valid && is_positive;
        m->n_turned += valid && !is_positive;
    }
    b->n = 0;
}

/** Measure the cells of a chunk that one rule decides. */
static void measure_type(pl_watch *w, int type, int64_t begin, int64_t end, measured *m) {
    const int is_brick = type == PLANISH_CELL_HEXAHEDRON && !w->floor;
    const int dim = w->plan->dim;
    int32_t left[LANES];
    bricks h;
    block b;
    h.n = h.n_asked = b.n = 0;
    for (int64_t i = begin; i <= end; i++) {
        int n_left = 0;
        if (i < end && w->type[i] != type)
            continue;
        if (i < end) {
            const double *x =
                w->plan->scratch.coordinates + (int64_t)(is_brick ? w->node[i][0] : 0) * dim;
            w->state[i] = PL_WATCH_VALID;
            if (!is_brick || !add_brick(w, (int32_t)i, x, &h))
                left[n_left++] = (int32_t)i;
            h.n_asked = h.n;
        }
        if (h.n == LANES || (i == end && h.n > 0))
            n_left = certify_bricks(w, &h, left);
        for (int l = 0; l < n_left; l++) {
            if (b.n == LANES)
                measure_block(w, &b, m);
            b.of[b.n] = left[l];
            add(w, w->rule[type], pl_watch_cell(w, left[l]), 0, &b);
        }
    }
    measure_block(w, &b, m);
}

static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    look *s = context;
    measured m = {0, 0};
    (void)thread;
    for (int type = 1; type < PL_WATCH_TYPES; type++)
        if (s->watch->rule[type])
            measure_type(s->watch, type, begin, end, &m);
    __atomic_fetch_add(&s->n, m.n, __ATOMIC_RELAXED);
    __atomic_fetch_add(&s->watch->n_turned, m.n_turned, __ATOMIC_RELAXED);
}

int64_t pl_watch_measure(pl_watch *w) {
    look s = {.watch = w};
    w->n_turned = 0;
    if (w->n > 0)
        pl_parallel_for(w->plan->threads, w->n, CHUNK, measure_chunk, &s);
    return s.n;
}

static int has_moved(const pl_watch *w, int64_t cell) {
    const planish_plan *plan = w->plan;
    const size_t size = (size_t)plan->dim * sizeof(double);
    int32_t corner[PL_CELL_CORNERS];
    const int n = pl_plan_cell_corners(plan, cell, corner);
    for (int j = 0; j < n; j++)
        if (memcmp(plan->scratch.coordinates + (int64_t)plan->inner[corner[j]] * plan->dim,
                   w->mids.given + (int64_t)corner[j] * plan->dim, size) != 0)
            return 1;
    const int64_t of_caller = given_of(plan, cell);
    for (int64_t k = plan->cells.offset[of_caller];
         w->mids.own && k < plan->cells.offset[of_caller + 1]; k++)
        if (plan->cells.node[k] >= 0 && pl_mid_has_moved(&w->mids, plan->cells.node[k]))
            return 1;
    return 0;
}

/** How far nodes of order 2 may be off the middle of their corners in a straight cell. They keep
 *  that, also where the cell has become smaller. */
static double off_of(const pl_watch *w, const double *const start[], int n, int dim) {
    double longest = 0;
    for (int j = 0; j < n; j++)
        for (int k = 0; k < j; k++)
            longest = pl_larger(pl_distance(dim, start[j], start[k]), longest);
    return pl_larger(STRAIGHT * longest, w->rounding) + w->stray;
}

/** Whether the coefficients of a straight cell of order 2 are positive for sure. Without nodes off
 *  the middle they are means of those of the linear cell, but for a factor: at least scale^dim *
 *  determinant in units of common. longest: its longest edge. */
static int is_plain(const pl_jacobian_rule *rule, double determinant, double longest, double off) {
    const int dim = rule->type->shape->dim;
    double scale = 0; /* controls of linear cells at corners are so many times nodes, by halves */
    for (int t = 0; t < rule->n_control_terms && rule->control_term[t].to == 0; t++)
        scale += 0.5 * rule->control_term[t].weight;
    const double strayed = 2 * rule->control_weight * off, reach = scale * longest + strayed;
    return scale * scale * (dim == 3 ? scale : 1) * determinant >
           1.0001 * dim * strayed * reach * (dim == 3 ? reach : 1);
}

/** Whether the corners alone say that a straight simplex is valid. */
PL_INLINE int is_plain_simplex(const pl_watch *w, const pl_jacobian_rule *rule, int64_t cell,
                               const int dim) {
    const planish_plan *plan = w->plan;
    const double *vertex[4], *start[4];
    double edges[3][3], longest = 0;
    const int64_t element = pl_first_of_cell(&plan->work, cell);
    for (int j = 0; j <= dim; j++) {
        const int64_t node = plan->work.elements[element * (dim + 1) + j];
        vertex[j] = plan->scratch.coordinates + (int64_t)plan->inner[node] * dim;
        start[j] = w->mids.given + node * dim;
        for (int k = 0; k < j; k++)
            longest = pl_larger(pl_distance(dim, vertex[j], vertex[k]), longest);
    }
    pl_edges(dim, vertex, edges);
    return is_plain(rule, sign_of(w, cell) * pl_determinant_of_edges(dim, edges), longest,
                    off_of(w, start, dim + 1, dim));
}

/** Whether the corners alone say that a straight cell is valid. */
static int is_plain_cell(const pl_watch *w, const pl_watch_rule *linear,
                         const pl_jacobian_rule *rule, int64_t cell, block *b) {
    int32_t corner[PL_CELL_CORNERS];
    const double *start[PL_CELL_CORNERS];
    const int n = pl_plan_cell_corners(w->plan, cell, corner), dim = w->plan->dim;
    for (int j = 0; j < n; j++)
        start[j] = w->mids.given + (int64_t)corner[j] * dim;
    b->n = 0;
    add(w, linear, cell, 0, b);
    evaluate(w, b);
    const double least = b->jacobian.least[0] - b->jacobian.error[0];
    return b->exponent[0] == 0 &&
           is_plain(rule, least / linear->jacobian.common, longest_of(&linear->jacobian, b, 0, dim),
                    off_of(w, start, n, dim));
}

static int is_valid_alone(const pl_watch *w, const pl_watch_rule *rule, int64_t cell, int at_start,
                          block *b) {
    b->n = 0;
    add(w, rule, cell, at_start, b);
    evaluate(w, b);
    return is_valid(b, 0);
}

/** Whether corners of a cell were positive and are not any more. */
static int has_turned(const pl_watch *w, int64_t cell) {
    return !has_positive_corners(w, cell, 0) && has_positive_corners(w, cell, 1);
}

pl_validity pl_watch_decide(const pl_watch *w, int64_t cell) {
    const pl_watch_rule *rule = w->rule[type_of(w->plan, cell)->type];
    block b;
    if (!rule)
        return has_positive_corners(w, cell, 0) ? PL_VALID : PL_INVALID;
    b.n = 0;
    add(w, rule, cell, 0, &b);
    evaluate(w, &b);
    return pl_validity_of_lane(&rule->jacobian, &b.jacobian, 0, b.node[0], b.x[0], b.sign[0]);
}

int pl_watch_has_poor(const pl_watch *w, double quality) {
    int any = 0;
    for (int64_t i = 0; w->quality && i < w->n; i++)
        any |= w->type[i] && w->quality[i] < quality;
    return any;
}

static void mark(const look *s, int64_t cell) {
    const planish_plan *plan = s->watch->plan;
    const int64_t first = pl_first_of_cell(&plan->work, cell);
    const int64_t n = plan->work.corner ? plan->work.cell_begin[cell + 1] - first : 1;
    memset(s->state + first, 1, (size_t)n);
}

/** Mark the cells of b that are not valid and were. */
static int64_t mark_broken(look *s, block *b) {
    const pl_watch *w = s->watch;
    block alone;
    int64_t n = 0;
    if (b->n > 0)
        evaluate(w, b);
    for (int l = 0; l < b->n; l++)
        if (!is_valid(b, l) && (is_valid_alone(w, b->rule, b->of[l], 1, &alone) ||
                                (s->of_all && has_turned(w, b->of[l])))) {
            mark(s, b->of[l]);
            n++;
        }
    b->n = 0;
    return n;
}

/** The rule that decides a cell as it is, or NULL: its corners do, and say (or are not asked) that it
 *  is valid. */
static const pl_watch_rule *rule_of(const look *s, int64_t cell, block *room) {
    const pl_watch *w = s->watch;
    const pl_cell_type *type = type_of(w->plan, cell);
    const pl_watch_rule *own = w->rule[type->type];
    const int dim = type->shape->dim;
    if (type->order == 1 || !own || w->is_curved[cell])
        return own;
    if (type->shape->n_simplices == 1)
        return (dim == 3 ? is_plain_simplex(w, &own->jacobian, cell, 3)
                         : is_plain_simplex(w, &own->jacobian, cell, 2))
                   ? NULL
                   : own;
    return is_plain_cell(w, w->rule[linear_type(type->shape)->type], &own->jacobian, cell, room)
               ? NULL
               : own;
}

static void broken_chunk(void *context, int64_t begin, int64_t end, int thread) {
    look *s = context;
    const pl_watch *w = s->watch;
    int64_t n = 0;
    block b, room;
    (void)thread;
    b.n = 0;
    for (int64_t cell = begin; cell < end; cell++) {
        if (!has_moved(w, cell))
            continue;
        const pl_watch_rule *rule = rule_of(s, cell, &room);
        if (rule) {
            if (is_full(&b, rule))
                n += mark_broken(s, &b);
            b.of[b.n] = (int32_t)cell;
            add(w, rule, cell, 0, &b);
        } else if (s->of_all && type_of(w->plan, cell)->order == 1 && has_turned(w, cell)) {
            mark(s, cell);
            n++;
        }
    }
    n += mark_broken(s, &b);
    __atomic_fetch_add(&s->n, n, __ATOMIC_RELAXED);
}

int64_t pl_watch_find_broken(const pl_watch *w, int of_all, uint8_t *state) {
    look s = {.watch = (pl_watch *)(uintptr_t)w, .state = state, .of_all = of_all};
    pl_parallel_for(w->plan->threads, pl_view_cells(&w->plan->work), CHUNK, broken_chunk, &s);
    return s.n;
}

/* ---- the beginning -------------------------------------------------------------------------- */

/** A search for cells. */
typedef struct search {
    pl_watch *watch;
    const planish_options *options;
    double min_volume; /* of cells without their own */
    uint8_t *is_off;   /* [nodes of the mesh] nodes that are off the middle of their corners */
    uint8_t has_type[PL_WATCH_TYPES]; /* shared, as are these: */
    int64_t n_curved;
    int64_t lowest; /* node that is not finite, or INT64_MAX */
    double largest; /* coordinate of these nodes, absolute */
    int fills;      /* lists: count, or fill in */
} search;

/** Find by how much a node is off the middle of its n parents, and the longest distance of two of
 *  these: squares. */
PL_INLINE void measure_mid(const pl_mids *mids, int32_t node, const double *const parent[], int n,
                           double *off, double *edge, const int dim) {
    double middle[3];
    *off = *edge = 0;
    for (int d = 0; d < dim; d++) {
        middle[d] = 0;
        for (int k = 0; k < n; k++)
            middle[d] += parent[k][d] / n;
        const double x = pl_mid_coordinate(mids, node, d, 0) - middle[d];
        *off += x * x;
        *edge += (parent[1][d] - parent[0][d]) * (parent[1][d] - parent[0][d]);
    }
}

static int is_off(const pl_watch *w, double off, double longest) {
    return off > STRAIGHT * STRAIGHT * longest && off > w->rounding * w->rounding;
}

/** Find the nodes that are off by more than a part of their own edge. */
static void mids_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    const pl_mids *m = &s->watch->mids;
    const int dim = m->start.dim;
    int64_t lowest = INT64_MAX;
    double largest = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double off = 0, edge = 0;
        s->is_off[i] = 0;
        if (m->end[i][0] == PL_NO_MID)
            continue;
        if (m->end[i][0] >= 0) {
            const double *ends[] = {m->given + (int64_t)m->end[i][0] * dim,
                                    m->given + (int64_t)m->end[i][1] * dim};
            measure_mid(m, (int32_t)i, ends, 2, &off, &edge, dim);
        }
        /* Of a node with several parents any may be noted: its cells decide each by its own. */
        s->is_off[i] = is_off(s->watch, off, edge) || m->end[i][0] == PL_OF_MORE ||
                       m->plan->role[i] & PL_OF_EDGES;
        for (int d = 0; d < dim; d++) {
            const double x = pl_mid_coordinate(m, (int32_t)i, d, 0);
            largest = pl_larger(fabs(x), largest);
            if (!isfinite(x) && i < lowest)
                lowest = i;
        }
    }
    pl_raise_double(&s->largest, largest);
    pl_lower_to(&s->lowest, lowest);
}

/** Whether a node of the cell is off by more than a part of its longest edge. */
static int is_cell_curved(const search *s, int64_t cell) {
    const pl_watch *w = s->watch;
    const planish_plan *plan = w->plan;
    const int dim = plan->dim;
    const pl_cell_type *type = type_of(plan, cell);
    double longest = 0, farthest = 0;
    int32_t corner[PL_CELL_CORNERS];
    int any = 0;
    const int n_corners = type->order > 1 ? pl_plan_cell_corners(plan, cell, corner) : 0;
    const int32_t *given = plan->cells.node + plan->cells.offset[given_of(plan, cell)];
    for (int i = n_corners; i < type->n_nodes && type->order > 1; i++)
        any |= given[i] >= 0 && s->is_off[given[i]];
    for (int i = n_corners; any && i < type->n_nodes; i++) {
        const double *parent[PL_CELL_CORNERS];
        double off, edge;
        int n = 0;
        const uint8_t parents = pl_cell_parents(type, i);
        const int p = type->between[i][0], q = type->between[i][1];
        parent[n++] = w->mids.given + (int64_t)corner[p] * dim;
        parent[n++] = w->mids.given + (int64_t)corner[q] * dim;
        for (int c = 0; c < n_corners; c++)
            if (parents >> c & 1 && c != p && c != q)
                parent[n++] = w->mids.given + (int64_t)corner[c] * dim;
        measure_mid(&w->mids, given[i] >= 0 ? given[i] : 0, parent, n, &off, &edge, dim);
        if (n == 2)
            longest = pl_larger(edge, longest);
        if (given[i] >= 0)
            farthest = pl_larger(off, farthest);
    }
    return any && is_off(w, farthest, longest);
}

/** The type whose rule decides a cell during sweeps; 0: its corners do. */
static int deciding_type(const pl_watch *w, int64_t cell) {
    const pl_cell_type *type = type_of(w->plan, cell);
    if (w->is_curved && w->is_curved[cell])
        return type->type;
    return type->shape->dim == 3 && type->shape->n_corners >= 6 ? linear_type(type->shape)->type
                                                                : 0;
}

static void note_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const search *s = context;
    pl_watch *w = s->watch;
    (void)thread;
    for (int64_t cell = begin; cell < end; cell++) {
        const pl_cell_type *type = type_of(w->plan, cell);
        if (type->order > 1)
            pl_mids_note(&w->mids, cell, type, s->fills);
    }
}

static void search_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    int64_t n = 0;
    (void)thread;
    for (int64_t cell = begin; cell < end; cell++) {
        const int is_found = is_cell_curved(s, cell);
        s->watch->is_curved[cell] = (uint8_t)is_found;
        n += is_found;
    }
    __atomic_fetch_add(&s->n_curved, n, __ATOMIC_RELAXED);
}

/** Find mids and curved cells, all at once. */
static int find_curved(search *s, const double *given, const double *start, planish_error *error) {
    pl_watch *w = s->watch;
    const int threads = w->plan->threads;
    const int64_t n_cells = pl_view_cells(&w->plan->work);
    int status = pl_mids_create(w->plan, s->options, given, start, &w->mids, error);
    if (status)
        return status;
    s->is_off = pl_alloc(w->mids.start.n, sizeof *s->is_off);
    w->is_curved = pl_alloc(n_cells, sizeof *w->is_curved);
    if (!s->is_off || !w->is_curved)
        return pl_fail_memory(error, "the curved elements");
    pl_parallel_for(threads, n_cells, CHUNK, note_chunk, s);
    status = pl_mids_number(&w->mids, error);
    if (status)
        return status;
    s->fills = w->mids.n_more > 0;
    if (s->fills)
        pl_parallel_for(threads, n_cells, CHUNK, note_chunk, s);
    pl_parallel_for(threads, w->mids.start.n, CHUNK_NODES, mids_chunk, s);
    if (s->lowest < INT64_MAX)
        return pl_fail_at(error, PLANISH_ERROR_MESH, -1, s->lowest,
                          "node %" PRId64 " has a coordinate that is not a finite number",
                          s->lowest);
    pl_parallel_for(threads, n_cells, CHUNK, search_chunk, s);
    return PLANISH_OK;
}

static void type_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    uint8_t has[PL_WATCH_TYPES] = {0};
    (void)thread;
    for (int64_t cell = begin; cell < end; cell++)
        has[type_of(s->watch->plan, cell)->type] = 1;
    for (int t = 0; t < PL_WATCH_TYPES; t++)
        if (has[t])
            pl_set_flag(&s->has_type[t], 1);
}

static int make_rule(pl_watch *w, const pl_cell_type *type) {
    pl_watch_rule **rule = &w->rule[type->type];
    if (*rule)
        return 1;
    *rule = pl_alloc_zero(1, sizeof **rule);
    if (!*rule)
        return 0;
    pl_jacobian_rule_make(type, &(*rule)->jacobian);
    find_weights(*rule);
    return 1;
}

/** Make the rules of the types that need them, and find whether there are any of order 2. */
static int make_rules(search *s, int *order_2) {
    int made = 1;
    *order_2 = 0;
    for (int t = 0; t < PL_WATCH_TYPES; t++) {
        const pl_cell_type *type = s->has_type[t] ? pl_cell_type_of(t) : NULL;
        if (!type)
            continue;
        if (type->order > 1 || (type->shape->dim == 3 && type->shape->n_corners >= 6))
            made = made && make_rule(s->watch, type);
        if (type->order > 1 && type->shape->n_simplices > 1)
            made = made && make_rule(s->watch, linear_type(type->shape));
        *order_2 |= type->order > 1;
    }
    return made;
}

/** The floor of a cell's coefficients: by its own minimum volume, or that of all. */
static double floor_of(const search *s, int64_t cell, int type) {
    const planish_plan *plan = s->watch->plan;
    const int64_t first = pl_first_of_cell(&plan->work, cell);
    const double own = plan->work.min_volume ? plan->work.min_volume[first] : 0;
    const double volume = own > 0 ? own : s->min_volume;
    if (!type)
        return 0;
    const pl_jacobian_rule *rule = &s->watch->rule[type]->jacobian;
    double scale = 1; /* as in is_plain */
    for (int t = 0; t < rule->n_control_terms && rule->control_term[t].to == 0; t++)
        scale = 0.5 * rule->control_term[t].weight;
    return volume / plan->form[pl_form_code(plan->work.corner[first], 0, 0)].volume * rule->common *
           scale * scale * (plan->dim == 3 ? scale : 1);
}

static void cell_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const search *s = context;
    pl_watch *w = s->watch;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t cell = pl_watch_cell(w, i);
        const int type = deciding_type(w, cell);
        w->type[i] = (uint8_t)type;
        w->room[i] = type ? 0 : INFINITY;
        w->state[i] = PL_WATCH_VALID;
        w->n_refused_of[i] = 0;
        if (w->quality)
            w->quality[i] = INFINITY;
        if (w->floor)
            w->floor[i] = floor_of(s, cell, type);
        if (!w->node)
            continue;
        int32_t corner[PL_CELL_CORNERS];
        const int n = pl_plan_cell_corners(w->plan, cell, corner);
        const int turned = sign_of(w, cell) < 0 ? n / 2 : 0;
        for (int j = 0; j < PL_CELL_CORNERS; j++) /* of a hexahedron, top first: a reflection */
            w->node[i][j] = j < n ? w->plan->inner[corner[n == 8 ? (j + turned) % n : j]] : -1;
    }
}

/** Count, or list, the watched cells at each movable node. */
static void list_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const search *s = context;
    pl_watch *w = s->watch;
    const planish_plan *plan = w->plan;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int32_t corner[PL_CELL_CORNERS];
        const int n = pl_plan_cell_corners(plan, pl_watch_cell(w, i), corner);
        for (int j = 0; j < n; j++) {
            int is_first = plan->work.mobility[corner[j]] != 0;
            for (int k = 0; k < j; k++) /* nodes that are there twice */
                is_first &= corner[k] != corner[j];
            if (!is_first)
                continue;
            int64_t *at = &w->begin[plan->inner[corner[j]] + 1];
            const int64_t place = __atomic_fetch_add(at, 1, __ATOMIC_RELAXED);
            if (s->fills)
                w->watched[place] = (int32_t)i;
        }
    }
}

/** Sort the cells of each node by type, then number. */
static void sort_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const search *s = context;
    pl_watch *w = s->watch;
    (void)thread;
    for (int64_t node = begin; node < end; node++)
        for (int64_t k = w->begin[node] + 1; k < w->begin[node + 1]; k++) {
            const int32_t cell = w->watched[k];
            int64_t at = k;
            for (; at > w->begin[node]; at--) {
                const int32_t other = w->watched[at - 1];
                if (w->type[other] < w->type[cell] ||
                    (w->type[other] == w->type[cell] && other < cell))
                    break;
                w->watched[at] = other;
            }
            w->watched[at] = cell;
        }
}

/** List the watched cells of each node. */
static int make_lists(search *s) {
    pl_watch *w = s->watch;
    const int threads = w->plan->threads;
    const int64_t n_nodes = w->plan->work.n_nodes;
    int64_t n = 0;
    w->begin = pl_alloc_zero(n_nodes + 1, sizeof *w->begin);
    if (!w->begin)
        return 0;
    s->fills = 0;
    pl_parallel_for(threads, w->n, CHUNK, list_chunk, s);
    for (int64_t i = 1; i <= n_nodes; i++) { /* begin[i + 1]: where those of node i begin */
        const int64_t of_node = w->begin[i];
        w->begin[i] = n;
        n += of_node;
    }
    w->watched = pl_alloc(n, sizeof *w->watched);
    if (!w->watched)
        return 0;
    s->fills = 1;
    pl_parallel_for(threads, w->n, CHUNK, list_chunk, s);
    pl_parallel_for(threads, n_nodes, CHUNK_NODES, sort_chunk, s);
    return 1;
}

/** The lowest inner number of the nodes of a cell. */
static int32_t lowest_node(const planish_plan *plan, int64_t cell) {
    int32_t corner[PL_CELL_CORNERS], lowest = INT32_MAX;
    const int n = pl_plan_cell_corners(plan, cell, corner);
    for (int j = 0; j < n; j++)
        lowest = plan->inner[corner[j]] < lowest ? plan->inner[corner[j]] : lowest;
    return lowest;
}

/** List all cells of the plan along its curve, so that what visits one after the other need lies
 *  side by side. */
static int order_cells(pl_watch *w) {
    const planish_plan *plan = w->plan;
    int64_t *place = pl_alloc_zero(plan->work.n_nodes + 1, sizeof *place);
    if (!place)
        return 0;
    for (int64_t cell = 0; cell < w->n; cell++)
        place[lowest_node(plan, cell) + 1]++;
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        place[i + 1] += place[i];
    for (int64_t cell = 0; cell < w->n; cell++)
        w->cell[place[lowest_node(plan, cell)]++] = (int32_t)cell;
    pl_free(place);
    return 1;
}

/** Make the watched cells: curved ones, with corners all. */
static int make_cells(search *s) {
    pl_watch *w = s->watch;
    const planish_plan *plan = w->plan;
    const int64_t n_cells = pl_view_cells(&plan->work);
    int64_t n = 0;
    for (int64_t cell = 0; w->is_curved && cell < n_cells; cell++)
        n += w->is_curved[cell];
    w->n = plan->work.corner ? n_cells : n;
    w->cell = pl_alloc(w->n, sizeof *w->cell);
    w->node = plan->work.corner ? pl_alloc(w->n, sizeof *w->node) : NULL;
    w->type = pl_alloc(w->n, sizeof *w->type);
    w->room = pl_alloc(w->n, sizeof *w->room);
    w->state = pl_alloc(w->n, sizeof *w->state);
    w->n_refused_of = pl_alloc(w->n, sizeof *w->n_refused_of);
    w->quality = w->is_curved ? pl_alloc(w->n, sizeof *w->quality) : NULL;
    const int has_floor = plan->work.corner && (plan->work.min_volume || s->min_volume > 0);
    w->floor = has_floor ? pl_alloc(w->n, sizeof *w->floor) : NULL;
    if ((plan->work.corner && !w->node) || !w->cell || !w->type || !w->room || !w->state ||
        !w->n_refused_of || (w->is_curved && !w->quality) || (has_floor && !w->floor))
        return 0;
    n = 0;
    if (plan->work.corner && !order_cells(w))
        return 0;
    for (int64_t cell = 0; !plan->work.corner && cell < n_cells; cell++)
        if (w->is_curved[cell])
            w->cell[n++] = (int32_t)cell;
    pl_parallel_for(plan->threads, w->n, CHUNK, cell_chunk, s);
    return make_lists(s);
}

/** How far a node may stray from where it follows; largest: coordinate of such nodes. */
static double stray_of(const pl_watch *w, const planish_options *options, double largest) {
    for (int64_t i = 0; i < w->plan->work.n_nodes * w->plan->dim; i++)
        largest = fmax(largest, fabs(w->mids.given[i]));
    /* Nodes may go beyond where nodes were, but not far. */
    enum { BEYOND = 4, ROUNDINGS = 8 };
    const double unit = options->precision == PLANISH_PRECISION_DOUBLE ? DBL_EPSILON : FLT_EPSILON;
    return options->precision == PLANISH_PRECISION_ROUNDED ? INFINITY
                                                           : BEYOND * ROUNDINGS * unit * largest;
}

static int create(search *s, const double *given, const double *start, planish_error *error) {
    pl_watch *w = s->watch;
    const planish_plan *plan = w->plan;
    int order_2, status = PLANISH_OK;
    pl_parallel_for(plan->threads, pl_view_cells(&plan->work), CHUNK_NODES, type_chunk, s);
    if (!make_rules(s, &order_2))
        return pl_fail_memory(error, "the elements to be watched");
    if (!order_2 && !plan->work.corner)
        return PLANISH_OK;
    w->mids.given = given;
    if (order_2)
        status = find_curved(s, given, start, error);
    if (status)
        return status;
    w->stray = order_2 ? stray_of(w, s->options, s->largest) : 0;
    w->n_curved = s->n_curved;
    return make_cells(s) ? PLANISH_OK : pl_fail_memory(error, "the elements to be watched");
}

int pl_watch_create(const planish_plan *plan, const planish_options *options, const double *given,
                    const double *start, double min_volume, pl_watch *w, planish_error *error) {
    *w = (pl_watch){.plan = plan,
                    .worst_ar2 = INFINITY,
                    .min_volume = min_volume,
                    .rounding = options->rounding};
    search s = {.watch = w, .options = options, .min_volume = min_volume, .lowest = INT64_MAX};
    if (plan->cells.n == 0)
        return PLANISH_OK;
    const int status = create(&s, given, start, error);
    pl_free(s.is_off);
    return status;
}

static void free_cells(pl_watch *w) {
    pl_free(w->cell);
    pl_free(w->type);
    pl_free(w->node);
    pl_free(w->room);
    pl_free(w->floor);
    pl_free(w->state);
    pl_free(w->n_refused_of);
    pl_free(w->quality);
    pl_free(w->begin);
    pl_free(w->watched);
    w->cell = w->watched = NULL;
    w->node = NULL;
    w->type = w->state = w->n_refused_of = NULL;
    w->room = w->floor = NULL;
    w->quality = NULL;
    w->begin = NULL;
    w->n = 0;
}

int64_t pl_cell_with(const planish_plan *plan, int64_t element) {
    int64_t begin = 0, end = pl_view_cells(&plan->work);
    while (plan->work.corner && end - begin > 1) {
        const int64_t middle = begin + (end - begin) / 2;
        *(pl_first_of_cell(&plan->work, middle) <= element ? &begin : &end) = middle;
    }
    return plan->work.corner ? begin : element;
}

int pl_watch_add(pl_watch *w, int64_t n, const int32_t *element, planish_error *error) {
    search s = {.watch = w, .min_volume = w->min_volume};
    int64_t n_new = 0;
    for (int64_t i = 0; i < n; i++) {
        uint8_t *is_curved = &w->is_curved[pl_cell_with(w->plan, element[i])];
        n_new += !*is_curved;
        *is_curved = 1;
    }
    if (n_new == 0)
        return PLANISH_OK;
    free_cells(w);
    return make_cells(&s) ? PLANISH_OK : pl_fail_memory(error, "the elements to be watched");
}

void pl_watch_destroy(pl_watch *w) {
    if (w->mids.end)
        pl_mids_destroy(&w->mids);
    for (int t = 0; t < PL_WATCH_TYPES; t++)
        pl_free(w->rule[t]);
    pl_free(w->is_curved);
    free_cells(w);
    *w = (pl_watch){.n = 0};
}
