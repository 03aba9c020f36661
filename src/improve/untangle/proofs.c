/* proofs: which elements below their minimum volumes stay so for ever.
 *
 * Parts of a mesh whose boundary encloses no positive volume cannot be valid. Free nodes are
 * inside: the signed measures of all cells that free nodes join, one to the next, add up to the
 * same wherever these nodes are. It is the volume that the held nodes around enclose; 0 if there
 * are none. Where that is not positive, not all elements can be. Stars are proved by
 * star/feasibility.c.
 */
#include "improve/untangle/proofs.h"
#include "improve/untangle/given_up.h"

#include "base/clock.h"
#include "base/joined.h"
#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/simplex.h"

#include <math.h>

/* ---- enclosed volumes ----------------------------------------------------------------------- */

/* What is enclosed counts as nothing below this part of what its facets span with a node, as in the
 * proofs of stars; and the rounding of a determinant, relative to the products that it is made of.
 */
#define MARGIN   1e-9
#define ROUNDING 0x1p-48

/** Facts about cells that free nodes join, at the root of these nodes. */
typedef struct enclosure {
    double sum, size, products; /* of the measures of their facets with the anchor */
    int32_t anchor;             /* a held node; -1: there is none */
    int is_open;                /* a node around slides: nothing is proved */
    int64_t n_several;          /* cells with several free nodes; 0: one star, which is proved by
                                   itself, as some of its elements may be repaired */
} enclosure;

/** The cells that free nodes join; nodes by inner numbers. Arrays are owned. */
typedef struct enclosures {
    const planish_plan *plan;
    const double *x;
    int exponent;    /* of the largest coordinate of a held node */
    int32_t *parent; /* [n_nodes] of a union-find structure over free nodes */
    enclosure *of;   /* [n_nodes] at roots */
} enclosures;

static int32_t corner(const enclosures *s, int64_t element, int j) {
    return s->plan->work.elements[element * (s->plan->dim + 1) + j];
}

/** Whether the measure of the cell of an element is the weighted sum of those of its corners: not of
 *  hexahedra and wedges. */
static int has_measure_of_corners(const planish_plan *plan, int64_t element) {
    const int kind = plan->work.corner ? pl_corner_kind(plan->work.corner[element]) : 0;
    return plan->dim == 2 || kind == PL_KIND_SIMPLEX || kind == PL_KIND_PYRAMID;
}

/** Weight of an element, relative to a simplex. */
static double share_of(const planish_plan *plan, int64_t element) {
    if (!plan->work.corner)
        return 1;
    const pl_corner_form *form = &plan->form[pl_form_code(plan->work.corner[element], 0, 0)];
    return form->share * form->volume / plan->form[PL_KIND_SIMPLEX].volume;
}

static int is_free(const enclosures *s, int32_t node) {
    return s->plan->work.mobility[node] == PL_INTERIOR;
}

/** A cell. */
typedef struct cell {
    int64_t begin, end; /* its elements */
    int32_t root;       /* of its free nodes; -1: it has none */
    int has_several;    /* free nodes */
} cell;

static cell cell_at(const enclosures *s, int64_t index) {
    const int corners = s->plan->dim + 1;
    cell c = {.begin = pl_first_of_cell(&s->plan->work, index),
              .end = pl_first_of_cell(&s->plan->work, index + 1),
              .root = -1};
    int32_t first = -1;
    for (int64_t i = c.begin * corners; i < c.end * corners; i++) {
        const int32_t node = s->plan->work.elements[i];
        if (!is_free(s, node))
            continue;
        c.has_several |= first >= 0 && node != first;
        first = first < 0 ? node : first;
    }
    if (first >= 0)
        c.root = pl_class_of(s->parent, s->plan->inner[first]);
    return c;
}

static void join_cells(enclosures *s) {
    const int corners = s->plan->dim + 1;
    for (int64_t i = 0; i < s->plan->work.n_nodes; i++) {
        s->parent[i] = (int32_t)i;
        s->of[i].anchor = -1;
    }
    for (int64_t k = 0; k < pl_view_cells(&s->plan->work); k++) {
        const cell c = cell_at(s, k);
        int32_t root = c.root;
        for (int64_t i = c.begin * corners; i < c.end * corners && c.has_several; i++)
            if (is_free(s, s->plan->work.elements[i]))
                root = pl_join(s->parent, root, s->plan->inner[s->plan->work.elements[i]]);
    }
}

/** Find anchors, how large coordinates are, where nodes slide, and cells with several free nodes.
 *  Where an element's measure is not that of its corners nothing is proved either. */
static void find_anchors(enclosures *s) {
    const int dim = s->plan->dim, corners = dim + 1;
    double largest = 0;
    for (int64_t k = 0; k < pl_view_cells(&s->plan->work); k++) {
        const cell c = cell_at(s, k);
        if (c.root < 0)
            continue;
        s->of[c.root].n_several += c.has_several;
        s->of[c.root].is_open |= !has_measure_of_corners(s->plan, c.begin);
        for (int64_t i = c.begin * corners; i < c.end * corners; i++) {
            const int32_t node = s->plan->work.elements[i], inner = s->plan->inner[node];
            if (is_free(s, node))
                continue;
            s->of[c.root].is_open |= s->plan->work.mobility[node] != PL_HELD;
            if (s->of[c.root].anchor < 0)
                s->of[c.root].anchor = inner;
            for (int d = 0; d < dim; d++)
                largest = fmax(largest, fabs(s->x[(int64_t)inner * dim + d]));
        }
    }
    frexp(largest, &s->exponent);
}

/** Return the sum of the products that a determinant is made of, without signs. */
static double products_of(int dim, const double (*e)[3]) {
    double a[3][3] = {{0}};
    for (int i = 0; i < dim; i++)
        for (int j = 0; j < dim; j++)
            a[i][j] = fabs(e[i][j]);
    if (dim == 2)
        return a[0][0] * a[1][1] + a[0][1] * a[1][0];
    return a[0][0] * (a[1][1] * a[2][2] + a[1][2] * a[2][1]) +
           a[0][1] * (a[1][0] * a[2][2] + a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] + a[1][1] * a[2][0]);
}

/** Add the measure of an element with its free nodes at the anchor: 0 with several. */
static void add_element(enclosures *s, int64_t element, enclosure *of) {
    const planish_plan *plan = s->plan;
    const int dim = plan->dim;
    const double *x[4];
    double e[3][3];
    int n_at_anchor = 0;
    for (int j = 0; j <= dim; j++) {
        const int32_t node = corner(s, element, j), inner = plan->inner[node];
        n_at_anchor += is_free(s, node) || inner == of->anchor;
        if (n_at_anchor > 1)
            return;
        x[j] = s->x + (int64_t)(is_free(s, node) ? of->anchor : inner) * dim;
    }
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = ldexp(x[j + 1][d], -s->exponent) - ldexp(x[0][d], -s->exponent);
    const double D = share_of(plan, element) * pl_determinant_of_edges(dim, (const double(*)[3])e);
    of->sum += plan->work.sign ? D * plan->work.sign[element] : D;
    of->size += fabs(D);
    of->products += products_of(dim, (const double(*)[3])e);
}

/** Mark elements that are joined and cannot all be positive, if they are below, and their nodes. */
static int64_t give_up(const enclosures *s, uint8_t *state, uint8_t *given_up) {
    int64_t n_marked = 0;
    for (int64_t k = 0; k < pl_view_cells(&s->plan->work); k++) {
        const cell c = cell_at(s, k);
        const enclosure *of = c.root < 0 ? NULL : &s->of[c.root];
        int is_below = 0;
        if (!of || of->is_open || of->n_several == 0 ||
            !(of->sum + ROUNDING * of->products <= MARGIN * of->size))
            continue;
        for (int64_t i = c.begin; i < c.end; i++) {
            for (int j = 0; j <= s->plan->dim && given_up; j++)
                if (is_free(s, corner(s, i, j)))
                    given_up[s->plan->inner[corner(s, i, j)]] = 1;
            is_below |= state[i] == PLANISH_VOLUME_BELOW;
            if (state[i] == PLANISH_VOLUME_BELOW)
                state[i] = PLANISH_VOLUME_INFEASIBLE;
        }
        n_marked += is_below;
    }
    return n_marked;
}

int pl_mark_enclosed(const planish_plan *plan, const double *x, uint8_t *state, uint8_t *given_up,
                     int64_t *n, planish_error *error) {
    enclosures s = {.plan = plan, .x = x};
    *n = 0;
    if (pl_part_here())
        return PLANISH_OK;
    s.parent = pl_alloc(plan->work.n_nodes, sizeof *s.parent);
    s.of = pl_alloc_zero(plan->work.n_nodes, sizeof *s.of);
    const int done = s.parent && s.of;
    if (done) {
        join_cells(&s);
        find_anchors(&s);
        for (int64_t k = 0; k < pl_view_cells(&plan->work); k++) {
            const cell c = cell_at(&s, k);
            for (int64_t i = c.begin; i < c.end; i++)
                if (c.root >= 0 && s.of[c.root].anchor >= 0)
                    add_element(&s, i, &s.of[c.root]);
        }
        *n = give_up(&s, state, given_up);
    }
    pl_free(s.parent);
    pl_free(s.of);
    return done ? PLANISH_OK : pl_fail_memory(error, "what the boundary encloses");
}

/* ---- stars ---------------------------------------------------------------------------------- */

/** The search for proofs. */
typedef struct proof_search {
    const planish_plan *plan;
    const pl_star_problem *problem;
    uint8_t *state;
    double *scratch;     /* of the kernels */
    int32_t *star_of;    /* [n] by inner numbers: the star of a free node; -1: of a ghost */
    int32_t *next_facet; /* [n_stars] link facets of the star seen so far */
    uint8_t *is_fixed;   /* [n] by inner numbers */
    uint8_t *is_wanted;  /* [n_stars] a proof at the star would decide about an element */
    uint8_t *part;       /* [link facets of all stars] pl_proof_role */
} proof_search;

/** Return the only star that can prove something of an element; -1: it has no free node, -2: it has
 * several, or one that slides or is a ghost: of that nothing is proved. */
static int32_t only_star(const proof_search *s, int64_t element) {
    const planish_plan *plan = s->plan;
    int32_t node = -1;
    for (int j = 0; j <= plan->dim; j++) {
        const int32_t other = plan->work.elements[element * (plan->dim + 1) + j];
        if (plan->work.mobility[other])
            node = node == -1 && plan->work.mobility[other] == PL_INTERIOR ? other : -2;
    }
    if (node < 0)
        return node;
    return s->star_of[plan->inner[node]] < 0 ? -2 : s->star_of[plan->inner[node]];
}

/** Whether two fixed nodes of an element are at the same place: it has no volume then. */
static int has_coincident_nodes(const proof_search *s, int64_t element) {
    const planish_plan *plan = s->plan;
    const int dim = plan->dim;
    const int32_t *node = plan->work.elements + element * (dim + 1);
    for (int j = 0; j <= dim; j++)
        for (int k = 0; k < j; k++) {
            const double *x = s->problem->coordinates + (int64_t)plan->inner[node[j]] * dim;
            const double *y = s->problem->coordinates + (int64_t)plan->inner[node[k]] * dim;
            int same = !plan->work.mobility[node[j]] && !plan->work.mobility[node[k]];
            for (int d = 0; d < dim; d++)
                same &= x[d] == y[d];
            if (same)
                return 1;
        }
    return 0;
}

/** Look for proofs at the stars that could decide about elements, one after another. A limit that
 *  one process has reached is reached in all. */
static void look_for_proofs(proof_search *s, pl_stop_check *limit) {
    const planish_plan *plan = s->plan;
    const pl_stars *stars = &plan->interior.stars;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        if (s->state[i] != PLANISH_VOLUME_BELOW)
            continue;
        const int32_t star = only_star(s, i);
        if (star == -1 || has_coincident_nodes(s, i))
            s->state[i] = PLANISH_VOLUME_INFEASIBLE;
        else if (star >= 0)
            s->is_wanted[star] = 1;
    }
    for (int64_t i = 0; i < stars->n_stars && !pl_limit_is_reached(limit); i++)
        if (s->is_wanted[i]) {
            pl_star_infeasible(s->problem, i, plan->dim, s->is_fixed, s->scratch,
                               s->part + stars->link_offset[i], limit);
            s->is_wanted[i] = pl_limit_is_reached(limit) != 0; /* and else it is decided */
        }
    if (!limit)
        return;
    double answer = limit->answer;
    pl_parts_largest(&answer, 1);
    limit->answer = (int)answer;
}

/** Mark elements by the proofs of their stars, whose facets are in the order of their elements. If
 *  given_up only those that are, else all that are below and part of a proof. */
static int64_t mark_elements(proof_search *s, int given_up) {
    const planish_plan *plan = s->plan;
    int64_t n_infeasible = 0;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        for (int j = 0; j <= plan->dim; j++) {
            const int32_t node = plan->work.elements[i * (plan->dim + 1) + j];
            const int32_t star = s->star_of[plan->inner[node]];
            if (star < 0)
                continue;
            const uint8_t part =
                s->part[plan->interior.stars.link_offset[star] + s->next_facet[star]++];
            if (given_up ? part == PL_PROOF_GIVEN_UP
                         : part != PL_PROOF_NONE && s->state[i] == PLANISH_VOLUME_BELOW)
                s->state[i] = PLANISH_VOLUME_INFEASIBLE;
        }
        n_infeasible += s->state[i] == PLANISH_VOLUME_INFEASIBLE;
    }
    return n_infeasible;
}

int pl_mark_infeasible(const planish_plan *plan, const pl_star_problem *problem, uint8_t *state,
                       pl_stop_check *limit, pl_infeasible *found, uint8_t **part,
                       planish_error *error) {
    const int64_t n = plan->work.n_nodes, n_stars = plan->interior.stars.n_stars;
    proof_search s = {.plan = plan,
                      .problem = problem,
                      .state = state,
                      .scratch = pl_alloc(plan->scratch.kernel_stride, sizeof *s.scratch),
                      .star_of = pl_alloc(n, sizeof *s.star_of),
                      .next_facet = pl_alloc_zero(n_stars, sizeof *s.next_facet),
                      .is_fixed = pl_alloc(n, sizeof *s.is_fixed),
                      .is_wanted = pl_alloc_zero(n_stars, sizeof *s.is_wanted),
                      .part =
                          pl_alloc_zero(plan->interior.stars.link_offset[n_stars], sizeof *s.part)};
    const int done = s.scratch && s.star_of && s.next_facet && s.is_fixed && s.is_wanted && s.part;
    if (done) {
        for (int64_t i = 0; i < n; i++)
            s.is_fixed[plan->inner[i]] = !plan->work.mobility[i];
        pl_plan_number_stars(plan, s.star_of);
        look_for_proofs(&s, limit);
        found->n = mark_elements(&s, part != NULL);
        found->n_undecided = 0;
        /* Stars that were not searched to the end could tell more of their elements. */
        for (int64_t c = 0; limit && limit->answer && c < pl_view_cells(&plan->work); c++) {
            const int64_t end = pl_first_of_cell(&plan->work, c + 1);
            int any = 0;
            for (int64_t i = pl_first_of_cell(&plan->work, c); i < end; i++) {
                const int32_t star = state[i] == PLANISH_VOLUME_BELOW ? only_star(&s, i) : -1;
                any |= star >= 0 && s.is_wanted[star];
            }
            found->n_undecided += any;
        }
        if (part) {
            *part = s.part;
            s.part = NULL;
        }
    }
    pl_free(s.scratch);
    pl_free(s.star_of);
    pl_free(s.next_facet);
    pl_free(s.is_fixed);
    pl_free(s.is_wanted);
    pl_free(s.part);
    return done ? PLANISH_OK : pl_fail_memory(error, "the search for infeasible elements");
}
