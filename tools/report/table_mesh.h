/* table_mesh: what a mesh is: the first lines of a table, and the nodes that may move. */
#ifndef PL_REPORT_TABLE_MESH_H
#define PL_REPORT_TABLE_MESH_H

#include "job/cells.h"
#include "job/job.h"

#include <stdio.h>

/** Put the first line: file and format, elements in words, nodes. Elements of many types have
 * further lines. */
void pl_table_row_mesh(FILE *stream, const pl_job *job, const char *elements);

/** Put the first lines of a mesh of which not all elements are straight simplices: their numbers, and
 *  what follows their corners. */
void pl_table_rows_cells(FILE *stream, const pl_job *job, const pl_cells_validity *validity);

/** Put the first line of a mesh whose simplices alone matter. */
void pl_table_row_simplices(FILE *stream, const pl_job *job);

/** Put what the targets of the elements are, if they have any. */
void pl_table_row_target(FILE *stream, const pl_job *job);

/** Put how many nodes may move, or could. */
void pl_table_row_free(FILE *stream, const pl_job *job);

#endif
