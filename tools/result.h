/* result: what a run has come to, and its report as JSON. */
#ifndef PL_TOOLS_RESULT_H
#define PL_TOOLS_RESULT_H

#include "job.h"
#include "progress.h"

/** Everything that smooth can say about a run. */
typedef struct pl_result {
    planish_quality before, after;
    planish_result smooth;
    double smooth_seconds, write_seconds, total_seconds;
    char reason[256]; /* why the end is not the plain one, or "" */
} pl_result;

/** The report of smooth as JSON text, to be released by free; NULL without memory. */
char *pl_result_smooth_json(const pl_job *job, const pl_result *result,
                            const pl_progress *progress);

/** The report of quality, likewise. */
char *pl_result_quality_json(const pl_job *job, const planish_quality *quality);

#endif
