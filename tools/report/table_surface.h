/* table_surface: how far the surface of a mesh moved, and what that did to volumes. */
#ifndef PL_REPORT_TABLE_SURFACE_H
#define PL_REPORT_TABLE_SURFACE_H

#include "report/result.h"

#include <stdio.h>

/** Put a proved distance between the surface and the original one. */
void pl_table_put_distance(FILE *stream, const char *start, const char *middle,
                           const planish_shape_distance *d);

/** Put what nodes slide on, and how far the surface has moved. */
void pl_table_put_surface(FILE *stream, const pl_job *job, const pl_result *result);

/** Put how the surface was fitted to another one. */
void pl_table_put_onto(FILE *stream, const pl_job *job);

#endif
