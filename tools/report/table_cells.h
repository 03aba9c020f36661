/* table_cells: measures of elements of every type, and their sizes. */
#ifndef PL_REPORT_TABLE_CELLS_H
#define PL_REPORT_TABLE_CELLS_H

#include "report/result.h"

#include <stdio.h>

/** Put the sizes of elements against those that are wanted; before may be NULL. */
void pl_table_rows_sizes(FILE *stream, const planish_size_quality *before,
                         const planish_size_quality *after);

/** Put the measures of a mesh with elements of other types, by cells; what the plan knows of those
 *  with movable nodes is its own. */
void pl_table_rows_aspect(FILE *stream, const pl_job *job, const pl_result *result);

/** Put the measures of elements of every type. */
void pl_table_put_cells(FILE *stream, const pl_job *job, const pl_cells *cells);

#endif
