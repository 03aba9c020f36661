/* create: the nodes of a fit, and the elements around them. */
#include "fit/create.h"

#include "base/memory.h"
#include "base/status.h"
#include "fit/pieces.h"
#include "topology/cells.h"

#include <inttypes.h>
#include <string.h>

/** The elements of a mesh as cells; types and offsets are owned. */
typedef struct cell_list {
    planish_cells cells;
    uint8_t *type;
    int64_t *offset;
    pl_cell_census census;
} cell_list;

/** List the mesh's elements. Errors: _MEMORY. */
static int list_cells(const planish_mesh *mesh, cell_list *list, planish_error *error) {
    const int64_t n = mesh->n_elements;
    if (mesh->cells) {
        list->cells = *mesh->cells;
        return PLANISH_OK;
    }
    list->type = pl_alloc(n, sizeof *list->type);
    list->offset = pl_alloc(n + 1, sizeof *list->offset);
    if (!list->type || !list->offset)
        return pl_fail_memory(error, "the elements of a fit");
    memset(list->type, PLANISH_CELL_TETRAHEDRON, (size_t)n);
    for (int64_t i = 0; i <= n; i++)
        list->offset[i] = 4 * i;
    list->cells =
        (planish_cells){.n = n, .type = list->type, .offset = list->offset, .node = mesh->elements};
    return PLANISH_OK;
}

static void free_list(cell_list *list) {
    pl_free(list->type);
    pl_free(list->offset);
    pl_cell_census_destroy(&list->census);
}

/** Return the number of a type's rule, which is made if there is none; -1: it is no solid of order 1, or
 *  there is no memory. */
static int rule_of(planish_fit *fit, int type) {
    const pl_cell_type *of = pl_cell_type_of(type);
    if (!of || of->shape->dim != 3 || of->order != 1)
        return -1;
    for (int i = 0; i < fit->n_rules; i++)
        if (fit->rule[i]->type == of)
            return i;
    pl_jacobian_rule *rule = pl_alloc(1, sizeof *rule);
    if (!rule)
        return -1;
    pl_jacobian_rule_make(of, rule);
    fit->rule[fit->n_rules] = rule;
    return fit->n_rules++;
}

static int has_twice(const int32_t *node, int64_t n) {
    for (int64_t i = 0; i < n; i++)
        for (int64_t j = 0; j < i; j++)
            if (node[i] == node[j])
                return 1;
    return 0;
}

/** Whether an element has a node that may have a place. */
static int is_concerned(const planish_fit *fit, const int32_t *node, int64_t n) {
    for (int64_t i = 0; i < n; i++)
        if (node[i] >= 0 && fit->own->number[node[i]] >= 0 &&
            fit->state[fit->own->number[node[i]]] == PL_FIT_PLACED)
            return 1;
    return 0;
}

/** Hold nodes of the mesh's surface. */
static void hold_nodes(planish_fit *fit, const int32_t *node, int64_t n) {
    for (int64_t k = 0; k < n; k++)
        if (node[k] >= 0 && fit->own->number[node[k]] >= 0)
            fit->state[fit->own->number[node[k]]] = PL_FIT_HELD;
}

/** Hold the corners of the facets of an element that more than two elements have. */
static void hold_shared(planish_fit *fit, const cell_list *list, int64_t element) {
    enum { MANY = 3 };
    for (int k = 0; k < PL_CELL_FACET_PLACES; k++) {
        int32_t node[4];
        if (list->census.n_sharing[element * PL_CELL_FACET_PLACES + k] < MANY)
            continue;
        const int n = pl_cell_facet(&list->cells, element, k, node);
        hold_nodes(fit, node, n);
    }
}

/** Hold the nodes of elements that no step can be judged by, or that are there twice. */
static void hold_odd(planish_fit *fit, const cell_list *list) {
    const planish_cells *cells = &list->cells;
    for (int64_t i = 0; i < cells->n; i++) {
        const int32_t *node = cells->node + cells->offset[i];
        const int64_t n = cells->offset[i + 1] - cells->offset[i];
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        if (!type || type->shape->dim != 3 || type->order != 1 || has_twice(node, n) ||
            list->census.is_duplicate[i])
            hold_nodes(fit, node, n);
        else
            hold_shared(fit, list, i);
    }
}

/** Take the elements around the nodes. Errors: _MEMORY. */
static int take_elements(planish_fit *fit, const cell_list *list, planish_error *error) {
    const planish_cells *cells = &list->cells;
    int64_t n = 0;
    for (int64_t i = 0; i < cells->n; i++)
        n += is_concerned(fit, cells->node + cells->offset[i],
                          cells->offset[i + 1] - cells->offset[i]);
    fit->element = pl_alloc(n, sizeof *fit->element);
    fit->least = pl_alloc_zero(n, sizeof *fit->least);
    for (int64_t i = 0; fit->element && i < cells->n; i++) {
        const int32_t *node = cells->node + cells->offset[i];
        const int64_t n_corners = cells->offset[i + 1] - cells->offset[i];
        const int rule = is_concerned(fit, node, n_corners) ? rule_of(fit, cells->type[i]) : -1;
        if (rule < 0)
            continue;
        pl_fit_element *e = &fit->element[fit->n_elements++];
        *e = (pl_fit_element){.sign = list->census.sign[i], .type = (uint8_t)rule};
        memcpy(e->node, node, (size_t)n_corners * sizeof *node);
    }
    return fit->element && fit->least && fit->n_elements == n
               ? PLANISH_OK
               : pl_fail_memory(error, "the elements of a fit");
}

static int n_corners_of(const planish_fit *fit, const pl_fit_element *e) {
    return fit->rule[e->type]->type->shape->n_corners;
}

/** List the elements of each node. Errors: _MEMORY. */
static int list_elements(planish_fit *fit, planish_error *error) {
    fit->offset = pl_alloc_zero(fit->n_nodes + 2, sizeof *fit->offset);
    int64_t *begin = fit->offset ? fit->offset + 1 : NULL, n = 0;
    for (int64_t i = 0; begin && i < fit->n_elements; i++)
        for (int k = 0; k < n_corners_of(fit, &fit->element[i]); k++) {
            const int32_t node = fit->own->number[fit->element[i].node[k]];
            if (node >= 0)
                begin[node]++;
        }
    for (int64_t i = 0; begin && i <= fit->n_nodes; i++) {
        const int64_t here = begin[i];
        begin[i] = n;
        n += here;
    }
    fit->element_of = pl_alloc(n, sizeof *fit->element_of);
    if (!begin || !fit->element_of)
        return pl_fail_memory(error, "the elements of a fit");
    for (int64_t i = 0; i < fit->n_elements; i++) /* begin[j] becomes the end of node j */
        for (int k = 0; k < n_corners_of(fit, &fit->element[i]); k++) {
            const int32_t node = fit->own->number[fit->element[i].node[k]];
            if (node >= 0)
                fit->element_of[begin[node]++] = (int32_t)i;
        }
    return PLANISH_OK;
}

/** Whether an element of the mesh has order 2; *at: the first one. */
static int has_order_2(const planish_cells *cells, int64_t *at) {
    for (int64_t i = 0; i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        *at = i;
        if (type && type->shape->dim == 3 && type->order == 2)
            return 1;
    }
    return 0;
}

/** Find the nodes of the boundary that nobody holds. */
static void find_nodes(planish_fit *fit, const planish_mesh *mesh) {
    const planish_shape *own = fit->own;
    for (int32_t f = 0; f < own->n_facets; f++)
        for (int k = 0; k < 3 && pl_fit_is_outer(own, f); k++) {
            const int32_t node = own->facet[f][k];
            const int is_held =
                mesh->constraint && mesh->constraint[own->node[node]] == PLANISH_CONSTRAINT_FIXED;
            fit->state[node] = is_held ? PL_FIT_HELD : PL_FIT_PLACED;
        }
}

static int allocate(planish_fit *fit, planish_error *error) {
    const int64_t n = fit->n_nodes;
    fit->state = pl_alloc_zero(n, sizeof *fit->state);
    fit->kind = pl_alloc_zero(n, sizeof *fit->kind);
    fit->is_cut = pl_alloc_zero(n, sizeof *fit->is_cut);
    fit->slides = pl_alloc_zero(n, sizeof *fit->slides);
    fit->is_there = pl_alloc_zero(n, sizeof *fit->is_there);
    fit->place = pl_alloc_zero(n, sizeof *fit->place);
    fit->goal = pl_alloc_zero(n, sizeof *fit->goal);
    fit->direction = pl_alloc_zero(n, sizeof *fit->direction);
    fit->from = pl_alloc(n, sizeof *fit->from);
    fit->part = pl_alloc_zero(n, sizeof *fit->part);
    fit->cosine = pl_alloc(n, sizeof *fit->cosine);
    fit->is_marked = pl_alloc(n, sizeof *fit->is_marked);
    fit->block = pl_alloc_zero(fit->threads, sizeof *fit->block);
    int have = fit->block != NULL;
    for (int i = 0; have && i < fit->threads; i++)
        have = (fit->block[i] = pl_alloc_zero(1, sizeof **fit->block)) != NULL;
    return have && fit->state && fit->kind && fit->is_cut && fit->slides && fit->is_there &&
                   fit->place && fit->goal && fit->direction && fit->from && fit->part &&
                   fit->cosine && fit->is_marked
               ? PLANISH_OK
               : pl_fail_memory(error, "the nodes of a fit");
}

int pl_fit_create(const planish_mesh *mesh, planish_fit *fit, planish_error *error) {
    cell_list list = {0};
    int64_t at = 0;
    fit->n_nodes = fit->own->n_nodes;
    fit->to_own = fit->own->scale / fit->onto->scale;
    int status = allocate(fit, error);
    if (!status)
        status = list_cells(mesh, &list, error);
    if (!status && has_order_2(&list.cells, &at))
        status = pl_fail_at(error, PLANISH_ERROR_ARGUMENT, at, -1,
                            "element %" PRId64 " is of order 2; only meshes of elements of order 1 "
                            "are fitted to another surface",
                            at);
    if (!status)
        status = pl_cell_census_find(&list.cells, 3, mesh->n_nodes, mesh->coordinates, fit->threads,
                                     &list.census, error);
    if (!status) {
        find_nodes(fit, mesh);
        hold_odd(fit, &list);
        status = take_elements(fit, &list, error);
    }
    if (!status)
        status = list_elements(fit, error);
    free_list(&list);
    return status;
}

void pl_fit_destroy(planish_fit *fit) {
    pl_free(fit->state);
    pl_free(fit->kind);
    pl_free(fit->is_cut);
    pl_free(fit->slides);
    pl_free(fit->is_there);
    pl_free(fit->place);
    pl_free(fit->goal);
    pl_free(fit->direction);
    pl_fit_free_pieces(&fit->pieces);
    pl_fit_free_pieces(&fit->own_pieces);
    pl_free(fit->piece_of);
    pl_free(fit->side);
    pl_free(fit->partner);
    pl_free(fit->is_taken);
    pl_free(fit->covered);
    pl_free(fit->turn);
    pl_free(fit->is_corner);
    pl_tree_destroy(&fit->facets);
    pl_tree_destroy(&fit->edges);
    pl_tree_destroy(&fit->corners);
    pl_free(fit->element);
    pl_free(fit->least);
    pl_free(fit->offset);
    pl_free(fit->element_of);
    pl_free(fit->from);
    pl_free(fit->part);
    pl_free(fit->cosine);
    pl_free(fit->is_marked);
    for (int i = 0; i < fit->n_rules; i++)
        pl_free(fit->rule[i]);
    for (int i = 0; fit->block && i < fit->threads; i++)
        pl_free(fit->block[i]);
    pl_free(fit->block);
    *fit = (planish_fit){0};
}
