/* valid_ratios: ratios of a mesh by corners, without the elements that are inverted inside. */
#include "job/valid_ratios.h"

#include "job/job.h"
#include "terminal/message.h"

#include <math.h>
#include <stdlib.h>

/** Sums over valid elements. */
typedef struct sums {
    double square, most;
    int64_t n;
} sums;

/** Whether a node of an element is free or slides. */
static int is_movable(const pl_job *job, const uint8_t *is_free, int64_t element) {
    int n, any = 0;
    const int32_t *corner = pl_job_corners(job, element, &n);
    for (int k = 0; k < n; k++)
        any |= is_free[corner[k]] || (job->plan_info.n_sliding > 0 &&
                                      job->constraint[corner[k]] > PLANISH_CONSTRAINT_FIXED);
    return any;
}

/** Sum up the ratios of [0] fixed and [1] movable elements. */
static void add_up(const pl_job *job, const pl_cells_validity *validity, const uint8_t *is_free,
                   sums *of) {
    for (int64_t i = 0; i < job->mesh.n_elements; i++) {
        const double ratio = validity->aspect_ratio[i];
        if (!(ratio > 0))
            continue;
        sums *to = &of[is_movable(job, is_free, i)];
        to->square += ratio * ratio;
        to->most = fmax(to->most, ratio);
        to->n++;
    }
}

static void put(const sums *of, double *rms, double *most) {
    *rms = of->n > 0 ? sqrt(of->square / (double)of->n) : NAN;
    *most = of->n > 0 ? of->most : NAN;
}

int pl_measure_valid(const pl_job *job, planish_quality *quality, pl_cells_validity *validity) {
    sums of[2] = {{0}};
    int status = pl_job_measure(job, quality);
    if (!status)
        status = pl_cells_validity_find(job, validity);
    if (status || !job->has_types || validity->n_inside == 0)
        return status;
    uint8_t *is_free = malloc((size_t)job->mesh.n_nodes + 1);
    if (!is_free)
        return pl_job_complain_memory(job, "values of nodes");
    status = pl_job_get_free(job, is_free);
    if (!status) {
        add_up(job, validity, is_free, of);
        put(&of[0], &quality->fixed_rms_radius_ratio, &quality->fixed_max_radius_ratio);
        put(&of[1], &quality->rms_radius_ratio_movable, &quality->max_radius_ratio_movable);
    }
    free(is_free);
    return status;
}
