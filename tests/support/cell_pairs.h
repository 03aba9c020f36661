/* cell_pairs: the same mesh by cells and by elements, for tests of planish_mesh.cells.
 *
 *   cell_pair_of, _fasten, _release       cells of simplices, with mids and other elements
 *   cell_pair_place, _append              its nodes and cells
 *   cell_pair_by_cells, _zeroed           arrays
 *   cell_pair_slide, _stop_sliding, _make_periodic    constraints of both
 *   cell_pair_box, _options               what most tests take
 */
#ifndef TEST_SUPPORT_CELL_PAIRS_H
#define TEST_SUPPORT_CELL_PAIRS_H

#include "support/meshes.h"

/** How cells are made of simplices, as bits. */
enum {
    PAIR_ORDER_2 = 1,     /* simplices have mids, in the middle */
    PAIR_HALF = 2,        /* every other one of them */
    PAIR_OTHERS = 4,      /* other elements stand between them: some hold nodes of simplices */
    PAIR_BY_COMPONENT = 8 /* coordinates are x x .. y y .. */
};

/** A mesh of cells and the same one of elements. */
typedef struct cell_pair {
    planish_mesh plain; /* constraint is FIXED where cells hold nodes */
    planish_mesh mesh;
    planish_cells cells;
    uint8_t *type;
    int64_t *offset;
    int32_t *node;
    double *x;           /* of mesh */
    uint8_t *constraint; /* of plain [n] */
    int64_t *cell_of;    /* [elements of plain] */
    int32_t (*end)[2];   /* [n_nodes] both ends of a mid, else -1 */
} cell_pair;

/** Return n things of size bytes, all 0, to be freed. */
void *cell_pair_zeroed(int64_t n, size_t size);

/** Coordinate d of a node of mesh, which may be written. */
double *cell_pair_place(const cell_pair *p, int64_t node, int d);

/** Append a cell of n nodes to those of mesh. */
void cell_pair_append(cell_pair *p, int type, const int32_t *node, int n);

/** Make cells of simplices, how as above; cell_pair_fasten is to come next, cell_pair_release at the
 *  end. */
cell_pair cell_pair_of(const test_mesh *simplices, int how);

/** Tell mesh where its cells are: p has been returned, so that they stay. */
void cell_pair_fasten(cell_pair *p);

/** Free the arrays of p. */
void cell_pair_release(cell_pair *p);

/** Values by element as an array by cells, with garbage at other cells; to be freed. */
void *cell_pair_by_cells(const cell_pair *p, const void *plain, size_t size);

/** Options of a short run by two threads. */
planish_options cell_pair_options(void);

/** Make a box of so many cubes along each side, perturbed by shake edges and numbered at random. */
test_mesh cell_pair_box(int dim, int cells, double shake);

/** Let nodes of both meshes slide, by planish_find_slides with each one's surface. */
void cell_pair_slide(cell_pair *p, const planish_surface *surface, const planish_surface *of_cells);

/** Free what cell_pair_slide has made. */
void cell_pair_stop_sliding(cell_pair *p);

/** The sides x = 0 and x = size of both meshes in pairs; mids in the pairs of mesh, too. At most most
 *  pairs of corners. */
void cell_pair_make_periodic(cell_pair *p, double size, int64_t most);

#endif
