/* elements: the elements at each node of a mesh with curved simplices, and which nodes may move. */
#include "improve/mend/elements.h"

#include "base/memory.h"
#include "base/status.h"
#include "shape/curved.h"

#include <math.h>
#include <string.h>

int pl_mend_order(const pl_mend *c, int64_t element) {
    return pl_cell_type_of(c->plan->cells.type[pl_plan_element(c->plan, element)])->order;
}

int pl_mend_is_simplex(const pl_mend *c, int64_t element) {
    const int type = c->plan->cells.type[pl_plan_element(c->plan, element)];
    return pl_cell_type_of(type)->shape->n_corners == c->dim + 1;
}

const int32_t *pl_mend_nodes(const pl_mend *c, int64_t element, int *n) {
    const planish_cells *cells = &c->plan->cells;
    const int64_t cell = pl_plan_element(c->plan, element);
    *n = (int)(cells->offset[cell + 1] - cells->offset[cell]);
    return cells->node + cells->offset[cell];
}

int32_t pl_mend_corner(const pl_mend *c, int64_t element, int i) {
    return c->plan->work.elements[element * (c->dim + 1) + i];
}

double pl_mend_sign(const pl_mend *c, int64_t element) {
    return c->plan->work.sign ? c->plan->work.sign[element] : 1;
}

int pl_mend_place(const pl_mend *c, int64_t element, int32_t node) {
    int n, i = 0;
    const int32_t *of = pl_mend_nodes(c, element, &n);
    while (of[i] != node)
        i++;
    return i;
}

/** Places in an element of the ends of the edge that a node of it is the mid of. */
static const uint8_t *ends_in(const pl_mend *c, int64_t element, int32_t mid) {
    return c->rule[1]->jacobian.type->between[pl_mend_place(c, element, mid)];
}

const uint8_t *pl_mend_ends(const pl_mend *c, int32_t mid) {
    return ends_in(c, c->at[c->begin[mid]], mid);
}

/* ---- kinds of nodes -------------------------------------------------------------------------- */

/** Count the tetrahedra at an edge, whose mid is given, that have a node as a corner. */
static int count_with_corner(const pl_mend *c, int32_t mid, int32_t corner) {
    int count = 0, n;
    for (int64_t k = c->begin[mid]; k < c->begin[mid + 1]; k++) {
        const int32_t *of = pl_mend_nodes(c, c->at[k], &n);
        for (int i = 0; i < 4; i++)
            count += of[i] == corner;
    }
    return count;
}

/** Whether a mid is inside: the elements at its edge close around it. */
static int closes(const pl_mend *c, int32_t mid) {
    if (c->dim == 2)
        return c->begin[mid + 1] - c->begin[mid] == 2;
    for (int64_t k = c->begin[mid]; k < c->begin[mid + 1]; k++) {
        int n;
        const int32_t *of = pl_mend_nodes(c, c->at[k], &n);
        const uint8_t *ends = ends_in(c, c->at[k], mid);
        for (int i = 0; i < 4; i++)
            if (i != ends[0] && i != ends[1] && count_with_corner(c, mid, of[i]) != 2)
                return 0;
    }
    return 1;
}

static int has_simplices_alone(const pl_mend *c, int32_t node) {
    for (int64_t k = c->begin[node]; k < c->begin[node + 1]; k++)
        if (!pl_mend_is_simplex(c, c->at[k]))
            return 0;
    return 1;
}

/** Whether an end of a mid's edge moves. */
static int has_moving_end(const pl_mend *c, int32_t mid) {
    const int64_t element = c->at[c->begin[mid]];
    const uint8_t *ends = pl_mend_ends(c, mid);
    return c->mobility[pl_mend_corner(c, element, ends[0])] != PL_HELD ||
           c->mobility[pl_mend_corner(c, element, ends[1])] != PL_HELD;
}

/** Whether the caller's choice of nodes, if there is one, has an end of a mid's edge. */
static int has_chosen_end(const pl_mend *c, int32_t mid) {
    return (!c->options->around && !c->plan->is_selective) || has_moving_end(c, mid);
}

/** Whether a node is on the shape that the surface is to keep, be it between regions. */
static int is_on_shape(const pl_mend *c, int32_t node) {
    const planish_shape *shape = c->options->shape;
    return shape && shape->number[node] >= 0;
}

/** Kind of a node that follows others. On the shape it goes where the skin says: proofs cannot tell. */
static pl_mend_kind kind_of_mid(const pl_mend *c, int32_t node, int role) {
    if (!has_simplices_alone(c, node) || (role & (PL_OF_EDGES | PL_BOUND)))
        return PL_MEND_HELD;
    if (is_on_shape(c, node))
        return has_moving_end(c, node) ? PL_MEND_SLIDES : PL_MEND_HELD;
    return closes(c, node) && has_chosen_end(c, node) ? PL_MEND_MID : PL_MEND_HELD;
}

/** Mobility of a node as a corner; a mid has none. */
static int mobility_of(const pl_mend *c, int32_t node) {
    if (c->plan->work.corner)
        return c->mobility[node];
    for (int64_t k = c->begin[node]; k < c->begin[node + 1]; k++) {
        const int place = pl_mend_place(c, c->at[k], node);
        if (place <= c->dim)
            return c->mobility[pl_mend_corner(c, c->at[k], place)];
    }
    return PL_HELD;
}

static pl_mend_kind find_kind(const pl_mend *c, int32_t node) {
    const int role = c->plan->role[node];
    if (c->begin[node] == c->begin[node + 1] || (c->is_outside && c->is_outside[node]))
        return PL_MEND_HELD;
    if (pl_follows((uint8_t)role))
        return kind_of_mid(c, node, role);
    const int mobility = mobility_of(c, node);
    if (mobility == PL_INTERIOR && !(role & (PL_OF_MID | PL_OF_OTHER)) &&
        has_simplices_alone(c, node))
        return PL_MEND_CORNER;
    return mobility != PL_HELD ? PL_MEND_SLIDES : PL_MEND_HELD;
}

pl_mend_kind pl_mend_kind_of(pl_mend *c, int32_t node) {
    if (node < 0)
        return PL_MEND_HELD;
    if (c->kind[node] == PL_MEND_UNKNOWN)
        c->kind[node] = (uint8_t)find_kind(c, node);
    return (pl_mend_kind)c->kind[node];
}

/* ---- the view -------------------------------------------------------------------------------- */

/** All nodes of a cell of the plan. */
static int nodes_of_cell(const void *context, int64_t cell, int32_t node[PL_CELL_NODES]) {
    const pl_mend *c = context;
    int n;
    const int32_t *of = pl_mend_nodes(c, pl_first_of_cell(&c->plan->work, cell), &n);
    memcpy(node, of, (size_t)n * sizeof *node);
    return n;
}

/** List the elements of all nodes of the mesh. */
static int list_elements(pl_mend *c) {
    const planish_plan *plan = c->plan;
    pl_incidence cells;
    if (!pl_items_of_nodes(plan->whole.n_nodes, pl_view_cells(&plan->work), nodes_of_cell, c, 1,
                           &cells))
        return 0;
    c->begin = cells.offset;
    c->at = cells.element;
    for (int64_t k = 0; k < c->begin[plan->whole.n_nodes]; k++)
        c->at[k] = (int32_t)pl_first_of_cell(&plan->work, c->at[k]);
    return 1;
}

/** Mark the nodes of elements that the plan, which is of a subset, lacks. */
static int find_outside(pl_mend *c) {
    const planish_plan *plan = c->plan;
    const planish_cells *cells = &plan->cells;
    if (plan->scope == PL_ALL)
        return 1;
    uint8_t *is_inside = pl_alloc_zero(cells->n, 1);
    c->is_outside = pl_alloc_zero(plan->whole.n_nodes, 1);
    for (int64_t e = 0; is_inside && e < plan->work.n_elements; e++)
        is_inside[pl_plan_element(plan, e)] = 1;
    for (int64_t i = 0; is_inside && c->is_outside && i < cells->n; i++)
        for (int64_t k = cells->offset[i]; !is_inside[i] && k < cells->offset[i + 1]; k++)
            if (cells->node[k] >= 0)
                c->is_outside[cells->node[k]] = 1;
    const int done = is_inside && c->is_outside;
    pl_free(is_inside);
    return done;
}

void pl_mend_destroy(pl_mend *c) {
    pl_free(c->begin);
    pl_free(c->at);
    pl_free(c->kind);
    pl_free(c->is_outside);
    pl_free(c->is_given_up);
    pl_row_rule_free(c->rule[0]);
    pl_row_rule_free(c->rule[1]);
}

int pl_mend_create(pl_mend *c, planish_error *error) {
    const int is_plane = c->plan->dim == 2;
    c->dim = c->plan->dim;
    c->kind = pl_alloc_zero(c->plan->whole.n_nodes, 1);
    c->is_given_up = pl_alloc_zero(c->plan->work.n_elements, 1);
    c->rule[0] = pl_row_rule_make(
        pl_cell_type_of(is_plane ? PLANISH_CELL_TRIANGLE : PLANISH_CELL_TETRAHEDRON));
    c->rule[1] = pl_row_rule_make(
        pl_cell_type_of(is_plane ? PLANISH_CELL_TRIANGLE6 : PLANISH_CELL_TETRAHEDRON10));
    if (!c->kind || !c->is_given_up || !c->rule[0] || !c->rule[1] || !list_elements(c) ||
        !find_outside(c))
        return pl_fail_memory(error, "curved elements");
    return PLANISH_OK;
}

/* ---- validity and quality -------------------------------------------------------------------- */

pl_validity pl_mend_decide(const pl_mend *c, int64_t element) {
    return pl_watch_decide(c->watch, pl_cell_with(c->plan, element));
}

int64_t pl_mend_watched(const pl_mend *c, int64_t i) {
    const pl_watch *w = c->watch;
    if (w->type[i] != c->rule[1]->jacobian.type->type)
        return -1;
    const int64_t element = pl_first_of_cell(&c->plan->work, pl_watch_cell(w, i));
    return c->is_given_up[element] ? -1 : element;
}

int64_t pl_mend_watched_invalid(const pl_mend *c, int64_t i) {
    return c->watch->state[i] & PL_WATCH_VALID ? -1 : pl_mend_watched(c, i);
}

double pl_mend_quality(const pl_mend *c, int64_t element) {
    const pl_row_rule *rule = c->rule[pl_mend_order(c, element) - 1];
    double x[PL_CELL_NODES * 3], coefficient[PL_JACOBIAN_COEFFICIENTS], least = INFINITY, mean = 0;
    const int n = rule->jacobian.n_coefficients;
    pl_places_of_element(c->watch, element, x, NULL);
    pl_row_coefficients(rule, x, pl_mend_sign(c, element), coefficient);
    for (int i = 0; i < n; i++) {
        least = fmin(least, coefficient[i]);
        mean += coefficient[i] / n;
    }
    return mean > 0 ? least / mean : -INFINITY;
}
