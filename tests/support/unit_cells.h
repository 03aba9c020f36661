/* unit_cells: one straight element of any type, with its nodes in the order of a format, and the
 * check that a reader has put them into the right order. */
#ifndef TEST_SUPPORT_UNIT_CELLS_H
#define TEST_SUPPORT_UNIT_CELLS_H

#include "io/file/file.h"

/** An element as the document of a format describes it: corners as VTK has them, then nodes that
 *  are in the middle between two corners. */
typedef struct unit_cell {
    const char *name; /* in the format, */
    int number;       /* or its number there */
    int type;         /* planish_cell_type */
    const char *mids; /* the corners of each, counted from 1, as in "12 23 31" */
} unit_cell;

enum { UNIT_NODES = 27 };

/** Find the places [n][3] of the nodes of an element, a skewed one, so that a node in another place
 *  of the order makes it curved or invalid. is_mirrored: of the other handedness. Returns n. */
int unit_cell_places(const unit_cell *cell, int is_mirrored, double *xyz);

/** Return the dimension of an element, and its number of nodes. */
int unit_cell_dim(const unit_cell *cell);
int unit_cell_nodes(const unit_cell *cell);

/** Return whether planish smooths an element: a straight triangle or tetrahedron. */
int unit_cell_is_kept(const unit_cell *cell);

/** Fail the test unless the file has the element alone (or copies of it, n in all): valid,
 *  straight, with its nodes between the corners that VTK has them between. */
void unit_cell_check(planish_file *file, const unit_cell *cell, int n);

#endif
