/* result: the findings of a run, and its report as JSON.
 *
 *     pl_result, pl_result_smooth_json      of smooth
 *     pl_quality_report_*                   of quality, mesh by mesh (measured.h)
 */
#ifndef PL_TOOLS_RESULT_H
#define PL_TOOLS_RESULT_H

#include "job/heights.h"
#include "job/progress.h"
#include "report/measured.h"
#include "report/picture.h"

/** Everything that smooth can say about a run. */
typedef struct pl_result {
    planish_quality before, after;                     /* by the corners of elements, */
    pl_cells_validity validity_before, validity_after; /* and with their mid-side nodes */
    uint64_t input_checksum;                           /* of the coordinates as read, */
    uint64_t checksum;                                 /* and as written */
    pl_picture *picture;                               /* for a page, owned, or NULL */
    int64_t returned_nodes; /* nodes of a tilted plane that went back (promises.h) */
    int64_t below_before;   /* elements below their minimum volume in the input */
    pl_volumes volumes;     /* those of the result */
    pl_unfixable unfixable;
    pl_reversed reversed;
    pl_worst worst_before, worst_after; /* empty if there is no report */
    pl_surface_state surface;
    planish_result smooth;
    double smooth_seconds, write_seconds, total_seconds;
    int lacks_history;  /* of the page: a message has said why */
    int lacks_reports;  /* there was no memory for what reports need */
    char reason[1024];  /* why the end is not the plain one, or "" */
    pl_heights heights; /* of layers, after */
} pl_result;

/** Whether first-order optimality was measured: there is more to it than a small gradient. */
int pl_result_has_optimality(const pl_job *job);

/** The report of smooth as JSON text, to be released by free; NULL without memory. */
char *pl_result_smooth_json(const pl_job *job, const pl_result *result,
                            const pl_progress *progress);

struct cJSON;

/** The report of quality while it is made: mesh by mesh. */
typedef struct pl_quality_report {
    struct cJSON *meshes;
    int failed;
} pl_quality_report;

void pl_quality_report_begin(pl_quality_report *report);
void pl_quality_report_add(pl_quality_report *report, const pl_job *job,
                           const pl_measured *measured);

/** Its text, as above: the list of the meshes, or, if that is not wanted, the only one. */
char *pl_quality_report_finish(pl_quality_report *report, int is_list);

void pl_quality_report_free(pl_quality_report *report);

#endif
