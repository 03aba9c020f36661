/* mfem_nodes: the nodes of meshes, above all of those that have them as a grid function (`nodes`).
 *
 * Continuous functions (H1) have a value for each vertex that is used, then, if of second order, for
 * each edge, each quadrilateral face and the inside of each element. Edges and faces are numbered as
 * elements first have them. Discontinuous functions (L2) have values element by element. Values of
 * one place become one node there; a vertex that has several places (of a periodic mesh) holds all.
 */
#include "io/core/number.h"
#include "io/mfem/mfem_reader.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/* ---- coordinates ---------------------------------------------------------------------------- */

typedef struct coordinate_job {
    const mfem_reader *r;
    const char *what;
    int64_t n;
    int first, columns; /* of a record */
} coordinate_job;

/** Read coordinates, and note where the first of each record stands. */
static int read_records(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                        planish_error *error) {
    const coordinate_job *job = context;
    io_model *model = job->r->model;
    for (int64_t i = begin; i < end; i++) {
        double *xyz = model->xyz + 3 * i;
        if (job->r->columns == 2 && job->first == 0)
            xyz[2] = 0;
        io_skip_space_comments(cursor, '#');
        model->text_offset[job->first * job->n + i] = cursor->at - model->input.data;
        for (int d = job->first; d < job->first + job->columns; d++) {
            const char *at = cursor->at;
            if (io_real(cursor, &xyz[d]))
                return io_fail_at(model, cursor->at, error,
                                  "%s %lld: a coordinate expected (the file may be cut short)",
                                  job->what, (long long)i);
            const int status = io_check_finite(model, xyz[d], i, at, error);
            if (status)
                return status;
        }
    }
    return PLANISH_OK;
}

int mfem_read_coordinates(mfem_reader *r, int64_t n, const char *what) {
    io_model *model = r->model;
    const int n_runs = r->is_by_component ? r->columns : 1;
    coordinate_job job = {.r = r, .what = what, .n = n, .columns = r->columns / n_runs};
    int status = io_check_count(model, r->cursor, n, 2 * r->columns, "nodes", r->error);
    model->columns = r->columns;
    if (!status)
        status = io_model_alloc_nodes(model, n, 0, r->error);
    if (status)
        return status;
    model->text_offset = pl_alloc(n_runs * n, sizeof *model->text_offset);
    if (!model->text_offset)
        return pl_fail_memory(r->error, "the nodes of the file");
    for (; job.first < r->columns && !status; job.first += job.columns) {
        const io_span span = {
            .n_nodes = n, .encoding = IO_TEXT, .component = job.first, .n_components = job.columns};
        status = io_model_span(model, span, r->error);
        if (!status)
            status =
                io_text_records(&r->text, &r->cursor, n, job.columns, read_records, &job, r->error);
    }
    return status;
}

/* ---- the head of `nodes` -------------------------------------------------------------------- */

/** Take text from the beginning of a name, if it begins so. */
static int take(io_slice *name, const char *text) {
    const int64_t n = (int64_t)strlen(text);
    if (io_slice_length(*name) < n || memcmp(name->begin, text, (size_t)n) != 0)
        return 0;
    name->begin += n;
    return 1;
}

static int take_number(io_slice *name, int64_t *value) {
    return io_parse_integer(&name->begin, name->end, value) == 0;
}

/** Understand the name of a collection with points at corners: H1_2D_P2, L2_T1_3D_P1, ... Return
 *  whether it is one. */
static int parse_collection(mfem_reader *r, io_slice name, int64_t *order) {
    static const struct {
        const char *name;
        mfem_space space;
        int order;
    } fixed[] = {{"Linear", MFEM_CONTINUOUS, 1},
                 {"Quadratic", MFEM_CONTINUOUS, 2},
                 {"Cubic", MFEM_CONTINUOUS, 3},
                 {"LinearDiscont2D", MFEM_BY_ELEMENT, 1},
                 {"LinearDiscont3D", MFEM_BY_ELEMENT, 1},
                 {"QuadraticDiscont2D", MFEM_BY_ELEMENT, 2},
                 {"QuadraticDiscont3D", MFEM_BY_ELEMENT, 2}};
    for (size_t i = 0; i < sizeof fixed / sizeof *fixed; i++)
        if (io_slice_is(name, fixed[i].name, 0)) {
            r->space = fixed[i].space;
            *order = fixed[i].order;
            return 1;
        }
    int64_t basis, dim, pyramid = 1;
    if (take(&name, "L2_T")) {
        r->space = MFEM_DISCONTINUOUS;
        if (!take_number(&name, &basis) || (basis != 1 && basis != 4) || !take(&name, "_"))
            return 0; /* but for Gauss-Lobatto and closed uniform, points are inside of elements */
    } else {
        r->space = MFEM_CONTINUOUS;
        if (!take(&name, "H1_") && !take(&name, "H1@G_") && !take(&name, "H1@U_"))
            return 0;
    }
    if (!take_number(&name, &dim) || dim != r->dim || !take(&name, "D_P") ||
        !take_number(&name, order) || (take(&name, "_Pyr") && !take_number(&name, &pyramid)))
        return 0;
    r->pyramid_inside = pyramid != 0;
    return io_slice_length(name) == 0 && *order > 0;
}

/** Read a whole number behind its name. */
static int read_value(mfem_reader *r, const char *name, int64_t first, int64_t last, int *value) {
    const io_record_kind kind = {.model = r->model, .what = name};
    int64_t number = 0;
    io_skip_space_comments(&r->cursor, '#');
    const io_slice word = io_next_word(&r->cursor);
    if (!io_slice_is(word, name, 0))
        return io_fail_at(r->model, word.begin, r->error, "%s expected after nodes", name);
    const int status = io_take_whole(&kind, &r->cursor, 0, first, last, &number, r->error);
    *value = (int)number;
    return status;
}

int mfem_read_space(mfem_reader *r) {
    int64_t order;
    io_skip_space_comments(&r->cursor, '#');
    const io_slice head = io_slice_trim(io_next_line(&r->cursor));
    const int has_end = io_slice_is(head, "MFEM FiniteElementSpace v1.0", 0);
    if (!has_end && !io_slice_is(head, "FiniteElementSpace", 0))
        return io_fail_at(r->model, head.begin, r->error,
                          "FiniteElementSpace expected after nodes");
    io_skip_space_comments(&r->cursor, '#');
    const io_slice word = io_next_word(&r->cursor);
    if (!io_slice_is(word, "FiniteElementCollection:", 0))
        return io_fail_at(r->model, word.begin, r->error,
                          "FiniteElementCollection: expected after nodes");
    const io_slice name = io_slice_trim(io_next_line(&r->cursor));
    if (!parse_collection(r, name, &order))
        return io_fail_at(r->model, name.begin, r->error,
                          "nodes of the collection '%.*s' are not read; in MFEM "
                          "mesh.SetCurvature(2) makes nodes of H1 that are",
                          IO_QUOTED(name));
    if (order > 2)
        return io_fail_order(r->model, name.begin, "nodes",
                             " (in MFEM: mesh.SetCurvature(2), then Save)", r->error);
    r->order = (int)order;
    int status = read_value(r, "VDim:", r->dim, 3, &r->columns);
    int is_by_node = 0;
    if (!status)
        status = read_value(r, "Ordering:", 0, 1, &is_by_node);
    r->is_by_component = !is_by_node;
    if (status || !has_end)
        return status;
    io_skip_space_comments(&r->cursor, '#');
    const io_slice end = io_slice_trim(io_next_line(&r->cursor));
    return io_slice_is(end, "End: MFEM FiniteElementSpace v1.0", 0)
               ? PLANISH_OK
               : io_fail_at(r->model, end.begin, r->error,
                            "'%.*s' in the space of the nodes is not read", IO_QUOTED(end));
}

/* ---- numbers of values ---------------------------------------------------------------------- */

/** Number the vertices that elements or boundary elements have: MFEM removes all others. */
static int number_vertices(mfem_reader *r) {
    r->vertex_node = pl_alloc(r->n_vertices, sizeof *r->vertex_node);
    if (!r->vertex_node)
        return pl_fail_memory(r->error, "the vertices of the file");
    for (int64_t v = 0; v < r->n_vertices; v++)
        r->vertex_node[v] = MFEM_NO_NODE;
    for (int is_boundary = 0; is_boundary < 2; is_boundary++) {
        const mfem_list *list = is_boundary ? &r->boundary : &r->elements;
        for (int64_t i = 0; i < list->n; i++)
            for (int k = 0; k < mfem_geometries[list->geometry[i]].corners; k++)
                r->vertex_node[list->vertex[i * list->stride + k]] = 0;
    }
    for (int64_t v = 0; v < r->n_vertices; v++)
        if (r->vertex_node[v] == 0)
            r->vertex_node[v] = (int32_t)r->n_used++;
    return PLANISH_OK;
}

/** Number the edges and quadrilateral faces of all elements. */
static int number_parts(mfem_reader *r) {
    const mfem_list *list = &r->elements;
    const int is_uniform = list->stride < MFEM_MOST_CORNERS && list->n > 0;
    const mfem_geometry *first = &mfem_geometries[is_uniform ? list->geometry[0] : 0];
    int status = PLANISH_OK;
    r->part_stride = is_uniform ? first->n_edges + first->n_quadrilaterals : MFEM_MOST_PARTS;
    r->part = pl_alloc(list->n, (size_t)r->part_stride * sizeof *r->part);
    if (!r->part)
        return pl_fail_memory(r->error, "the edges of elements");
    for (int64_t i = 0; i < list->n; i++) {
        const mfem_geometry *g = &mfem_geometries[list->geometry[i]];
        const int32_t *vertex = list->vertex + i * list->stride;
        int32_t *part = r->part + i * r->part_stride;
        for (int e = 0; e < g->n_edges && !status; e++) {
            const int32_t ends[2] = {vertex[g->edge[e][0]], vertex[g->edge[e][1]]};
            status = io_part_numbers_add(&r->edges, ends, part++, r->error);
        }
        for (int q = 0; q < g->n_quadrilaterals && !status; q++) {
            const uint8_t *at = g->quadrilateral[q];
            const int32_t corners[4] = {vertex[at[0]], vertex[at[1]], vertex[at[2]], vertex[at[3]]};
            status = io_part_numbers_add(&r->quadrilaterals, corners, part++, r->error);
        }
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** Count the values inside an element of a continuous function of second order. */
static int count_inside(const mfem_reader *r, const mfem_geometry *g) {
    return g->shape == IO_PYRAMID ? r->pyramid_inside : g->n_inside;
}

/** Count the values of a function that each element has of its own. */
static int count_own(mfem_reader *r, int64_t *n) {
    const mfem_list *list = &r->elements;
    for (int64_t i = 0; i < list->n; i++) {
        const mfem_geometry *g = &mfem_geometries[list->geometry[i]];
        if (g->shape == IO_PYRAMID && (r->space == MFEM_DISCONTINUOUS || r->order == 2))
            return io_fail_at(r->model, r->cursor.at, r->error,
                              "element %lld is a pyramid, whose discontinuous nodes are not read; "
                              "in MFEM mesh.SetCurvature(%d) makes continuous ones, if the mesh is "
                              "not periodic",
                              (long long)i, r->order);
        *n += mfem_count_nodes(g, r->order);
    }
    return PLANISH_OK;
}

/** Count the values of a continuous function. */
static int count_continuous(mfem_reader *r, int64_t *n) {
    int status = number_vertices(r);
    if (!status && r->order == 2)
        status = number_parts(r);
    *n = r->n_used + r->edges.n + r->quadrilaterals.n;
    for (int64_t i = 0; i < r->elements.n && r->order == 2; i++)
        *n += count_inside(r, &mfem_geometries[r->elements.geometry[i]]);
    return status;
}

/* ---- nodes of elements ---------------------------------------------------------------------- */

/* Values of a lattice, x first, then y, z, that are the nodes of a geometry in its order. */
static const uint8_t lattice1[MFEM_N_GEOMETRIES][MFEM_MOST_CORNERS] = {
    [2] = {0, 1, 2},
    [3] = {0, 1, 3, 2},
    [4] = {0, 1, 2, 3},
    [5] = {0, 1, 3, 2, 4, 5, 7, 6},
    [6] = {0, 1, 2, 3, 4, 5}};
static const uint8_t lattice2[MFEM_N_GEOMETRIES][IO_CELL_NODES] = {
    [2] = {0, 2, 5, 1, 4, 3},
    [3] = {0, 2, 8, 6, 1, 5, 7, 3, 4},
    [4] = {0, 2, 5, 9, 1, 3, 6, 4, 7, 8},
    [5] = {0,  2,  8, 6,  18, 20, 26, 24, 1,  5,  7,  3,  19, 23,
           25, 21, 9, 11, 17, 15, 4,  10, 14, 16, 12, 22, 13},
    [6] = {0, 2, 5, 12, 14, 17, 1, 4, 3, 13, 16, 15, 6, 8, 11, 7, 10, 9}};

/** Find the nodes of an element that has values of its own, the first of them first. */
static void own_nodes(const mfem_reader *r, int geometry, int64_t first, int n, int32_t *nodes) {
    const uint8_t *lattice = r->order == 1 ? lattice1[geometry] : lattice2[geometry];
    for (int k = 0; k < n; k++) {
        const int64_t place = first + (r->space == MFEM_DISCONTINUOUS ? lattice[k] : k);
        nodes[k] = r->model->place_node ? r->model->place_node[place] : (int32_t)place;
    }
}

int mfem_element_nodes(const mfem_reader *r, int64_t i, mfem_walk *walk, int32_t *nodes) {
    const mfem_list *list = &r->elements;
    const mfem_geometry *g = &mfem_geometries[list->geometry[i]];
    const int n = mfem_count_nodes(g, r->order);
    if (r->space > MFEM_CONTINUOUS) {
        own_nodes(r, list->geometry[i], walk->own, n, nodes);
        walk->own += n;
        return n;
    }
    for (int k = 0; k < g->corners; k++) {
        const int32_t vertex = list->vertex[i * list->stride + k];
        nodes[k] = r->vertex_node ? r->vertex_node[vertex] : vertex;
    }
    if (r->order == 1)
        return n;
    const int32_t *part = r->part + i * r->part_stride;
    const int64_t first_quadrilateral = r->n_used + r->edges.n,
                  first_inside = first_quadrilateral + r->quadrilaterals.n;
    int k = g->corners;
    for (int e = 0; e < g->n_edges; e++)
        nodes[k++] = (int32_t)(r->n_used + *part++);
    for (int q = 0; q < g->n_quadrilaterals; q++)
        nodes[k++] = (int32_t)(first_quadrilateral + *part++);
    if (g->n_inside)
        nodes[k] = (int32_t)(first_inside + walk->inside);
    walk->inside += count_inside(r, g);
    return n;
}

int mfem_boundary_nodes(const mfem_reader *r, int64_t i, int32_t *nodes) {
    const mfem_list *list = &r->boundary;
    const mfem_geometry *g = &mfem_geometries[list->geometry[i]];
    const int32_t *vertex = list->vertex + i * list->stride;
    int is_whole = 1;
    for (int k = 0; k < g->corners; k++) {
        nodes[k] = r->vertex_node ? r->vertex_node[vertex[k]] : vertex[k];
        is_whole &= nodes[k] >= 0;
    }
    for (int k = 0; k < g->corners && !is_whole; k++)
        if (nodes[k] >= 0)
            io_hold_node(r->model, nodes[k], IO_HELD_REQUIRED);
    if (!is_whole || r->order == 1 || r->space > MFEM_CONTINUOUS)
        return is_whole ? g->corners : 0;
    int n = g->corners;
    for (int e = 0; e < g->n_edges; e++) {
        const int32_t ends[2] = {vertex[g->edge[e][0]], vertex[g->edge[e][1]]};
        const int64_t edge = io_part_numbers_find(&r->edges, ends);
        nodes[n++] = edge < 0 ? -1 : (int32_t)(r->n_used + edge);
    }
    if (g->shape == IO_QUADRILATERAL) {
        const int64_t face = io_part_numbers_find(&r->quadrilaterals, vertex);
        nodes[n++] = face < 0 ? -1 : (int32_t)(r->n_used + r->edges.n + face);
    }
    return n;
}

/* ---- seams ---------------------------------------------------------------------------------- */

enum { NO_VERTEX = -1, NO_CORNER = -2 };

/** Note that a node stands at a vertex, or (NO_CORNER) inside of an element. A node of several vertices is
 *  held. owner: vertex of each node, or NO_VERTEX. */
static void note_vertex(io_model *model, int32_t *owner, int32_t node, int32_t vertex) {
    if (owner[node] == NO_VERTEX)
        owner[node] = vertex;
    if (owner[node] != vertex)
        model->hold[node] |= IO_HELD_REQUIRED | IO_HELD_PERIODIC;
}

/** Note that a vertex has a node. All nodes of a vertex that has several are held. */
static void note_node(mfem_reader *r, int32_t vertex, int32_t node) {
    const uint8_t reason = IO_HELD_REQUIRED | IO_HELD_PERIODIC;
    int32_t *first = &r->vertex_node[vertex];
    if (*first == MFEM_NO_NODE)
        *first = node;
    if (*first == node)
        return;
    if (*first >= 0)
        r->model->hold[*first] |= reason;
    r->model->hold[node] |= reason;
    *first = MFEM_SEVERAL_NODES;
}

/** Find the node of each vertex. Vertices that have several nodes, and nodes of several vertices,
 *  hold: the mesh is joined there in another way than its places are. */
static int hold_seams(mfem_reader *r) {
    const mfem_list *list = &r->elements;
    mfem_walk walk = {0};
    int32_t *owner = pl_alloc(r->model->n_nodes, sizeof *owner);
    r->vertex_node = pl_alloc(r->n_vertices, sizeof *r->vertex_node);
    if (!owner || !r->vertex_node) {
        pl_free(owner);
        return pl_fail_memory(r->error, "the vertices of the file");
    }
    for (int64_t v = 0; v < r->n_vertices; v++)
        r->vertex_node[v] = MFEM_NO_NODE;
    for (int64_t i = 0; i < r->model->n_nodes; i++)
        owner[i] = NO_VERTEX;
    for (int64_t i = 0; i < list->n; i++) {
        int32_t nodes[IO_CELL_NODES];
        const int n = mfem_element_nodes(r, i, &walk, nodes);
        const int corners = mfem_geometries[list->geometry[i]].corners;
        for (int k = 0; k < n; k++) {
            const int32_t vertex = k < corners ? list->vertex[i * list->stride + k] : NO_CORNER;
            note_vertex(r->model, owner, nodes[k], vertex);
            if (k < corners)
                note_node(r, vertex, nodes[k]);
        }
    }
    pl_free(owner);
    return PLANISH_OK;
}

void mfem_hold_mids(mfem_reader *r) {
    uint8_t *hold = r->model->hold;
    mfem_walk walk = {0};
    for (int64_t i = 0; i < r->elements.n && r->order == 2; i++) {
        int32_t nodes[IO_CELL_NODES];
        const mfem_geometry *g = &mfem_geometries[r->elements.geometry[i]];
        mfem_element_nodes(r, i, &walk, nodes);
        for (int e = 0; e < g->n_edges; e++)
            hold[nodes[g->corners + e]] |= (uint8_t)(hold[nodes[g->edge[e][0]]] &
                                                     hold[nodes[g->edge[e][1]]] & IO_HELD_REQUIRED);
        for (int q = 0; q < g->n_quadrilaterals; q++) {
            const uint8_t *at = g->quadrilateral[q];
            uint8_t all = IO_HELD_REQUIRED;
            for (int k = 0; k < 4; k++)
                all &= hold[nodes[at[k]]];
            hold[nodes[g->corners + g->n_edges + q]] |= all;
        }
    }
}

int mfem_read_nodes(mfem_reader *r) {
    const int is_own = r->space > MFEM_CONTINUOUS;
    int64_t n = 0;
    int status = is_own ? count_own(r, &n) : count_continuous(r, &n);
    if (!status)
        status = mfem_read_coordinates(r, n, "node");
    if (!status && is_own)
        status = io_weld_nodes(r->model, r->error);
    if (!status && is_own)
        status = hold_seams(r);
    return status;
}
