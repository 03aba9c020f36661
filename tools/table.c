/* table: what a mesh is worth, for people: what hurts most stands first.
 *
 * Both tables come from the same rows; before is NULL where there is but one state of the mesh.
 */
#include "table.h"

#include <inttypes.h>
#include <math.h>

enum { LABEL_WIDTH = 31, VALUE_WIDTH = 13, HISTOGRAM_WIDTH = 40 };

static void put_label(FILE *stream, const char *label) {
    fprintf(stream, "%-*s", LABEL_WIDTH, label);
}

static void put_real(FILE *stream, double value) {
    if (isfinite(value))
        fprintf(stream, "%*.5g", VALUE_WIDTH, value);
    else
        fprintf(stream, "%*s", VALUE_WIDTH, "-");
}

static void row_real(FILE *stream, const char *label, const double *before, double after,
                     const char *unit) {
    put_label(stream, label);
    if (before)
        put_real(stream, *before);
    put_real(stream, after);
    fprintf(stream, "%s\n", unit);
}

static void row_count(FILE *stream, const char *label, const int64_t *before, int64_t after) {
    put_label(stream, label);
    if (before)
        fprintf(stream, "%*" PRId64, VALUE_WIDTH, *before);
    fprintf(stream, "%*" PRId64 "\n", VALUE_WIDTH, after);
}

static void row_mesh(FILE *stream, const pl_job *job) {
    fprintf(stream, "%s: %s, %" PRId64 " %s, %" PRId64 " nodes, %" PRId64 " of them free to move",
            job->arguments->input, job->file_info.format, job->mesh.n_elements,
            job->mesh.dim == 3 ? "tetrahedra" : "triangles", job->mesh.n_nodes,
            job->plan_info.n_free);
    if (job->arguments->slide)
        fprintf(stream, ", %" PRId64 " to slide", job->plan_info.n_sliding);
    else if (job->could_slide > 0)
        fprintf(stream, ", %" PRId64 " could slide (--slide auto)", job->could_slide);
    fputc('\n', stream);
}

/** The floor: elements whose nodes are all fixed stay as they are, whatever the others do. */
static void row_floor(FILE *stream, const planish_quality *before, const planish_quality *after) {
    const double floor = after->fixed_max_radius_ratio;
    if (after->n_fixed == 0)
        return;
    row_real(stream, "  floor (no node free)", before ? &before->fixed_max_radius_ratio : NULL,
             floor, "");
}

static void rows_quality(FILE *stream, int dim, const planish_quality *before,
                         const planish_quality *after) {
    row_real(stream, "worst radius ratio", before ? &before->max_radius_ratio : NULL,
             after->max_radius_ratio, "");
    row_floor(stream, before, after);
    row_real(stream, dim == 3 ? "smallest dihedral angle" : "smallest angle",
             before ? &before->min_angle_deg : NULL, after->min_angle_deg, " deg");
    if (after->n_fixed > 0)
        row_real(stream, "  of elements with free nodes",
                 before ? &before->min_angle_deg_movable : NULL, after->min_angle_deg_movable,
                 " deg");
    row_real(stream, dim == 3 ? "largest dihedral angle" : "largest angle",
             before ? &before->max_angle_deg : NULL, after->max_angle_deg, " deg");
    row_real(stream, "RMS radius ratio", before ? &before->rms_radius_ratio : NULL,
             after->rms_radius_ratio, "");
    row_real(stream, "  of elements with free nodes",
             before ? &before->rms_radius_ratio_movable : NULL, after->rms_radius_ratio_movable,
             "");
    row_real(stream, "mean radius ratio", before ? &before->mean_radius_ratio : NULL,
             after->mean_radius_ratio, "");
    row_real(stream, dim == 3 ? "smallest volume" : "smallest area",
             before ? &before->min_volume : NULL, after->min_volume, "");
    row_count(stream, "inverted elements", before ? &before->inverted : NULL, after->inverted);
}

/** Elements below their least volume, where there is one. */
static void row_volumes(FILE *stream, const pl_job *job, const int64_t *before, int64_t after) {
    if (pl_arguments_bound_volumes(job->arguments))
        row_count(stream, "elements below minimum volume", before, after);
}

/** What was minimised, where it is not one of the measures. */
static void row_objective(FILE *stream, const pl_job *job, const planish_result *smooth) {
    char label[LABEL_WIDTH + 1];
    const char *name = pl_objective_name(job->options.objective);
    if (!pl_arguments_change_objective(job->arguments))
        return;
    if (job->options.area_weight > 0)
        snprintf(label, sizeof label, "F (%s, mu2 = %.4g)", name, job->options.area_weight);
    else
        snprintf(label, sizeof label, "F (%s)", name);
    row_real(stream, label, &smooth->objective_before, smooth->objective, "");
}

static void put_held_outside(FILE *stream, int64_t n) {
    if (n > 0)
        fprintf(stream, "note: %" PRId64 " node%s outside of the bounds and stayed there\n", n,
                n == 1 ? " was" : "s were");
}

static void put_end(FILE *stream, const planish_result *smooth) {
    switch (smooth->stop) {
    case PLANISH_STOP_CONVERGED:
        fprintf(stream, "converged");
        break;
    case PLANISH_STOP_MAX_SWEEPS:
        fprintf(stream, "stopped at the most sweeps allowed");
        break;
    case PLANISH_STOP_TIME_LIMIT:
        fprintf(stream, "stopped by the time limit");
        break;
    case PLANISH_STOP_INTERRUPTED:
        fprintf(stream, "interrupted");
        break;
    case PLANISH_STOP_INFEASIBLE:
        fprintf(stream, "converged, but for volumes that cannot be reached,");
        break;
    }
    const int sweeps = smooth->sweeps - smooth->worst_sweeps;
    fprintf(stream, " after %d sweep%s", sweeps, sweeps == 1 ? "" : "s");
    if (smooth->untangling_sweeps > 0)
        fprintf(stream, " (%d of them untangling)", smooth->untangling_sweeps);
    fprintf(stream, ", %" PRId64 " nodes moved by up to %.3g\n", smooth->moved_nodes,
            smooth->max_displacement);
}

/** What the sweeps for the worst elements brought, and what they cost. */
static void put_worst(FILE *stream, const pl_job *job, const planish_result *smooth) {
    const int of_angle = job->options.worst == PLANISH_WORST_ANGLE;
    if (smooth->worst_sweeps == 0)
        return;
    const double rise = smooth->objective / smooth->objective_of_worst - 1;
    fprintf(stream,
            "and %d for the worst element with a free node: %s %.4g -> %.4g%s, while %s %s by %.2g "
            "%%\n",
            smooth->worst_sweeps, of_angle ? "smallest angle" : "radius ratio",
            smooth->worst_before, smooth->worst_after, of_angle ? " deg" : "",
            job->options.area_weight > 0 ? "F" : "the RMS", rise < 0 ? "fell" : "rose",
            fabs(100 * rise));
}

static void put_back_note(FILE *stream, int64_t n) {
    if (n > 0)
        fprintf(stream,
                "note: %" PRId64
                " node%s put back: the smallest angle of the mesh was getting smaller\n",
                n, n == 1 ? " was" : "s were");
}

void pl_table_smooth(FILE *stream, const pl_job *job, const pl_result *result) {
    row_mesh(stream, job);
    fprintf(stream, "%-*s%*s%*s\n", LABEL_WIDTH, "", VALUE_WIDTH, "before", VALUE_WIDTH, "after");
    rows_quality(stream, job->mesh.dim, &result->before, &result->after);
    row_volumes(stream, job, &result->below_before, result->volumes.n_below);
    row_objective(stream, job, &result->smooth);
    put_held_outside(stream, result->smooth.held_outside);
    put_back_note(stream, result->smooth.put_back);
    put_end(stream, &result->smooth);
    put_worst(stream, job, &result->smooth);
    fprintf(stream, "%.3f s: read %.3f, set up %.3f, smooth %.3f, write %.3f; %d thread%s\n",
            result->total_seconds, job->read_seconds, job->setup_seconds, result->smooth_seconds,
            result->write_seconds, job->plan_info.threads, job->plan_info.threads == 1 ? "" : "s");
}

static void put_histogram(FILE *stream, const planish_quality *quality) {
    int64_t most = 1;
    for (int i = 0; i < PLANISH_HISTOGRAM_BINS; i++)
        if (quality->histogram_counts[i] > most)
            most = quality->histogram_counts[i];
    fprintf(stream, "elements by radius ratio:\n");
    for (int i = 0; i < PLANISH_HISTOGRAM_BINS; i++) {
        const int64_t count = quality->histogram_counts[i];
        const double share = (double)count / (double)most;
        const int bar = (int)ceil(share * HISTOGRAM_WIDTH);
        fprintf(stream, "  from %7.5g %*" PRId64 " ", quality->histogram_edges[i], VALUE_WIDTH,
                count);
        for (int j = 0; j < bar; j++)
            fputc('#', stream);
        fputc('\n', stream);
    }
}

static void row_spread(FILE *stream, const char *label, const planish_spread *spread,
                       const char *range) {
    put_label(stream, label);
    put_real(stream, spread->min);
    put_real(stream, spread->mean);
    put_real(stream, spread->max);
    fprintf(stream, "  %s\n", range);
}

/** All measures of the elements (docs/measures.md); the range begins with the value of the regular
 *  element, but for R / longest edge, where that is 1. */
static void rows_measures(FILE *stream, int dim, const planish_quality *q) {
    const int solid = dim == 3;
    fprintf(stream, "%-*s%*s%*s%*s  %s\n", LABEL_WIDTH, "over the elements", VALUE_WIDTH,
            "smallest", VALUE_WIDTH, "mean", VALUE_WIDTH, "largest", "best .. worst");
    row_spread(stream, solid ? "radius ratio R/(3r)" : "radius ratio R/(2r)", &q->radius_ratio,
               "1 .. inf");
    row_spread(stream, "R / longest edge", &q->circumradius_to_edge,
               solid ? "0.8165 (regular: 1) .. inf" : "0.8660 (regular: 1) .. inf");
    row_spread(stream, "longest edge / r", &q->edge_to_inradius, "1 .. inf");
    row_spread(stream, "longest edge / shortest", &q->edge_ratio, "1 .. inf");
    row_spread(stream, "mean ratio", &q->mean_ratio, "1 .. 0");
    row_spread(stream, "scaled Jacobian", &q->scaled_jacobian, "1 .. 0");
    row_spread(stream, solid ? "smallest dihedral angle, deg" : "smallest angle, deg",
               &q->smallest_angle_deg, solid ? "70.53 .. 0" : "60 .. 0");
    row_spread(stream, solid ? "largest dihedral angle, deg" : "largest angle, deg",
               &q->largest_angle_deg, solid ? "70.53 .. 180" : "60 .. 180");
}

void pl_table_quality(FILE *stream, const pl_job *job, const planish_quality *quality,
                      const pl_volumes *volumes) {
    row_mesh(stream, job);
    rows_quality(stream, job->mesh.dim, NULL, quality);
    row_volumes(stream, job, NULL, volumes->n_below);
    if (quality->worst_element >= 0)
        fprintf(stream, "the worst is element %" PRId64 "\n",
                planish_file_element_number(job->file, quality->worst_element));
    rows_measures(stream, job->mesh.dim, quality);
    put_histogram(stream, quality);
}

void pl_table_oddities(FILE *stream, const pl_job *job) {
    const planish_plan_info *info = &job->plan_info;
    if (info->n_nonmanifold_facets > 0)
        fprintf(stream,
                "note: %" PRId64 " %s belong to more than two elements; their nodes are held\n",
                info->n_nonmanifold_facets, job->mesh.dim == 3 ? "faces" : "edges");
    if (info->n_duplicate_elements > 0)
        fprintf(stream, "note: %" PRId64 " elements have the nodes of another one; they are held\n",
                info->n_duplicate_elements);
    if (job->file_info.n_other_elements > 0)
        fprintf(stream,
                "note: %" PRId64 " elements of other types pass through; their nodes are held\n",
                job->file_info.n_other_elements);
    if (job->file_info.ends_open)
        fprintf(stream,
                "note: the last line of %s has no end: if the file was cut short there, its last "
                "number may be wrong\n",
                job->arguments->input);
}
