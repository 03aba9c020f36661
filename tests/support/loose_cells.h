/* loose_cells: elements of every type that share no nodes, for tests of measures.
 *
 *   loose_cells_create, _destroy, _add, _add_line, _mixed     the elements
 *   cell_values_make, _destroy, _expect_same                  arrays of what is measured of each
 */
#ifndef PL_TESTS_LOOSE_CELLS_H
#define PL_TESTS_LOOSE_CELLS_H

#include <planish/planish.h>

enum { LOOSE_TYPES = 16, LOOSE_MOST = 20000 /* elements */ };

/** All types that are measured. */
extern const int loose_types[LOOSE_TYPES];

/** Elements that share no nodes. */
typedef struct loose_cells {
    int dim;
    planish_cells cells;
    int64_t n_nodes;
    uint8_t *type;
    int64_t *offset;
    int32_t *node;
    double *x;
} loose_cells;

/** A point of a table. */
typedef double loose_point[3];

/** Return the table of a type's corners: of triangles, quadrilaterals, tetrahedra, pyramids, wedges or
 *  hexahedra. */
const loose_point *loose_choose(int type, const loose_point *const of[6]);

/** Return the corners of the ideal element of a type. */
const loose_point *loose_ideal_corners(int type);

/** Make an empty mesh, to be destroyed in the end. */
loose_cells loose_cells_create(int dim);

/** Free the arrays of m. */
void loose_cells_destroy(loose_cells *m);

/** Add the ideal element of a type, its corners pushed, its mids off their middles by bend, mirrored
 *  if side is -1. Return the first of its nodes. */
int32_t loose_cells_add(loose_cells *m, int type, double push, double bend, double side,
                        uint64_t *random);

/** Add a line between the first two nodes. */
void loose_cells_add_line(loose_cells *m);

/** Make n elements of all types of dimension dim, valid and invalid, and lines. */
loose_cells loose_cells_mixed(int dim, int64_t n, uint64_t seed);

/** The elements as a mesh. */
planish_mesh loose_cells_mesh(const loose_cells *m);

/** Arrays of all values, and their planish_cell_values. */
typedef struct cell_values {
    int64_t n;
    uint8_t *bytes;
    double *doubles;
    planish_cell_values of;
} cell_values;

/** Make arrays for n elements, marked (faults.h). */
cell_values cell_values_make(int64_t n);

/** Free the arrays of v. */
void cell_values_destroy(cell_values *v);

/** Expect that a and b have the same bits. */
void cell_values_expect_same(const cell_values *a, const cell_values *b);

#endif
