/* curve: mids of curved elements move by themselves.
 *
 * Sweeps move corners, and mids follow. Where a curved element is invalid, or its least Bezier
 * coefficient of det J is below options.curve_quality of their mean, the mids of its inner edges get
 * places of their own; where it is invalid its free corners move, too. Of a star of such a node the
 * coefficients of the elements are rows (sweep/rows.h): affine, with a mean ratio that is convex.
 *
 *   1. Elements that are invalid wherever their free nodes go are proved (prove), and count no more.
 *   2. Those that are invalid are gathered in clusters that share free nodes. Each is untangled by the
 *      regularised energy (star/kernel_foldover.h) of its rows: by mids alone, then with corners, then
 *      with the nodes around.
 *   3. The sum of mean ratios over the rows is minimised, coefficients positive.
 *
 * What a cluster has become is taken if no element is invalid that was not, and not more are. All of
 * it is serial, in the order of nodes: the same bits on any number of threads.
 */
#include "improve/improve.h"
#include "sweep/rows.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/angle.h"
#include "geometry/cube_root.h"
#include "star/kernel_cone.h"
#include "star/kernel_direction.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum {
    NODES = 10,        /* most nodes of a simplex of order 2 */
    STAGES = 4,        /* of untangling: with more and more nodes */
    EFFORT = 2000,     /* visits that untangling may take in all, */
    EFFORT_EACH = 300, /* and so many more for each invalid element */
    SWEEPS = 200,
    STALLED = 15, /* sweeps that do not help */
    SMOOTH_SWEEPS = 30,
    STEPS = 3, /* Newton steps of a visit */
    HALVINGS = 12
};

/* Rows of elements that are given up pull a little, by their energy with so much regularisation. */
#define SOFT_WEIGHT  0.05
#define SOFT_EPSILON 0.5
/* A visit goes so far to where a coefficient becomes 0, as a part. */
#define FRACTION 0.9
/* A star is at rest, or all are, when their function falls by less than this, relative. */
#define AT_REST 1e-4

/** What a node of the mesh may do. */
enum { UNKNOWN = 0, HELD, SLIDES, MID, CORNER };

/** Node that moves. */
typedef struct handle {
    int32_t node;  /* the caller's number, */
    int32_t inner; /* and that of the plan's coordinates; -1: a mid */
    int is_active;
    double saved[3]; /* coordinates, or what a mid has moved by itself */
} handle;

/** Rows of a star. Arrays are owned. */
typedef struct star_rows {
    int64_t n, capacity;
    pl_star_row *row; /* [n] */
    double *scale;    /* [n][2] 1 / the wanted D, 1 / the E of the ideal element of this D */
    uint8_t *is_soft; /* [n] */
} star_rows;

/** Elements and nodes that are worked on together. Arrays are owned. */
typedef struct cluster {
    int64_t n_handles, n_elements, handle_room, element_room;
    handle *handle;     /* [n_handles] */
    int32_t *element;   /* [n_elements] */
    uint8_t *was_valid; /* [n_elements] */
    double epsilon;
} cluster;

/** The work. Arrays are owned. */
typedef struct repair {
    pl_run *run; /* NULL: proofs alone are wanted */
    const planish_plan *plan;
    const planish_options *options;
    pl_watch *watch;
    const uint8_t *mobility; /* [n of the plan] */
    int dim;
    int moves_corners;
    int64_t *begin;       /* [nodes of the mesh + 1] where the elements of each begin */
    int32_t *at;          /* elements of the plan */
    uint8_t *kind;        /* [nodes of the mesh] */
    uint8_t *is_outside;  /* [nodes of the mesh] of an element that the plan lacks; NULL: none is */
    uint8_t *is_given_up; /* [elements of the plan] */
    int32_t *handle_of;   /* [nodes of the mesh] in the cluster; -1: none */
    uint8_t *is_member;   /* [elements of the plan] of the cluster */
    uint8_t *tried;       /* [elements of the plan] 1 + stage in which they were not mended */
    int64_t effort;       /* visits that untangling may still take */
    double *target;       /* [elements of the plan] the wanted D of members */
    pl_row_rule *rule[2]; /* of order 1 and 2 */
    star_rows star;
    pl_stop_check *limit;
    int lacks_memory;
} repair;

/* ---- elements and nodes --------------------------------------------------------------------- */

static int order_of(const repair *r, int64_t element) {
    return pl_cell_type_of(r->plan->cells.type[pl_plan_element(r->plan, element)])->order;
}

static int is_simplex(const repair *r, int64_t element) {
    const int type = r->plan->cells.type[pl_plan_element(r->plan, element)];
    return pl_cell_type_of(type)->shape->n_corners == r->dim + 1;
}

/** The caller's nodes of an element; *n of them. */
static const int32_t *nodes_of(const repair *r, int64_t element, int *n) {
    const planish_cells *cells = &r->plan->cells;
    const int64_t cell = pl_plan_element(r->plan, element);
    *n = (int)(cells->offset[cell + 1] - cells->offset[cell]);
    return cells->node + cells->offset[cell];
}

/** Node of the plan that is corner i of an element. */
static int32_t corner_of(const repair *r, int64_t element, int i) {
    return r->plan->work.elements[element * (r->dim + 1) + i];
}

static double sign_of(const repair *r, int64_t element) {
    return r->plan->work.sign ? r->plan->work.sign[element] : 1;
}

/** Place of a node in an element. */
static int place_in(const repair *r, int64_t element, int32_t node) {
    int n, i = 0;
    const int32_t *of = nodes_of(r, element, &n);
    while (of[i] != node)
        i++;
    return i;
}

/** Whether a mid is inside: the elements at its edge close around it. */
static int closes(const repair *r, int32_t node) {
    const int64_t first = r->begin[node], end = r->begin[node + 1];
    if (r->dim == 2)
        return end - first == 2;
    for (int64_t k = first; k < end; k++) {
        int n, m;
        const int32_t *of = nodes_of(r, r->at[k], &n);
        const uint8_t *ends = r->rule[1]->jacobian.type->between[place_in(r, r->at[k], node)];
        for (int i = 0; i < 4; i++) {
            int count = 0;
            if (i == ends[0] || i == ends[1])
                continue;
            for (int64_t o = first; o < end; o++) {
                const int32_t *other = nodes_of(r, r->at[o], &m);
                for (int j = 0; j < 4; j++)
                    count += other[j] == of[i];
            }
            if (count != 2)
                return 0;
        }
    }
    return 1;
}

static int has_chosen_end(const repair *r, int32_t node) {
    const int64_t element = r->at[r->begin[node]];
    const uint8_t *ends = r->rule[1]->jacobian.type->between[place_in(r, element, node)];
    return (!r->options->around && !r->plan->is_selective) ||
           r->mobility[corner_of(r, element, ends[0])] != PL_HELD ||
           r->mobility[corner_of(r, element, ends[1])] != PL_HELD;
}

/** Mobility of a node as a corner; a mid has none. */
static int mobility_of(const repair *r, int32_t node) {
    for (int64_t k = r->begin[node]; k < r->begin[node + 1]; k++) {
        const int place = place_in(r, r->at[k], node);
        if (r->plan->work.corner)
            return r->mobility[node];
        if (place <= r->dim)
            return r->mobility[corner_of(r, r->at[k], place)];
    }
    return PL_HELD;
}

static int find_kind(const repair *r, int32_t node) {
    const int role = r->plan->role[node];
    const int64_t first = r->begin[node], end = r->begin[node + 1];
    if (first == end || (r->is_outside && r->is_outside[node]))
        return HELD;
    if (pl_follows((uint8_t)role)) {
        for (int64_t k = first; k < end; k++)
            if (!is_simplex(r, r->at[k]))
                return HELD;
        return role & (PL_OF_EDGES | PL_BOUND) || !closes(r, node) || !has_chosen_end(r, node)
                   ? HELD
                   : MID;
    }
    const int mobility = mobility_of(r, node);
    int is_plain = mobility == PL_INTERIOR && !(role & (PL_OF_MID | PL_OF_OTHER));
    for (int64_t k = first; k < end; k++)
        is_plain &= is_simplex(r, r->at[k]);
    return is_plain ? CORNER : mobility != PL_HELD ? SLIDES : HELD;
}

static int kind_of(repair *r, int32_t node) {
    if (node < 0)
        return HELD;
    if (r->kind[node] == UNKNOWN)
        r->kind[node] = (uint8_t)find_kind(r, node);
    return r->kind[node];
}

/** All nodes of a cell of the plan. */
static int nodes_of_cell(const void *context, int64_t cell, int32_t node[PL_CELL_NODES]) {
    const repair *r = context;
    int n;
    const int32_t *of = nodes_of(r, pl_first_of_cell(&r->plan->work, cell), &n);
    memcpy(node, of, (size_t)n * sizeof *node);
    return n;
}

/** List the elements of all nodes of the mesh. */
static int list_elements(repair *r) {
    const planish_plan *plan = r->plan;
    pl_incidence cells;
    if (!pl_items_of_nodes(plan->whole.n_nodes, pl_view_cells(&plan->work), nodes_of_cell, r, 1,
                           &cells))
        return 0;
    r->begin = cells.offset;
    r->at = cells.element;
    for (int64_t k = 0; k < r->begin[plan->whole.n_nodes]; k++)
        r->at[k] = (int32_t)pl_first_of_cell(&plan->work, r->at[k]);
    return 1;
}

/** Mark the nodes of elements that the plan, which is of a subset, lacks. */
static int find_outside(repair *r) {
    const planish_plan *plan = r->plan;
    const planish_cells *cells = &plan->cells;
    if (plan->scope == PL_ALL)
        return 1;
    uint8_t *is_inside = pl_alloc_zero(cells->n, 1);
    r->is_outside = pl_alloc_zero(plan->whole.n_nodes, 1);
    for (int64_t e = 0; is_inside && e < plan->work.n_elements; e++)
        is_inside[pl_plan_element(plan, e)] = 1;
    for (int64_t c = 0; is_inside && r->is_outside && c < cells->n; c++)
        for (int64_t k = cells->offset[c]; !is_inside[c] && k < cells->offset[c + 1]; k++)
            if (cells->node[k] >= 0)
                r->is_outside[cells->node[k]] = 1;
    const int done = is_inside && r->is_outside;
    pl_free(is_inside);
    return done;
}

static void repair_destroy(repair *r) {
    pl_free(r->begin);
    pl_free(r->at);
    pl_free(r->kind);
    pl_free(r->is_outside);
    pl_free(r->is_given_up);
    pl_free(r->handle_of);
    pl_free(r->is_member);
    pl_free(r->tried);
    pl_free(r->target);
    pl_free(r->star.row);
    pl_free(r->star.scale);
    pl_free(r->star.is_soft);
    pl_row_rule_free(r->rule[0]);
    pl_row_rule_free(r->rule[1]);
}

/** Make r, which has run, plan, options, watch, mobility and limit. */
static int repair_create(repair *r, planish_error *error) {
    const planish_plan *plan = r->plan;
    const int64_t n = plan->whole.n_nodes, m = plan->work.n_elements;
    const int is_plane = plan->dim == 2;
    r->dim = plan->dim;
    r->kind = pl_alloc_zero(n, 1);
    r->is_given_up = pl_alloc_zero(m, 1);
    r->handle_of = pl_alloc(n, sizeof *r->handle_of);
    r->is_member = pl_alloc_zero(m, 1);
    r->tried = pl_alloc_zero(m, 1);
    r->target = pl_alloc(m, sizeof *r->target);
    r->rule[0] = pl_row_rule_make(
        pl_cell_type_of(is_plane ? PLANISH_CELL_TRIANGLE : PLANISH_CELL_TETRAHEDRON));
    r->rule[1] = pl_row_rule_make(
        pl_cell_type_of(is_plane ? PLANISH_CELL_TRIANGLE6 : PLANISH_CELL_TETRAHEDRON10));
    if (!r->kind || !r->is_given_up || !r->handle_of || !r->is_member || !r->tried || !r->target ||
        !r->rule[0] || !r->rule[1] || !list_elements(r) || !find_outside(r))
        return pl_fail_memory(error, "curved elements");
    memset(r->handle_of, -1, (size_t)n * sizeof *r->handle_of);
    return PLANISH_OK;
}

/* ---- places --------------------------------------------------------------------------------- */

static double *coordinates_of(const repair *r, const handle *h) {
    return r->plan->scratch.coordinates + (int64_t)h->inner * r->dim;
}

static double *own_of(const repair *r, const handle *h) {
    return r->watch->mids.own + (int64_t)h->node * r->dim;
}

static void place_of(const repair *r, const handle *h, double *x) {
    if (h->inner < 0)
        pl_mid_place(&r->watch->mids, h->node, x);
    else
        memcpy(x, coordinates_of(r, h), (size_t)r->dim * sizeof *x);
}

static void save(const repair *r, handle *h) {
    memcpy(h->saved, h->inner < 0 ? own_of(r, h) : coordinates_of(r, h),
           (size_t)r->dim * sizeof *h->saved);
}

static void restore(const repair *r, const handle *h) {
    memcpy(h->inner < 0 ? own_of(r, h) : coordinates_of(r, h), h->saved,
           (size_t)r->dim * sizeof *h->saved);
}

/** Whether a mid may be at x: within the bounds of options, and no farther from its start than both
 *  of its ends may go. */
static int mid_may_be(const repair *r, int32_t node, const double *x) {
    const planish_options *o = r->options;
    const pl_mids *mids = &r->watch->mids;
    const int64_t element = r->at[r->begin[node]];
    const uint8_t *ends = r->rule[1]->jacobian.type->between[place_in(r, element, node)];
    double start[3];
    for (int d = 0; d < r->dim; d++) {
        const int64_t i = (int64_t)node * r->dim + d;
        start[d] = mids->start.x[pl_point_at(&mids->start, node, d)];
        if (x[d] < o->box_lower[d] || x[d] > o->box_upper[d] || (o->lower && x[d] < o->lower[i]) ||
            (o->upper && x[d] > o->upper[i]))
            return 0;
    }
    const double *radius = r->run->guard.star.radius;
    for (int k = 0; k < 2 && radius; k++)
        if (pl_distance(r->dim, x, start) > radius[r->plan->inner[corner_of(r, element, ends[k])]])
            return 0;
    return 1;
}

/** Move a node to x, or as near as it can be stored; 0 if it may not be there. */
static int put(const repair *r, const handle *h, double *x) {
    double now[3];
    if (h->inner >= 0) {
        if (!pl_star_admit(&r->run->problem, h->inner, r->dim, x))
            return 0;
        memcpy(coordinates_of(r, h), x, (size_t)r->dim * sizeof *x);
        return 1;
    }
    place_of(r, h, now);
    for (int d = 0; d < r->dim; d++)
        own_of(r, h)[d] += x[d] - now[d];
    place_of(r, h, now);
    return mid_may_be(r, h->node, now);
}

/* ---- rows of a star ------------------------------------------------------------------------- */

/** D of an element as a straight one. */
static double straight_measure(const repair *r, int64_t element) {
    double x[PL_CELL_NODES * 3], D;
    pl_places_of_element(r->watch, element, x, NULL);
    pl_row_coefficients(r->rule[0], x, sign_of(r, element), &D);
    return D;
}

/** Make room for n rows. */
static int grow_rows(repair *r, int64_t n) {
    star_rows *s = &r->star;
    int64_t room[3] = {s->capacity, s->capacity, s->capacity};
    if (n <= s->capacity)
        return 1;
    pl_star_row *row = pl_grow(s->row, s->n, n, &room[0], sizeof *row);
    s->row = row ? row : s->row;
    double *scale = pl_grow(s->scale, 2 * s->n, 2 * n, &room[1], sizeof *scale);
    s->scale = scale ? scale : s->scale;
    uint8_t *is_soft = pl_grow(s->is_soft, s->n, n, &room[2], 1);
    s->is_soft = is_soft ? is_soft : s->is_soft;
    if (!row || !scale || !is_soft) {
        r->lacks_memory = 1;
        return 0;
    }
    s->capacity = n;
    return 1;
}

/** Add the rows of an element for the handle h: of its coefficients, and if a corner moves those of
 *  the straight element. */
static void add_rows(repair *r, int64_t element, const handle *h) {
    star_rows *s = &r->star;
    const int order = order_of(r, element), place = place_in(r, element, h->node);
    const double wanted = r->target[element];
    double x[PL_CELL_NODES * 3], rate[PL_CELL_NODES] = {0};
    pl_star_row row[2 * PL_CELL_NODES];
    pl_places_of_element(r->watch, element, x, NULL);
    pl_row_handle(r->rule[order - 1], place, rate);
    int n = pl_rows_of_element(r->rule[order - 1], x, sign_of(r, element), rate, 1, row, NULL);
    if (order == 2 && h->inner >= 0) {
        double straight[PL_CELL_NODES] = {0};
        straight[place] = 1;
        const int more =
            pl_rows_of_element(r->rule[0], x, sign_of(r, element), straight,
                               1.0 / r->rule[1]->jacobian.n_coefficients, row + n, NULL);
        n += more;
    }
    if (!grow_rows(r, s->n + n))
        return;
    const double root = r->dim == 3 ? pl_cube_root(wanted) : 1;
    for (int i = 0; i < n; i++) {
        const int64_t k = s->n++;
        s->row[k] = row[i];
        s->scale[2 * k] = 1 / wanted;
        s->scale[2 * k + 1] = sqrt(row[i].factor) / (r->dim == 3 ? root * root : wanted);
        s->is_soft[k] = r->is_given_up[element];
    }
}

/** Gather the star of a node. */
static void gather(repair *r, const handle *h) {
    r->star.n = 0;
    for (int64_t k = r->begin[h->node]; k < r->begin[h->node + 1]; k++)
        add_rows(r, r->at[k], h);
}

/** Value of a star where its node has moved, and derivatives. */
typedef struct value {
    double f, least; /* least: D / the wanted one, of rows that are not soft */
    double gradient[3], hessian[6];
} value;

/** Add what a function of T = E / E* and u = D / D* is, with its derivatives by these. */
typedef struct slopes {
    double f, of_t, of_u, of_tt, of_tu, of_uu;
} slopes;

/** The regularised energy. Curvature along u that is negative is left out. */
PL_INLINE slopes energy_of(double T, double u, double epsilon, const int dim) {
    const double p = 2.0 / dim, s = sqrt(u * u + epsilon * epsilon);
    const double chi = u > 0 ? 0.5 * (u + s) : 0.5 * epsilon * epsilon / (s - u);
    const double root = dim == 3 ? pl_cube_root(chi) : chi, inverse = 1 / chi, i = 1 / s;
    const double power = dim == 3 ? 1 / (root * root) : inverse, q = 1 + u * u, slant = u * i;
    const double bend = T * power * p * (p + slant) * i * i +
                        0.5 * inverse * (2 - 4 * u * i + q * (1 + slant) * i * i);
    return (slopes){.f = T * power + 0.5 * q * inverse,
                    .of_t = power,
                    .of_u = 0.5 * inverse * (2 * u - q * i) - T * power * p * i,
                    .of_tu = -power * p * i,
                    .of_uu = bend > 0 ? bend : 0};
}

/** The squared mean ratio T^2 u^-k. */
PL_INLINE slopes ratio_of(double T, double u, const int dim) {
    const double k = dim == 3 ? 4.0 / 3 : 2, inverse = 1 / u;
    const double root = dim == 3 ? 1 / pl_cube_root(u) : inverse;
    const double power = dim == 3 ? root * root * root * root : inverse * inverse;
    const double f = T * T * power;
    return (slopes){.f = f,
                    .of_t = 2 * T * power,
                    .of_u = -k * f * inverse,
                    .of_tt = 2 * power,
                    .of_tu = -2 * k * T * power * inverse,
                    .of_uu = k * (k + 1) * f * inverse * inverse};
}

/** Find the value of the star in r with its node moved by d. epsilon of the energy; 0: of the mean
 *  ratios, infinite where a row is not positive. */
PL_INLINE value find_value(const star_rows *s, const double *d, double epsilon, const int dim) {
    value v = {.least = INFINITY};
    for (int64_t i = 0; i < s->n; i++) {
        const pl_star_row *row = &s->row[i];
        const double to_u = s->scale[2 * i], to_t = s->scale[2 * i + 1];
        double E = row->e, D = row->D0, gt[3] = {0}, gu[3] = {0};
        for (int a = 0; a < dim; a++) {
            E += (2 * row->slope_e[a] + row->c * d[a]) * d[a];
            D += row->slope_d[a] * d[a];
            gt[a] = 2 * to_t * (row->slope_e[a] + row->c * d[a]);
            gu[a] = to_u * row->slope_d[a];
        }
        const double T = E * to_t, u = D * to_u;
        const double weight = s->is_soft[i] ? SOFT_WEIGHT * row->weight : row->weight;
        if (!s->is_soft[i])
            v.least = u < v.least ? u : v.least;
        if (!s->is_soft[i] && !(epsilon > 0) && !(u > 0)) {
            v.f = INFINITY;
            return v;
        }
        const slopes f = s->is_soft[i] ? energy_of(T, u, SOFT_EPSILON, dim)
                         : epsilon > 0 ? energy_of(T, u, epsilon, dim)
                                       : ratio_of(T, u, dim);
        v.f += weight * f.f;
        for (int a = 0; a < dim; a++) {
            v.gradient[a] += weight * (f.of_t * gt[a] + f.of_u * gu[a]);
            for (int b = a; b < dim; b++)
                v.hessian[packed(a, b, dim)] +=
                    weight * (f.of_tt * gt[a] * gt[b] + f.of_tu * (gt[a] * gu[b] + gu[a] * gt[b]) +
                              f.of_uu * gu[a] * gu[b] + (a == b ? 2 * to_t * row->c * f.of_t : 0));
        }
    }
    return v;
}

static value value_at(const repair *r, const double *d, double epsilon) {
    return r->dim == 3 ? find_value(&r->star, d, epsilon, 3) : find_value(&r->star, d, epsilon, 2);
}

/** Largest step along direction from d, as a multiple of it, that leaves the rows positive. */
static double largest_step(const repair *r, const double *d, const double *direction) {
    const star_rows *s = &r->star;
    double rate = 0;
    for (int64_t i = 0; i < s->n; i++) {
        const pl_star_row *row = &s->row[i];
        const double D = row->D0 + dot(row->slope_d, d, r->dim);
        const double fall = -dot(row->slope_d, direction, r->dim);
        if (!s->is_soft[i] && fall > rate * D)
            rate = fall / D;
    }
    return rate > 0 ? FRACTION / rate : INFINITY;
}

/** One step from d, where the value is *v: both are changed. Returns whether it went. */
static int go_one_step(const repair *r, double *d, value *v, double epsilon) {
    double direction[3] = {0}, at[3] = {0};
    if (!newton_direction(v->gradient, v->hessian, direction, r->dim))
        return 0;
    const double slope = dot(v->gradient, direction, r->dim);
    double step = epsilon > 0 ? 1 : fmin(1, largest_step(r, d, direction));
    if (!(slope < 0))
        return 0;
    for (int i = 0; i < HALVINGS; i++) {
        for (int a = 0; a < r->dim; a++)
            at[a] = d[a] + step * direction[a];
        const value next = value_at(r, at, epsilon);
        if (next.f <= v->f + 1e-4 * step * slope && next.f < v->f) {
            memcpy(d, at, sizeof at);
            *v = next;
            return 1;
        }
        step *= i < 3 ? 0.5 : 0.2;
    }
    return 0;
}

/** In a star whose mean ratios are to be minimised: elements with a row that is not positive count
 *  as given up. */
static void soften(repair *r) {
    for (int64_t i = 0; i < r->star.n; i++)
        r->star.is_soft[i] = r->star.is_soft[i] || !(r->star.row[i].D0 > 0);
}

/** Visit the star of a node; returns by how much its function has fallen, relative. */
static double visit(repair *r, handle *h, double epsilon) {
    double d[3] = {0}, place[3] = {0}, now[3] = {0}, to[3] = {0};
    gather(r, h);
    if (!(epsilon > 0))
        soften(r);
    const value before = value_at(r, d, epsilon);
    value v = before;
    for (int i = 0; i < STEPS; i++) {
        const double f = v.f;
        if (!go_one_step(r, d, &v, epsilon) || !(f - v.f > 0.1 * f))
            break;
    }
    if (!(v.f < before.f) || r->lacks_memory)
        return 0;
    handle kept = *h;
    save(r, &kept);
    place_of(r, h, place);
    for (int a = 0; a < r->dim; a++)
        to[a] = place[a] + d[a];
    if (put(r, h, to)) {
        place_of(r, h, now);
        for (int a = 0; a < r->dim; a++)
            d[a] = now[a] - place[a];
        const double f = value_at(r, d, epsilon).f;
        if (f < before.f)
            return (before.f - f) / before.f;
    }
    restore(r, &kept);
    return 0;
}

/* ---- clusters ------------------------------------------------------------------------------- */

/** Add an element to the cluster. */
static void add_element(repair *r, cluster *c, int32_t element) {
    if (r->is_member[element])
        return;
    r->is_member[element] = 1;
    if (!pl_append(&c->element, &c->n_elements, &c->element_room, &element, sizeof element))
        r->lacks_memory = 1;
}

/** Add a node that moves, and the elements at it. */
static void add_handle(repair *r, cluster *c, int32_t node) {
    if (r->handle_of[node] >= 0)
        return;
    const int64_t first = r->at[r->begin[node]];
    handle h = {.node = node, .inner = -1, .is_active = 1};
    if (kind_of(r, node) == CORNER)
        h.inner = r->plan->inner[corner_of(r, first, place_in(r, first, node))];
    save(r, &h);
    r->handle_of[node] = (int32_t)c->n_handles;
    if (!pl_append(&c->handle, &c->n_handles, &c->handle_room, &h, sizeof h)) {
        r->lacks_memory = 1;
        r->handle_of[node] = -1;
        return;
    }
    for (int64_t k = r->begin[node]; k < r->begin[node + 1]; k++)
        add_element(r, c, r->at[k]);
}

/** Add those of the nodes of an element that are mids, or (with_corners) free corners. */
static void add_nodes_of(repair *r, cluster *c, int64_t element, int with_corners) {
    int n;
    const int32_t *of = nodes_of(r, element, &n);
    for (int i = 0; i < n; i++)
        if (kind_of(r, of[i]) == MID ||
            (with_corners && r->moves_corners && kind_of(r, of[i]) == CORNER))
            add_handle(r, c, of[i]);
}

static void cluster_destroy(repair *r, cluster *c) {
    for (int64_t i = 0; i < c->n_handles; i++)
        r->handle_of[c->handle[i].node] = -1;
    for (int64_t i = 0; i < c->n_elements; i++)
        r->is_member[c->element[i]] = 0;
    pl_free(c->handle);
    pl_free(c->element);
    pl_free(c->was_valid);
    *c = (cluster){.n_handles = 0};
}

static pl_validity decide(const repair *r, int64_t element) {
    return pl_watch_decide(r->watch, pl_cell_with(r->plan, element));
}

static int is_valid(const repair *r, int64_t element) {
    return decide(r, element) == PL_VALID;
}

/** Watched cell i, if it is a simplex of order 2, as an element; else -1. *invalid: whether it was
 *  invalid when it was measured last. */
static int64_t watched(const repair *r, int64_t i, int *invalid) {
    const pl_watch *w = r->watch;
    const int64_t element = pl_first_of_cell(&r->plan->work, pl_watch_cell(w, i));
    *invalid = !(w->state[i] & PL_WATCH_VALID);
    return w->type[i] == r->rule[1]->jacobian.type->type ? element : -1;
}

/** Set the wanted D of the cluster's elements: their own as straight ones, or where that is not
 *  positive the mean around. */
static void set_targets(repair *r, const cluster *c) {
    double sum = 0;
    for (int64_t i = 0; i < c->n_elements; i++)
        sum += fabs(straight_measure(r, c->element[i]));
    const double mean = sum / (double)(c->n_elements > 0 ? c->n_elements : 1);
    for (int64_t i = 0; i < c->n_elements; i++) {
        const double D = straight_measure(r, c->element[i]);
        r->target[c->element[i]] = D > 1e-3 * mean ? D : mean;
    }
}

/** Note which elements of the cluster are valid. */
static void note_valid(repair *r, cluster *c) {
    c->was_valid = pl_alloc(c->n_elements, 1);
    if (!c->was_valid)
        r->lacks_memory = 1;
    for (int64_t i = 0; c->was_valid && i < c->n_elements; i++)
        c->was_valid[i] = (uint8_t)is_valid(r, c->element[i]);
}

static void restore_all(const repair *r, const cluster *c) {
    for (int64_t i = 0; i < c->n_handles; i++)
        restore(r, &c->handle[i]);
}

/** Least coefficient of an element over their mean; *mean: that. */
static double quality_of(const repair *r, int64_t element, double *mean) {
    const pl_row_rule *rule = r->rule[order_of(r, element) - 1];
    double x[PL_CELL_NODES * 3], coefficient[PL_JACOBIAN_COEFFICIENTS], least = INFINITY;
    const int n = rule->jacobian.n_coefficients;
    pl_places_of_element(r->watch, element, x, NULL);
    pl_row_coefficients(rule, x, sign_of(r, element), coefficient);
    *mean = 0;
    for (int i = 0; i < n; i++) {
        least = fmin(least, coefficient[i]);
        *mean += coefficient[i] / n;
    }
    return *mean > 0 ? least / *mean : -INFINITY;
}

/** Number of elements of the cluster that count and have a coefficient that is not positive. */
static int64_t count_tangled(const repair *r, const cluster *c) {
    int64_t n = 0;
    double mean;
    for (int64_t i = 0; i < c->n_elements; i++)
        n += !r->is_given_up[c->element[i]] && !(quality_of(r, c->element[i], &mean) > 0);
    return n;
}

/** Sum and least D of all stars of the cluster, with the energy's epsilon. */
static double sum_energy(repair *r, cluster *c, double *least) {
    static const double still[3] = {0, 0, 0};
    double sum = 0;
    *least = INFINITY;
    for (int64_t i = 0; i < c->n_handles; i++) {
        gather(r, &c->handle[i]);
        const value v = value_at(r, still, c->epsilon);
        sum += v.f;
        *least = fmin(*least, v.least);
    }
    return sum;
}

/** Lower epsilon as the energy has fallen. */
static void lower_epsilon(cluster *c, double before, double after, double least) {
    const double sigma = fmax(0.1, before > 0 ? 1 - after / before : 0.1);
    const double root = sqrt(least * least + c->epsilon * c->epsilon);
    c->epsilon *= least >= 0 ? 1 - sigma : 1 - sigma * root / (fabs(least) + root);
    c->epsilon = fmax(c->epsilon, 1e-9);
}

/** Sweep over the cluster until its elements that count have positive coefficients; returns how many
 *  have not. */
static int64_t untangle(repair *r, cluster *c) {
    double least, best = -INFINITY, before = 0;
    int64_t n = count_tangled(r, c), fewest = n;
    c->epsilon = 1;
    sum_energy(r, c, &least);
    c->epsilon = sqrt(1e-12 + 0.04 * least * least);
    for (int sweep = 0, stalled = 0; sweep < SWEEPS && n > 0 && stalled < STALLED; sweep++) {
        for (int64_t i = 0; i < c->n_handles; i++)
            visit(r, &c->handle[i], c->epsilon);
        r->effort -= 2 * c->n_handles;
        const double after = sum_energy(r, c, &least);
        n = count_tangled(r, c);
        lower_epsilon(c, before, after, least);
        stalled = n < fewest || least > best + 1e-3 * fabs(best) ? 0 : stalled + 1;
        fewest = n < fewest ? n : fewest;
        best = fmax(best, least);
        before = after;
        if (r->lacks_memory || r->effort < 0 || pl_limit_is_reached(r->limit))
            break;
    }
    return n;
}

/** Minimise the mean ratios of the cluster. */
static void smooth(repair *r, cluster *c) {
    int goes_on = 1;
    for (int64_t i = 0; i < c->n_handles; i++)
        c->handle[i].is_active = 1;
    for (int sweep = 0; sweep < SMOOTH_SWEEPS && goes_on; sweep++) {
        goes_on = 0;
        for (int64_t i = 0; i < c->n_handles; i++) {
            handle *h = &c->handle[i];
            if (!h->is_active)
                continue;
            h->is_active = 0;
            if (!(visit(r, h, 0) > AT_REST))
                continue;
            goes_on = 1;
            for (int64_t k = r->begin[h->node]; k < r->begin[h->node + 1]; k++) {
                int n;
                const int32_t *of = nodes_of(r, r->at[k], &n);
                for (int j = 0; j < n; j++)
                    if (of[j] >= 0 && r->handle_of[of[j]] >= 0)
                        c->handle[r->handle_of[of[j]]].is_active = 1;
            }
        }
        if (r->lacks_memory || pl_limit_is_reached(r->limit))
            return;
    }
}

/** Whether an element with free corners is worse than any was at the start. */
static int is_worse(const repair *r, int64_t element) {
    const pl_star_limits *limits = &r->run->limits_at_start;
    double x[PL_CELL_NODES * 3], edges[3][3] = {{0}};
    const double *vertex[4] = {x, x + r->dim, x + 2 * r->dim, x + 3 * r->dim};
    pl_places_of_element(r->watch, element, x, NULL);
    if (!(limits->rr2 < INFINITY || limits->acuteness < INFINITY))
        return 0;
    pl_edges(r->dim, vertex, edges);
    const double D = pl_determinant_of_edges(r->dim, edges);
    return pl_radius_ratio_square(r->dim, vertex) > limits->rr2 * PL_LIMIT_MARGIN ||
           pl_acuteness(r->dim, edges, D) > limits->acuteness * PL_LIMIT_MARGIN;
}

/** Whether what the cluster has become can be taken: fewer elements are invalid, or (or_as_many) as
 *  many, and none that was not. */
static int can_be_taken(const repair *r, const cluster *c, int or_as_many) {
    int64_t n_before = 0, n_after = 0;
    int moves_corners = 0;
    for (int64_t i = 0; i < c->n_handles; i++)
        moves_corners |= c->handle[i].inner >= 0;
    for (int64_t i = 0; i < c->n_elements; i++) {
        const int now = is_valid(r, c->element[i]);
        if (c->was_valid[i] && !now)
            return 0;
        if (moves_corners && is_worse(r, c->element[i]))
            return 0;
        n_before += !c->was_valid[i];
        n_after += !now;
    }
    return n_after < n_before || (or_as_many && n_after == n_before);
}

/** Make the cluster of the invalid elements that share free nodes with seed, for a stage of
 *  untangling. */
static void gather_cluster(repair *r, int64_t seed, int stage, cluster *c) {
    add_element(r, c, (int32_t)seed);
    for (int64_t i = 0; i < c->n_elements; i++) /* grows meanwhile */
        if (!r->is_given_up[c->element[i]] && !is_valid(r, c->element[i]))
            add_nodes_of(r, c, c->element[i], stage > 0);
    for (int ring = 2; ring <= stage; ring++) {
        const int64_t n = c->n_elements;
        for (int64_t i = 0; i < n; i++)
            add_nodes_of(r, c, c->element[i], 1);
    }
    set_targets(r, c);
    note_valid(r, c);
}

/** Try to mend the elements around seed in a stage, and note those that are left as tried. If that
 *  fails and gives_up, the worst of them is given up. Returns whether fewer are invalid. */
static int mend(repair *r, int64_t seed, int stage, int gives_up) {
    cluster c = {.n_handles = 0};
    int is_taken = 0;
    gather_cluster(r, seed, stage, &c);
    if (c.n_handles > 0 && !r->lacks_memory) {
        untangle(r, &c);
        is_taken = !r->lacks_memory && can_be_taken(r, &c, 0);
        if (is_taken) {
            for (int64_t i = 0; i < c.n_handles; i++)
                save(r, &c.handle[i]);
            pl_free(c.was_valid);
            note_valid(r, &c);
            smooth(r, &c);
        }
        if (!is_taken || r->lacks_memory || !can_be_taken(r, &c, 1))
            restore_all(r, &c);
    }
    int64_t worst = seed;
    double lowest = INFINITY, mean;
    for (int64_t i = 0; i < c.n_elements && !is_taken && !r->lacks_memory; i++) {
        const double quality = quality_of(r, c.element[i], &mean);
        if (c.was_valid[i] || r->is_given_up[c.element[i]])
            continue;
        r->tried[c.element[i]] = (uint8_t)(stage + 1);
        worst = quality < lowest ? c.element[i] : worst;
        lowest = fmin(quality, lowest);
    }
    if (!is_taken && gives_up)
        r->is_given_up[worst] = 1;
    cluster_destroy(r, &c);
    return is_taken;
}

/** Mend the invalid elements that are not given up, in one stage. Once a cluster has failed it is not
 *  tried again, or (gives_up) not without another element that is given up. */
static void mend_stage(repair *r, int stage, int gives_up) {
    for (int64_t i = 0; i < r->watch->n; i++) {
        int invalid;
        const int64_t element = watched(r, i, &invalid);
        while (element >= 0 && invalid && !r->is_given_up[element] && !is_valid(r, element) &&
               (gives_up || r->tried[element] != stage + 1) && r->effort > 0) {
            if (r->lacks_memory || pl_limit_is_reached(r->limit))
                return;
            if (!mend(r, element, stage, gives_up) && !gives_up)
                break;
        }
    }
}

/** Mend all invalid curved elements that are not given up: with few nodes first. */
static void mend_all(repair *r) {
    int64_t n_invalid = 0;
    for (int64_t i = 0; i < r->watch->n; i++) {
        int invalid;
        const int64_t element = watched(r, i, &invalid);
        n_invalid += element >= 0 && invalid && !r->is_given_up[element];
    }
    r->effort = EFFORT + EFFORT_EACH * n_invalid;
    const int n_stages = r->moves_corners ? STAGES : 1;
    for (int stage = 0; stage < n_stages; stage++)
        mend_stage(r, stage, 0);
    mend_stage(r, n_stages - 1, 1);
}

/* ---- proofs --------------------------------------------------------------------------------- */

enum {
    LATTICE = 12, /* points of a proof are so many to an edge, and one more */
    MOST_POINTS = (LATTICE + 1) * (LATTICE + 2) * (LATTICE + 3) / 6
};

/* A proof holds for nodes within so many sizes of the element, whatever rounding did to it. */
#define PROOF_REACH 1e6
/* What rounding can have done to a value of det J, relative to the largest coefficient. */
#define ROUNDING 1e-12

/** Search for proofs. Arrays are owned. */
typedef struct proofs {
    repair *r;
    int n_points;
    double (*blend)[PL_CELL_NODES];       /* [n_points] a value of det J, by coefficients */
    double (*gradient)[PL_CELL_NODES][3]; /* [n_points] of the shape functions */
    uint16_t *still; /* [n_points] bit i: det J does not move with node i alone */
    int64_t n, capacity;
    double (*row)[CONE_DIM]; /* [n] det J at a point is not above -row . (way of the node, 1) */
    int32_t *element;        /* [n] of which each row is */
} proofs;

static void proofs_destroy(proofs *p) {
    pl_free(p->blend);
    pl_free(p->gradient);
    pl_free(p->still);
    pl_free(p->row);
    pl_free(p->element);
}

/** Whether det J at a point stays if the nodes move at these rates. */
static int is_still(const proofs *p, int point, const double rate[]) {
    const pl_jacobian_rule *rule = &p->r->rule[1]->jacobian;
    double most = 0;
    for (int a = 0; a < p->r->dim; a++) {
        double g = 0;
        for (int i = 0; i < rule->n_nodes; i++)
            g += rate[i] * p->gradient[point][i][a];
        most = fmax(most, fabs(g));
    }
    return most < 1e-12;
}

static int proofs_create(repair *r, proofs *p) {
    *p = (proofs){.r = r,
                  .blend = pl_alloc(MOST_POINTS, sizeof *p->blend),
                  .gradient = pl_alloc(MOST_POINTS, sizeof *p->gradient),
                  .still = pl_alloc_zero(MOST_POINTS, sizeof *p->still)};
    if (!p->blend || !p->gradient || !p->still)
        return 0;
    for (int i = 0; i <= LATTICE; i++)
        for (int j = 0; i + j <= LATTICE; j++)
            for (int k = 0; i + j + k <= LATTICE && (r->dim == 3 || k == 0); k++, p->n_points++) {
                const double xi[3] = {(double)i / LATTICE, (double)j / LATTICE,
                                      (double)k / LATTICE};
                pl_row_point(r->rule[1], xi, p->blend[p->n_points], p->gradient[p->n_points]);
                for (int node = 0; node < r->rule[1]->jacobian.n_nodes; node++) {
                    double rate[NODES] = {0};
                    rate[node] = 1;
                    p->still[p->n_points] |= (uint16_t)(is_still(p, p->n_points, rate) << node);
                }
            }
    return 1;
}

/** Find how the nodes of an element move with its node at place, if the other free nodes stay: mids
 *  that move by themselves do not follow. */
static void find_rates(repair *r, int64_t element, int place, double rate[]) {
    int n;
    const int32_t *of = nodes_of(r, element, &n);
    for (int i = 0; i < NODES; i++)
        rate[i] = 0;
    pl_row_handle(r->rule[1], place, rate);
    for (int i = 0; i < n; i++)
        if (i != place && kind_of(r, of[i]) == MID)
            rate[i] = 0;
}

static void add_proof_row(proofs *p, const double *row, int64_t element) {
    const int64_t n = p->n;
    int64_t room[2] = {p->capacity, p->capacity};
    if (n == p->capacity) {
        double(*rows)[CONE_DIM] = pl_grow(p->row, n, n + 1, &room[0], sizeof *rows);
        p->row = rows ? rows : p->row;
        int32_t *elements = pl_grow(p->element, n, n + 1, &room[1], sizeof *elements);
        p->element = elements ? elements : p->element;
        if (!rows || !elements) {
            p->r->lacks_memory = 1;
            return;
        }
        p->capacity = room[0] < room[1] ? room[0] : room[1];
    }
    memcpy(p->row[n], row, sizeof p->row[n]);
    p->element[n] = (int32_t)element;
    p->n++;
}

/** Add the rows of an element for its node, whose place in it is given; place -1: none moves. Points
 *  that move with other free nodes say nothing. size: unit of the node's way. */
static void add_points(proofs *p, int64_t element, int place, double size) {
    repair *r = p->r;
    const pl_row_rule *rule = r->rule[1];
    const int dim = r->dim, n_coefficients = rule->jacobian.n_coefficients;
    double x[PL_CELL_NODES * 3], rate[NODES] = {0}, D0[PL_CELL_NODES], largest = 0;
    double slope[PL_CELL_NODES][3] = {{0}}, other[NODES][NODES];
    pl_star_row row[PL_CELL_NODES];
    uint8_t index[PL_CELL_NODES];
    int n, n_others = 0;
    const int32_t *of = nodes_of(r, element, &n);
    pl_places_of_element(r->watch, element, x, NULL);
    pl_row_coefficients(rule, x, sign_of(r, element), D0);
    for (int c = 0; c < n_coefficients; c++)
        largest = fmax(largest, fabs(D0[c]));
    if (place >= 0) {
        find_rates(r, element, place, rate);
        const int n_rows = pl_rows_of_element(rule, x, sign_of(r, element), rate, 1, row, index);
        for (int i = 0; i < n_rows; i++)
            for (int d = 0; d < dim; d++)
                slope[index[i]][d] = row[i].slope_d[d] * size;
    }
    uint16_t alone = 0; /* others that nothing follows */
    for (int i = 0; i < n; i++) {
        int n_rates = 0;
        if (i == place || kind_of(r, of[i]) == HELD)
            continue;
        find_rates(r, element, i, other[n_others]);
        for (int k = 0; k < n; k++)
            n_rates += other[n_others][k] != 0;
        if (n_rates == 1)
            alone |= (uint16_t)(1 << i);
        else
            n_others++;
    }
    for (int k = 0; k < p->n_points; k++) {
        double at[CONE_DIM] = {0}, length2 = 0;
        int says = (alone & ~p->still[k]) == 0;
        for (int i = 0; i < n_others && says; i++)
            says = is_still(p, k, other[i]);
        if (!says)
            continue;
        at[dim] = -ROUNDING * largest;
        for (int c = 0; c < n_coefficients; c++) {
            at[dim] -= p->blend[k][c] * D0[c];
            for (int d = 0; d < dim; d++)
                at[d] -= p->blend[k][c] * slope[c][d];
        }
        for (int d = 0; d <= dim; d++)
            length2 += at[d] * at[d];
        for (int d = 0; d <= dim && length2 > 0; d++)
            at[d] /= sqrt(length2);
        add_proof_row(p, at, element);
    }
}

/** Whether the rows contradict each other, and element is needed for that: then no place of the node
 *  makes all of their elements valid. By Farkas' lemma, as in star/feasibility.c. */
static int contradict(const proofs *p, int64_t element) {
    const int dim = p->r->dim;
    const double up[CONE_DIM] = {dim == 0, 0, dim == 2, dim == 3};
    cone_point point;
    double sum[CONE_DIM] = {0}, residual = 0;
    int is_needed = 0;
    if (p->n == 0 || !cone_project((const double(*)[CONE_DIM])p->row, p->n, up, dim + 1, &point))
        return 0;
    for (int i = 0; i < point.n_active; i++) {
        is_needed |= p->element[point.active[i]] == element;
        for (int d = 0; d <= dim; d++)
            sum[d] += point.multiplier[i] * p->row[point.active[i]][d];
    }
    for (int d = 0; d < dim; d++)
        residual += fabs(sum[d]);
    return point.n_active > 0 && is_needed && sum[dim] > PROOF_REACH * residual;
}

/** Length of an element's longest edge. */
static double size_of(const repair *r, int64_t element) {
    double x[PL_CELL_NODES * 3], longest = 0;
    pl_places_of_element(r->watch, element, x, NULL);
    for (int i = 1; i <= r->dim; i++)
        longest = fmax(longest, pl_distance(r->dim, x, x + i * r->dim));
    return longest;
}

/** Whether an element that is invalid stays so wherever one of its free nodes goes, or that or others
 *  around this node do. */
static int is_hopeless(proofs *p, int64_t element) {
    repair *r = p->r;
    int n, n_free = 0;
    const int32_t *of = nodes_of(r, element, &n);
    const double size = size_of(r, element);
    for (int i = 0; i < n; i++) {
        if (kind_of(r, of[i]) == HELD)
            continue;
        n_free++;
        p->n = 0;
        add_points(p, element, i, size);
        if (contradict(p, element))
            return 1;
    }
    for (int i = 0; i < n && !r->lacks_memory; i++) {
        if (kind_of(r, of[i]) == HELD)
            continue;
        p->n = 0;
        for (int64_t k = r->begin[of[i]]; k < r->begin[of[i] + 1]; k++)
            if (!r->is_given_up[r->at[k]] && is_simplex(r, r->at[k]) && order_of(r, r->at[k]) == 2)
                add_points(p, r->at[k], place_in(r, r->at[k], of[i]), size);
        if (contradict(p, element))
            return 1;
    }
    return n_free == 0 && decide(r, element) == PL_INVALID;
}

/** Give up the elements that are proved to be invalid wherever free nodes go; returns how many. *first
 *  (with any) is the first of them. */
static int64_t prove(repair *r, int64_t *first) {
    int64_t n = 0;
    proofs p;
    if (!proofs_create(r, &p))
        r->lacks_memory = 1;
    for (int64_t i = 0; i < r->watch->n && !r->lacks_memory && !pl_limit_is_reached(r->limit);
         i++) {
        int invalid;
        const int64_t element = watched(r, i, &invalid);
        if (element < 0 || !invalid || !is_hopeless(&p, element))
            continue;
        r->is_given_up[element] = 1;
        if (n++ == 0)
            *first = element;
    }
    proofs_destroy(&p);
    return n;
}

int pl_mark_hopeless(const planish_plan *plan, const planish_options *options, const double *given,
                     const double *coordinates, pl_stop_check *limit, uint8_t *state,
                     planish_error *error) {
    pl_watch watch;
    repair r = {.plan = plan,
                .options = options,
                .watch = &watch,
                .mobility = plan->work.mobility,
                .limit = limit};
    int64_t first;
    pl_plan_order(plan, given, plan->scratch.coordinates);
    int status = pl_watch_create(plan, options, given, coordinates, 0, &watch, error);
    if (!status && watch.n_curved > 0 && pl_watch_measure(&watch) > 0) {
        status = repair_create(&r, error);
        if (!status)
            prove(&r, &first);
        if (!status && r.lacks_memory)
            status = pl_fail_memory(error, "curved elements");
        for (int64_t e = 0; !status && e < plan->work.n_elements; e++)
            state[e] = r.is_given_up[e] ? PLANISH_VOLUME_INFEASIBLE : state[e];
        repair_destroy(&r);
    }
    pl_watch_destroy(&watch);
    return status;
}

/* ---- phases --------------------------------------------------------------------------------- */

/** Improve the elements whose least coefficient is below options.curve_quality of their mean. */
static void improve_poor(repair *r) {
    const pl_watch *w = r->watch;
    cluster c = {.n_handles = 0};
    for (int64_t i = 0; i < w->n; i++) {
        int invalid;
        double mean;
        const int64_t element = watched(r, i, &invalid);
        if (element >= 0 && !r->is_given_up[element] &&
            quality_of(r, element, &mean) < r->options->curve_quality)
            add_nodes_of(r, &c, element, 0);
    }
    set_targets(r, &c);
    note_valid(r, &c);
    if (!r->lacks_memory)
        smooth(r, &c);
    for (int is_fine = 0; !is_fine && !r->lacks_memory;) {
        is_fine = 1;
        for (int64_t i = 0; i < c.n_elements; i++) {
            int n;
            const int32_t *of = nodes_of(r, c.element[i], &n);
            if (!c.was_valid[i] || is_valid(r, c.element[i]))
                continue;
            is_fine = 0;
            for (int j = 0; j < n; j++)
                if (of[j] >= 0 && r->handle_of[of[j]] >= 0)
                    restore(r, &c.handle[r->handle_of[of[j]]]);
        }
    }
    cluster_destroy(r, &c);
}

/** Watch all elements of mids that have moved by themselves; r->result counts these mids. */
static int watch_more(repair *r, planish_error *error) {
    int64_t n = 0, room = 0, n_mids = 0;
    int32_t *element = NULL;
    for (int64_t node = 0; node < r->plan->whole.n_nodes; node++) {
        if (r->kind[node] != MID || !pl_mid_has_moved(&r->watch->mids, (int32_t)node))
            continue;
        n_mids++;
        for (int64_t k = r->begin[node]; k < r->begin[node + 1]; k++)
            if (!pl_append(&element, &n, &room, &r->at[k], sizeof *element))
                r->lacks_memory = 1;
    }
    r->run->result->n_released_mids = n_mids;
    const int status = r->lacks_memory ? pl_fail_memory(error, "curved elements")
                                       : pl_watch_add(r->watch, n, element, error);
    pl_free(element);
    return status;
}

/** Do both phases: invalid elements, and if improves poor ones by mids alone. */
static int repair_curved(pl_run *run, int improves, planish_error *error) {
    pl_stop_check limit = pl_run_stop_check(run);
    repair r = {.run = run,
                .plan = run->plan,
                .options = run->options,
                .watch = &run->watch,
                .mobility = run->guard.mobility ? run->guard.mobility : run->plan->work.mobility,
                .limit = &limit,
                .moves_corners = !improves};
    int64_t first = -1;
    int status = repair_create(&r, error);
    if (!status)
        status = pl_mids_release(&run->watch.mids, error);
    if (!status) {
        run->result->n_hopeless = prove(&r, &first);
        if (run->options->untangle)
            mend_all(&r);
        if (improves)
            improve_poor(&r);
        status = watch_more(&r, error);
    }
    if (!status) {
        if (first >= 0)
            pl_log(PLANISH_LOG_NOTE,
                   "%" PRId64
                   " curved elements are invalid wherever their free nodes go, the first "
                   "is element %" PRId64,
                   run->result->n_hopeless, pl_plan_element(run->plan, first));
        pl_run_measure(run);
        if (limit.answer)
            run->stop = (planish_stop)limit.answer;
    }
    repair_destroy(&r);
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
    return pl_watch_has_poor(&r->watch, r->options->curve_quality) ? repair_curved(r, 1, error)
                                                                   : PLANISH_OK;
}
