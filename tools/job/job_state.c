/* job_state: what every part of a job asks it: its file's numbers, its elements, how nodes are held,
 * messages. */
#include "job/job_state.h"

#include "job/cell_types.h"
#include "terminal/message.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

const char *const *pl_job_region_arrays(const pl_job *job) {
    return planish_file_region_arrays(job->arguments->ignore_regions ? NULL : job->file);
}

int pl_job_element_dim(const pl_job *job) {
    return job->is_surface ? 2 : job->mesh.dim;
}

const int32_t *pl_job_corners(const pl_job *job, int64_t element, int *n) {
    const planish_cells *cells = job->mesh.cells;
    *n = job->mesh.dim + 1;
    if (!cells)
        return job->mesh.elements + element * *n;
    *n = pl_cell_corners((planish_cell_type)cells->type[element]);
    return cells->node + cells->offset[element];
}

int64_t pl_job_element_number(const pl_job *job, int64_t element) {
    return job->file ? planish_file_element_number(job->file, element) : element;
}

void pl_job_box_widen(pl_job_box *box, int dim, const double *x, int64_t n) {
    for (int d = 0; d < dim; d++) {
        double low = box->is_known ? box->low[d] : INFINITY;
        double high = box->is_known ? box->high[d] : -INFINITY;
        for (int64_t i = 0; i < n; i++) {
            low = fmin(low, x[i * dim + d]);
            high = fmax(high, x[i * dim + d]);
        }
        box->low[d] = low;
        box->high[d] = high;
    }
    box->is_known = 1;
}

/** Whether the error is an element with the same node at two corners. */
static int is_collapsed(const pl_job *job, const planish_error *error) {
    if (error->code != PLANISH_ERROR_MESH || !job->file || error->element < 0 ||
        error->element >= job->mesh.n_elements)
        return 0;
    int n_corners, n = 0;
    const int32_t *corner = pl_job_corners(job, error->element, &n_corners);
    for (int i = 0; i < n_corners; i++)
        n += corner[i] == error->node;
    return n > 1;
}

int pl_job_complain(const pl_job *job, int status, const planish_error *error) {
    const char *input = job->arguments->input;
    char where[64] = "";
    /* The library's text has its own numbers. */
    if (is_collapsed(job, error))
        return pl_complain(status,
                           "%s: element %" PRId64 " has node %" PRId64
                           " twice; remove the collapsed element",
                           input, planish_file_element_number(job->file, error->element),
                           planish_file_node_number(job->file, error->node));
    if (error->element >= 0 && job->file)
        snprintf(where, sizeof where, " (element %" PRId64 " of the file)",
                 planish_file_element_number(job->file, error->element));
    else if (error->node >= 0 && job->file)
        snprintf(where, sizeof where, " (node %" PRId64 " of the file)",
                 planish_file_node_number(job->file, error->node));
    if (error->code == PLANISH_ERROR_FILE || error->code == PLANISH_ERROR_FORMAT)
        return pl_complain(status, "%s", error->text);
    return pl_complain(status, "%s: %s%s", input, error->text, where);
}

planish_hold pl_job_hold(const pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    return (planish_hold){.tags = arguments->fix,
                          .n_tags = arguments->n_fix,
                          .ignore_regions = arguments->ignore_regions,
                          .slide_tags = arguments->slide_tag,
                          .n_slide_tags = arguments->n_slide_tags};
}

int pl_job_complain_memory(const pl_job *job, const char *of) {
    return pl_complain(PL_EXIT_FAILED,
                       "%s: out of memory for %s (%" PRId64 " elements, %" PRId64 " nodes)",
                       job->arguments->input, of, job->mesh.n_elements, job->mesh.n_nodes);
}
