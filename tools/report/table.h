/* table: what a mesh is worth, for people: what hurts most stands first. */
#ifndef PL_TOOLS_TABLE_H
#define PL_TOOLS_TABLE_H

#include "report/result.h"

#include <stdio.h>

/** Before and after, how it ended and what it took. */
void pl_table_smooth(FILE *stream, const pl_job *job, const pl_result *result);

/** One mesh. */
void pl_table_quality(FILE *stream, const pl_job *job, const planish_quality *quality,
                      const pl_volumes *volumes);

/** What is odd about the mesh, a line each: facets of more than two elements and the like. */
void pl_table_oddities(FILE *stream, const pl_job *job);

/** A note where elements are numbered the other way round than most, and not all of them because
 * they are inverted. */
void pl_table_reversed(FILE *stream, const planish_quality *quality);

#endif
