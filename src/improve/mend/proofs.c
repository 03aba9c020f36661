/* proofs: rows of det J at points, and which of them contradict each other. */
#include "improve/mend/proofs.h"

#include "base/memory.h"
#include "base/status.h"
#include "star/kernel_cone.h"

#include <math.h>
#include <string.h>

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
    pl_mend *curve;
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
    const pl_jacobian_rule *rule = &p->curve->rule[1]->jacobian;
    double most = 0;
    for (int a = 0; a < p->curve->dim; a++) {
        double g = 0;
        for (int i = 0; i < rule->n_nodes; i++)
            g += rate[i] * p->gradient[point][i][a];
        most = fmax(most, fabs(g));
    }
    return most < 1e-12;
}

/** Add the point of the lattice at xi. */
static void add_point(proofs *p, const double *xi) {
    const pl_row_rule *rule = p->curve->rule[1];
    const int point = p->n_points++;
    pl_row_point(rule, xi, p->blend[point], p->gradient[point]);
    for (int node = 0; node < rule->jacobian.n_nodes; node++) {
        double rate[PL_MEND_NODES] = {0};
        rate[node] = 1;
        p->still[point] |= (uint16_t)(is_still(p, point, rate) << node);
    }
}

/** Make p, to be destroyed in any case; returns 0 without memory. */
static int proofs_create(pl_mend *c, proofs *p) {
    *p = (proofs){.curve = c,
                  .blend = pl_alloc(MOST_POINTS, sizeof *p->blend),
                  .gradient = pl_alloc(MOST_POINTS, sizeof *p->gradient),
                  .still = pl_alloc_zero(MOST_POINTS, sizeof *p->still)};
    if (!p->blend || !p->gradient || !p->still)
        return 0;
    for (int i = 0; i <= LATTICE; i++)
        for (int j = 0; i + j <= LATTICE; j++)
            for (int k = 0; i + j + k <= LATTICE && (c->dim == 3 || k == 0); k++) {
                const double xi[3] = {(double)i / LATTICE, (double)j / LATTICE,
                                      (double)k / LATTICE};
                add_point(p, xi);
            }
    return 1;
}

/* ---- rows ------------------------------------------------------------------------------------ */

static void add_row(proofs *p, const double *row, int64_t element) {
    const int64_t n = p->n;
    int64_t room[2] = {p->capacity, p->capacity};
    if (n == p->capacity) {
        double(*rows)[CONE_DIM] = pl_grow(p->row, n, n + 1, &room[0], sizeof *rows);
        p->row = rows ? rows : p->row;
        int32_t *elements = pl_grow(p->element, n, n + 1, &room[1], sizeof *elements);
        p->element = elements ? elements : p->element;
        if (!rows || !elements) {
            p->curve->lacks_memory = 1;
            return;
        }
        p->capacity = room[0] < room[1] ? room[0] : room[1];
    }
    memcpy(p->row[n], row, sizeof p->row[n]);
    p->element[n] = (int32_t)element;
    p->n++;
}

/** Find how the nodes of an element move with its node at place, if the other free nodes stay: mids
 *  that move by themselves do not follow. */
static void find_rates(pl_mend *c, int64_t element, int place, double rate[]) {
    int n;
    const int32_t *of = pl_mend_nodes(c, element, &n);
    for (int i = 0; i < PL_MEND_NODES; i++)
        rate[i] = 0;
    pl_row_handle(c->rule[1], place, rate);
    for (int i = 0; i < n; i++)
        if (i != place && pl_mend_kind_of(c, of[i]) == PL_MEND_MID)
            rate[i] = 0;
}

/** Other free nodes of an element beside one. */
typedef struct others {
    uint16_t alone;                            /* bit i: node i is free, and nothing follows it */
    int n;                                     /* of those that some node follows, */
    double rate[PL_MEND_NODES][PL_MEND_NODES]; /* [n] how the nodes move with each */
} others;

static void find_others(pl_mend *c, int64_t element, int place, others *o) {
    int n;
    const int32_t *of = pl_mend_nodes(c, element, &n);
    o->alone = 0;
    o->n = 0;
    for (int i = 0; i < n; i++) {
        int n_rates = 0;
        if (i == place || pl_mend_kind_of(c, of[i]) == PL_MEND_HELD)
            continue;
        find_rates(c, element, i, o->rate[o->n]);
        for (int k = 0; k < n; k++)
            n_rates += o->rate[o->n][k] != 0;
        if (n_rates == 1)
            o->alone |= (uint16_t)(1 << i);
        else
            o->n++;
    }
}

/** Whether det J at a point stays wherever other nodes go. */
static int is_still_for(const proofs *p, int point, const others *o) {
    int is = (o->alone & ~p->still[point]) == 0;
    for (int i = 0; i < o->n && is; i++)
        is = is_still(p, point, o->rate[i]);
    return is;
}

/** Coefficients of det J of an element, and how they change with the way of a node. */
typedef struct coefficients {
    double D[PL_CELL_NODES], largest, slope[PL_CELL_NODES][3];
} coefficients;

/** Find the coefficients for the node at place. size: unit of the node's way. */
static void find_coefficients(pl_mend *c, int64_t element, int place, double size,
                              coefficients *to) {
    const pl_row_rule *rule = c->rule[1];
    const double sign = pl_mend_sign(c, element);
    double x[PL_CELL_NODES * 3], rate[PL_MEND_NODES];
    pl_star_row row[PL_CELL_NODES];
    uint8_t index[PL_CELL_NODES];
    *to = (coefficients){.largest = 0};
    pl_places_of_element(c->watch, element, x, NULL);
    pl_row_coefficients(rule, x, sign, to->D);
    for (int i = 0; i < rule->jacobian.n_coefficients; i++)
        to->largest = fmax(to->largest, fabs(to->D[i]));
    find_rates(c, element, place, rate);
    const int n_rows = pl_rows_of_element(rule, x, sign, rate, 1, row, index);
    for (int i = 0; i < n_rows; i++)
        for (int d = 0; d < c->dim; d++)
            to->slope[index[i]][d] = row[i].slope_d[d] * size;
}

/** Add the rows of an element for its node at place, with size the unit of the node's way. Points that
 *  move with other free nodes say nothing. */
static void add_points(proofs *p, int64_t element, int place, double size) {
    const int dim = p->curve->dim;
    others o;
    coefficients c;
    find_others(p->curve, element, place, &o);
    find_coefficients(p->curve, element, place, size, &c);
    for (int k = 0; k < p->n_points; k++) {
        double at[CONE_DIM] = {0}, length2 = 0;
        if (!is_still_for(p, k, &o))
            continue;
        at[dim] = -ROUNDING * c.largest;
        for (int i = 0; i < p->curve->rule[1]->jacobian.n_coefficients; i++) {
            at[dim] -= p->blend[k][i] * c.D[i];
            for (int d = 0; d < dim; d++)
                at[d] -= p->blend[k][i] * c.slope[i][d];
        }
        for (int d = 0; d <= dim; d++)
            length2 += at[d] * at[d];
        for (int d = 0; d <= dim && length2 > 0; d++)
            at[d] /= sqrt(length2);
        add_row(p, at, element);
    }
}

/* ---- proofs ---------------------------------------------------------------------------------- */

/** Whether the rows contradict each other, and element is needed for that: then no place of the node
 *  makes all of their elements valid. By Farkas' lemma, as in star/feasibility.c. */
static int contradict(const proofs *p, int64_t element) {
    const int dim = p->curve->dim;
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

/** Length of an element's longest edge from its first corner. */
static double size_of(const pl_mend *c, int64_t element) {
    double x[PL_CELL_NODES * 3], longest = 0;
    pl_places_of_element(c->watch, element, x, NULL);
    for (int i = 1; i <= c->dim; i++)
        longest = fmax(longest, pl_distance(c->dim, x, x + i * c->dim));
    return longest;
}

/** Whether an element is invalid wherever its node at place goes, by its own points. */
static int is_proved_alone(proofs *p, int64_t element, int place, double size) {
    p->n = 0;
    add_points(p, element, place, size);
    return contradict(p, element);
}

/** Whether an element or another one at a node of it is invalid wherever that node goes. */
static int is_proved_around(proofs *p, int64_t element, int32_t node, double size) {
    const pl_mend *c = p->curve;
    p->n = 0;
    for (int64_t k = c->begin[node]; k < c->begin[node + 1]; k++)
        if (!c->is_given_up[c->at[k]] && pl_mend_is_simplex(c, c->at[k]) &&
            pl_mend_order(c, c->at[k]) == 2)
            add_points(p, c->at[k], pl_mend_place(c, c->at[k], node), size);
    return contradict(p, element);
}

/** Whether an element that is invalid stays so wherever one of its free nodes goes, or that or others
 *  around this node do. */
static int is_hopeless(proofs *p, int64_t element) {
    pl_mend *c = p->curve;
    int n, n_free = 0;
    const int32_t *of = pl_mend_nodes(c, element, &n);
    const double size = size_of(c, element);
    for (int i = 0; i < n; i++) {
        if (pl_mend_kind_of(c, of[i]) == PL_MEND_HELD)
            continue;
        n_free++;
        if (is_proved_alone(p, element, i, size))
            return 1;
    }
    for (int i = 0; i < n && !c->lacks_memory; i++)
        if (pl_mend_kind_of(c, of[i]) != PL_MEND_HELD && is_proved_around(p, element, of[i], size))
            return 1;
    return n_free == 0 && pl_mend_decide(c, element) == PL_INVALID;
}

int pl_mend_prove(pl_mend *c, int64_t *n, int64_t *first, planish_error *error) {
    proofs p;
    *n = 0;
    if (!proofs_create(c, &p))
        c->lacks_memory = 1;
    for (int64_t i = 0; i < c->watch->n && !c->lacks_memory && !pl_limit_is_reached(c->limit);
         i++) {
        const int64_t element = pl_mend_watched_invalid(c, i);
        if (element < 0 || !is_hopeless(&p, element))
            continue;
        c->is_given_up[element] = 1;
        if ((*n)++ == 0)
            *first = element;
    }
    proofs_destroy(&p);
    return c->lacks_memory ? pl_fail_memory(error, "curved elements") : PLANISH_OK;
}
