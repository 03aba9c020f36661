/* enclosed: parts of a mesh whose boundary encloses no positive volume, and that cannot be valid.
 *
 * Free nodes are inside: the signed measures of all elements that free nodes join, one to the next,
 * add up to the same wherever these nodes are. It is what the held nodes around enclose; 0 if there
 * are none. Where that is not positive, not all elements can be.
 */
#include "improve/untangle/proofs.h"
#include "improve/untangle/tangle.h"

#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/simplex.h"

#include <math.h>

/* What is enclosed counts as nothing below this part of what its facets span with a node, as in the
 * proofs of stars; and the rounding of a determinant, relative to the products that it is made of.
 */
#define MARGIN   1e-9
#define ROUNDING 0x1p-48

/** Facts about elements that free nodes join, at the root of these nodes. */
typedef struct enclosure {
    double sum, size, products; /* of the measures of their facets with the anchor */
    int32_t anchor;             /* a held node; -1: there is none */
    int is_open;                /* a node around slides: nothing is proved */
    int64_t n_several;          /* elements with several free nodes; 0: one star, which is proved by
                                   itself, as some of its elements may be repaired */
} enclosure;

/** The work; nodes by inner numbers. Arrays are owned. */
typedef struct search {
    const planish_plan *plan;
    const double *x;
    int exponent;    /* of the largest coordinate of a held node */
    int32_t *parent; /* [n_nodes] of a union-find structure over free nodes */
    enclosure *of;   /* [n_nodes] at roots */
} search;

static int32_t root_of(const search *s, int32_t node) {
    while (s->parent[node] != node) {
        s->parent[node] = s->parent[s->parent[node]];
        node = s->parent[node];
    }
    return node;
}

static int32_t corner(const search *s, int64_t element, int j) {
    return s->plan->work.elements[element * (s->plan->dim + 1) + j];
}

/** The root of an element's free nodes, -1 if it has none; *n counts them. */
static int32_t root_of_element(const search *s, int64_t element, int *n) {
    int32_t root = -1;
    *n = 0;
    for (int j = 0; j <= s->plan->dim; j++) {
        const int32_t node = corner(s, element, j);
        if (s->plan->work.mobility[node] != PL_INTERIOR)
            continue;
        root = *n == 0 ? root_of(s, s->plan->inner[node]) : root;
        ++*n;
    }
    return root;
}

static void join_elements(search *s) {
    for (int64_t i = 0; i < s->plan->work.n_nodes; i++) {
        s->parent[i] = (int32_t)i;
        s->of[i].anchor = -1;
    }
    for (int64_t i = 0; i < s->plan->work.n_elements; i++) {
        int n;
        const int32_t first = root_of_element(s, i, &n);
        for (int j = 0, root = first; j <= s->plan->dim && n > 1; j++) {
            const int32_t node = corner(s, i, j);
            if (s->plan->work.mobility[node] != PL_INTERIOR)
                continue;
            const int32_t other = root_of(s, s->plan->inner[node]);
            const int32_t low = root < other ? root : other;
            s->parent[root] = s->parent[other] = low;
            root = low;
        }
    }
}

/** Anchors, how large coordinates are, and where nodes slide. */
static void look_around(search *s) {
    const int dim = s->plan->dim;
    double largest = 0;
    for (int64_t i = 0; i < s->plan->work.n_elements; i++) {
        int n;
        const int32_t root = root_of_element(s, i, &n);
        for (int j = 0; j <= dim && root >= 0; j++) {
            const int32_t node = corner(s, i, j), inner = s->plan->inner[node];
            if (s->plan->work.mobility[node] == PL_INTERIOR)
                continue;
            s->of[root].is_open |= s->plan->work.mobility[node] != PL_HELD;
            if (s->of[root].anchor < 0)
                s->of[root].anchor = inner;
            for (int d = 0; d < dim; d++)
                largest = fmax(largest, fabs(s->x[(int64_t)inner * dim + d]));
        }
    }
    frexp(largest, &s->exponent);
}

/** The sum of the products that a determinant is made of, without signs. */
static double products_of(int dim, const double (*e)[3]) {
    double a[3][3];
    for (int i = 0; i < dim; i++)
        for (int j = 0; j < dim; j++)
            a[i][j] = fabs(e[i][j]);
    if (dim == 2)
        return a[0][0] * a[1][1] + a[0][1] * a[1][0];
    return a[0][0] * (a[1][1] * a[2][2] + a[1][2] * a[2][1]) +
           a[0][1] * (a[1][0] * a[2][2] + a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] + a[1][1] * a[2][0]);
}

/** Add what an element with one free node measures with that at the anchor; others measure 0. */
static void add_element(search *s, int64_t element, enclosure *of) {
    const planish_plan *plan = s->plan;
    const int dim = plan->dim;
    const double *x[4];
    double e[3][3];
    for (int j = 0; j <= dim; j++) {
        const int32_t node = corner(s, element, j), inner = plan->inner[node];
        const int is_free = plan->work.mobility[node] == PL_INTERIOR;
        if (!is_free && inner == of->anchor)
            return;
        x[j] = s->x + (int64_t)(is_free ? of->anchor : inner) * dim;
    }
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = ldexp(x[j + 1][d], -s->exponent) - ldexp(x[0][d], -s->exponent);
    const double D = pl_determinant_of_edges(dim, (const double(*)[3])e);
    of->sum += plan->work.sign ? D * plan->work.sign[element] : D;
    of->size += fabs(D);
    of->products += products_of(dim, (const double(*)[3])e);
}

static void add_elements(search *s) {
    for (int64_t i = 0; i < s->plan->work.n_elements; i++) {
        int n;
        const int32_t root = root_of_element(s, i, &n);
        if (root >= 0)
            s->of[root].n_several += n > 1;
        if (n == 1 && s->of[root].anchor >= 0)
            add_element(s, i, &s->of[root]);
    }
}

/** Whether elements that are joined cannot all be positive. */
static int is_lost(const enclosure *of) {
    return !of->is_open && of->n_several > 0 &&
           of->sum + ROUNDING * of->products <= MARGIN * of->size;
}

/** Mark what is lost: elements that are below, and nodes. */
static int64_t mark(const search *s, uint8_t *state, uint8_t *lost) {
    int64_t n_marked = 0;
    for (int64_t i = 0; i < s->plan->work.n_elements; i++) {
        int n;
        const int32_t root = root_of_element(s, i, &n);
        if (root < 0 || !is_lost(&s->of[root]))
            continue;
        for (int j = 0; j <= s->plan->dim && lost; j++)
            if (s->plan->work.mobility[corner(s, i, j)] == PL_INTERIOR)
                lost[s->plan->inner[corner(s, i, j)]] = 1;
        if (state[i] != PLANISH_VOLUME_BELOW)
            continue;
        state[i] = PLANISH_VOLUME_INFEASIBLE;
        n_marked++;
    }
    return n_marked;
}

int pl_mark_enclosed(const planish_plan *plan, const double *x, uint8_t *state, uint8_t *lost,
                     int64_t *n, planish_error *error) {
    search s = {.plan = plan, .x = x};
    *n = 0;
    if (pl_part_here())
        return PLANISH_OK;
    s.parent = pl_alloc(plan->work.n_nodes, sizeof *s.parent);
    s.of = pl_alloc_zero(plan->work.n_nodes, sizeof *s.of);
    const int done = s.parent && s.of;
    if (done) {
        join_elements(&s);
        look_around(&s);
        add_elements(&s);
        *n = mark(&s, state, lost);
    }
    pl_free(s.parent);
    pl_free(s.of);
    return done ? PLANISH_OK : pl_fail_memory(error, "what the boundary encloses");
}
