/* cell_star: one node with cells of any type around it, as the kernels see their corners. The cells
 * share the node and nothing else: nothing in a star's function depends on more. */
#ifndef TEST_SUPPORT_CELL_STAR_H
#define TEST_SUPPORT_CELL_STAR_H

#include "star/star.h"

enum {
    CELL_STAR_MAX_CELLS = 8,
    CELL_STAR_MAX_NODES = 1 + 7 * CELL_STAR_MAX_CELLS,
    CELL_STAR_MAX_FACETS = 4 * CELL_STAR_MAX_CELLS,
    CELL_STAR_MAX_ROWS = 8
};

typedef struct cell_star {
    int dim, n_cells;
    const pl_cell_shape *shape[CELL_STAR_MAX_CELLS];
    int node[CELL_STAR_MAX_CELLS][8]; /* of the star; 0: its own */
    double coordinates[3 * CELL_STAR_MAX_NODES];
    int n_facets;
    int cell[CELL_STAR_MAX_FACETS], corner[CELL_STAR_MAX_FACETS]; /* of each facet, */
    int facet[CELL_STAR_MAX_FACETS][3];                           /* and its nodes */
    pl_corner_form form[PL_N_FORMS];
    uint8_t code[CELL_STAR_MAX_FACETS], positions[9 * CELL_STAR_MAX_FACETS];
    int32_t centre, ring[CELL_STAR_MAX_NODES];
    int64_t ring_offset[2], link_offset[2];
    uint8_t changed[CELL_STAR_MAX_NODES];
    int64_t n_rows; /* further rows, of has_more */
    pl_star_row row[CELL_STAR_MAX_ROWS];
    uint8_t has_more;
    double *scratch; /* owned */
    pl_star_guard guard;
    pl_star_problem problem; /* without the guard */
} cell_star;

/** Make a star of n cells of random shapes, valid and distorted by at most noise (0 to 0.4). shape
 *  NULL: any. Release with cell_star_destroy. */
void cell_star_create(cell_star *star, int dim, const pl_cell_shape *shape, int n, double noise,
                      uint64_t *random);
void cell_star_destroy(cell_star *star);

/** The corner of a facet by definition, with the star's node at x, in long double: mu^2 = |T|^4 /
 *  (dim^2 det T^(4 / dim)), its determinant D, 1 / SJ^2, the smoothed squared edge ratio, and the
 *  sum of squares |T|^2. */
typedef struct cell_corner {
    long double mu2, D, edges, squares, ideal_determinant;
    long double jacobian; /* 1 / SJ^2; of a simplex the largest, of all its vertices: */
    int n_jacobians;
    long double jacobians[4];
} cell_corner;
cell_corner cell_star_corner(const cell_star *star, int facet, const long double *x);

/** The further row that a facet would be: the same D and mu^2 for any move of the node; its weight is
 *  the corner's share. */
pl_star_row cell_star_row(const cell_star *star, int facet);

/** Have the problem heed the first n rows of star->row. */
void cell_star_use_rows(cell_star *star, int n);

/** Corners of the cell of a facet: what share a corner has in its cell. */
int cell_star_corners(const cell_star *star, int facet);

/** The ideal element of a shape, with edges of 1: position of its corners. */
void cell_star_ideal(const pl_cell_shape *shape, double x[8][3]);

#endif
