/* result_quality: measures of a mesh as JSON. */
#ifndef PL_REPORT_RESULT_QUALITY_H
#define PL_REPORT_RESULT_QUALITY_H

#include "report/json.h"
#include "report/measured.h"

/** Add the quality of simplices: by their corners, and where validity is known also by their
 *  mid-side nodes. edge_ratio and scaled_jacobian are those of the corners. */
void pl_result_add_quality(pl_json *json, cJSON *root, const char *name, const pl_job *job,
                           const planish_quality *q, const pl_cells_validity *validity,
                           int64_t below_min_volume, const pl_worst *worst);

/** Add the quality of a mesh with elements of other types before or after smoothing: by cells, and
 *  what the plan knows of their nodes. The keys of radius ratios and angles are null. */
void pl_result_add_smoothed_cells(pl_json *json, cJSON *root, const char *name, const pl_job *job,
                                  const planish_quality *q, const pl_cells_validity *validity,
                                  int64_t below_min_volume, const pl_worst *worst);

/** Add the quality of a mesh with elements of other types. The keys of simplices are null, as these
 *  measures do not exist of all elements; the object `simplices` has them. */
void pl_result_add_cells(pl_json *json, cJSON *root, const pl_job *job,
                         const pl_measured *measured);

#endif
