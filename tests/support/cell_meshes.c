/* cell_meshes: structured boxes; every cube is one cell, two wedges, or six pyramids. */
#include "cell_meshes.h"

#include "geometry/cell.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_PARTS = 6, MOST_NODES = 27 };

static int is_flat(cell_box_kind kind) {
    return kind == BOX_QUADRILATERALS || kind == BOX_MIXED_2D;
}

static void reserve(cell_box *b, int64_t n_nodes, int64_t n_cells) {
    b->x = calloc((size_t)n_nodes * 3, sizeof *b->x);
    b->type = calloc((size_t)n_cells, 1);
    b->offset = calloc((size_t)n_cells + 1, sizeof *b->offset);
    b->node = calloc((size_t)n_cells * MOST_NODES, sizeof *b->node);
    if (!b->x || !b->type || !b->offset || !b->node)
        abort();
}

static void link_arrays(cell_box *b) {
    b->cells.type = b->type;
    b->cells.offset = b->offset;
    b->cells.node = b->node;
    b->mesh.cells = &b->cells;
    b->mesh.coordinates = b->x;
    b->mesh.n_elements = b->cells.n;
}

static void add(cell_box *b, int type, const int32_t *node, int n) {
    const int64_t at = b->offset[b->cells.n];
    memcpy(b->node + at, node, (size_t)n * sizeof *node);
    b->type[b->cells.n++] = (uint8_t)type;
    b->offset[b->cells.n] = at + n;
}

/** Add the cells of the square with corners c [4]. */
static void add_square(cell_box *b, const int32_t *c, int is_cut) {
    const int32_t low[] = {c[0], c[1], c[2]}, high[] = {c[0], c[2], c[3]};
    if (!is_cut) {
        add(b, PLANISH_CELL_QUADRILATERAL, c, 4);
        return;
    }
    add(b, PLANISH_CELL_TRIANGLE, low, 3);
    add(b, PLANISH_CELL_TRIANGLE, high, 3);
}

/** Add the cells of the cube with corners c [8], of kind; centre: a node for its middle. */
static void add_cube(cell_box *b, const int32_t *c, cell_box_kind kind, int32_t centre) {
    static const uint8_t face[6][4] = {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1},
                                       {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};
    if (kind == BOX_HEXAHEDRA)
        add(b, PLANISH_CELL_HEXAHEDRON, c, 8);
    if (kind == BOX_WEDGES) {
        const int32_t one[] = {c[0], c[1], c[2], c[4], c[5], c[6]};
        const int32_t two[] = {c[0], c[2], c[3], c[4], c[6], c[7]};
        add(b, PLANISH_CELL_WEDGE, one, 6);
        add(b, PLANISH_CELL_WEDGE, two, 6);
    }
    for (int f = 0; kind == BOX_PYRAMIDS && f < 6; f++) {
        const int32_t node[] = {c[face[f][0]], c[face[f][1]], c[face[f][2]], c[face[f][3]], centre};
        add(b, PLANISH_CELL_PYRAMID, node, 5);
    }
}

/** Kind of the column at i, j. */
static cell_box_kind kind_of_column(cell_box_kind kind, int i, int j) {
    static const cell_box_kind turn[] = {BOX_HEXAHEDRA, BOX_WEDGES, BOX_PYRAMIDS};
    return kind == BOX_MIXED ? turn[(i + 2 * j) % 3] : kind;
}

static int32_t add_centre(cell_box *b, int dim, double x, double y, double z) {
    const double at[] = {x + 0.5, y + 0.5, z + 0.5};
    memcpy(b->x + b->mesh.n_nodes * dim, at, (size_t)dim * sizeof *at);
    return (int32_t)b->mesh.n_nodes++;
}

cell_box *cell_box_create(cell_box_kind kind, int n) {
    static const uint8_t corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                         {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    cell_box *b = calloc(1, sizeof *b);
    const int dim = is_flat(kind) ? 2 : 3, layers = dim == 3 ? n : 1;
    const int64_t side = n + 1, cubes = (int64_t)n * n * layers;
    if (!b)
        abort();
    b->mesh.dim = dim;
    reserve(b, side * side * (dim == 3 ? side : 1) + cubes, cubes * MOST_PARTS);
    for (int k = 0; k < (dim == 3 ? side : 1); k++)
        for (int j = 0; j < side; j++)
            for (int i = 0; i < side; i++) {
                const double at[] = {i, j, k};
                memcpy(b->x + b->mesh.n_nodes++ * dim, at, (size_t)dim * sizeof *at);
            }
    for (int k = 0; k < layers; k++)
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++) {
                int32_t c[8];
                for (int q = 0; q < 8; q++)
                    c[q] = (int32_t)(i + corner[q][0] +
                                     side * (j + corner[q][1] + side * (k + corner[q][2])));
                const cell_box_kind own = kind_of_column(kind, i, j);
                if (dim == 2)
                    add_square(b, c, kind == BOX_MIXED_2D && (i + j) % 3 == 0);
                else
                    add_cube(b, c, own, own == BOX_PYRAMIDS ? add_centre(b, 3, i, j, k) : -1);
            }
    link_arrays(b);
    return b;
}

/* ---- order 2 --------------------------------------------------------------------------------- */

/** Type of order 2 for one of order 1. */
static int raised(int type, int is_full) {
    switch (type) {
    case PLANISH_CELL_TRIANGLE:
        return PLANISH_CELL_TRIANGLE6;
    case PLANISH_CELL_QUADRILATERAL:
        return is_full ? PLANISH_CELL_QUADRILATERAL9 : PLANISH_CELL_QUADRILATERAL8;
    case PLANISH_CELL_TETRAHEDRON:
        return PLANISH_CELL_TETRAHEDRON10;
    case PLANISH_CELL_HEXAHEDRON:
        return is_full ? PLANISH_CELL_HEXAHEDRON27 : PLANISH_CELL_HEXAHEDRON20;
    case PLANISH_CELL_WEDGE:
        return is_full ? PLANISH_CELL_WEDGE18 : PLANISH_CELL_WEDGE15;
    default:
        return type;
    }
}

/** Return the node at place x, which is made if there is none from first on. */
static int32_t node_at(cell_box *b, const double *x, int64_t first) {
    const size_t size = (size_t)b->mesh.dim * sizeof *x;
    for (int64_t i = first; i < b->mesh.n_nodes; i++)
        if (memcmp(b->x + i * b->mesh.dim, x, size) == 0)
            return (int32_t)i;
    memcpy(b->x + b->mesh.n_nodes * b->mesh.dim, x, size);
    return (int32_t)b->mesh.n_nodes++;
}

cell_box *cell_box_raise(const cell_box *box, int is_full) {
    cell_box *b = calloc(1, sizeof *b);
    const int dim = box->mesh.dim;
    if (!b)
        abort();
    b->mesh.dim = dim;
    reserve(b, box->mesh.n_nodes + box->cells.n * MOST_NODES, box->cells.n);
    memcpy(b->x, box->x, (size_t)(box->mesh.n_nodes * dim) * sizeof *b->x);
    b->mesh.n_nodes = box->mesh.n_nodes;
    for (int64_t i = 0; i < box->cells.n; i++) {
        const pl_cell_type *type = pl_cell_type_of(raised(box->type[i], is_full));
        const int32_t *corner = box->node + box->offset[i];
        int32_t node[MOST_NODES];
        for (int j = 0; j < type->n_nodes; j++) {
            const uint8_t *pair = type->between[j];
            double x[3] = {0, 0, 0};
            for (int d = 0; d < dim; d++)
                x[d] = 0.5 * box->x[(int64_t)corner[pair[0]] * dim + d] +
                       0.5 * box->x[(int64_t)corner[pair[1]] * dim + d];
            node[j] = pair[0] == pair[1] ? corner[j] : node_at(b, x, box->mesh.n_nodes);
        }
        add(b, type->type, node, type->n_nodes);
    }
    link_arrays(b);
    return b;
}

/* ---- places ----------------------------------------------------------------------------------- */

void cell_box_shake(cell_box *b, double amount, uint64_t seed) {
    const int dim = b->mesh.dim;
    double largest = 0;
    for (int64_t i = 0; i < b->mesh.n_nodes * dim; i++)
        largest = b->x[i] > largest ? b->x[i] : largest;
    for (int64_t i = 0; i < b->mesh.n_nodes; i++) {
        int is_inside = 1;
        for (int d = 0; d < dim; d++)
            is_inside &= b->x[i * dim + d] > 0 && b->x[i * dim + d] < largest;
        for (int d = 0; is_inside && d < dim; d++) {
            seed = seed * 6364136223846793005U + 1442695040888963407U;
            b->x[i * dim + d] += amount * ((double)(seed >> 11) * 0x1p-52 - 1);
        }
    }
}

void cell_box_destroy(cell_box *b) {
    if (!b)
        return;
    free(b->x);
    free(b->type);
    free(b->offset);
    free(b->node);
    free(b);
}
