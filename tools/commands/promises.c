/* promises: what planish_smooth promises of a result, kept where the file rounds it, and checked.
 *
 * In a tilted plane the library has rounded nothing to what the file holds, as no number of its
 * coordinates is one of the file. So signs are made sure of (planish_file_round_in_plane), and the promises
 * are looked at again: elements that break them get their nodes back, and if that does not do, all.
 */
#include "commands/promises.h"

#include "terminal/message.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* F before and after is summed over the same elements, most of which are unchanged: a rise
 * within the rounding of such a sum says nothing. Relative. */
static const double F_ROUNDING = 1e-12;

/* Scaled Jacobians are at most about 1; those of nearly flat corners are rounded. */
static const double JACOBIAN_ROUNDING = 1e-12;

/* Ratios and angles of facets in space, which may be needles. */
static const double SURFACE_ROUNDING = 1e-6;

/** Whether the mesh was valid, so that its worst element counts. */
static int was_valid(const pl_result *result) {
    return pl_cells_validity_faults(&result->validity_before, &result->before) == 0 &&
           result->below_before == 0;
}

/** Whether an element was valid with its mid-side nodes, and is not so now. What untangles elements of
 *  other types may leave others not valid, but no more of them. */
static int is_newly_invalid(const pl_cells_validity *before, const pl_cells_validity *after,
                            int64_t element) {
    return after->is_known && before->state[element] == PLANISH_CELL_STATE_VALID &&
           after->state[element] != PLANISH_CELL_STATE_VALID;
}

/** Name of the first measure that after has worse than the promises allow, or NULL; its values
 *  *from and *to. */
static const char *find_broken(const pl_job *job, const pl_result *result,
                               const planish_quality *after, const pl_cells_validity *validity,
                               double *from, double *to) {
    const planish_quality *before = &result->before;
    /* AR is a mean over corners; of a surface in space sweeps and table have formulas of their own */
    const double slack = job->is_surface ? SURFACE_ROUNDING : job->has_types ? F_ROUNDING : 0;
    *from = (double)pl_cells_validity_faults(&result->validity_before, before);
    *to = (double)pl_cells_validity_faults(validity, after);
    if (!job->has_types) {
        *from = (double)before->n_inverted;
        *to = (double)after->n_inverted;
    }
    if (*to > *from)
        return "the number of inverted elements";
    *from = 0;
    *to = 1;
    for (int64_t i = 0; validity->is_known && !job->has_types && i < job->mesh.n_elements; i++)
        if (is_newly_invalid(&result->validity_before, validity, i))
            return "the number of elements that mid-side nodes have inverted";
    if (!was_valid(result) || job->options.method != PLANISH_METHOD_PLANISH)
        return NULL;
    *from = before->max_radius_ratio_movable;
    *to = after->max_radius_ratio_movable;
    if (*to > *from * (1 + slack))
        return "the worst ratio of elements with a movable node";
    if (pl_job_changes_objective(job))
        return NULL;
    /* Where targets may be sharp nothing is promised of scaled Jacobians. */
    if (job->has_types && pl_job_is_blunt(job)) {
        *from = result->validity_before.quality.all.min_scaled_jacobian;
        *to = validity->quality.all.min_scaled_jacobian;
        if (*to < *from - JACOBIAN_ROUNDING - slack)
            return "the least scaled Jacobian";
    } else if (!job->has_types) {
        *from = before->min_angle_deg_movable;
        *to = after->min_angle_deg_movable;
        if (pl_angle_is_smaller(*to, *from * (1 - slack)))
            return "the smallest angle of elements with a movable node";
    }
    if (result->smooth.objective_of_worst > 0) /* the RMS may rise for the worst elements */
        return NULL;
    *from = before->rms_radius_ratio;
    *to = after->rms_radius_ratio;
    return *to > *from * (1 + fmax(F_ROUNDING, slack)) ? "the RMS" : NULL;
}

int pl_promises_check(const pl_job *job, const pl_result *result) {
    const planish_result *smooth = &result->smooth;
    double from, to;
    if (job->options.method != PLANISH_METHOD_PLANISH)
        return 0;
    const char *broken =
        find_broken(job, result, &result->after, &result->validity_after, &from, &to);
    if (!broken && was_valid(result)) {
        from = smooth->objective_of_worst > 0
                   ? smooth->objective_of_worst * (1 + job->options.worst_rise)
                   : smooth->objective_before;
        to = smooth->objective;
        broken = to > from * (1 + F_ROUNDING) ? "F" : NULL;
    }
    return broken ? pl_complain(PL_EXIT_FAILED,
                                "%s: internal error: %s went from %.17g to %.17g; nothing was "
                                "written, please report this",
                                job->arguments->input, broken, from, to)
                  : 0;
}

/** Whether an element breaks a promise: it is inverted, newly invalid, or worse than the worst
 *  was. */
static int breaks(const pl_result *result, const pl_cells_validity *now, const double *ratio,
                  int64_t element) {
    return ratio[element] == 0 || is_newly_invalid(&result->validity_before, now, element) ||
           (was_valid(result) && ratio[element] > result->before.max_radius_ratio_movable);
}

/** Let the corners of elements that break promises go back, or all nodes if that changes nothing or
 *  is_last; mids follow. */
static void mark_back(const pl_job *job, const pl_result *result, const pl_cells_validity *now,
                      const double *ratio, int is_last, uint8_t *back) {
    int any = 0, n;
    for (int64_t i = 0; i < job->mesh.n_elements; i++) {
        const int32_t *corner = pl_job_corners(job, i, &n);
        if (!breaks(result, now, ratio, i))
            continue;
        for (int j = 0; j < n; j++) {
            any |= !back[corner[j]];
            back[corner[j]] = 1;
        }
    }
    if (is_last || !any)
        memset(back, 1, (size_t)job->mesh.n_nodes);
}

/** Round, and find out whether a promise is broken; if so, mark what is to go back. back [n_nodes],
 *  ratio [n_elements]: working space. */
static int settle_once(pl_job *job, pl_result *result, int is_last, uint8_t *back, double *ratio,
                       int *is_broken) {
    double *coordinates = planish_file_coordinates(job->file), from, to;
    planish_error error;
    planish_quality after;
    pl_cells_validity now = {.is_known = 0};
    int64_t n = 0;
    int code = planish_file_round_in_plane(job->file, coordinates, back, &n, &error);
    result->returned_nodes += n;
    if (!code)
        code = job->engine->measure(job, &after, &error);
    int status = code ? 0 : pl_cells_validity_find(job, &now);
    *is_broken = !code && !status && find_broken(job, result, &after, &now, &from, &to);
    if (*is_broken)
        code = job->engine->measure_elements(job, ratio, &error);
    if (code)
        status = pl_job_complain(job, PL_EXIT_FAILED, &error);
    else if (*is_broken)
        mark_back(job, result, &now, ratio, is_last, back);
    pl_cells_validity_free(&now);
    return status;
}

int pl_promises_keep(pl_job *job, pl_result *result) {
    enum { ROUNDS = 20 };
    planish_plane plane;
    if (!job->file || !planish_file_plane(job->file, &plane) || !plane.is_tilted)
        return 0;
    uint8_t *back = calloc((size_t)job->mesh.n_nodes + 1, 1);
    double *ratio = malloc(((size_t)job->mesh.n_elements + 1) * sizeof *ratio);
    int status = 0;
    if (!back || !ratio)
        status = pl_job_complain_memory(job, "the places of nodes");
    /* In the end all nodes are back. */
    for (int round = 0, is_broken = 1; !status && is_broken && round <= ROUNDS + 1; round++)
        status = settle_once(job, result, round >= ROUNDS, back, ratio, &is_broken);
    result->smooth.n_moved_nodes -= result->returned_nodes;
    if (!status && result->returned_nodes > 0 && job->arguments->verbosity != PL_QUIET)
        pl_note(stderr,
                "%" PRId64 " nodes stay where they were: in the tilted plane, rounding to the "
                "file's digits would make elements worse or inverted",
                result->returned_nodes);
    free(ratio);
    free(back);
    return status;
}
