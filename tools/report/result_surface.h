/* result_surface: the surface of a mesh as JSON: its features, and how far it has moved. */
#ifndef PL_REPORT_RESULT_SURFACE_H
#define PL_REPORT_RESULT_SURFACE_H

#include "job/curved.h"
#include "job/job.h"
#include "report/json.h"

/** Add the surface: its features, the nodes that slide on it, and how far it has moved; null: nobody
 *  asked for its shape. smooth: NULL of the command quality. */
void pl_result_add_surface(pl_json *json, cJSON *root, const pl_job *job,
                           const pl_surface_state *state, const planish_result *smooth);

#endif
