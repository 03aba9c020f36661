/* foam_cells: elements of the cells that faces enclose.
 *
 * A cell has no list of nodes, only faces. Four triangles may be those of a tetrahedron, six
 * quadrilaterals those of a hexahedron, and so on. One face is taken as the base. Its nodes, and those
 * that other faces have beyond the edges of the base, are the element's. Then all faces are compared
 * with the element's. The order of nodes follows from faces alone, whose normals leave the cell: an
 * element that is inverted by its coordinates is listed as inverted. Most cells are found by a faster
 * walk before (foam_walk.c).
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

/* ---- all cells ------------------------------------------------------------------------------ */

/** Sides of faces by cell: face, or ~face where the cell is its neighbour. Cells with a type have none. */
typedef struct sides {
    int64_t *start; /* [n_cells + 1] */
    int32_t *side;
} sides;

static int32_t side_face(int32_t side) {
    return side < 0 ? ~side : side;
}

/** Return the cell on a side of a face that has no type yet, or -1. */
static int32_t find_open(const foam_mesh *mesh, const uint8_t *type, int64_t face,
                         int is_neighbour) {
    const int32_t cell = is_neighbour ? foam_neighbour(mesh, face) : mesh->owner[face];
    return cell >= 0 && !type[cell] ? cell : -1;
}

static int make_sides(const foam_mesh *mesh, const uint8_t *type, sides *s, planish_error *error) {
    const int64_t n = mesh->n_cells;
    int32_t cell;
    s->start = pl_alloc_zero(n + 2, sizeof *s->start);
    if (!s->start)
        return pl_fail_memory(error, "cells");
    for (int64_t i = 0; i < mesh->n_faces; i++)
        for (int k = 0; k < 2; k++)
            if ((cell = find_open(mesh, type, i, k)) >= 0)
                s->start[cell + 2]++;
    for (int64_t i = 0; i < n; i++) {
        if (s->start[i + 2] < LEAST_FACES && !type[i])
            return pl_fail(error, PLANISH_ERROR_FORMAT,
                           "%s: cell %" PRId64 " of owner and neighbour has %" PRId64
                           " faces: four at least expected",
                           mesh->model->input.path, i, s->start[i + 2]);
        s->start[i + 2] += s->start[i + 1];
    }
    s->side = pl_alloc(s->start[n + 1], sizeof *s->side);
    if (!s->side)
        return pl_fail_memory(error, "cells");
    for (int64_t i = 0; i < mesh->n_faces; i++)
        for (int k = 0; k < 2; k++)
            if ((cell = find_open(mesh, type, i, k)) >= 0)
                s->side[s->start[cell + 1]++] = k ? ~(int32_t)i : (int32_t)i;
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

/** Cells without a type, whose elements are found by their faces. */
typedef struct search {
    const foam_mesh *mesh;
    sides sides;
    foam_elements *elements;
} search;

static void find_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const search *s = context;
    const foam_elements *e = s->elements;
    (void)thread;
    for (int64_t cell = begin; cell < end; cell++) {
        cell_faces f;
        if (e->type[cell] || !gather(s->mesh, &s->sides, cell, &f))
            continue;
        for (int k = 0; k < N_SHAPES; k++)
            if (has_kinds(&shapes[k], &f) && is_of_shape(&shapes[k], &f, e->node + cell * e->width))
                e->type[cell] = shapes[k].type;
    }
}

/** Make room for elements of cells, which have no type so far. */
static int make_elements(const foam_mesh *mesh, foam_elements *e, planish_error *error) {
    const int is_simple = mesh->dim == 2 || mesh->start[mesh->n_faces] == 3 * mesh->n_faces;
    *e = (foam_elements){.type = pl_alloc_zero(mesh->n_cells, sizeof *e->type),
                         .width = is_simple ? FACE_CORNERS : MOST_CORNERS};
    e->node = pl_alloc(mesh->n_cells, (size_t)e->width * sizeof *e->node);
    return e->type && e->node ? PLANISH_OK : pl_fail_memory(error, "cells");
}

int foam_find_elements(const foam_mesh *mesh, int is_plain, foam_elements *elements,
                       planish_error *error) {
    enum { CHUNK = 1 << 9 };
    search s = {.mesh = mesh, .elements = elements};
    int status = make_elements(mesh, elements, error);
    if (!status && !is_plain)
        status = foam_walk_faces(mesh, elements, error);
    if (!status && memchr(elements->type, 0, (size_t)mesh->n_cells)) {
        status = make_sides(mesh, elements->type, &s.sides, error);
        if (!status)
            pl_parallel_for(io_model_threads(mesh->model), mesh->n_cells, CHUNK, find_chunk, &s);
    }
    pl_free(s.sides.start);
    pl_free(s.sides.side);
    return status;
}

/** Find the elements of a layer: the faces that its cells have on a side. */
static int find_flat_elements(const foam_mesh *mesh, foam_elements *e, planish_error *error) {
    sides s = {.start = NULL};
    int status = make_elements(mesh, e, error);
    if (!status) /* which checks that cells have faces enough */
        status = make_sides(mesh, e->type, &s, error);
    pl_free(s.start);
    pl_free(s.side);
    for (int64_t cell = 0; cell < mesh->n_cells && !status; cell++) {
        const int32_t face = mesh->base[cell], begin = mesh->start[face];
        const int n = mesh->start[face + 1] - begin;
        for (int k = 0; k < n && n <= FACE_CORNERS; k++)
            e->node[cell * FACE_CORNERS + k] = foam_node(mesh, mesh->node[begin + k]);
        if (n <= FACE_CORNERS)
            e->type[cell] = n == 3 ? PLANISH_CELL_TRIANGLE : PLANISH_CELL_QUADRILATERAL;
    }
    return status;
}

/* ---- the model ------------------------------------------------------------------------------ */

/** Let cells that become no element hold their nodes. */
static void hold_cells(const foam_mesh *mesh, const uint8_t *type) {
    for (int64_t i = 0; i < mesh->n_faces; i++)
        if (find_open(mesh, type, i, 0) >= 0 || find_open(mesh, type, i, 1) >= 0)
            for (int64_t k = mesh->start[i]; k < mesh->start[i + 1]; k++)
                io_hold_node(mesh->model, foam_node(mesh, mesh->node[k]), IO_HELD_BY_OTHER);
}

static int is_simplex(int type) {
    return type == PLANISH_CELL_TETRAHEDRON || type == PLANISH_CELL_TRIANGLE;
}

/** Add the element that a cell has become to the model. */
static int add_element(foam_mesh *mesh, int type, const int32_t *node, int64_t cell,
                       planish_error *error) {
    io_model *model = mesh->model;
    if (is_simplex(type)) {
        mesh->thing[cell] = (int32_t)io_model_cells(model, mesh->dim)->n;
        return io_cells_add(model, mesh->dim, node, 0, cell, error);
    }
    mesh->thing[cell] = (int32_t)io_model_others(model, mesh->dim)->n; /* so far, among these */
    model->n_other++;
    return io_model_add_other(model, type, node, 0, cell, error);
}

/** Add the elements of all cells to the model. */
static int add_elements(foam_mesh *mesh, const foam_elements *e, planish_error *error) {
    io_model *model = mesh->model;
    int64_t n_simplices = 0, n_others = 0, n_nodes = 0;
    for (int64_t cell = 0; cell < mesh->n_cells; cell++) {
        const int type = e->type[cell], is_other = type && !is_simplex(type);
        n_simplices += is_simplex(type);
        n_others += is_other;
        n_nodes += is_other ? io_cell_type_nodes(type) : 0;
    }
    const int64_t n_polyhedra = mesh->n_cells - n_simplices - n_others;
    model->n_other += n_polyhedra;
    if (n_polyhedra > 0)
        hold_cells(mesh, e->type);
    int status = io_cells_reserve(model, mesh->dim, n_simplices, 1, 1, error);
    if (!status)
        status = io_others_reserve(model, mesh->dim, n_others, n_nodes, 1, error);
    for (int64_t cell = 0; cell < mesh->n_cells && !status; cell++) {
        mesh->thing[cell] = -1;
        if (e->type[cell])
            status = add_element(mesh, e->type[cell], e->node + cell * e->width, cell, error);
    }
    return status;
}

int foam_make_cells(foam_mesh *mesh, planish_error *error) {
    foam_elements e;
    int status = mesh->dim == 2 ? find_flat_elements(mesh, &e, error)
                                : foam_find_elements(mesh, 0, &e, error);
    if (!status && !(mesh->thing = pl_alloc(mesh->n_cells, sizeof *mesh->thing)))
        status = pl_fail_memory(error, "cells");
    if (!status)
        status = add_elements(mesh, &e, error);
    pl_free(e.type);
    pl_free(e.node);
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
