/* table: the tables and notes on a mesh for a terminal.
 *
 *     pl_table_smooth      a mesh before and after, how smoothing ended and how long it took
 *     pl_table_compare     two states of a mesh
 *     pl_table_quality     one mesh
 *     pl_table_worst       the worst elements, two lines each
 *     pl_table_oddities    notes on what is odd about the mesh
 *     pl_table_reversed    the note on reversed elements
 */
#ifndef PL_TOOLS_TABLE_H
#define PL_TOOLS_TABLE_H

#include "report/result.h"

#include <stdio.h>

/** Print the measures of a mesh before and after, how smoothing ended and how long it took. */
void pl_table_smooth(FILE *stream, const pl_job *job, const pl_result *result);

/** Print the measures of two states of a mesh, and how far nodes are apart. */
void pl_table_compare(FILE *stream, const pl_job *job, const pl_result *result);

/** Print the measures of one mesh. */
void pl_table_quality(FILE *stream, const pl_job *job, const pl_measured *measured);

/** Print the first n of the worst elements, two lines each. */
void pl_table_worst(FILE *stream, const pl_worst *worst, int64_t n);

/** Print notes on what is odd about the mesh: facets of more than two elements and the like. */
void pl_table_oddities(FILE *stream, const pl_job *job);

/** Print a note if elements are numbered the other way round than most, and not all of these are
 *  inverted. */
void pl_table_reversed(FILE *stream, const planish_quality *quality);

#endif
