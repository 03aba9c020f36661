/* table_rows: lines of a table for a terminal: a label, a value or two, and how that changed.
 *
 *     pl_table_widths_of                            columns
 *     pl_table_put_label, _put_real, _put_heading   parts of a line
 *     pl_table_row_real, _row_count                 whole lines
 *     pl_table_word_for                             a word for one or many
 */
#ifndef PL_REPORT_TABLE_ROWS_H
#define PL_REPORT_TABLE_ROWS_H

#include <stdint.h>
#include <stdio.h>

enum { PL_UNIT_WIDTH = 4, PL_CHANGE_WIDTH = 11, PL_MOST_LABEL = 31, PL_TYPE_WIDTH = 15 };

/** Columns of a table's parts. */
typedef struct pl_table_widths {
    int label, value, spread;
    int is_narrow; /* columns that can be spared are left out */
} pl_table_widths;

/** Return the columns that fit the terminal of stream. */
pl_table_widths pl_table_widths_of(FILE *stream);

/** Meaning of a row's number: which way is better, and how a change of it is told. */
typedef struct pl_table_measure {
    const char *unit;
    enum { PL_LESS_IS_BETTER, PL_MORE_IS_BETTER } sense;
    enum { PL_CHANGE_RELATIVE, PL_CHANGE_ABSOLUTE, PL_CHANGE_COUNTED, PL_NOT_COMPARED } change;
} pl_table_measure;

/** Put a label in its column. */
void pl_table_put_label(FILE *stream, const char *label);

/** Put a value of width columns; "-" if it is not finite. */
void pl_table_put_real(FILE *stream, int width, double value);

/** Put a line in the style of headings. */
void pl_table_put_heading(FILE *stream, const char *text);

/** Put a line of a real value; before: the value that it is compared with, or NULL. */
void pl_table_row_real(FILE *stream, const char *label, const double *before, double after,
                       const pl_table_measure *m);

/** Put a line of a number of faults; before: as above. */
void pl_table_row_count(FILE *stream, const char *label, const int64_t *before, int64_t after);

/** "1 node", "2 nodes": the number, and the word for so many. */
const char *pl_table_word_for(int64_t n, const char *one, const char *many);

#endif
