/* text: names and sentences in lines of a given width. */
#ifndef PL_TOOLS_TEXT_H
#define PL_TOOLS_TEXT_H

#include <stddef.h>
#include <stdio.h>

enum { PL_TEXT_WIDTH = 80 }; /* of all that is printed for people */

/** Columns that text takes: its characters if it is UTF-8. */
int pl_text_columns(const char *text);

/** Name in columns at most: if it is longer, with "..." for its middle; control characters become
 *  '?'. text [size] is filled in and returned; size: 4 * columns + 1 is always enough. */
const char *pl_text_fit(const char *name, int columns, char *text, size_t size);

/** Print sentence and a line end, in lines of PL_TEXT_WIDTH at most, broken at blanks. */
void pl_text_wrap(FILE *stream, const char *sentence);

#endif
