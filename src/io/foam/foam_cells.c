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
#include "base/parallel.h"
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
    uint64_t key[MOST_FACES][2]; /* equal for faces of the same nodes in the same sense */
} cell_faces;

static int shape_corners(const shape *s, int face) {
    return s->face[face][FACE_CORNERS - 1] < 0 ? 3 : 4;
}

/* ---- the nodes of an element ---------------------------------------------------------------- */

/* Which faces a cell has is as good as random: a branch on nodes would be mispredicted half of the
 * time. So what follows looks at all faces, and chooses without branches. */

/** Make the key of a face of n nodes: these, the smallest first. */
static inline void make_key_of(int n, const int32_t *node, uint64_t *key) {
    const int32_t round[] = {node[0],     node[1],     node[2],    node[3 % n],
                             node[4 % n], node[5 % n], node[6 % n]};
    uint64_t least =
        UINT64_MAX; /* nodes, their places in the last two bits: a minimum, no branch */
    for (int k = 0; k < n; k++) {
        const uint64_t placed = (uint64_t)(uint32_t)node[k] << 2 | (uint64_t)k;
        least = placed < least ? placed : least;
    }
    const int first = (int)(least & 3);
    key[0] = (uint64_t)round[first] << 32 | (uint32_t)round[first + 1];
    key[1] = (uint64_t)round[first + 2] << 32 | (n == 3 ? UINT32_MAX : (uint32_t)round[first + 3]);
}

static void make_key(int n, const int32_t *node, uint64_t *key) {
    if (n == 3) /* compiled for either number */
        make_key_of(3, node, key);
    else
        make_key_of(4, node, key);
}

/** Find the first face with the edge from a to b, and the node behind it, before it; else -1. */
static void find_beyond(const cell_faces *f, int32_t a, int32_t b, int32_t *behind,
                        int32_t *before) {
    *behind = *before = -1;
    for (int i = f->n - 1; i >= 0; i--) {
        const int32_t *node = f->node[i];
        const int n = f->corners[i];
        for (int k = n - 1, next = 0, beyond = 1; k >= 0; beyond = next, next = k--) {
            const int is_edge = (node[k] == a) & (node[next] == b);
            *behind = is_edge ? node[beyond] : *behind;
            *before = is_edge ? node[k > 0 ? k - 1 : n - 1] : *before;
        }
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
    int32_t corner[FACE_CORNERS];
    uint64_t key[2];
    const int n = shape_corners(s, face);
    for (int k = 0; k < n; k++)
        corner[k] = node[s->face[face][k]];
    make_key(n, corner, key);
    int found = 0;
    for (int i = 0; i < f->n; i++)
        found |= (f->key[i][0] == key[0]) & (f->key[i][1] == key[1]);
    return found;
}

/** Return whether a cell has as many faces of each kind as a shape; no two shapes have the same. */
static int has_kinds(const shape *s, const cell_faces *f) {
    return s->n_triangles == f->n_triangles && s->n_quadrilaterals == f->n_quadrilaterals;
}

/** Return whether the cell, which has as many faces of each kind, is an element of a shape: node
 *  [n_corners] is then filled in. */
static int is_of_shape(const shape *s, cell_faces *f, int32_t *node) {
    for (int i = 0; i < f->n; i++)
        make_key(f->corners[i], f->node[i], f->key[i]);
    propose(s, f, node);
    for (int i = 0; i < s->n_corners; i++)
        for (int k = 0; k < i; k++)
            if (node[i] == node[k])
                return 0;
    for (int i = 1; i < f->n; i++) /* the first is the base, of which node was made */
        if (!has_face(f, s, i, node))
            return 0;
    return 1;
}

/** Find the tetrahedron that four triangles are, as is_of_shape does: node [4] is then filled in. */
static int is_tetrahedron(const cell_faces *f, int32_t *node) {
    const int32_t a = f->node[0][0], b = f->node[0][2], c = f->node[0][1]; /* the base */
    const int32_t *side = f->node[1];
    const int32_t d = (side[0] != a && side[0] != b && side[0] != c)   ? side[0]
                      : (side[1] != a && side[1] != b && side[1] != c) ? side[1]
                                                                       : side[2];
    int found = 0;
    for (int i = 1; i < 4; i++) /* behind the apex come the ends of an edge of the base */
        for (int k = 0; k < 3; k++) {
            const int32_t *of = f->node[i];
            const int32_t p = of[k], q = of[(k + 1) % 3], r = of[(k + 2) % 3];
            found |= ((p == d) & (q == a) & (r == b)) << 0 | ((p == d) & (q == b) & (r == c)) << 1 |
                     ((p == d) & (q == c) & (r == a)) << 2;
        }
    node[0] = a;
    node[1] = b;
    node[2] = c;
    node[3] = d;
    return (found == 7) & (a != b) & (b != c) & (c != a) & (d != a) & (d != b) & (d != c);
}

/* ---- all cells ------------------------------------------------------------------------------ */

/** Sides of faces by cell: face, or ~face where the cell is its neighbour. */
typedef struct sides {
    int64_t *start; /* [n_cells + 1] */
    int32_t *side;
} sides;

static int32_t side_face(int32_t side) {
    return side < 0 ? ~side : side;
}

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
    enum { AHEAD = 32 }; /* sides: their faces lie anywhere in memory */
    const int64_t last = s->start[mesh->n_cells] - 1, n = s->start[cell + 1] - s->start[cell];
    if (n > MOST_FACES)
        return 0;
    f->n = (int)n;
    f->n_triangles = f->n_quadrilaterals = 0;
    for (int i = 0; i < f->n; i++) {
        const int64_t at = s->start[cell] + i;
        if (at + 2 * AHEAD <= last) {
            __builtin_prefetch(&mesh->start[side_face(s->side[at + 2 * AHEAD])]);
            __builtin_prefetch(&mesh->node[mesh->start[side_face(s->side[at + AHEAD])]]);
        }
        const int32_t side = s->side[at], face = side_face(side);
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
        const int32_t face = side_face(s->side[i]);
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

enum { BLOCK = 1 << 14, CHUNK = 1 << 9 }; /* cells whose elements are kept until they are added */

/** Elements of cells first, first + 1, ... */
typedef struct cell_block {
    const foam_mesh *mesh;
    const sides *sides;
    int64_t first;
    uint8_t *shape;                /* [BLOCK] N_SHAPES: none */
    int32_t (*node)[MOST_CORNERS]; /* [BLOCK] */
} cell_block;

static void find_elements(void *context, int64_t begin, int64_t end, int thread) {
    const cell_block *b = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        cell_faces f;
        int32_t *node = b->node[i];
        uint8_t k = gather(b->mesh, b->sides, b->first + i, &f) ? 0 : N_SHAPES;
        while (k < N_SHAPES && !has_kinds(&shapes[k], &f))
            k++;
        if (k < N_SHAPES &&
            !(k == 0 ? is_tetrahedron(&f, node) : is_of_shape(&shapes[k], &f, node)))
            k = N_SHAPES;
        b->shape[i] = k;
    }
}

/** Make elements of all cells. */
static int add_cells(foam_mesh *mesh, const sides *s, planish_error *error) {
    cell_block b = {.mesh = mesh, .sides = s};
    b.shape = pl_alloc(BLOCK, sizeof *b.shape);
    b.node = pl_alloc(BLOCK, sizeof *b.node);
    int status = b.shape && b.node ? PLANISH_OK : pl_fail_memory(error, "cells");
    for (; b.first < mesh->n_cells && !status; b.first += BLOCK) {
        const int64_t left = mesh->n_cells - b.first, n = left < BLOCK ? left : BLOCK;
        pl_parallel_for(mesh->model->threads, n, CHUNK, find_elements, &b);
        for (int64_t i = 0; i < n && !status; i++) {
            const int64_t cell = b.first + i;
            mesh->thing[cell] = -1;
            if (b.shape[i] < N_SHAPES)
                status = add_element(mesh, shapes[b.shape[i]].type, b.node[i], cell, error);
            else
                hold_cell(mesh, s, cell);
        }
    }
    pl_free(b.shape);
    pl_free(b.node);
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
