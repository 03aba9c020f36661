/* foam_cells: elements of the cells that faces enclose.
 *
 * A cell has no list of nodes, only faces. Four triangles may be those of a tetrahedron, six
 * quadrilaterals those of a hexahedron, and so on. One face is taken as the base. Its nodes, and those
 * that other faces have beyond the edges of the base, are the element's. Then all faces are compared
 * with the element's. The order of nodes follows from faces alone, whose normals leave the cell: an
 * element that is inverted by its coordinates is listed as inverted.
 *
 * All other cells are polyhedra, and hold their nodes.
 */
#include "io/foam/foam_cells.h"

#include "io/core/cell_types.h"

#include "base/memory.h"
#include "base/status.h"

#include <inttypes.h>
#include <string.h>

enum { MOST_FACES = 6, MOST_CORNERS = 8, FACE_CORNERS = 4, LEAST_FACES = 4 };

/** A shape: its faces, whose normals leave it, of nodes in VTK's order. */
typedef struct shape {
    uint8_t type, n_corners, n_triangles, n_quadrilaterals;
    int8_t face[MOST_FACES][FACE_CORNERS]; /* -1: a triangle. The first is the base */
} shape;

static const shape shapes[] = {
    {PLANISH_CELL_TETRAHEDRON,
     4,
     4,
     0,
     {{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}}},
    {PLANISH_CELL_PYRAMID,
     5,
     4,
     1,
     {{0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}}},
    {PLANISH_CELL_WEDGE,
     6,
     2,
     3,
     {{0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}},
    {PLANISH_CELL_HEXAHEDRON,
     8,
     0,
     6,
     {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}}};
enum { N_SHAPES = sizeof shapes / sizeof *shapes };

/** Faces of a cell, whose normals leave it. */
typedef struct cell_faces {
    int n, n_triangles, n_quadrilaterals;
    int corners[MOST_FACES];
    int32_t node[MOST_FACES][FACE_CORNERS];
} cell_faces;

static int shape_corners(const shape *s, int face) {
    return s->face[face][FACE_CORNERS - 1] < 0 ? 3 : 4;
}

/* ---- the nodes of an element ---------------------------------------------------------------- */

/** Find the face with the edge from a to b, and the node behind it, before it; else -1. */
static void find_beyond(const cell_faces *f, int32_t a, int32_t b, int32_t *behind,
                        int32_t *before) {
    *behind = *before = -1;
    for (int i = 0; i < f->n; i++)
        for (int k = 0, n = f->corners[i]; k < n; k++)
            if (f->node[i][k] == a && f->node[i][(k + 1) % n] == b) {
                *behind = f->node[i][(k + 2) % n];
                *before = f->node[i][(k + n - 1) % n];
                return;
            }
}

/** Find the nodes that the element of a shape would have. */
static void propose(const shape *s, const cell_faces *f, int32_t *node) {
    const int corners = shape_corners(s, 0);
    int base = 0;
    while (f->corners[base] != corners)
        base++;
    for (int k = 0; k < corners; k++)
        node[s->face[0][k]] = f->node[base][k];
    if (s->type == PLANISH_CELL_TETRAHEDRON || s->type == PLANISH_CELL_PYRAMID) {
        int32_t ignored;
        find_beyond(f, node[0], node[1], &node[corners], &ignored);
        return;
    }
    find_beyond(f, node[0], node[1], &node[corners + 1], &node[corners]);
    if (s->type == PLANISH_CELL_WEDGE)
        find_beyond(f, node[1], node[2], &node[5], &node[4]);
    else
        find_beyond(f, node[2], node[3], &node[7], &node[6]);
}

/** Return whether one of the cell's faces is the face of a shape, in the same sense. */
static int has_face(const cell_faces *f, const shape *s, int face, const int32_t *node) {
    const int n = shape_corners(s, face);
    for (int i = 0; i < f->n; i++)
        for (int turn = 0; turn < n && f->corners[i] == n; turn++) {
            int k = 0;
            while (k < n && f->node[i][(k + turn) % n] == node[s->face[face][k]])
                k++;
            if (k == n)
                return 1;
        }
    return 0;
}

/** Return whether the cell is an element of a shape: node [n_corners] is then filled in. */
static int is_of_shape(const shape *s, const cell_faces *f, int32_t *node) {
    if (s->n_triangles != f->n_triangles || s->n_quadrilaterals != f->n_quadrilaterals)
        return 0;
    propose(s, f, node);
    for (int i = 0; i < s->n_corners; i++)
        for (int k = 0; k < i; k++)
            if (node[i] == node[k])
                return 0;
    for (int i = 0; i < f->n; i++)
        if (!has_face(f, s, i, node))
            return 0;
    return 1;
}

/* ---- all cells ------------------------------------------------------------------------------ */

/** Sides of faces by cell: face, or ~face where the cell is its neighbour. */
typedef struct sides {
    int64_t *start; /* [n_cells + 1] */
    int32_t *side;
} sides;

static int make_sides(const foam_mesh *mesh, sides *s, planish_error *error) {
    const int64_t n = mesh->n_cells;
    s->start = pl_alloc_zero(n + 2, sizeof *s->start);
    if (!s->start)
        return pl_fail_memory(error, "cells");
    for (int64_t i = 0; i < mesh->n_faces; i++) {
        s->start[mesh->owner[i] + 2]++;
        if (mesh->neighbour[i] >= 0)
            s->start[mesh->neighbour[i] + 2]++;
    }
    for (int64_t i = 0; i < n; i++) {
        if (s->start[i + 2] < LEAST_FACES)
            return pl_fail(error, PLANISH_ERROR_FORMAT,
                           "%s: cell %" PRId64 " of owner and neighbour has %" PRId64
                           " faces: four at least expected",
                           mesh->model->input.path, i, s->start[i + 2]);
        s->start[i + 2] += s->start[i + 1];
    }
    s->side = pl_alloc(s->start[n + 1], sizeof *s->side);
    if (!s->side)
        return pl_fail_memory(error, "cells");
    for (int64_t i = 0; i < mesh->n_faces; i++) {
        s->side[s->start[mesh->owner[i] + 1]++] = (int32_t)i;
        if (mesh->neighbour[i] >= 0)
            s->side[s->start[mesh->neighbour[i] + 1]++] = ~(int32_t)i;
    }
    return PLANISH_OK;
}

/** Gather the faces of a cell. Return 0 if it has too many of them, or such of too many nodes. */
static int gather(const foam_mesh *mesh, const sides *s, int64_t cell, cell_faces *f) {
    const int64_t n = s->start[cell + 1] - s->start[cell];
    if (n > MOST_FACES)
        return 0;
    *f = (cell_faces){.n = (int)n};
    for (int i = 0; i < f->n; i++) {
        const int32_t side = s->side[s->start[cell] + i], face = side < 0 ? ~side : side;
        const int64_t begin = mesh->start[face], corners = mesh->start[face + 1] - begin;
        if (corners > FACE_CORNERS)
            return 0;
        f->corners[i] = (int)corners;
        f->n_triangles += corners == 3;
        f->n_quadrilaterals += corners == 4;
        for (int k = 0; k < corners; k++)
            f->node[i][k] = mesh->node[side < 0 ? begin + corners - 1 - k : begin + k];
    }
    return 1;
}

/** Let a cell that becomes no element hold its nodes. */
static void hold_cell(const foam_mesh *mesh, const sides *s, int64_t cell) {
    for (int64_t i = s->start[cell]; i < s->start[cell + 1]; i++) {
        const int32_t face = s->side[i] < 0 ? ~s->side[i] : s->side[i];
        for (int64_t k = mesh->start[face]; k < mesh->start[face + 1]; k++)
            io_hold_node(mesh->model, foam_node(mesh, mesh->node[k]), IO_HELD_BY_OTHER);
    }
    mesh->model->n_other++;
}

/** Add the element that a cell has become to the model. */
static int add_element(foam_mesh *mesh, int type, const int32_t *node, int64_t cell,
                       planish_error *error) {
    io_model *model = mesh->model;
    if (type == PLANISH_CELL_TETRAHEDRON || type == PLANISH_CELL_TRIANGLE) {
        mesh->thing[cell] = (int32_t)io_model_cells(model, mesh->dim)->n;
        return io_cells_add(model, mesh->dim, node, 0, cell, error);
    }
    mesh->thing[cell] = (int32_t)io_model_others(model, mesh->dim)->n; /* so far, among these */
    model->n_other++;
    return io_model_add_other(model, type, node, 0, cell, error);
}

/** Make elements of all cells. */
static int add_cells(foam_mesh *mesh, const sides *s, planish_error *error) {
    int status = PLANISH_OK;
    for (int64_t cell = 0; cell < mesh->n_cells && !status; cell++) {
        cell_faces f;
        int32_t node[MOST_CORNERS];
        const shape *of = NULL;
        const int is_small = gather(mesh, s, cell, &f);
        for (int i = 0; i < N_SHAPES && is_small && !of; i++)
            of = is_of_shape(&shapes[i], &f, node) ? &shapes[i] : NULL;
        mesh->thing[cell] = -1;
        if (of)
            status = add_element(mesh, of->type, node, cell, error);
        else
            hold_cell(mesh, s, cell);
    }
    return status;
}

/** Make elements of the faces that the cells of a layer have on its side. */
static int add_flat_cells(foam_mesh *mesh, const sides *s, planish_error *error) {
    int status = PLANISH_OK;
    for (int64_t cell = 0; cell < mesh->n_cells && !status; cell++) {
        const int64_t begin = mesh->start[mesh->base[cell]];
        const int64_t n = mesh->start[mesh->base[cell] + 1] - begin;
        int32_t node[FACE_CORNERS];
        mesh->thing[cell] = -1;
        for (int64_t k = 0; k < n && n <= FACE_CORNERS; k++)
            node[k] = foam_node(mesh, mesh->node[begin + k]);
        if (n > FACE_CORNERS)
            hold_cell(mesh, s, cell);
        else
            status = add_element(mesh, n == 3 ? PLANISH_CELL_TRIANGLE : PLANISH_CELL_QUADRILATERAL,
                                 node, cell, error);
    }
    return status;
}

int foam_make_cells(foam_mesh *mesh, planish_error *error) {
    sides s = {.start = NULL};
    int status = make_sides(mesh, &s, error);
    if (!status && !(mesh->thing = pl_alloc(mesh->n_cells, sizeof *mesh->thing)))
        status = pl_fail_memory(error, "cells");
    if (!status)
        status = mesh->dim == 2 ? add_flat_cells(mesh, &s, error) : add_cells(mesh, &s, error);
    pl_free(s.start);
    pl_free(s.side);
    if (status)
        return status;
    const io_cells *simplices = io_model_cells(mesh->model, mesh->dim);
    const io_others *others = io_model_others(mesh->model, mesh->dim);
    for (int64_t i = 0; i < others->n; i++) /* they count behind the simplices */
        mesh->thing[others->number[i]] += (int32_t)simplices->n;
    if (simplices->n + others->n == 0)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: none of its %" PRId64 " cells is a tetrahedron, pyramid, prism or "
                       "hexahedron: other polyhedra cannot be smoothed",
                       mesh->model->input.path, mesh->n_cells);
    return PLANISH_OK;
}
