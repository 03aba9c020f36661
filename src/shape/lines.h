/* lines: straight chains of edges. Internal to shape. */
#ifndef PL_SHAPE_LINES_H
#define PL_SHAPE_LINES_H

#include "shape/planes.h"

/** Straight lines: chains of two or more ridges. */
typedef struct pl_lines {
    int64_t n;
    int32_t *n_ridges;  /* [n_nodes] ridges that end at each node */
    int32_t *of_node;   /* [n_nodes] the line that the node is inside of, or -1 */
    int32_t (*next)[2]; /* [n_nodes] its neighbours on that line */
    double *direction;  /* [n][3] of unit length */
} pl_lines;

/** Find the lines that ridges make. A node is inside of one if two ridges of the same label meet
 *  there, straight on. Errors: _MEMORY. */
int pl_lines_create(const pl_surface *surface, const pl_ridges *ridges, double tolerance,
                    pl_lines *lines, planish_error *error);

/** Free the arrays of lines. */
void pl_lines_destroy(pl_lines *lines);

#endif
