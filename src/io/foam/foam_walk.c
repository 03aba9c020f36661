/* foam_walk: tetrahedra and hexahedra, by one walk over the faces.
 *
 * Most cells are of these two shapes. To find them by the list of each cell's faces, as foam_cells.c
 * does for all shapes, takes more time and memory than the rest of reading. Here each face is looked
 * at once, in the file's order, and fills in what it says of the cells on its sides. The first face of
 * a cell is its base. A side face has one edge of the base, and says which nodes are beyond. The face
 * of a hexahedron that has no node of the base is compared in the end. What the walk finds is what
 * foam_cells.c finds (tests/io/test_foam_cells.c).
 */
#include "io/foam/foam_walk.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <string.h>

/** Bits of knowledge about a cell. Those below BASE are the sides at the edges of the base. */
enum { SIDES_OF_3 = 7, SIDES_OF_4 = 15, BASE = 16, TOP = 32, FOUR = 64, WRONG = 128 };

typedef struct walk {
    const foam_mesh *mesh;
    const foam_elements *elements;
    uint8_t *known; /* [n_cells] */
    int32_t *top;   /* [n_cells] side that has no node of the base: face, or ~face if the cell is
                       its neighbour; NULL: no face has four nodes */
} walk;

/** Set a node that may be known before. Return 0 if it is another one then. */
static inline int set_node(int32_t *node, int32_t found) {
    const int is_same = (*node < 0) | (*node == found);
    *node = found;
    return is_same;
}

/* n is 3 or 4, and known where these are inlined. Which edge a face has is as good as random: choices
 * are made without branches. */

/** Begin a cell with its first face, of nodes whose normal leaves it. */
static inline int begin_cell(int n, const int32_t *face, int32_t *element) {
    int is_wrong = 0;
    for (int k = 0; k < n; k++) { /* that of the base, 0 1 2 3, enters it */
        element[k] = face[(n - k) % n];
        for (int j = 0; j < k; j++)
            is_wrong |= element[j] == element[k];
    }
    for (int k = n; k < (n == 3 ? 4 : 8); k++)
        element[k] = -1;
    return BASE | (n == 4) * FOUR | is_wrong * WRONG;
}

/** Add another face to a cell. Return the bit that is known with it. */
static inline int add_face(int n, const int32_t *face, int32_t *element) {
    int corner[4] = {0}, n_of_base = 0, first = 0;
    for (int i = 0; i < n; i++) {
        corner[i] = -1;
        for (int k = 0; k < n; k++)
            corner[i] = face[i] == element[k] ? k : corner[i];
        n_of_base += corner[i] >= 0;
    }
    for (int i = 0; i < n; i++)
        first = corner[i] >= 0 && corner[(i + 1) % n] >= 0 ? i : first;
    const int k = corner[first], next = (k + 1) % n;
    if (n_of_base != 2 || k < 0 || corner[(first + 1) % n] != next)
        return n == 4 && n_of_base == 0 ? TOP : WRONG;
    int is_right = set_node(&element[n == 3 ? 3 : 4 + next], face[(first + 2) % n]);
    if (n == 4)
        is_right &= set_node(&element[4 + k], face[(first + 3) % n]);
    return is_right ? 1 << k : WRONG;
}

/** Note a side of a face of n nodes. */
static inline void note_side(const walk *w, int n, const int32_t *face, int64_t cell,
                             int32_t side) {
    int32_t *element = w->elements->node + cell * w->elements->width;
    int known = w->known[cell];
    if (!known) {
        known = begin_cell(n, face, element);
    } else if ((known & FOUR) != (n == 4) * FOUR || known & WRONG) {
        known |= WRONG;
    } else {
        const int bit = add_face(n, face, element);
        known |= known & bit ? WRONG : bit;
        if (n == 4 && bit == TOP)
            w->top[cell] = side;
    }
    w->known[cell] = (uint8_t)known;
}

/** Note both sides of a face, of the cells begin .. end - 1. */
static inline void note_face(const walk *w, int n, const int32_t *face, int32_t number,
                             const int32_t *cell, int64_t begin, int64_t end) {
    int32_t back[4];
    for (int k = 0; k < n; k++)
        back[k] = face[n - 1 - k];
    if (cell[0] >= begin && cell[0] < end)
        note_side(w, n, face, cell[0], number);
    if (cell[1] >= begin && cell[1] < end)
        note_side(w, n, back, cell[1], ~number);
}

/** Walk over all faces, for the cells begin .. end - 1. */
static void walk_chunk(void *context, int64_t begin, int64_t end, int thread) {
    enum { AHEAD = 32 }; /* faces: the cells on their other sides lie anywhere in memory */
    const walk *w = context;
    const foam_mesh *mesh = w->mesh;
    (void)thread;
    memset(w->known + begin, 0, (size_t)(end - begin));
    for (int64_t i = 0; i < mesh->n_faces; i++) {
        const int32_t *face = mesh->node + mesh->start[i];
        const int n = mesh->start[i + 1] - mesh->start[i];
        const int32_t cell[2] = {mesh->owner[i], foam_neighbour(mesh, i)};
        if (i + AHEAD < mesh->n_listed && mesh->neighbour[i + AHEAD] >= 0)
            __builtin_prefetch(
                w->elements->node + (int64_t)mesh->neighbour[i + AHEAD] * w->elements->width, 1);
        if (n == 3)
            note_face(w, 3, face, (int32_t)i, cell, begin, end);
        else if (n == 4)
            note_face(w, 4, face, (int32_t)i, cell, begin, end);
        else
            for (int k = 0; k < 2; k++)
                if (cell[k] >= begin && cell[k] < end)
                    w->known[cell[k]] |= WRONG;
    }
}

/** Return whether the top of a hexahedron is the face 4 5 6 7. */
static int has_top(const foam_mesh *mesh, const int32_t *element, int32_t side) {
    const int32_t *face = mesh->node + mesh->start[side < 0 ? ~side : side];
    const int step = side < 0 ? 3 : 1; /* from node to node around, seen from outside */
    int first = 0;
    while (first < 3 && face[first] != element[4])
        first++;
    int is_top = 1;
    for (int k = 0; k < 4; k++) {
        is_top &= face[(first + step * k) % 4] == element[4 + k];
        for (int j = 0; j < k; j++)
            is_top &= element[4 + j] != element[4 + k];
    }
    return is_top;
}

static void find_types(void *context, int64_t begin, int64_t end, int thread) {
    const walk *w = context;
    (void)thread;
    for (int64_t cell = begin; cell < end; cell++) {
        uint8_t *type = &w->elements->type[cell];
        if (w->known[cell] == (BASE | SIDES_OF_3))
            *type = PLANISH_CELL_TETRAHEDRON;
        else if (w->known[cell] == (BASE | SIDES_OF_4 | FOUR | TOP) &&
                 has_top(w->mesh, w->elements->node + cell * w->elements->width, w->top[cell]))
            *type = PLANISH_CELL_HEXAHEDRON;
    }
}

int foam_walk_faces(const foam_mesh *mesh, foam_elements *elements, planish_error *error) {
    enum { LEAST = 1 << 16, CHUNK = 1 << 12 }; /* cells that are worth a walk, and types */
    const int64_t n = mesh->n_cells, threads = pl_thread_count(io_model_threads(mesh->model));
    const int64_t share = (n + threads - 1) / threads;
    walk w = {.mesh = mesh, .elements = elements, .known = pl_alloc(n, sizeof *w.known)};
    if (elements->width > 4)
        w.top = pl_alloc(n, sizeof *w.top);
    const int is_there = w.known && (w.top || elements->width == 4);
    if (is_there) {
        pl_parallel_for(io_model_threads(mesh->model), n, share > LEAST ? share : LEAST, walk_chunk,
                        &w);
        pl_parallel_for(io_model_threads(mesh->model), n, CHUNK, find_types, &w);
    }
    pl_free(w.known);
    pl_free(w.top);
    return is_there ? PLANISH_OK : pl_fail_memory(error, "cells");
}
