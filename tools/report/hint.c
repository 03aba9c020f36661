/* hint: the option that would improve the worst element further. */
#include "report/hint.h"
#include "options/combinations.h"

#include <inttypes.h>

/* A worst element that is no worse than that is not worth a hint. */
static const double GOOD_RATIO = 2.5;

/** Whether the worst element has no node that moves. */
static int is_worst_held(const pl_job *job, const pl_result *result) {
    const planish_quality *after = &result->after;
    const double worst = job->has_types ? result->validity_after.quality.all.max_aspect_ratio
                                        : after->max_radius_ratio;
    return after->n_fixed_elements > 0 && after->fixed_max_radius_ratio >= worst * (1 - 1e-9);
}

/** Find the options that would let a node of the worst element move, as bits PL_RELEASED_BY_.
 *  *is_layer: layers hold all its nodes. */
static unsigned find_releases(const pl_job *job, const pl_result *result, int *is_layer) {
    const int64_t worst = job->has_types ? result->validity_after.quality.all.worst_element
                                         : result->after.worst_element;
    unsigned releases = 0;
    int n_corners = 0;
    *is_layer = job->in_layer && worst >= 0;
    const int32_t *corner = worst >= 0 ? pl_job_corners(job, worst, &n_corners) : NULL;
    for (int j = 0; j < n_corners; j++) {
        releases |= job->released_by ? job->released_by[corner[j]] : 0;
        *is_layer = *is_layer && job->in_layer[corner[j]];
    }
    return releases;
}

/** Say which option would let nodes of the worst element move, in text [size]. Returns 0 if none is known. */
static int name_option(const pl_job *job, const pl_result *result, char *text, size_t size) {
    const pl_arguments *arguments = job->arguments;
    const planish_plan_info *info = &job->plan_info;
    int is_layer;
    const unsigned releases = find_releases(job, result, &is_layer);
    if (!arguments->slide && (releases & PL_RELEASED_BY_SLIDE))
        snprintf(text, size, "--slide auto lets %" PRId64 " nodes slide", job->could_slide);
    else if (releases & PL_RELEASED_BY_LAYERS)
        snprintf(text, size, "--layers ignore lets nodes of thin layers move");
    else if (job->mesh.dim == 3 && !arguments->slide_curved && !is_layer &&
             info->n_free + info->n_sliding < job->mesh.n_nodes)
        snprintf(text, size,
                 arguments->n_fix > 0 ? "try --slide curved, or fewer --fix"
                                      : "--slide curved lets more nodes slide");
    else
        return 0;
    return 1;
}

void pl_hint_print(FILE *stream, const pl_job *job, const pl_result *result) {
    const double worst = job->has_types ? result->validity_after.quality.all.max_aspect_ratio
                                        : result->after.max_radius_ratio;
    const int is_held = is_worst_held(job, result);
    char option[80];
    if (job->is_surface || !(worst > GOOD_RATIO) || job->options.method != PLANISH_METHOD_PLANISH ||
        pl_arguments_target(job->arguments))
        return;
    if (!is_held && !job->arguments->worst &&
        job->layers.n_kept == 0) /* these would be held then */
        fputs("hint: --objective worst may improve the worst elements further\n", stream);
    else if (is_held && name_option(job, result, option, sizeof option))
        fprintf(stream, "hint: the worst element has no movable node; %s\n", option);
}
