/* drawn_inside: the inside of a solid mesh in a picture: its elements, of a large mesh every k-th
 * one, and a grid with the worst element of each cell.
 *
 *     pl_drawn_inside_find, _free    the elements
 *     pl_drawn_grid_find, _take      the grid
 */
#ifndef PL_REPORT_DRAWN_INSIDE_H
#define PL_REPORT_DRAWN_INSIDE_H

#include "job/job.h"
#include "report/drawn_values.h"

/** Elements that are drawn, by their corners. */
typedef struct pl_drawn_inside {
    int64_t n;        /* elements */
    int64_t stride;   /* every stride-th of the mesh is one; 1: all are */
    int32_t *element; /* [n] owned */
    uint8_t *size;    /* [n] corners of each, owned */
    int64_t n_corners;
    int32_t *corner; /* [n_corners] points, owned */
    int64_t n_points;
    int32_t *node; /* [n_points] node of each point, owned */
} pl_drawn_inside;

/** Choose the solid elements that are drawn: all if there are at most most, else few. Returns 0, or an
 *  exit status after a message. inside is to be freed also after that. */
int pl_drawn_inside_find(const pl_job *job, int64_t most, int64_t few, pl_drawn_inside *inside);

void pl_drawn_inside_free(pl_drawn_inside *inside);

/** Cubes that fill the box of a mesh. */
typedef struct pl_drawn_grid {
    double low[3], size; /* corner of the box, and side of a cube */
    int32_t n[3];
    int64_t n_cells;
} pl_drawn_grid;

/** Return a grid of at most about most cubes over the box from low to high. */
pl_drawn_grid pl_drawn_grid_find(const double *low, const double *high, int64_t most);

/** Fill code [values->n_measures][grid->n_cells] with the code of the worst element in each cube, or
 *  PL_DRAWN_NOTHING; x runs fastest. */
void pl_drawn_grid_take(const pl_drawn_grid *grid, const pl_job *job, const pl_drawn_values *values,
                        uint8_t *code);

#endif
