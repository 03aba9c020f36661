/* judge: whether a run has reached all that was asked for. */
#ifndef PL_TOOLS_JUDGE_H
#define PL_TOOLS_JUDGE_H

#include "report/result.h"

/** Find out whether all was reached, and fill in result->reason where it was not, or where there was
 *  nothing to do. Returns PL_EXIT_DONE or PL_EXIT_PARTLY. */
int pl_judge(const pl_job *job, pl_result *result);

#endif
