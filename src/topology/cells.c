/* cells: the lowest element that is wrong is found on all threads; then it is told what is wrong. */
#include "topology/cells.h"
#include "topology/no_node.h"

#include "base/parallel.h"
#include "base/status.h"
#include "geometry/cell.h"

#include <inttypes.h>

enum { CHUNK = 4096 }; /* elements that one thread checks at a time */

/** A search for the lowest element that is wrong. */
typedef struct lowest_search {
    const planish_cells *cells;
    int64_t n_nodes;
    int64_t lowest; /* INT64_MAX: none so far; shared */
} lowest_search;

/** Number of nodes of a type; -1: there is no such type. */
static int nodes_of_type(int type) {
    if (type == PLANISH_CELL_VERTEX)
        return 1;
    if (type == PLANISH_CELL_LINE || type == PLANISH_CELL_LINE3)
        return type == PLANISH_CELL_LINE ? 2 : 3;
    const pl_cell_type *of = pl_cell_type_of(type);
    return of ? of->n_nodes : -1;
}

/** Whether node i of an element of a type may be missing: the mid of an edge. */
static int may_be_missing(const pl_cell_type *type, int i) {
    if (!type || i < type->shape->n_corners)
        return 0;
    for (int e = 0; e < type->shape->n_edges; e++) {
        const uint8_t *edge = type->shape->edge[e], *pair = type->between[i];
        if ((edge[0] == pair[0] && edge[1] == pair[1]) ||
            (edge[0] == pair[1] && edge[1] == pair[0]))
            return 1;
    }
    return 0;
}

static int is_simplex(const pl_cell_type *type) {
    return type && type->shape->n_simplices == 1;
}

/** Check an element, whose offsets are in order. */
static int check_cell(const planish_cells *cells, int64_t n_nodes, int64_t element,
                      planish_error *error) {
    const int type = cells->type[element], n = nodes_of_type(type);
    const int64_t given = cells->offset[element + 1] - cells->offset[element];
    const pl_cell_type *of = pl_cell_type_of(type);
    const int32_t *node = cells->node + cells->offset[element];
    char there[PL_NODES_TEXT];
    if (n < 0)
        return pl_fail_at(error, PLANISH_ERROR_MESH, element, -1,
                          "element %" PRId64
                          " is of type %d, which is not a planish_cell_type; leave the element out",
                          element, type);
    if (given != n)
        return pl_fail_at(error, PLANISH_ERROR_MESH, element, -1,
                          "element %" PRId64 " of type %d has %" PRId64
                          " nodes by its offsets, but "
                          "elements of that type have %d; correct type or offsets",
                          element, type, given, n);
    for (int i = 0; i < n; i++) {
        if (node[i] == -1 && may_be_missing(of, i))
            continue;
        if (node[i] < 0 || node[i] >= n_nodes)
            return pl_fail_at(error, PLANISH_ERROR_MESH, element, node[i],
                              "element %" PRId64 " has node %" PRId32
                              ", but the mesh has %s; correct the element%s",
                              element, node[i], pl_nodes_there(n_nodes, there),
                              pl_no_node_hint(node[i], n_nodes));
        for (int j = 0; is_simplex(of) && j < i; j++)
            if (node[i] == node[j])
                return pl_fail_at(error, PLANISH_ERROR_MESH, element, node[i],
                                  "element %" PRId64 " has node %" PRId32
                                  " twice; remove the collapsed element",
                                  element, node[i]);
    }
    return PLANISH_OK;
}

static void check_chunk(void *context, int64_t begin, int64_t end, int thread) {
    lowest_search *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (check_cell(s->cells, s->n_nodes, i, NULL)) {
            pl_lower_to(&s->lowest, i);
            return;
        }
}

int pl_check_cell_fields(const planish_cells *cells, planish_error *error) {
    if (cells->n < 0 || cells->n > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "cells.n is %" PRId64 "; give 0 to %d elements", cells->n, INT32_MAX);
    if (cells->n > 0 && (!cells->type || !cells->offset || !cells->node))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "cells has no array of types, offsets or nodes; give all three");
    return pl_check_reserved("planish_cells", cells->reserved, sizeof cells->reserved, error);
}

int pl_check_cells(const planish_cells *cells, int64_t n_nodes, int threads, planish_error *error) {
    const int status = pl_check_cell_fields(cells, error);
    if (status)
        return status;
    for (int64_t i = 0; i < cells->n; i++)
        if (cells->offset[i + 1] < cells->offset[i] || cells->offset[0] != 0)
            return pl_fail_at(error, PLANISH_ERROR_MESH, i, -1,
                              "the offsets of element %" PRId64 " are %" PRId64 " and %" PRId64
                              "; they begin at 0 and ascend",
                              i, cells->offset[i], cells->offset[i + 1]);
    lowest_search s = {.cells = cells, .n_nodes = n_nodes, .lowest = INT64_MAX};
    pl_parallel_for(threads, cells->n, CHUNK, check_chunk, &s);
    return s.lowest == INT64_MAX ? PLANISH_OK : check_cell(cells, n_nodes, s.lowest, error);
}
