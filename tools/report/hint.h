/* hint: the option that would improve the worst element further. */
#ifndef PL_TOOLS_HINT_H
#define PL_TOOLS_HINT_H

#include "report/result.h"

#include <stdio.h>

/** Print why the worst element has not become better by smoothing, and the option that would let its nodes
 *  move. Print nothing where no option is known to help. */
void pl_hint_print(FILE *stream, const pl_job *job, const pl_result *result);

#endif
