/* histogram: the elements by their ratios, as bars of characters. */
#ifndef PL_TOOLS_HISTOGRAM_H
#define PL_TOOLS_HISTOGRAM_H

#include <planish/planish.h>

#include <stdio.h>

/** A row for each bin up to the last that has elements, and one of the inverted, if any; before
 * (may be NULL) and after side by side, on one scale. ratio: the name of their ratio. */
void pl_histogram_print(FILE *stream, const char *ratio, const planish_quality *before,
                        const planish_quality *after);

#endif
