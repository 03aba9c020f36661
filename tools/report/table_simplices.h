/* table_simplices: measures of simplices, and inverted elements of any type. */
#ifndef PL_REPORT_TABLE_SIMPLICES_H
#define PL_REPORT_TABLE_SIMPLICES_H

#include "job/cells.h"

#include <stdio.h>

/** Whether ratios and angles are of the same elements before (NULL: no matter) and after: they are
 *  those of the valid ones. */
int pl_table_are_of_same(const planish_quality *before, const planish_quality *after);

/** Put the rows of elements that are inverted: by their corners, or by their mid-side nodes. Where
 *  validity is not known, quality tells. */
void pl_table_rows_inverted(FILE *stream, const planish_quality *before,
                            const planish_quality *after, const pl_cells_validity *validity_before,
                            const pl_cells_validity *validity);

/** Put the measures of simplices; validity_before, validity: with their mid-side nodes. */
void pl_table_rows_quality(FILE *stream, int dim, const planish_quality *before,
                           const planish_quality *after, const pl_cells_validity *validity_before,
                           const pl_cells_validity *validity);

/** Put all measures of simplices (docs/measures.md); the range begins with the value of the regular
 *  element, but for R / longest edge, where that is 1. */
void pl_table_put_spreads(FILE *stream, int solid, const planish_quality *q);

#endif
