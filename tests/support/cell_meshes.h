/* cell_meshes: boxes of cells of every type, for tests.
 *
 *   cell_box_create, _destroy    a structured box
 *   cell_box_raise               the same with mids: types of order 2
 *   cell_box_shake               nodes inside pushed about
 */
#ifndef PL_TESTS_CELL_MESHES_H
#define PL_TESTS_CELL_MESHES_H

#include <planish/planish.h>

/** What boxes are made of. MIXED: columns of hexahedra, of wedges and of pyramids; in 2-D of
 *  quadrilaterals and of triangles. */
typedef enum cell_box_kind {
    BOX_QUADRILATERALS,
    BOX_MIXED_2D,
    BOX_HEXAHEDRA,
    BOX_WEDGES,
    BOX_PYRAMIDS,
    BOX_MIXED,
    N_BOX_KINDS
} cell_box_kind;

/** A mesh of cells, with its arrays. mesh.coordinates is x. */
typedef struct cell_box {
    planish_mesh mesh;
    planish_cells cells;
    double *x;
    int32_t *node;
    int64_t *offset;
    uint8_t *type;
} cell_box;

/** Make a box of n cubes (squares) of size 1 along each side. Destroy it in the end. */
cell_box *cell_box_create(cell_box_kind kind, int n);

/** Return a copy of box whose cells are of order 2, with mids where they are straight: of 8 and 20 nodes,
 *  or (is_full) of 9, 18 and 27. Pyramids stay as they are, so that edges may have mids of which they
 *  know nothing. */
cell_box *cell_box_raise(const cell_box *box, int is_full);

/** Push the nodes that are strictly inside the unit-celled box by up to amount in each direction, by
 *  random numbers of seed. For boxes of order 1. */
void cell_box_shake(cell_box *box, double amount, uint64_t seed);

/** Free box. */
void cell_box_destroy(cell_box *box);

#endif
