/* mids: lines and facets that a file lists by their corners alone get the mids of the elements.
 *
 * The edges and quadrilaterals that lack a node are numbered. Elements then say which node each has; if
 * they differ, it is the first of these nodes. Last the nodes are put into the lists.
 */
#include "io/core/mids.h"

#include "io/core/elements.h"
#include "io/core/part_numbers.h"
#include "io/core/parts.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <string.h>

enum { CHUNK = 1 << 14, N_LOWER = 3, EDGE = 2, QUADRILATERAL = 4, MOST_NODES = 9 };

/** Parts of one kind of lines and facets that lack the node in their middle. */
typedef struct lacks {
    io_part_numbers numbers;
    int32_t *node; /* [numbers.n] owned: what elements have there, -1: nothing */
} lacks;

typedef struct completion {
    io_model *model;
    planish_error *error;
    int dim;                     /* of the elements */
    int have_mids, have_middles; /* elements, on edges and on quadrilaterals */
    io_list elements;            /* that threads look at */
    uint8_t *is_corner;          /* [n_nodes] owned: of a part that lacks its node */
    lacks edges, quadrilaterals;
} completion;

/** A line or facet, or an element, with all nodes that its type may have; -1: it lacks one. */
typedef struct cell {
    int32_t node[IO_CELL_NODES];
    int dim, corners, n_edges; /* mids stand behind the corners, a middle behind these */
    int is_quadrilateral;
} cell;

/** Return element i of a list, which lacks what its type does not have. */
static cell cell_of(const io_list *list, int64_t i) {
    cell c = {.dim = list->dim};
    for (int k = 0; k < IO_CELL_NODES; k++)
        c.node[k] = -1;
    io_list_all_nodes(list, i, c.node, &c.corners);
    c.n_edges = list->dim == 1 ? 1 : io_parts_of(list->dim, c.corners)->n_edges;
    c.is_quadrilateral = list->dim == 2 && c.corners == 4;
    return c;
}

/** Find the corners of edge e of a cell. */
static void edge_of(const cell *c, int e, int32_t ends[2]) {
    static const int8_t of_line[2] = {0, 1};
    const int8_t *at = c->dim == 1 ? of_line : io_parts_of(c->dim, c->corners)->edge[e];
    ends[0] = c->node[at[0]];
    ends[1] = c->node[at[1]];
}

/* ---- what is missing ------------------------------------------------------------------------- */

/** Note a part that lacks its node. */
static int note_lack(completion *c, lacks *of, const int32_t *corners) {
    int32_t number;
    for (int k = 0; k < of->numbers.width; k++)
        c->is_corner[corners[k]] = 1;
    return io_part_numbers_add(&of->numbers, corners, &number, c->error);
}

/** Note what the lines or facets of a list lack. */
static int note_list(completion *c, const io_list *list) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < list->n && !status; i++) {
        const cell of = cell_of(list, i);
        int32_t ends[2];
        for (int e = 0; e < of.n_edges && !status; e++) {
            edge_of(&of, e, ends);
            if (of.node[of.corners + e] < 0)
                status = note_lack(c, &c->edges, ends);
        }
        if (of.is_quadrilateral && c->have_middles && of.node[of.corners + of.n_edges] < 0 &&
            !status)
            status = note_lack(c, &c->quadrilaterals, of.node);
    }
    return status;
}

/* ---- what elements have ------------------------------------------------------------------------ */

static int make_nodes(lacks *of, planish_error *error) {
    of->node = pl_alloc(of->numbers.n, sizeof *of->node);
    if (!of->node)
        return pl_fail_memory(error, "the mids of facets");
    memset(of->node, -1, (size_t)of->numbers.n * sizeof *of->node);
    return PLANISH_OK;
}

/** Note that an element has a node, if it is not -1, in the middle of a part. */
static void note_node(const completion *c, const lacks *of, const int32_t *corners, int32_t node) {
    int is_lacking = node >= 0;
    for (int k = 0; k < of->numbers.width && is_lacking; k++)
        is_lacking = c->is_corner[corners[k]];
    const int64_t number = is_lacking ? io_part_numbers_find(&of->numbers, corners) : -1;
    if (number < 0)
        return;
    int32_t *at = &of->node[number], there = __atomic_load_n(at, __ATOMIC_RELAXED);
    while ((there < 0 || node < there) &&
           !__atomic_compare_exchange_n(at, &there, node, 0, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
        continue;
}

/** Note the nodes in the middle of the edges and quadrilaterals of an element. */
static void note_element(const completion *c, const cell *of) {
    const io_parts *parts = io_parts_of(of->dim, of->corners);
    int32_t corners[QUADRILATERAL] = {0};
    for (int e = 0; e < parts->n_edges; e++) {
        edge_of(of, e, corners);
        note_node(c, &c->edges, corners, of->node[of->corners + e]);
    }
    for (int f = 0; f < parts->n_faces; f++) {
        if (io_part_corners(parts, f) != QUADRILATERAL || parts->middle[f] < 0)
            continue;
        for (int k = 0; k < QUADRILATERAL; k++)
            corners[k] = of->node[parts->face[f][k]];
        note_node(c, &c->quadrilaterals, corners,
                  of->node[of->corners + parts->n_edges + parts->middle[f]]);
    }
}

static void note_elements(void *context, int64_t begin, int64_t end, int thread) {
    const completion *c = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const cell of = cell_of(&c->elements, i);
        note_element(c, &of);
    }
}

/** Note which nodes elements have where some are lacking. */
static int find_nodes(completion *c) {
    const int lists[2] = {c->dim, io_others_list(c->dim)};
    int status = make_nodes(&c->edges, c->error);
    if (!status)
        status = make_nodes(&c->quadrilaterals, c->error);
    for (int k = 0; k < 2 && !status; k++) {
        c->elements = io_model_list(c->model, lists[k]);
        pl_parallel_for(io_model_threads(c->model), c->elements.n, CHUNK, note_elements, c);
    }
    return status;
}

/* ---- the lists ----------------------------------------------------------------------------------- */

/** Return the node that was found in the middle of a part, or -1. */
static int32_t found(const lacks *of, const int32_t *corners) {
    const int64_t number = io_part_numbers_find(&of->numbers, corners);
    return number < 0 ? -1 : of->node[number];
}

/** Put the nodes that were found into a cell. Return whether it has any behind its corners. */
static int complete(const completion *c, cell *of) {
    int has_any = 0;
    for (int e = 0; e < of->n_edges; e++) {
        int32_t ends[2], *mid = &of->node[of->corners + e];
        edge_of(of, e, ends);
        *mid = *mid < 0 ? found(&c->edges, ends) : *mid;
        has_any |= *mid >= 0;
    }
    int32_t *middle = &of->node[of->corners + of->n_edges];
    if (of->is_quadrilateral && *middle < 0)
        *middle = found(&c->quadrilaterals, of->node);
    return has_any || (of->is_quadrilateral && *middle >= 0);
}

/** Complete simplices: lines or triangles. */
static int complete_cells(const completion *c, int dim) {
    io_cells *cells = io_model_cells(c->model, dim);
    const io_list list = io_model_list(c->model, dim);
    const size_t n_mids = (size_t)io_n_mids(dim);
    int status = PLANISH_OK;
    for (int64_t i = 0; i < list.n && !status; i++) {
        cell of = cell_of(&list, i);
        if (!complete(c, &of))
            continue;
        status = io_cells_reserve_mids(c->model, dim, c->error);
        if (!status)
            memcpy(cells->mid + (size_t)i * n_mids, of.node + of.corners,
                   n_mids * sizeof *cells->mid);
    }
    return status;
}

/** Return the type of a quadrilateral with all nodes that it has, or the old one if that has more. */
static int type_of(const cell *of, int old) {
    int n = io_cell_type_nodes(old);
    for (int k = n; k < MOST_NODES; k++)
        n = of->node[k] < 0 ? n : k < 8 ? 8 : 9;
    return io_cell_type(IO_QUADRILATERAL, n);
}

/** Complete quadrilaterals: they become those of more nodes. */
static int complete_others(const completion *c) {
    io_others *o = &c->model->flat;
    const io_list list = io_model_list(c->model, IO_FLAT_LIST);
    int64_t capacity = 0, n_nodes = 0;
    if (o->n == 0)
        return PLANISH_OK;
    int32_t *node = pl_grow(NULL, 0, MOST_NODES * o->n, &capacity, sizeof *node);
    if (!node)
        return pl_fail_memory(c->error, "the facets of the file");
    for (int64_t i = 0; i < o->n; i++) {
        cell of = cell_of(&list, i);
        if (of.is_quadrilateral && complete(c, &of))
            o->type[i] = (uint8_t)type_of(&of, o->type[i]);
        const int n = io_cell_type_nodes(o->type[i]);
        memcpy(node + n_nodes, of.node, (size_t)n * sizeof *node);
        o->offset[i] = n_nodes; /* those behind it are still where they were */
        n_nodes += n;
    }
    o->offset[o->n] = n_nodes;
    pl_free(o->node);
    o->node = node;
    o->n_nodes = n_nodes;
    o->node_capacity = capacity;
    return PLANISH_OK;
}

/* ---- all --------------------------------------------------------------------------------------- */

static void release(completion *c) {
    io_part_numbers_release(&c->edges.numbers);
    io_part_numbers_release(&c->quadrilaterals.numbers);
    pl_free(c->edges.node);
    pl_free(c->quadrilaterals.node);
    pl_free(c->is_corner);
}

/** Find what nodes elements have behind their corners. */
static void look_at_elements(completion *c) {
    const io_list simplices = io_model_list(c->model, c->dim),
                  others = io_model_list(c->model, io_others_list(c->dim));
    c->have_mids = simplices.n > 0 && simplices.cells->mid;
    for (int64_t i = 0; i < others.n; i++) {
        const int type = others.others->type[i];
        c->have_mids |= type != io_cell_type_straight(type);
        c->have_middles |= type != io_cell_type_without_faces(type);
    }
}

int io_complete_mids(io_model *model, planish_error *error) {
    static const int lower[N_LOWER] = {1, 2, IO_FLAT_LIST};
    completion c = {.model = model,
                    .error = error,
                    .dim = io_model_dim(model),
                    .edges.numbers.width = EDGE,
                    .quadrilaterals.numbers.width = QUADRILATERAL};
    const int n_lower = c.dim == 3 ? N_LOWER : 1;
    look_at_elements(&c);
    if (!c.have_mids)
        return PLANISH_OK;
    c.is_corner = pl_alloc_zero(model->n_nodes, sizeof *c.is_corner);
    int status = c.is_corner ? PLANISH_OK : pl_fail_memory(error, "the mids of facets");
    for (int k = 0; k < n_lower && !status; k++) {
        const io_list list = io_model_list(model, lower[k]);
        status = note_list(&c, &list);
    }
    const int64_t n = c.edges.numbers.n + c.quadrilaterals.numbers.n;
    if (!status && n > 0)
        status = find_nodes(&c);
    for (int k = 0; k < n_lower && !status && n > 0; k++)
        status = lower[k] == IO_FLAT_LIST ? complete_others(&c) : complete_cells(&c, lower[k]);
    release(&c);
    return status;
}
