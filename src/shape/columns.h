/* columns: the edges across layers, their columns and rows. Internal to shape.
 *
 * An edge across a layer is an upright. Uprights end to end make a column. Uprights of one element, and
 * those of a simplex and of the columns at its other nodes beside it, are of one row.
 *
 *   pl_columns_find, _destroy     uprights, columns, rows
 *   pl_columns_corner, _edge      edges along layers, and any
 */
#ifndef PL_SHAPE_COLUMNS_H
#define PL_SHAPE_COLUMNS_H

#include "geometry/layer_shape.h"
#include "shape/drawn.h"
#include "topology/frame.h"

#include <planish/planish.h>

/** Element of a layer. */
typedef struct pl_layer_cell {
    int32_t cell;
    uint8_t factor;     /* of a product: the line of it that the uprights are, */
    uint8_t end[2];     /* of a simplex: the corners of its upright, the lower one first */
    uint8_t level;      /* and bit c: corner c is as high as the upper one; */
    uint8_t is_level;   /* 1: this is known */
    uint8_t n_uprights; /* own and, after them, of simplices those beside it */
    int32_t upright[PL_UPRIGHTS]; /* of products by pl_upright_at */
} pl_layer_cell;

/** Why other rows tell the height of an upright. */
typedef enum pl_told {
    PL_TOLD = 1,        /* nodes of the layer were displaced */
    PL_TOLD_AT_WALL = 2 /* a wall was moved: the upright is the first one there */
} pl_told;

/** Columns of a mesh; lengths in units of the frame. Owned, but for mesh. */
typedef struct pl_columns {
    const planish_mesh *mesh; /* cells, dense coordinates */
    pl_frame frame;
    pl_drawn drawn;
    int threads;
    int8_t *sign; /* [cells] as of pl_orient_cells */
    int64_t n_cells;
    pl_layer_cell *cell; /* [n_cells] ascending */
    int64_t n_uprights;
    int32_t *end;      /* [n_uprights][2] nodes, the lower number first */
    int64_t n_columns; /* columns with their uprights in order: */
    int64_t *begin;    /* [n_columns + 1] in upright and, plus the column's number, in node */
    int32_t *upright;  /* [n_uprights] */
    int32_t *node;     /* [n_uprights + n_columns] ends of the uprights, one after the other */
    int32_t *column;   /* [n_uprights] of an upright, */
    int32_t *place;    /* [n_uprights] and its place in upright */
    int64_t n_sides;   /* parts of columns that rise from one wall (sides.h): */
    int64_t *side;     /* [n_sides + 1] in upright */
    double *height;    /* [n_uprights] how long it is to be */
    uint8_t *leans;    /* [n_uprights] 1: it leans over its layer for good, as the wall turns */
    uint8_t *told;     /* [n_uprights] not 0: other rows tell its height, pl_told */
    uint8_t *is_moved; /* [n_sides] 1: its wall was moved by much */
} pl_columns;

/** Find the columns of the marked elements of mesh, and of flat or inverted ones that go on from them;
 *  not the levels of simplices (levels.h). Errors: _MEMORY, _MESH. */
int pl_columns_find(const planish_mesh *mesh, const uint8_t *is_layer, int threads, pl_columns *c,
                    planish_error *error);

/** Free the columns. */
void pl_columns_destroy(pl_columns *c);

/** Difference of nodes b - a. */
static inline void pl_columns_edge(const pl_columns *c, int32_t a, int32_t b, double edge[3]) {
    const int dim = c->mesh->dim;
    edge[2] = 0;
    for (int d = 0; d < dim; d++)
        edge[d] = pl_frame_difference(&c->frame, c->mesh->coordinates[(int64_t)b * dim + d],
                                      c->mesh->coordinates[(int64_t)a * dim + d]);
}

/** Number of corners of an element that decide on its layer: of products all, of simplices 1, or 0
 *  if their levels are not known. */
static inline int pl_layer_corners(const pl_cell_shape *shape, const pl_layer_cell *cell) {
    return shape->n_simplices > 1 ? shape->n_corners : cell->is_level;
}

/** Find the edges along the layer at corner k of an element, of simplices from the ends of the upright
 *  to nodes as high. along [dim - 1]; others are 0. Return the place of the upright there in
 *  cell->upright. */
int pl_columns_corner(const pl_columns *c, const pl_layer_cell *cell, int k, double along[2][3]);

#endif
