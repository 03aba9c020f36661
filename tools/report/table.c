/* table: what a mesh is worth, for people: what hurts most stands first. */
#include "report/table.h"
#include "options/combinations.h"

#include "job/surface.h"
#include "report/table_cells.h"
#include "report/table_mesh.h"
#include "report/table_rows.h"
#include "report/table_simplices.h"
#include "report/table_surface.h"
#include "terminal/histogram.h"
#include "terminal/message.h"
#include "terminal/terminal.h"

#include <inttypes.h>
#include <math.h>

/* Relative changes from this on are told by the two values, not as a percentage. */
static const double MOST_TOLD = 0.5;

/** Elements below their minimum volume, where there is one. */
static void row_volumes(FILE *stream, const pl_job *job, const int64_t *before, int64_t after) {
    if (pl_arguments_bound_volumes(job->arguments))
        pl_table_row_count(stream, "elements below minimum volume", before, after);
}

/** Put the objective, where it is not one of the measures, and why ratios are not compared. */
static void put_objective(FILE *stream, const pl_job *job, const pl_result *result) {
    const planish_quality *before = &result->before, *after = &result->after;
    const int64_t valid_before =
        before->n_elements - pl_cells_validity_faults(&result->validity_before, before);
    const int64_t valid_after =
        after->n_elements - pl_cells_validity_faults(&result->validity_after, after);
    const int same =
        job->has_types ? valid_before == valid_after : pl_table_are_of_same(before, after);
    const pl_table_measure f = {"", PL_LESS_IS_BETTER, same ? PL_CHANGE_RELATIVE : PL_NOT_COMPARED};
    const char *name = pl_objective_name(pl_job_objective(job));
    char label[PL_MOST_LABEL + 1], text[256];
    if (job->options.area_weight > 0)
        snprintf(label, sizeof label, "F (%s, mu2 = %.4g)", name, job->options.area_weight);
    else if (job->options.size_weight > 0)
        snprintf(label, sizeof label, "F (%s, sizes %.4g)", name, job->options.size_weight);
    else
        snprintf(label, sizeof label, "F (%s)", name);
    if (pl_job_changes_objective(job))
        pl_table_row_real(stream, label, &result->smooth.objective_before, result->smooth.objective,
                          &f);
    if (same)
        return;
    snprintf(text, sizeof text,
             "Ratios%s are those of the valid elements, %" PRId64 " before and %" PRId64
             " after, so they are not compared.",
             job->has_types ? "" : " and angles",
             job->has_types ? valid_before : before->n_elements - before->n_inverted,
             job->has_types ? valid_after : after->n_elements - after->n_inverted);
    pl_terminal_wrap(stream, text);
}

static const char *const stop_texts[] = {
    [PLANISH_STOP_CONVERGED] = "converged",
    [PLANISH_STOP_MAX_SWEEPS] = "stopped at the maximum number of sweeps",
    [PLANISH_STOP_TIME_LIMIT] = "stopped by the time limit",
    [PLANISH_STOP_INTERRUPTED] = "interrupted",
    [PLANISH_STOP_INFEASIBLE] = "converged, except for volumes that cannot be reached,"};

/** Put how the sweeps ended. */
static void put_end(FILE *stream, const planish_result *smooth) {
    char text[256], untangling[64] = "";
    const int sweeps = smooth->sweeps - smooth->worst_sweeps;
    if (smooth->untangling_sweeps > 0)
        snprintf(untangling, sizeof untangling, " (%d of them untangling)",
                 smooth->untangling_sweeps);
    snprintf(text, sizeof text, "%s after %d sweep%s%s, %" PRId64 " %s moved by up to %.3g",
             stop_texts[smooth->stop], sweeps, sweeps == 1 ? "" : "s", untangling,
             smooth->n_moved_nodes, pl_table_word_for(smooth->n_moved_nodes, "node", "nodes"),
             smooth->max_displacement);
    pl_terminal_wrap(stream, text);
}

/** Put the gain of the worst elements, and its cost. */
static void put_worst(FILE *stream, const pl_job *job, const planish_result *smooth) {
    char text[256];
    static const char *const names[] = {[PLANISH_WORST_RADIUS_RATIO] = "radius ratio",
                                        [PLANISH_WORST_ANGLE] = "smallest angle",
                                        [PLANISH_WORST_ASPECT_RATIO] = "aspect ratio",
                                        [PLANISH_WORST_SCALED_JACOBIAN] = "scaled Jacobian"};
    const int of_angle = job->options.worst == PLANISH_WORST_ANGLE;
    if (smooth->worst_sweeps == 0)
        return;
    const double rise = smooth->objective / smooth->objective_of_worst - 1;
    const char *name = job->options.area_weight > 0 ? "F" : "the RMS";
    const int n = snprintf(text, sizeof text,
                           "and %d for the worst element with a movable node: %s %.4g -> %.4g%s, ",
                           smooth->worst_sweeps, names[job->options.worst], smooth->worst_before,
                           smooth->worst_after, of_angle ? " deg" : "");
    if (fabs(rise) < MOST_TOLD)
        snprintf(text + n, sizeof text - (size_t)n, "while %s %s by %.2g %%", name,
                 rise < 0 ? "fell" : "rose", fabs(100 * rise));
    else
        snprintf(text + n, sizeof text - (size_t)n, "while %s went from %.4g to %.4g", name,
                 smooth->objective_of_worst, smooth->objective);
    pl_terminal_wrap(stream, text);
}

/** Put what happened to single nodes. */
static void put_notes(FILE *stream, const pl_job *job, const planish_result *smooth) {
    const int64_t n_outside = smooth->n_held_outside, n_back = smooth->n_put_back;
    if (n_outside > 0)
        pl_note(stream, "%" PRId64 " %s outside the bounds and stayed there", n_outside,
                pl_table_word_for(n_outside, "node was", "nodes were"));
    if (smooth->n_released_mids > 0)
        pl_note(stream, "%" PRId64 " mid-side %s on %s own", smooth->n_released_mids,
                pl_table_word_for(smooth->n_released_mids, "node has moved", "nodes have moved"),
                pl_table_word_for(smooth->n_released_mids, "its", "their"));
    if (smooth->n_refused > 0 && job->mesh.cells)
        pl_note(stream, "%" PRId64 " %s refused, because elements would have been inverted",
                smooth->n_refused, pl_table_word_for(smooth->n_refused, "move was", "moves were"));
    if (n_back > 0)
        pl_note(stream, "%" PRId64 " %s put back: the %s", n_back,
                pl_table_word_for(n_back, "node was", "nodes were"),
                !pl_job_is_blunt(job) ? "worst aspect ratio became larger"
                : job->has_types      ? "least scaled Jacobian became smaller"
                                      : "smallest angle became smaller");
}

static void put_heading_of_both(FILE *stream) {
    const pl_table_widths w = pl_table_widths_of(stream);
    fprintf(stream, "%s%-*s%*s%*s%*s%s\n", pl_style_begin(stream, PL_STYLE_HEADING), w.label, "",
            w.value, "before", w.value, "after", w.is_narrow ? 0 : PL_UNIT_WIDTH + PL_CHANGE_WIDTH,
            w.is_narrow ? "" : "change", pl_style_end(stream, PL_STYLE_HEADING));
}

/** Put the measures before and after, side by side. */
static void put_both(FILE *stream, const pl_job *job, const pl_result *result) {
    if (result->validity_after.is_known)
        pl_table_rows_cells(stream, job, &result->validity_before);
    else
        pl_table_row_simplices(stream, job);
    pl_table_row_target(stream, job);
    put_heading_of_both(stream);
    if (job->has_types)
        pl_table_rows_aspect(stream, job, result);
    else
        pl_table_rows_quality(stream, pl_job_element_dim(job), &result->before, &result->after,
                              &result->validity_before, &result->validity_after);
    row_volumes(stream, job, &result->below_before, result->volumes.n_below);
    put_objective(stream, job, result);
    pl_histogram_print(stream,
                       job->options.size_weight > 0 ? "AR with sizes"
                       : job->has_types             ? "aspect ratio"
                                                    : "radius ratio",
                       &result->before, &result->after);
}

void pl_table_compare(FILE *stream, const pl_job *job, const pl_result *result) {
    const int64_t n = result->smooth.n_moved_nodes;
    char text[128];
    put_both(stream, job, result);
    snprintf(text, sizeof text, "%" PRId64 " of %" PRId64 " nodes %s, by up to %.3g", n,
             job->mesh.n_nodes, n == 1 ? "differs" : "differ", result->smooth.max_displacement);
    pl_terminal_wrap(stream, text);
    pl_heights_put(stream, job, &result->heights);
}

void pl_table_smooth(FILE *stream, const pl_job *job, const pl_result *result) {
    char text[256];
    put_both(stream, job, result);
    put_notes(stream, job, &result->smooth);
    pl_table_row_free(stream, job);
    pl_table_put_surface(stream, job, result);
    pl_table_put_onto(stream, job);
    put_end(stream, &result->smooth);
    pl_heights_put(stream, job, &result->heights);
    put_worst(stream, job, &result->smooth);
    snprintf(text, sizeof text,
             "%.3f s: read %.3f, set up %.3f, smooth %.3f, write %.3f; %d thread%s",
             result->total_seconds, job->read_seconds, job->setup_seconds, result->smooth_seconds,
             result->write_seconds, job->plan_info.threads, job->plan_info.threads == 1 ? "" : "s");
    pl_terminal_wrap(stream, text);
}

void pl_table_quality(FILE *stream, const pl_job *job, const pl_measured *measured) {
    const planish_quality *q = &measured->quality;
    const pl_cells *cells = &measured->cells;
    const pl_cells_validity none = {.is_known = 0}; /* simplices are measured by their corners */
    const int solid = pl_job_element_dim(job) == 3;
    if (cells->has_others) {
        char counts[256];
        pl_cells_count(&cells->cells, counts, sizeof counts);
        pl_table_row_mesh(stream, job, counts);
        pl_table_row_target(stream, job);
        pl_table_put_cells(stream, job, cells);
        if (pl_like_has_sizes(&job->like))
            pl_table_rows_sizes(stream, NULL, &cells->sizes);
        pl_heights_put(stream, job, &measured->heights);
        if (job->is_surface)
            pl_surface_print(stream, job);
        if (job->mesh.n_elements == 0)
            return;
        pl_table_put_heading(stream, job->mesh.cells ? solid ? "tetrahedra alone, by their corners"
                                                             : "triangles alone, by their corners"
                                     : solid         ? "straight tetrahedra alone"
                                                     : "straight triangles alone");
    } else {
        pl_table_row_simplices(stream, job);
    }
    pl_table_rows_quality(stream, pl_job_element_dim(job), NULL, q, &none, &none);
    row_volumes(stream, job, NULL, measured->volumes.n_below);
    if (q->worst_element >= 0)
        fprintf(stream, "the worst element is %" PRId64 "\n",
                planish_file_element_number(job->file, q->worst_element));
    if (!pl_job_lacks_types(job)) /* it would tell of the simplices alone */
        pl_table_row_free(stream, job);
    if (job->is_surface && !cells->has_others)
        pl_surface_print(stream, job);
    if (measured->surface.is_known)
        pl_table_put_distance(stream, "the surface is off the original one by",
                              ", the original one is", &measured->surface.after);
    pl_table_put_spreads(stream, solid, q);
    pl_histogram_print(stream, "radius ratio", NULL, q);
}
