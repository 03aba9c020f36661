/* watch: whether the watched cells are valid: those of a node that has moved, and all of them. */
#include "sweep/watch_cell.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "geometry/simplex.h"
#include "quality/certificate.h"
#include "quality/measure.h"
#include "quality/measure_block.h"

#include <math.h>
#include <string.h>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

enum {
    LANES = PL_JACOBIAN_LANES,
    CHUNK = 256 /* cells that one thread takes at a time */
};

/* ---- after a move --------------------------------------------------------------------------- */

/** Note which of the cells of b, which were not valid or below their floor, are so no more beyond
 *  doubt. */
static void note_valid(pl_watch *w, pl_watch_block *b) {
    if (b->n > 0)
        pl_watch_evaluate(w, b);
    for (int l = 0; l < b->n; l++)
        pl_watch_keep_state(w, b, l,
                            w->state[b->of[l]] & PL_WATCH_VALID ||
                                b->jacobian.least[l] > b->jacobian.error[l]);
    b->n = 0;
}

/** Whether the block has no room for a cell of this rule. */
static int is_full(const pl_watch_block *b, const pl_watch_rule *rule) {
    return b->n == LANES || (b->n > 0 && b->rule != rule);
}

/** Whether a watched cell is below a floor. */
static int is_below(const pl_watch *w, int32_t i) {
    return w->floor && w->floor[i] > 0 && !(w->state[i] & PL_WATCH_ABOVE);
}

void pl_watch_look_again(pl_watch *w, int32_t node) {
    pl_watch_block b;
    b.n = 0;
    for (int64_t k = w->begin[node]; k < w->begin[node + 1]; k++) {
        const int32_t i = w->watched[k];
        const pl_watch_rule *rule = w->rule[w->type[i]];
        if (!rule || (w->state[i] & PL_WATCH_VALID && !is_below(w, i)))
            continue;
        if (is_full(&b, rule))
            note_valid(w, &b);
        b.of[b.n] = i;
        pl_watch_take(w, rule, pl_watch_cell(w, i), 0, &b);
    }
    note_valid(w, &b);
}

int64_t pl_watch_find_refusers(const pl_watch *w, uint8_t *state) {
    enum { REFUSALS = 3 };
    int64_t n = 0;
    pl_watch_block b;
    for (int64_t i = 0; w->plan->work.corner && i < w->n; i++) {
        if (w->n_refused_of[i] < REFUSALS || !w->rule[w->type[i]])
            continue;
        b.n = 0;
        pl_watch_take(w, w->rule[w->type[i]], pl_watch_cell(w, i), 0, &b);
        pl_watch_evaluate(w, &b);
        if (!(b.jacobian.least[0] > b.jacobian.error[0]))
            continue;
        if (state)
            state[w->plan->work.cell_begin[pl_watch_cell(w, i)]] = 1;
        n++;
    }
    return n;
}

/** Corners of solids of a block, in floats. */
typedef float places[LANES][PL_CELL_CORNERS][4];

/** Gather the first n corners of a watched cell, a solid, relative to a place. */
PL_INLINE void gather_corners(const pl_watch *w, int32_t i, int n, const double *origin,
                              float place[PL_CELL_CORNERS][4]) {
    const double *coordinates = w->plan->scratch.coordinates;
    const int32_t *node = w->node[i];
    for (int j = 0; j < n; j++) {
        const double *x = coordinates + (int64_t)node[j] * 3;
#if defined(__SSE2__)
        const __m128d xy = _mm_sub_pd(_mm_loadu_pd(x), _mm_loadu_pd(origin));
        const __m128d z = _mm_sub_sd(_mm_load_sd(x + 2), _mm_load_sd(origin + 2));
        _mm_storeu_ps(place[j], _mm_movelh_ps(_mm_cvtpd_ps(xy), _mm_cvtpd_ps(z)));
#else
        for (int d = 0; d < 3; d++)
            place[j][d] = (float)(x[d] - origin[d]);
#endif
    }
}

/** Spread n corners of all lanes; those past the last cell repeat the first. */
PL_INLINE void spread_corners(places place, int n_cells, int n, float x[][3][LANES]) {
    for (int l = n_cells; l < LANES; l++)
        memcpy(place[l], place[0], sizeof place[l]);
    for (int j = 0; j < n; j++)
#if defined(__SSE2__)
        for (int l = 0; l < LANES; l += 4) {
            __m128 a = _mm_loadu_ps(place[l][j]), b = _mm_loadu_ps(place[l + 1][j]);
            __m128 c = _mm_loadu_ps(place[l + 2][j]), e = _mm_loadu_ps(place[l + 3][j]);
            _MM_TRANSPOSE4_PS(a, b, c, e);
            _mm_storeu_ps(&x[j][0][l], a);
            _mm_storeu_ps(&x[j][1][l], b);
            _mm_storeu_ps(&x[j][2][l], c);
        }
#else
        for (int l = 0; l < LANES; l++)
            for (int d = 0; d < 3; d++)
                x[j][d][l] = place[l][j][d];
#endif
}

/** Hexahedra in a block of floats. */
typedef struct bricks {
    int n;
    int32_t of[LANES]; /* watched cells */
    places place;
    pl_brick_block block;
} bricks;

/** Add a watched hexahedron, relative to a place. */
PL_INLINE void add_brick(const pl_watch *w, int32_t i, const double *origin, bricks *b) {
    const int l = b->n++;
    gather_corners(w, i, 8, origin, b->place[l]);
    b->block.floor[l] = w->floor && w->state[i] & PL_WATCH_ABOVE
                            ? nextafterf((float)(w->floor[i] * 0.125), INFINITY)
                            : 0;
    b->of[l] = i;
}

/** Certify bricks: those that floats certify get their rooms. left [LANES]: the lanes of others;
 *  returns their number. */
static int certify_bricks(pl_watch *w, bricks *b, int left[LANES]) {
    int n = 0;
    for (int l = b->n; l < LANES; l++)
        b->block.floor[l] = 0;
    spread_corners(b->place, b->n, 8, b->block.x);
    pl_bricks_certify(&b->block);
    for (int l = 0; l < b->n; l++) {
        if (b->block.room[l] > 0)
            w->room[b->of[l]] = pl_watch_room_below(b->block.room[l]);
        else
            left[n++] = l;
    }
    b->n = 0;
    return n;
}

/** Watched cells of one type in a block of floats. */
typedef struct floats_block {
    int n;
    int32_t of[LANES];
    places place; /* of linear solids */
    pl_float_block block;
} floats_block;

/** Whether the corners in w->node decide a watched cell that has a type: a hexahedron or wedge. */
static int is_linear_solid(const pl_watch *w, int32_t i) {
    return w->type[i] == PLANISH_CELL_WEDGE || w->type[i] == PLANISH_CELL_HEXAHEDRON;
}

/** Add a watched cell, relative to a place. */
static void add_floats(const pl_watch *w, int32_t i, const double *origin, floats_block *b) {
    const pl_jacobian_rule *rule = &w->rule[w->type[i]]->jacobian;
    const int dim = w->plan->dim, l = b->n++;
    double place[PL_CELL_NODES * 3];
    int32_t node[PL_CELL_NODES];
    b->of[l] = i;
    if (is_linear_solid(w, i)) {
        gather_corners(w, i, rule->n_nodes, origin, b->place[l]);
        b->block.sign[l] = 1;
        return;
    }
    pl_watch_find_places(w, rule, pl_watch_cell(w, i), 0, place, node);
    for (int j = 0; j < rule->n_nodes; j++)
        for (int d = 0; d < dim; d++)
            b->block.x[j][d][l] = (float)(place[j * dim + d] - origin[d]);
    b->block.sign[l] = (float)pl_watch_sign(w, pl_watch_cell(w, i));
}

/** Give the cells that floats certify their rooms; left and the result as of certify_bricks. */
static int certify_floats(pl_watch *w, floats_block *b, int left[LANES]) {
    const pl_watch_rule *rule = w->rule[w->type[b->of[0]]];
    const int dim = w->plan->dim;
    int n = 0;
    const int is_gathered = is_linear_solid(w, b->of[0]);
    if (is_gathered)
        spread_corners(b->place, b->n, rule->jacobian.n_nodes, b->block.x);
    for (int l = b->n; l < LANES; l++) {
        for (int j = 0; j < rule->jacobian.n_nodes && !is_gathered; j++)
            for (int d = 0; d < dim; d++)
                b->block.x[j][d][l] = b->block.x[j][d][0];
        b->block.sign[l] = b->block.sign[0];
    }
    pl_jacobian_bound(&rule->jacobian, rule->is_at_corner, &b->block);
    for (int l = 0; l < b->n; l++) {
        const int32_t i = b->of[l];
        const double floor = w->floor && w->state[i] & PL_WATCH_ABOVE ? w->floor[i] : 0;
        const double room =
            b->block.all[l] > 0 && b->block.inner[l] > floor
                ? pl_watch_room(w, rule, b->block.inner[l] - floor, b->block.longest[l])
                : 0;
        if (room > 0)
            w->room[i] = pl_watch_room_below(room);
        else
            left[n++] = l;
    }
    b->n = 0;
    return n;
}

/** A watched cell that has no room left for a move. */
typedef struct question {
    int32_t cell;
    int move;
} question;

/** Cells that are being decided, and the moves that they ask for. */
typedef struct decision {
    pl_watch *watch;
    pl_watch_move *move;
    bricks bricks;
    floats_block floats;
    pl_watch_block block;
    int of_brick[LANES], of_floats[LANES], of_lane[LANES]; /* the move of each lane */
} decision;

/** Refuse a move for cell i. Of several such cells the first one by types and numbers counts, in
 *  whatever order they are decided. */
static void blame(const pl_watch *w, int32_t i, pl_watch_move *move) {
    const int32_t was = move->refuser;
    if (!move->is_refused || w->type[i] < w->type[was] || (i < was && w->type[i] == w->type[was]))
        move->refuser = i;
    move->is_refused = 1;
}

/** Decide the cells of the block, which were valid, and perhaps above their floor. */
static void decide_block(decision *s) {
    pl_watch *w = s->watch;
    pl_watch_block *b = &s->block;
    if (b->n > 0)
        pl_watch_evaluate(w, b);
    for (int l = 0; l < b->n; l++) {
        const int32_t i = b->of[l];
        const int was = w->state[i], valid = pl_watch_is_lane_valid(b, l);
        pl_watch_keep_state(w, b, l, valid);
        const int is_kept = valid && w->state[i] >= was;
        w->state[i] = (uint8_t)was; /* what is better than it was is noted where the node stays */
        if (!is_kept)
            blame(w, i, &s->move[s->of_lane[l]]);
    }
    b->n = 0;
}

static void add_to_block(decision *s, int32_t i, int move) {
    pl_watch_block *b = &s->block;
    if (b->n == LANES)
        decide_block(s);
    b->of[b->n] = i;
    s->of_lane[b->n] = move;
    pl_watch_take(s->watch, s->watch->rule[s->watch->type[i]], pl_watch_cell(s->watch, i), 0, b);
}

/** Certify the bricks; those that floats do not certify go to the block. */
static void decide_bricks(decision *s) {
    int left[LANES];
    const int n = s->bricks.n > 0 ? certify_bricks(s->watch, &s->bricks, left) : 0;
    for (int k = 0; k < n; k++)
        add_to_block(s, s->bricks.of[left[k]], s->of_brick[left[k]]);
}

/** A place near a cell, from which floats are precise: that of the node that moves; the cell's own where
 *  nodes follow, as cells of these may be a period away. */
static const double *origin_of(const decision *s, int32_t i, int move) {
    const pl_watch *w = s->watch;
    const planish_plan *plan = w->plan;
    int32_t corner[PL_CELL_CORNERS], node = s->move[move].node;
    if (w->follower.offset) {
        pl_plan_cell_corners(plan, pl_watch_cell(w, i), corner);
        node = plan->inner[corner[0]];
    }
    return plan->scratch.coordinates + (int64_t)node * plan->dim;
}

static void add_to_bricks(decision *s, int32_t i, int move) {
    s->of_brick[s->bricks.n] = move;
    add_brick(s->watch, i, origin_of(s, i, move), &s->bricks);
    if (s->bricks.n == LANES)
        decide_bricks(s);
}

/** Certify cells of any type as decide_bricks does hexahedra. */
static void decide_floats(decision *s) {
    int left[LANES];
    const int n = s->floats.n > 0 ? certify_floats(s->watch, &s->floats, left) : 0;
    for (int k = 0; k < n; k++)
        add_to_block(s, s->floats.of[left[k]], s->of_floats[left[k]]);
}

static void add_to_floats(decision *s, int32_t i, int move) {
    s->of_floats[s->floats.n] = move;
    add_floats(s->watch, i, origin_of(s, i, move), &s->floats);
    if (s->floats.n == LANES)
        decide_floats(s);
}

/** Decide the cells of n questions, type by type. */
static void answer(decision *s, const question *of, int n) {
    const pl_watch *w = s->watch;
    for (int type = 1; type < PL_WATCH_TYPES && n > 0; type++) {
        for (int k = 0; w->rule[type] && k < n; k++) {
            const int32_t i = of[k].cell;
            if (w->type[i] != type)
                continue;
            if (is_below(w, i))
                add_to_block(s, i, of[k].move);
            else if (type == PLANISH_CELL_HEXAHEDRON)
                add_to_bricks(s, i, of[k].move);
            else
                add_to_floats(s, i, of[k].move);
        }
        decide_bricks(s);
        decide_floats(s);
        decide_block(s);
    }
}

/** Decide those cells of n questions that were valid, and note the moves of those that were not, or
 *  below their floor. */
static void ask(decision *s, question *of, int n) {
    const pl_watch *w = s->watch;
    int n_valid = 0;
    for (int k = 0; k < n; k++) {
        const int32_t i = of[k].cell;
        const int is_valid = w->state[i] & PL_WATCH_VALID;
        s->move[of[k].move].has_others |= !is_valid || is_below(w, i);
        if (is_valid)
            of[n_valid++] = of[k];
    }
    answer(s, of, n_valid);
}

void pl_watch_decide_all(pl_watch *w, int n, const int32_t cell[], uint8_t is_valid[]) {
    question of[PL_WATCH_CELLS];
    pl_watch_move move[PL_WATCH_CELLS];
    decision s;
    if (n <= 0)
        return;
    s.watch = w;
    s.move = move;
    s.bricks.n = s.floats.n = s.block.n = 0;
    for (int k = 0; k < n; k++) {
        of[k] = (question){cell[k], k};
        move[k] = (pl_watch_move){.node = w->node[cell[k]][0], .refuser = -1};
    }
    answer(&s, of, n);
    for (int k = 0; k < n; k++)
        is_valid[k] = !move[k].is_refused;
}

/** Ask for what the decision of a watched cell begins with. */
PL_AT_ONCE void fetch_cell(const pl_watch *w, int32_t i) {
    __builtin_prefetch(&w->state[i]);
    __builtin_prefetch(&w->type[i]);
    if (w->node)
        __builtin_prefetch(w->node[i]);
}

void pl_watch_judge(pl_watch *w, int n, pl_watch_move move[]) {
    enum { QUESTIONS = 256 };
    question of[QUESTIONS];
    decision s;
    int n_of = 0;
    s.watch = w;
    s.move = move;
    s.bricks.n = s.floats.n = s.block.n = 0;
    for (int m = 0; m < n; m++) {
        const int64_t end = w->begin[move[m].node + 1];
        int64_t k = w->begin[move[m].node];
        move[m].has_others = 0;
        move[m].refuser = -1;
        if (n_of > 0 && end - k > QUESTIONS - n_of) {
            ask(&s, of, n_of);
            n_of = 0;
        }
        for (; !move[m].is_refused && k < end; k++) {
            const int32_t i = w->watched[k];
            if (w->late.is_on && w->late.when[i] == PL_WATCH_WAITS)
                continue;
            const double room = w->room[i] - move[m].way;
            if (room == INFINITY) /* nor have those after it a type */
                break;
            if (room > 0) {
                w->room[i] = pl_watch_room_below(room);
                continue;
            }
            fetch_cell(w, i);
            of[n_of++] = (question){i, m};
            if (n_of == QUESTIONS) {
                ask(&s, of, n_of);
                n_of = 0;
            }
        }
    }
    if (n_of > 0)
        ask(&s, of, n_of);
    for (int m = 0; m < n; m++) {
        const int32_t refuser = move[m].refuser;
        if (refuser >= 0 && w->n_refused_of[refuser] < UINT8_MAX)
            w->n_refused_of[refuser]++;
        if (move[m].is_refused) /* the node goes back */
            pl_watch_forget(w, move[m].node);
        else if (move[m].has_others)
            pl_watch_look_again(w, move[m].node);
    }
}

int pl_watch_admit(pl_watch *w, int32_t node, double way) {
    pl_watch_move move = {.node = node, .way = way};
    pl_watch_judge(w, 1, &move);
    return !move.is_refused;
}

void pl_watch_forget(pl_watch *w, int32_t node) {
    for (int64_t k = w->begin[node]; k < w->begin[node + 1]; k++)
        w->room[w->watched[k]] = w->type[w->watched[k]] ? 0 : INFINITY;
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

/** Bring edges [dim][dim] to a size of about 1; return the exponent of the power of two by which they were
 *  larger. */
static int scale_edges(int dim, double edge[3][3]) {
    double size = 0;
    int exponent = 0;
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            size = pl_larger(fabs(edge[j][d]), size);
    if (size > 0x1p-60 && size < 0x1p60) /* a power of two changes no bit of what is found */
        return 0;
    frexp(size, &exponent);
    exponent = pl_scale_exponent(exponent);
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edge[j][d] = ldexp(edge[j][d], -exponent);
    return exponent;
}

/** Find the edges of corner c of a cell with corners x, in a size of about 1. */
static void edges_of_corner(const pl_cell_shape *shape, const double *const x[], int c,
                            double edge[3][3]) {
    for (int j = 0; j < shape->dim; j++)
        pl_subtract(shape->dim, x[shape->neighbour[c][j]], x[c], edge[j]);
    scale_edges(shape->dim, edge);
}

/** Find the edges of an element of the plan. */
PL_INLINE void edges_of_element(const planish_plan *plan, int64_t element, double edge[3][3],
                                const int dim) {
    const double *x[4] = {NULL};
    for (int j = 0; j <= dim; j++)
        x[j] = plan->scratch.coordinates + (int64_t)pl_plan_inner(plan, element, j) * dim;
    pl_edges(dim, x, edge);
}

/** +1 or -1: the sign of the determinant that the element has if it is valid. */
static double sign_of(const planish_plan *plan, int64_t element) {
    return plan->work.sign ? plan->work.sign[element] : 1;
}

/** E of an element of the plan, a corner with a target, from its edges. */
PL_INLINE double target_energy(const planish_plan *plan, int64_t element, const double edge[3][3],
                               const int dim) {
    const double *v = plan->work.target[element].v;
    return plan->work.metric ? pl_target_energy_in(dim, edge, v, plan->work.metric[element].l)
                             : pl_target_energy(dim, edge, v);
}

/** Return the square that an element of the plan, a corner with a target, adds; infinite where it is not
 *  positive. */
static double target_square(const planish_plan *plan, int64_t element) {
    const int dim = plan->dim;
    const pl_target *target = &plan->work.target[element];
    double edge[3][3] = {{0}};
    edges_of_element(plan, element, edge, dim);
    const int exponent = scale_edges(dim, edge);
    const double unit = exponent == 0 ? target->unit : ldexp(target->unit, dim * exponent);
    const double D =
        sign_of(plan, element) * pl_determinant_of_edges(dim, (const double(*)[3])edge);
    const double energy = target_energy(plan, element, (const double(*)[3])edge, dim);
    return D > 0 ? pl_target_square(dim, energy, D, unit, plan->work.size_weight) : INFINITY;
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

/** The most that E^dim of a corner may be for a mu^2 within limit, in units of D^2 of the ideal corner. */
PL_INLINE double most_energy(double limit, const int dim) {
    return (1 - 1e-9) * (dim == 3 ? 27 * limit * sqrt(limit) : 4 * limit);
}

/** Whether a corner with E = e and D = d is beyond doubt within what most_energy is for; most: in units of
 *  its own D^2. */
PL_INLINE int is_within(double e, double d, double most, const int dim) {
    static const double SMALL = 1e-280, LARGE = 1e280;
    const double power = dim == 3 ? e * e * e : e * e, bound = most * (d * d);
    return d > 0 && power <= bound && power > SMALL && bound < LARGE;
}

/** Whether a corner of a cell with corners x may have a mu^2 above limit. */
PL_INLINE int may_exceed(const pl_cell_shape *shape, const double *const x[], double sign,
                         double limit, const int dim) {
    const double most = most_energy(limit, dim) / (shape->determinant * shape->determinant);
    for (int c = 0; c < shape->n_measured; c++) {
        double edge[3][3], e = 0;
        for (int j = 0; j < dim; j++) {
            pl_subtract(dim, x[shape->neighbour[c][j]], x[c], edge[j]);
            e += shape->to_corner[j] * pl_dot(dim, edge[j], edge[j]);
        }
        for (int i = 0, pair = 0; i < dim; i++)
            for (int j = i + 1; j < dim; j++, pair++)
                if (shape->between[pair] != 0) {
                    double apart[3];
                    pl_subtract(dim, edge[j], edge[i], apart);
                    e += shape->between[pair] * pl_dot(dim, apart, apart);
                }
        if (!is_within(e, sign * pl_determinant_of_edges(dim, edge), most, dim))
            return 1;
    }
    return 0;
}

/** Whether one of elements begin .. end - 1 of the plan, corners with targets, may have a mu^2 above
 *  limit. */
PL_INLINE int targets_may_exceed(const planish_plan *plan, int64_t begin, int64_t end, double limit,
                                 const int dim) {
    const double most = most_energy(limit, dim);
    for (int64_t e = begin; e < end; e++) {
        double edge[3][3];
        edges_of_element(plan, e, edge, dim);
        const double energy = target_energy(plan, e, (const double(*)[3])edge, dim);
        if (!is_within(energy, sign_of(plan, e) * pl_determinant_of_edges(dim, edge), most, dim))
            return 1;
    }
    return 0;
}

/** Raise worst to the ratios of a watched cell whose corners have targets, if one is above limit. */
static void raise_by_targets(const pl_watch *w, int32_t i, double limit, pl_worst_cell *worst) {
    const pl_view *work = &w->plan->work;
    const int64_t cell = pl_watch_cell(w, i);
    const int64_t begin = work->cell_begin[cell], end = work->cell_begin[cell + 1];
    double sum = 0;
    if (limit > 0 && work->size_weight == 0 &&
        !(work->dim == 3 ? targets_may_exceed(w->plan, begin, end, limit, 3)
                         : targets_may_exceed(w->plan, begin, end, limit, 2)))
        return;
    for (int64_t e = begin; e < end; e++) {
        const double mu2 = target_square(w->plan, e);
        sum += mu2;
        worst->mu2 = pl_larger(mu2, worst->mu2);
    }
    worst->ar2 = pl_larger(sum / (double)(end - begin), worst->ar2);
}

/** Raise worst to the measures of a watched cell, if a corner's mu^2 is above limit. */
static void raise_worst(const pl_watch *w, int32_t i, double limit, pl_worst_cell *worst) {
    const pl_cell_shape *shape = shape_of(w, i);
    const double *x[PL_CELL_CORNERS];
    const int is_turned = shape->n_corners == 8 || shape->n_corners == 6;
    if (w->plan->work.target) {
        raise_by_targets(w, i, limit, worst);
        return;
    }
    const double sign = is_turned ? 1 : pl_watch_sign(w, pl_watch_cell(w, i));
    double sum = 0;
    for (int j = 0; j < shape->n_corners; j++)
        x[j] = w->plan->scratch.coordinates + (int64_t)w->node[i][j] * shape->dim;
    if (limit > 0 && !(shape->dim == 3 ? may_exceed(shape, x, sign, limit, 3)
                                       : may_exceed(shape, x, sign, limit, 2)))
        return;
    for (int c = 0; c < shape->n_measured; c++) {
        double mu2, jacobian2;
        measure_corner(shape, x, c, sign, &mu2, &jacobian2);
        sum += mu2;
        worst->acuteness = pl_larger(1 / jacobian2, worst->acuteness);
        worst->mu2 = pl_larger(mu2, worst->mu2);
    }
    worst->ar2 = pl_larger(sum / shape->n_measured, worst->ar2);
}

void pl_watch_limit(pl_watch *watch, double worst_ar2) {
    const planish_plan *plan = watch->plan;
    const pl_view all = pl_view_of_all_elements(&plan->work);
    const int corners = plan->dim + 1;
    watch->worst_ar2 = worst_ar2;
    if (!(worst_ar2 < INFINITY) || watch->n == 0)
        return;
    if (!watch->has_large)
        watch->has_large = pl_alloc(plan->work.n_nodes + plan->n_images, 1);
    uint8_t *state = pl_alloc(all.n_elements, 1);
    if (!watch->has_large || !state) { /* the run fails in the end */
        pl_free(state);
        return;
    }
    memset(watch->has_large, 0, (size_t)(plan->work.n_nodes + plan->n_images));
    pl_find_worse_corners(&all, plan->scratch.to_measure, sqrt(worst_ar2), INFINITY, INFINITY,
                          plan->threads, state);
    for (int64_t c = 0; c < pl_view_cells(&all); c++) {
        const int64_t first = pl_first_of_cell(&all, c), end = pl_first_of_cell(&all, c + 1);
        int any = 0;
        for (int64_t i = first; i < end; i++)
            any |= state[i] != 0;
        for (int64_t i = first * corners; any && i < end * corners; i++)
            watch->has_large[plan->inner[all.elements[i]]] = 1;
    }
    pl_free(state);
}

pl_worst_cell pl_watch_worst(const pl_watch *w, int32_t node, double mu2) {
    pl_worst_cell worst = {0, 0, 0};
    for (int64_t k = w->begin[node]; k < w->begin[node + 1]; k++)
        raise_worst(w, w->watched[k], mu2, &worst);
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
        positive = pl_measure_sign(plan->dim, vertex) * pl_watch_sign(w, cell) > 0;
    }
    return positive;
}

/** Counts of a chunk of cells: invalid ones with positive corners; valid ones without. */
typedef struct measured {
    int64_t n, n_turned;
} measured;

/** Least coefficient over the mean of lane l, of simplices of order 2; of others infinite. */
static float quality_of(const pl_watch_block *b, int l) {
    const pl_cell_type *type = b->rule->jacobian.type;
    if (type->order == 1 || type->shape->n_simplices > 1)
        return INFINITY;
    const double mean = b->jacobian.mean[l];
    return mean > 0 ? (float)(b->jacobian.least[l] / mean) : -INFINITY;
}

/** Keep the states of the block's cells. */
static void measure_block(pl_watch *w, pl_watch_block *b, measured *m) {
    if (b->n > 0)
        pl_watch_evaluate(w, b);
    for (int l = 0; l < b->n; l++) {
        const int valid = pl_watch_is_lane_valid(b, l);
        pl_watch_keep_state(w, b, l, valid);
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
    const int is_float = is_brick || (type == PLANISH_CELL_WEDGE && !w->floor);
    int left[LANES];
    bricks h;
    floats_block f;
    pl_watch_block b;
    h.n = f.n = b.n = 0;
    for (int64_t i = begin; i <= end; i++) {
        if (i < end && w->type[i] != type)
            continue;
        int n_left = i < end && !is_float;
        left[0] = 0;
        h.of[0] = n_left ? (int32_t)i : h.of[0];
        if (i < end)
            w->state[i] = PL_WATCH_VALID;
        if (i < end && is_float) {
            const double *origin = w->plan->scratch.coordinates + (int64_t)w->node[i][0] * 3;
            if (is_brick)
                add_brick(w, (int32_t)i, origin, &h);
            else
                add_floats(w, (int32_t)i, origin, &f);
        }
        if (h.n == LANES || (i == end && h.n > 0))
            n_left = certify_bricks(w, &h, left);
        else if (f.n == LANES || (i == end && f.n > 0))
            n_left = certify_floats(w, &f, left);
        for (int l = 0; l < n_left; l++) {
            const int32_t of = is_float && !is_brick ? f.of[left[l]] : h.of[left[l]];
            if (b.n == LANES)
                measure_block(w, &b, m);
            b.of[b.n] = of;
            pl_watch_take(w, w->rule[type], pl_watch_cell(w, of), 0, &b);
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
    const int64_t of_caller = pl_plan_given_cell(plan, cell);
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
    return pl_larger(PL_STRAIGHT * longest, w->rounding) + w->stray;
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
    return is_plain(rule, pl_watch_sign(w, cell) * pl_determinant_of_edges(dim, edges), longest,
                    off_of(w, start, dim + 1, dim));
}

/** Whether the corners alone say that a straight cell is valid. */
static int is_plain_cell(const pl_watch *w, const pl_watch_rule *linear,
                         const pl_jacobian_rule *rule, int64_t cell, pl_watch_block *b) {
    int32_t corner[PL_CELL_CORNERS];
    const double *start[PL_CELL_CORNERS];
    const int n = pl_plan_cell_corners(w->plan, cell, corner), dim = w->plan->dim;
    for (int j = 0; j < n; j++)
        start[j] = w->mids.given + (int64_t)corner[j] * dim;
    b->n = 0;
    pl_watch_take(w, linear, cell, 0, b);
    pl_watch_evaluate(w, b);
    const double least = b->jacobian.least[0] - b->jacobian.error[0];
    return b->exponent[0] == 0 &&
           is_plain(rule, least / linear->jacobian.common,
                    pl_watch_longest(&linear->jacobian, b, 0, dim), off_of(w, start, n, dim));
}

static int is_valid_alone(const pl_watch *w, const pl_watch_rule *rule, int64_t cell, int at_start,
                          pl_watch_block *b) {
    b->n = 0;
    pl_watch_take(w, rule, cell, at_start, b);
    pl_watch_evaluate(w, b);
    return pl_watch_is_lane_valid(b, 0);
}

/** Whether corners of a cell were positive and are not any more. */
static int has_turned(const pl_watch *w, int64_t cell) {
    return !has_positive_corners(w, cell, 0) && has_positive_corners(w, cell, 1);
}

pl_validity pl_watch_decide(const pl_watch *w, int64_t cell) {
    const pl_watch_rule *rule = w->rule[pl_plan_cell_type(w->plan, cell)->type];
    pl_watch_block b;
    if (!rule)
        return has_positive_corners(w, cell, 0) ? PL_VALID : PL_INVALID;
    b.n = 0;
    pl_watch_take(w, rule, cell, 0, &b);
    pl_watch_evaluate(w, &b);
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
static int64_t mark_broken(look *s, pl_watch_block *b) {
    const pl_watch *w = s->watch;
    pl_watch_block alone;
    int64_t n = 0;
    if (b->n > 0)
        pl_watch_evaluate(w, b);
    for (int l = 0; l < b->n; l++)
        if (!pl_watch_is_lane_valid(b, l) && (is_valid_alone(w, b->rule, b->of[l], 1, &alone) ||
                                              is_valid_alone(w, b->rule, b->of[l], 2, &alone) ||
                                              (s->of_all && has_turned(w, b->of[l])))) {
            mark(s, b->of[l]);
            n++;
        }
    b->n = 0;
    return n;
}

/** The rule that decides a cell as it is, or NULL: its corners do, and say (or are not asked) that it
 *  is valid. */
static const pl_watch_rule *rule_of(const look *s, int64_t cell, pl_watch_block *room) {
    const pl_watch *w = s->watch;
    const pl_cell_type *type = pl_plan_cell_type(w->plan, cell);
    const pl_watch_rule *own = w->rule[type->type];
    const int dim = type->shape->dim;
    if (type->order == 1 || !own || w->is_curved[cell])
        return own;
    if (type->shape->n_simplices == 1)
        return (dim == 3 ? is_plain_simplex(w, &own->jacobian, cell, 3)
                         : is_plain_simplex(w, &own->jacobian, cell, 2))
                   ? NULL
                   : own;
    return is_plain_cell(w, w->rule[pl_linear_type(type->shape)->type], &own->jacobian, cell, room)
               ? NULL
               : own;
}

static void broken_chunk(void *context, int64_t begin, int64_t end, int thread) {
    look *s = context;
    const pl_watch *w = s->watch;
    int64_t n = 0;
    pl_watch_block b, room;
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
            pl_watch_take(w, rule, cell, 0, &b);
        } else if (s->of_all && pl_plan_cell_type(w->plan, cell)->order == 1 &&
                   has_turned(w, cell)) {
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
