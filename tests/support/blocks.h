/* blocks: solids that are fitted to other surfaces, and these surfaces.
 *
 *   block_create, _destroy                             a block of cells in a form
 *   block_stretch                                      the same stretched
 *   block_target_create, _create_curved, _destroy      a surface of triangles in a form
 *   block_target_place                                 the same stretched, and elsewhere
 */
#ifndef TEST_SUPPORT_BLOCKS_H
#define TEST_SUPPORT_BLOCKS_H

#include "support/cell_meshes.h"

/** Forms that the cube -1 .. 1 is taken to, times a size. */
typedef enum block_form { BLOCK_CUBE, BLOCK_BALL, BLOCK_CYLINDER } block_form;

/** A block of cubes, as cells or as six tetrahedra each, in a form. */
typedef struct block {
    cell_box *box;
    int32_t *tetrahedron;
    planish_mesh mesh;
    double *given; /* its coordinates at first */
    planish_shape *shape;
} block;

/** Make a block of n cubes along each side: tetrahedra, or cells of a kind. shake: how far nodes of the surface
 *  are off it at most, in parts of an edge, by random. */
void block_create(int is_tets, cell_box_kind kind, block_form f, int n, double size, double shake,
                  uint64_t *random, block *b);

/** Stretch a block along each axis. */
void block_stretch(block *b, const double stretch[3]);

void block_destroy(block *b);

/** The surface of a cube as triangles, taken to a form. It is not copied. */
typedef struct block_target {
    planish_mesh mesh; /* cells is &cells */
    planish_cells cells;
    double *x;
    int32_t *node;
    int64_t *offset;
    uint8_t *type;
    planish_shape *shape;
} block_target;

/** Make a surface of n squares along each side; is_turned: its triangles turn inwards. */
void block_target_create(block_form f, int n, double size, int is_turned, block_target *s);

/** Stretch a surface along each axis, then shift it. */
void block_target_place(block_target *s, const double stretch[3], const double shift[3]);

/** Make a surface of six sides of two triangles of order 2 each. */
void block_target_create_curved(block_form f, double size, block_target *s);

void block_target_destroy(block_target *s);

#endif
