/* hint: what would help more. */
#ifndef PL_TOOLS_HINT_H
#define PL_TOOLS_HINT_H

#include "report/result.h"

#include <stdio.h>

/** Print a line on why the worst element is no better after smoothing, and the option that would let it
 *  be; nothing where no option is known to help. */
void pl_hint_print(FILE *stream, const pl_job *job, const pl_result *result);

#endif
