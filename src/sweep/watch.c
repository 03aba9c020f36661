/* watch: which elements are watched, and whether they are valid. */
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
    NODES = 10,        /* most nodes of a simplex of order 2 */
    CHUNK = 256,       /* elements that one thread takes at a time, */
    CHUNK_NODES = 4096 /* or nodes */
};

/* An edge is straight if its mid is no farther off than this, in longest edges (cell_measure.c). */
static const double STRAIGHT = 1e-6;

/* Elements whose size is in this range are decided as they are, others scaled by a power of two. */
static const double SMALL = 0x1p-40, LARGE = 0x1p40;

/** Elements whose validity is asked for, one per lane. */
typedef struct block {
    int n;
    double x[LANES][NODES * 3]; /* [n_nodes][dim] */
    int32_t node[LANES][NODES]; /* places in x; -1: a missing mid */
    double sign[LANES];
    int exponent[LANES]; /* of the scale */
    pl_jacobian_block jacobian;
} block;

/* ---- places --------------------------------------------------------------------------------- */

static double sign_of(const pl_watch *c, int64_t element) {
    return c->plan->work.sign ? c->plan->work.sign[element] : 1;
}

static int is_order_2(const pl_watch *c, int64_t element) {
    return c->plan->cells.type[pl_plan_element(c->plan, element)] == c->rule->type->type;
}

/** Find the places of the nodes of an element, as they are or (at_start) were when the run began:
 *  x [n_nodes][dim]. node: see block. */
static void find_places(const pl_watch *c, int64_t element, int at_start, double *x,
                        int32_t *node) {
    const planish_plan *plan = c->plan;
    const int dim = plan->dim, corners = dim + 1;
    const int32_t *corner = plan->work.elements + element * corners;
    const int32_t *of_cell = plan->cells.node + plan->cells.offset[pl_plan_element(plan, element)];
    double way[4][3];
    for (int j = 0; j < corners; j++) {
        const double *from = c->mids.given + (int64_t)corner[j] * dim;
        const double *to =
            at_start ? from : plan->scratch.coordinates + (int64_t)plan->inner[corner[j]] * dim;
        node[j] = j;
        for (int d = 0; d < dim; d++) {
            x[j * dim + d] = to[d];
            way[j][d] = to[d] - from[d];
        }
    }
    for (int i = corners; i < c->rule->n_nodes; i++) {
        const int p = c->rule->type->between[i][0], q = c->rule->type->between[i][1];
        node[i] = of_cell[i] >= 0 ? i : -1;
        for (int d = 0; d < dim; d++)
            x[i * dim + d] = node[i] < 0 ? 0.5 * x[p * dim + d] + 0.5 * x[q * dim + d]
                             : at_start
                                 ? c->mids.start.x[pl_point_at(&c->mids.start, of_cell[i], d)]
                                 : pl_mid_coordinate(&c->mids, of_cell[i], d, way[p][d], way[q][d]);
    }
}

/** Add an element to the block. */
static void add(const pl_watch *c, int64_t element, int at_start, block *b) {
    const int dim = c->plan->dim, l = b->n++, n = c->rule->n_nodes;
    double *x = b->x[l], size = 0;
    find_places(c, element, at_start, x, b->node[l]);
    b->sign[l] = sign_of(c, element);
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

/** Evaluate the block. Lanes past the last element repeat the first. */
static void evaluate(const pl_watch *c, block *b) {
    const int dim = c->plan->dim;
    for (int l = b->n; l < LANES; l++) {
        b->sign[l] = b->sign[0];
        for (int i = 0; i < c->rule->n_nodes; i++)
            for (int d = 0; d < dim; d++)
                b->jacobian.x[i][d][l] = b->jacobian.x[i][d][0];
    }
    pl_jacobian_evaluate(c->rule, b->sign, &b->jacobian);
}

static int is_valid(const pl_watch *c, const block *b, int l) {
    return pl_validity_of_lane(c->rule, &b->jacobian, l, b->node[l], b->x[l], b->sign[l]) ==
           PL_VALID;
}

/* ---- bounds --------------------------------------------------------------------------------- */

/** Longest derivative of lane l along any edge. */
static double reach_of(const pl_watch *c, const block *b, int l) {
    const pl_jacobian_rule *rule = c->rule;
    const int dim = c->plan->dim;
    double control[NODES][3] = {{0}}, longest = 0;
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
                longest = fmax(longest, pl_distance(dim, control[of->plus],
                                                    control[rule->derivative[j][i].plus]));
        }
    return longest;
}

/** Keep the bounds of a curved element, which is valid and in lane l. They tell nothing of one that
 *  was scaled, or that bisections have decided. */
static void keep_bounds(pl_watch *c, int32_t w, const block *b, int l) {
    const double least = b->jacobian.least[l] - b->jacobian.error[l];
    c->bound[w] = least > 0 && b->exponent[l] == 0 ? least : 0;
    c->reach[w] = reach_of(c, b, l);
}

/** Whether the bounds alone admit a move of a corner by length: they are lowered by it. Where the
 *  weights of each control add up to w (the first control is w times the first corner), the controls
 *  of the corner and of the edges at it change by w and w / 2 times the move, so that a derivative
 *  changes by w / 2 of it, and by what mids stray. det is linear in each of its columns, and at most
 *  the product of their lengths. Along edges of which only one is at the corner a move changes one
 *  column; mids that stray change all. */
static int bound_admits(pl_watch *c, int32_t w, double length) {
    const int dim = c->plan->dim;
    const double moved = 0.5 * c->rule->control_term[0].weight * length;
    const double strayed = 2 * c->rule->control_weight * c->stray;
    const double reach = c->reach[w] + moved + strayed;
    const double less =
        1.0001 * c->rule->common * (moved + dim * strayed) * reach * (dim == 3 ? reach : 1);
    if (!(less < c->bound[w]))
        return 0;
    c->bound[w] -= less;
    c->reach[w] = reach;
    return 1;
}

/* ---- after a move --------------------------------------------------------------------------- */

/** Decide the elements of b, curved elements w [b->n] that were valid; 0 if one is not. */
static int keep_valid(pl_watch *c, block *b, const int32_t *w) {
    if (b->n > 0)
        evaluate(c, b);
    for (int l = 0; l < b->n; l++) {
        if (!is_valid(c, b, l))
            return 0;
        keep_bounds(c, w[l], b, l);
    }
    b->n = 0;
    return 1;
}

/** Note which of the elements of b, curved elements w [b->n] that were not valid, are beyond doubt
 *  now. */
static void note_valid(pl_watch *c, block *b, const int32_t *w) {
    if (b->n > 0)
        evaluate(c, b);
    for (int l = 0; l < b->n; l++) {
        keep_bounds(c, w[l], b, l);
        c->is_valid[w[l]] = b->jacobian.least[l] > b->jacobian.error[l];
    }
    b->n = 0;
}

/** Look again at the curved elements at node that were not valid. */
static void look_again(pl_watch *c, int32_t node, block *b) {
    int32_t w[LANES];
    b->n = 0;
    for (int64_t k = c->begin[node]; k < c->begin[node + 1]; k++) {
        if (c->is_valid[c->watched[k]])
            continue;
        w[b->n] = c->watched[k];
        add(c, c->element[c->watched[k]], 0, b);
        if (b->n == LANES)
            note_valid(c, b, w);
    }
    note_valid(c, b, w);
}

int pl_watch_admit(pl_watch *c, int32_t node, const double *way) {
    static const double origin[3] = {0, 0, 0};
    const double length = pl_distance(c->plan->dim, way, origin);
    int32_t w[LANES];
    block b;
    int is_fine = 1;
    b.n = 0;
    for (int64_t k = c->begin[node]; k < c->begin[node + 1] && is_fine; k++) {
        if (!c->is_valid[c->watched[k]] || bound_admits(c, c->watched[k], length))
            continue;
        w[b.n] = c->watched[k];
        add(c, c->element[c->watched[k]], 0, &b);
        if (b.n == LANES)
            is_fine = keep_valid(c, &b, w);
    }
    is_fine = is_fine && keep_valid(c, &b, w);
    for (int64_t k = c->begin[node]; k < c->begin[node + 1] && !is_fine; k++)
        c->bound[c->watched[k]] = 0; /* the node goes back */
    if (is_fine)
        look_again(c, node, &b);
    return is_fine;
}

/* ---- all of them ---------------------------------------------------------------------------- */

/** A look at all curved elements, or at all elements. */
typedef struct look {
    pl_watch *curved;
    uint8_t *state;
    int64_t n;  /* found; shared */
    int of_all; /* elements of order 1, too, and corners that have turned */
} look;

/** Exact sign of the corners of an element. */
static int has_positive_corners(const pl_watch *c, int64_t element, int at_start) {
    const planish_plan *plan = c->plan;
    const double *vertex[4];
    for (int j = 0; j <= plan->dim; j++) {
        const int32_t node = plan->work.elements[element * (plan->dim + 1) + j];
        vertex[j] = at_start ? c->mids.given + (int64_t)node * plan->dim
                             : plan->scratch.coordinates + (int64_t)plan->inner[node] * plan->dim;
    }
    return pl_measure_sign(plan->dim, vertex) * sign_of(c, element) > 0;
}

static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    look *s = context;
    pl_watch *c = s->curved;
    int64_t n = 0, n_turned = 0;
    block b;
    (void)thread;
    for (int64_t w = begin; w < end; w += LANES) {
        b.n = 0;
        for (int64_t i = w; i < end && i < w + LANES; i++)
            add(c, c->element[i], 0, &b);
        evaluate(c, &b);
        for (int l = 0; l < b.n; l++) {
            const int32_t i = (int32_t)w + l;
            c->is_valid[i] = (uint8_t)is_valid(c, &b, l);
            keep_bounds(c, i, &b, l);
            const int is_positive = has_positive_corners(c, c->element[i], 0);
            n += !c->is_valid[i] && is_positive;
            n_turned += c->is_valid[i] && !is_positive;
        }
    }
    __atomic_fetch_add(&s->n, n, __ATOMIC_RELAXED);
    __atomic_fetch_add(&c->n_turned, n_turned, __ATOMIC_RELAXED);
}

int64_t pl_watch_measure(pl_watch *c) {
    look s = {.curved = c};
    c->n_turned = 0;
    if (c->n > 0)
        pl_parallel_for(c->plan->threads, c->n, CHUNK, measure_chunk, &s);
    return s.n;
}

static int has_moved(const pl_watch *c, int64_t element) {
    const planish_plan *plan = c->plan;
    const size_t size = (size_t)plan->dim * sizeof(double);
    for (int j = 0; j <= plan->dim; j++) {
        const int64_t node = plan->work.elements[element * (plan->dim + 1) + j];
        if (memcmp(plan->scratch.coordinates + (int64_t)plan->inner[node] * plan->dim,
                   c->mids.given + node * plan->dim, size) != 0)
            return 1;
    }
    const int64_t cell = pl_plan_element(plan, element);
    for (int64_t k = plan->cells.offset[cell]; c->mids.own && k < plan->cells.offset[cell + 1]; k++)
        if (plan->cells.node[k] >= 0 && pl_mid_has_moved(&c->mids, plan->cells.node[k]))
            return 1;
    return 0;
}

/** Whether the corners alone say that an element which is not curved is valid: its coefficients are
 *  those of the straight one, but for mids that are off by rounding. */
PL_INLINE int is_plainly_valid(const pl_watch *c, int64_t element, const int dim) {
    const planish_plan *plan = c->plan;
    const double scale = 0.5 * c->rule->control_term[0].weight;
    const double *vertex[4], *start[4];
    double edges[3][3], longest = 0, longest_at_start = 0;
    if (c->is_curved[element])
        return 0;
    for (int j = 0; j <= dim; j++) {
        const int64_t node = plan->work.elements[element * (dim + 1) + j];
        vertex[j] = plan->scratch.coordinates + (int64_t)plan->inner[node] * dim;
        start[j] = c->mids.given + node * dim;
        for (int k = 0; k < j; k++) {
            longest = pl_larger(pl_distance(dim, vertex[j], vertex[k]), longest);
            longest_at_start = pl_larger(pl_distance(dim, start[j], start[k]), longest_at_start);
        }
    }
    pl_edges(dim, vertex, edges);
    /* Mids keep how far they are off, also where the element has become smaller. */
    const double off = pl_larger(STRAIGHT * longest_at_start, c->rounding) + c->stray;
    const double strayed = 2 * c->rule->control_weight * off, reach = scale * longest + strayed;
    const double determinant = sign_of(c, element) * pl_determinant_of_edges(dim, edges);
    return scale * scale * (dim == 3 ? scale : 1) * determinant >
           1.0001 * dim * strayed * reach * (dim == 3 ? reach : 1);
}

static int is_valid_alone(const pl_watch *c, int64_t element, int at_start, block *b) {
    b->n = 0;
    add(c, element, at_start, b);
    evaluate(c, b);
    return is_valid(c, b, 0);
}

/** Whether corners of an element were positive and are not any more. */
static int has_turned(const pl_watch *c, int64_t element) {
    return !has_positive_corners(c, element, 0) && has_positive_corners(c, element, 1);
}

/** Mark elements [n] of b that are not valid and were. */
static int64_t mark_broken(look *s, block *b, const int64_t *element) {
    block alone;
    int64_t n = 0;
    if (b->n > 0)
        evaluate(s->curved, b);
    for (int l = 0; l < b->n; l++)
        if (!is_valid(s->curved, b, l) && (is_valid_alone(s->curved, element[l], 1, &alone) ||
                                           (s->of_all && has_turned(s->curved, element[l])))) {
            s->state[element[l]] = 1;
            n++;
        }
    b->n = 0;
    return n;
}

static void broken_chunk(void *context, int64_t begin, int64_t end, int thread) {
    look *s = context;
    const pl_watch *c = s->curved;
    int64_t element[LANES], n = 0;
    block b;
    (void)thread;
    b.n = 0;
    for (int64_t e = begin; e < end; e++) {
        if ((is_order_2(c, e) &&
             (c->plan->dim == 3 ? is_plainly_valid(c, e, 3) : is_plainly_valid(c, e, 2))) ||
            !has_moved(c, e))
            continue;
        if (is_order_2(c, e)) {
            element[b.n] = e;
            add(c, e, 0, &b);
        } else if (s->of_all && has_turned(c, e)) {
            s->state[e] = 1;
            n++;
        }
        if (b.n == LANES)
            n += mark_broken(s, &b, element);
    }
    n += mark_broken(s, &b, element);
    __atomic_fetch_add(&s->n, n, __ATOMIC_RELAXED);
}

int64_t pl_watch_find_broken(const pl_watch *c, int of_all, uint8_t *state) {
    look s = {.curved = (pl_watch *)(uintptr_t)c, .state = state, .of_all = of_all};
    pl_parallel_for(c->plan->threads, c->plan->work.n_elements, CHUNK, broken_chunk, &s);
    return s.n;
}

/* ---- the beginning -------------------------------------------------------------------------- */

/** A search for curved elements. */
typedef struct search {
    pl_watch *curved;
    uint8_t *is_off; /* [nodes of the mesh] mids that are off the middle of their edge */
    int64_t n;       /* curved elements; shared, as are these: */
    int64_t lowest;  /* mid that is not finite, or INT64_MAX */
    double largest;  /* coordinate of mids, absolute */
} search;

/** Find by how much a mid is off the middle of a and b, and the length of that edge: squares. */
PL_INLINE void measure_mid(const pl_mids *mids, int32_t node, const double *a, const double *b,
                           double *off, double *edge, const int dim) {
    *off = *edge = 0;
    for (int d = 0; d < dim; d++) {
        const double x = pl_mid_coordinate(mids, node, d, 0, 0) - (0.5 * a[d] + 0.5 * b[d]);
        *off += x * x;
        *edge += (b[d] - a[d]) * (b[d] - a[d]);
    }
}

static int is_off(const pl_watch *c, double off, double longest) {
    return off > STRAIGHT * STRAIGHT * longest && off > c->rounding * c->rounding;
}

/** Find the mids that are off by more than a part of their own edge. */
static void mids_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    const pl_mids *m = &s->curved->mids;
    const int dim = m->start.dim;
    int64_t lowest = INT64_MAX;
    double largest = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double off, edge;
        s->is_off[i] = 0;
        if (m->end[i][0] < 0)
            continue;
        measure_mid(m, (int32_t)i, m->given + (int64_t)m->end[i][0] * dim,
                    m->given + (int64_t)m->end[i][1] * dim, &off, &edge, dim);
        /* Of a mid of several edges any may be noted: its elements decide each by its own. */
        s->is_off[i] = is_off(s->curved, off, edge) || m->plan->role[i] & PL_OF_EDGES;
        for (int d = 0; d < dim; d++) {
            const double x = pl_mid_coordinate(m, (int32_t)i, d, 0, 0);
            largest = pl_larger(fabs(x), largest);
            if (!isfinite(x) && i < lowest)
                lowest = i;
        }
    }
    pl_raise_double(&s->largest, largest);
    pl_lower_to(&s->lowest, lowest);
}

/** Whether a mid of the element is off by more than a part of its longest edge. */
static int is_element_curved(const search *s, int64_t element) {
    const pl_watch *c = s->curved;
    const planish_plan *plan = c->plan;
    const int dim = plan->dim, corners = dim + 1;
    const int32_t *corner = plan->work.elements + element * corners;
    const int32_t *of_cell = plan->cells.node + plan->cells.offset[pl_plan_element(plan, element)];
    double longest = 0, farthest = 0, off, edge;
    int any = 0;
    for (int i = corners; i < c->rule->n_nodes; i++)
        any |= of_cell[i] >= 0 && s->is_off[of_cell[i]];
    for (int i = corners; any && i < c->rule->n_nodes; i++) {
        const double *a = c->mids.given + (int64_t)corner[c->rule->type->between[i][0]] * dim;
        const double *b = c->mids.given + (int64_t)corner[c->rule->type->between[i][1]] * dim;
        measure_mid(&c->mids, of_cell[i] >= 0 ? of_cell[i] : 0, a, b, &off, &edge, dim);
        longest = pl_larger(edge, longest);
        if (of_cell[i] >= 0)
            farthest = pl_larger(off, farthest);
    }
    return any && is_off(c, farthest, longest);
}

static void note_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const search *s = context;
    (void)thread;
    for (int64_t e = begin; e < end; e++)
        if (is_order_2(s->curved, e))
            pl_mids_note(&s->curved->mids, e, s->curved->rule->type);
}

static void search_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    int64_t n = 0;
    (void)thread;
    for (int64_t e = begin; e < end; e++) {
        const int is_found = is_order_2(s->curved, e) && is_element_curved(s, e);
        s->curved->is_curved[e] = (uint8_t)is_found;
        n += is_found;
    }
    __atomic_fetch_add(&s->n, n, __ATOMIC_RELAXED);
}

/** Find mids and curved elements, all at once. */
static int find_all(search *s, planish_error *error) {
    pl_watch *c = s->curved;
    const int threads = c->plan->threads;
    s->is_off = pl_alloc(c->mids.start.n, sizeof *s->is_off);
    c->is_curved = pl_alloc(c->plan->work.n_elements, sizeof *c->is_curved);
    if (!s->is_off || !c->is_curved)
        return pl_fail_memory(error, "the curved elements");
    pl_parallel_for(threads, c->plan->work.n_elements, CHUNK, note_chunk, s);
    pl_parallel_for(threads, c->mids.start.n, CHUNK_NODES, mids_chunk, s);
    if (s->lowest < INT64_MAX)
        return pl_fail_at(error, PLANISH_ERROR_MESH, -1, s->lowest,
                          "node %" PRId64 " has a coordinate that is not a finite number",
                          s->lowest);
    pl_parallel_for(threads, c->plan->work.n_elements, CHUNK, search_chunk, s);
    return PLANISH_OK;
}

/** List the curved elements at each movable node. */
static void list_watched(pl_watch *c, int fills) {
    const planish_plan *plan = c->plan;
    for (int64_t w = 0; w < c->n; w++)
        for (int j = 0; j <= plan->dim; j++) {
            const int64_t node = plan->work.elements[c->element[w] * (plan->dim + 1) + j];
            if (!plan->work.mobility[node])
                continue;
            int64_t *at = &c->begin[plan->inner[node] + 1];
            if (fills)
                c->watched[*at] = (int32_t)w;
            ++*at;
        }
}

/** Make the lists of the curved elements that have been found. */
static int make_lists(pl_watch *c) {
    const int64_t n_nodes = c->plan->work.n_nodes;
    int64_t n = 0;
    for (int64_t e = 0; e < c->plan->work.n_elements; e++)
        n += c->is_curved[e] != 0;
    c->element = pl_alloc(n, sizeof *c->element);
    c->bound = pl_alloc(n, sizeof *c->bound);
    c->reach = pl_alloc(n, sizeof *c->reach);
    c->is_valid = pl_alloc(n, sizeof *c->is_valid);
    c->begin = pl_alloc_zero(n_nodes + 1, sizeof *c->begin);
    if (!c->element || !c->bound || !c->reach || !c->is_valid || !c->begin)
        return 0;
    for (int64_t e = 0; e < c->plan->work.n_elements; e++)
        if (c->is_curved[e])
            c->element[c->n++] = (int32_t)e;
    n = 0;
    list_watched(c, 0);
    for (int64_t i = 1; i <= n_nodes; i++) { /* begin[i + 1]: where those of node i begin */
        const int64_t of_node = c->begin[i];
        c->begin[i] = n;
        n += of_node;
    }
    c->watched = pl_alloc(n, sizeof *c->watched);
    if (!c->watched)
        return 0;
    list_watched(c, 1);
    return 1;
}

/** Type of the plan's elements of order 2, or NULL. */
static const pl_cell_type *find_order_2(const planish_plan *plan) {
    const int type = plan->dim == 3 ? PLANISH_CELL_TETRAHEDRON10 : PLANISH_CELL_TRIANGLE6;
    for (int64_t e = 0; plan->cells.n > 0 && e < plan->work.n_elements; e++)
        if (plan->cells.type[pl_plan_element(plan, e)] == type)
            return pl_cell_type_of(type);
    return NULL;
}

/** How far a mid may stray from half of the way of its ends; largest: coordinate of mids. */
static double stray_of(const pl_watch *c, const planish_options *options, double largest) {
    for (int64_t i = 0; i < c->plan->work.n_nodes * c->plan->dim; i++)
        largest = fmax(largest, fabs(c->mids.given[i]));
    /* Nodes may go beyond where nodes were, but not far. */
    enum { BEYOND = 4, ROUNDINGS = 8 };
    const double unit = options->precision == PLANISH_PRECISION_DOUBLE ? DBL_EPSILON : FLT_EPSILON;
    return options->precision == PLANISH_PRECISION_ROUNDED ? INFINITY
                                                           : BEYOND * ROUNDINGS * unit * largest;
}

int pl_watch_create(const planish_plan *plan, const planish_options *options, const double *given,
                    const double *start, pl_watch *c, planish_error *error) {
    const pl_cell_type *type = find_order_2(plan);
    *c = (pl_watch){.plan = plan};
    if (!type)
        return PLANISH_OK;
    c->rule = pl_alloc(1, sizeof *c->rule);
    if (!c->rule)
        return pl_fail_memory(error, "the curved elements");
    pl_jacobian_rule_make(type, c->rule);
    int status = pl_mids_create(plan, options, given, start, &c->mids, error);
    if (status)
        return status;
    c->rounding = options->rounding;
    search s = {.curved = c, .lowest = INT64_MAX};
    status = find_all(&s, error);
    pl_free(s.is_off);
    if (status)
        return status;
    c->stray = stray_of(c, options, s.largest);
    if (!make_lists(c))
        return pl_fail_memory(error, "the curved elements");
    c->n_curved = c->n;
    return PLANISH_OK;
}

static void free_lists(pl_watch *c) {
    pl_free(c->element);
    pl_free(c->bound);
    pl_free(c->reach);
    pl_free(c->is_valid);
    pl_free(c->begin);
    pl_free(c->watched);
    c->element = c->watched = NULL;
    c->bound = c->reach = NULL;
    c->is_valid = NULL;
    c->begin = NULL;
    c->n = 0;
}

int pl_watch_add(pl_watch *c, int64_t n, const int32_t *element, planish_error *error) {
    int64_t n_new = 0;
    for (int64_t i = 0; i < n; i++) {
        n_new += !c->is_curved[element[i]];
        c->is_curved[element[i]] = 1;
    }
    if (n_new == 0)
        return PLANISH_OK;
    free_lists(c);
    return make_lists(c) ? PLANISH_OK : pl_fail_memory(error, "the curved elements");
}

void pl_watch_destroy(pl_watch *c) {
    pl_mids_destroy(&c->mids);
    pl_free(c->rule);
    pl_free(c->is_curved);
    free_lists(c);
    *c = (pl_watch){.n = 0};
}
