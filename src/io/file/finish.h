/* finish: what is done to a model when its reader is done. */
#ifndef PL_IO_FILE_FINISH_H
#define PL_IO_FILE_FINISH_H

#include "io/core/format.h"

/** Find the lines and triangles that a file has only because it lists all edges or facets of its
 *  elements, and put them behind the others: n_plain of each (listed.c). */
int io_model_find_plain(io_model *model, planish_error *error);

/** Decide the dimension (tetrahedra if there are any, else triangles), let lines, and triangles of
 *  a 3-D mesh, hold their nodes, find the plane of a 2-D mesh (plane.h), lay out
 *  coordinates. Fails if there is nothing to smooth.
 *  format: that it was read as; NULL: text has as many digits as it needs. */
int io_model_finish(io_model *model, const io_format *format, planish_error *error);

#endif
