/* table: what a mesh is worth, for people: what hurts most stands first.
 *
 * Both tables come from the same rows; before is NULL where there is but one state of the mesh.
 */
#include "report/table.h"
#include "options/combinations.h"

#include "job/surface.h"
#include "terminal/histogram.h"
#include "terminal/message.h"
#include "terminal/terminal.h"
#include "terminal/text.h"

#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

enum { UNIT_WIDTH = 4, CHANGE_WIDTH = 11, MOST_LABEL = 31 };

/** Columns of a table's parts. */
typedef struct widths {
    int label, value, spread;
    int is_narrow; /* columns that can be spared are left out */
} widths;

static widths widths_of(FILE *stream) {
    static const widths wide = {MOST_LABEL, 13, 11, 0}, narrow = {29, 10, 10, 1};
    return pl_terminal_text_width(stream) < PL_TEXT_WIDTH ? narrow : wide;
}

/* Changes below this fraction of a value are not seen in the digits of it that are shown. */
static const double INVISIBLE = 5e-6;

/* Relative changes from this on are told by the two values, not as a percentage. */
static const double MOST_TOLD = 0.5;

/** Meaning of a row's number: which way is better, and how a change of it is told. */
typedef struct measure {
    const char *unit;
    enum { LESS_IS_BETTER, MORE_IS_BETTER } sense;
    enum { RELATIVE, ABSOLUTE, COUNTED, NOT_COMPARED } change;
} measure;

static const measure fault = {"", LESS_IS_BETTER, COUNTED};

/** A row for a measure of planish_quality. */
typedef struct quality_row {
    const char *solid, *plane; /* its label in 3-D and 2-D */
    size_t at;                 /* offset of the number */
    measure measure;
    enum { EVERY, WITH_FIXED } meshes; /* those that have it: with fixed elements */
    enum { OF_ANY, OF_VALID } of;      /* valid elements may be others before than after */
} quality_row;

#define AT(field) offsetof(planish_quality, field)
static const quality_row quality_rows[] = {
    {"worst radius ratio",
     "worst radius ratio",
     AT(max_radius_ratio),
     {"", LESS_IS_BETTER, RELATIVE},
     EVERY,
     OF_VALID},
    /* Their elements stay as they are, whatever the others do. */
    {"  of fixed elements",
     "  of fixed elements",
     AT(fixed_max_radius_ratio),
     {"", LESS_IS_BETTER, RELATIVE},
     WITH_FIXED,
     OF_ANY},
    {"smallest dihedral angle",
     "smallest angle",
     AT(min_angle_deg),
     {" deg", MORE_IS_BETTER, ABSOLUTE},
     EVERY,
     OF_VALID},
    {"  of movable elements",
     "  of movable elements",
     AT(min_angle_deg_movable),
     {" deg", MORE_IS_BETTER, ABSOLUTE},
     WITH_FIXED,
     OF_VALID},
    {"largest dihedral angle",
     "largest angle",
     AT(max_angle_deg),
     {" deg", LESS_IS_BETTER, ABSOLUTE},
     EVERY,
     OF_VALID},
    {"RMS radius ratio",
     "RMS radius ratio",
     AT(rms_radius_ratio),
     {"", LESS_IS_BETTER, RELATIVE},
     EVERY,
     OF_VALID},
    {"  of movable elements",
     "  of movable elements",
     AT(rms_radius_ratio_movable),
     {"", LESS_IS_BETTER, RELATIVE},
     WITH_FIXED,
     OF_VALID},
    {"mean radius ratio",
     "mean radius ratio",
     AT(mean_radius_ratio),
     {"", LESS_IS_BETTER, RELATIVE},
     EVERY,
     OF_VALID},
    {"smallest volume",
     "smallest area",
     AT(min_volume),
     {"", MORE_IS_BETTER, RELATIVE},
     EVERY,
     OF_ANY},
};

static void put_label(FILE *stream, const char *label) {
    fprintf(stream, "%-*s", widths_of(stream).label, label);
}

static void put_real(FILE *stream, int width, double value) {
    char text[32] = "-";
    if (isfinite(value) && snprintf(text, sizeof text, "%.5g", value) >= width)
        snprintf(text, sizeof text, "%.3g", value); /* a blank stays before it */
    fprintf(stream, "%*s", width, text);
}

/** Better or worse than before, beyond rounding; PL_STYLE_PLAIN: neither. */
static pl_style style_of_change(const measure *m, double before, double after) {
    const double change = m->sense == LESS_IS_BETTER ? before - after : after - before;
    const double size = fmax(fabs(before), fabs(after));
    if (m->change == NOT_COMPARED || !isfinite(change) || fabs(change) <= INVISIBLE * size)
        return PL_STYLE_PLAIN;
    return change > 0 ? PL_STYLE_BETTER : PL_STYLE_WORSE;
}

/** The change in its column, and a word for it. */
static void put_change(FILE *stream, const measure *m, double before, double after) {
    const pl_style style = style_of_change(m, before, after);
    char change[32] = "";
    if (style == PL_STYLE_PLAIN)
        return;
    if (m->change == ABSOLUTE)
        snprintf(change, sizeof change, "%+.4g", after - before);
    else if (m->change == COUNTED)
        snprintf(change, sizeof change, "%+.0f", after - before);
    else if (before > 0 && after >= 2 * before) /* no percentages above 100 */
        snprintf(change, sizeof change, "x %.3g", after / before);
    else if (before > 0 && after > 0)
        snprintf(change, sizeof change, "%+.3g %%", 100 * (after / before - 1));
    fprintf(stream, "%*s%s", UNIT_WIDTH - pl_text_columns(m->unit), "",
            pl_style_begin(stream, style));
    if (!widths_of(stream).is_narrow)
        fprintf(stream, "%*s ", CHANGE_WIDTH, change);
    fprintf(stream, " %s%s", style == PL_STYLE_BETTER ? "better" : "worse",
            pl_style_end(stream, style));
}

static void row_real(FILE *stream, const char *label, const double *before, double after,
                     const measure *m) {
    const pl_style style = before ? style_of_change(m, *before, after) : PL_STYLE_PLAIN;
    const int width = widths_of(stream).value;
    put_label(stream, label);
    if (before)
        put_real(stream, width, *before);
    fputs(pl_style_begin(stream, style), stream);
    put_real(stream, width, after);
    fprintf(stream, "%s%s", pl_style_end(stream, style), isfinite(after) ? m->unit : "");
    if (before)
        put_change(stream, m, *before, after);
    fputc('\n', stream);
}

static void row_count(FILE *stream, const char *label, const int64_t *before, int64_t after) {
    pl_style style = after > 0 ? PL_STYLE_WORSE : PL_STYLE_PLAIN;
    const int width = widths_of(stream).value;
    put_label(stream, label);
    if (before) {
        fprintf(stream, "%*" PRId64, width, *before);
        style = style_of_change(&fault, (double)*before, (double)after);
    }
    fprintf(stream, "%s%*" PRId64 "%s", pl_style_begin(stream, style), width, after,
            pl_style_end(stream, style));
    if (before)
        put_change(stream, &fault, (double)*before, (double)after);
    fputc('\n', stream);
}

/** "1 node", "2 nodes": the number, and the word for so many. */
static const char *word_for(int64_t n, const char *one, const char *many) {
    return n == 1 ? one : many;
}

/** Put the first line: file and format, elements in words, nodes. Elements of many types have
 * further lines. */
static void row_mesh(FILE *stream, const pl_job *job, const char *elements) {
    enum { NAME_ROOM = 20 };
    char counts[512], name[4 * PL_TEXT_WIDTH + 1];
    const int room = pl_terminal_text_width(stream);
    const int width =
        snprintf(counts, sizeof counts, ": %s, %s, %" PRId64 " %s", job->file_info.format, elements,
                 job->mesh.n_nodes, word_for(job->mesh.n_nodes, "node", "nodes"));
    if (width <= room - NAME_ROOM) {
        fprintf(stream, "%s%s\n",
                pl_text_fit(job->arguments->input, room - width, name, sizeof name), counts);
        return;
    }
    fprintf(stream, "%s: %s\n", pl_text_fit(job->arguments->input, room / 2, name, sizeof name),
            job->file_info.format);
    pl_terminal_wrap(stream, counts + strlen(": ") + strlen(job->file_info.format) + strlen(", "));
}

/** Whether any element has mid-side nodes. */
static int has_mids(const planish_cells *cells) {
    for (int64_t i = 0; i < cells->n; i++)
        if (cells->offset[i + 1] - cells->offset[i] >
            pl_cell_corners((planish_cell_type)cells->type[i]))
            return 1;
    return 0;
}

/** Put the first lines of a mesh of which not all elements are straight simplices: their numbers, and
 *  what follows their corners. */
static void rows_cells(FILE *stream, const pl_job *job, const pl_validity *validity) {
    char counts[512], text[640], name[4 * PL_TEXT_WIDTH + 1];
    const int64_t n = job->mesh.n_nodes;
    pl_cells_count(job->mesh.cells, counts, sizeof counts);
    if (!has_mids(job->mesh.cells)) {
        row_mesh(stream, job, counts);
        return;
    }
    fprintf(stream, "%s: %s, %" PRId64 " %s\n",
            pl_text_fit(job->arguments->input, PL_TEXT_WIDTH / 2, name, sizeof name),
            job->file_info.format, n, word_for(n, "node", "nodes"));
    snprintf(text, sizeof text, "%s, %" PRId64 " curved; mid-side nodes follow", counts,
             validity->quality.all.n_curved);
    pl_terminal_wrap(stream, text);
}

/** Put what the targets of the elements are, if they have any. */
static void row_target(FILE *stream, const pl_job *job) {
    char name[4 * PL_TEXT_WIDTH + 1];
    if (job->like.is_layer)
        fprintf(stream,

                "AR compares layers with their former heights, other elements with regular ones\n");
    else if (job->like.sizes.metric)
        fprintf(stream, "AR measures lengths by %s\n",
                pl_text_fit(pl_sizes_source(job->arguments), PL_TEXT_WIDTH / 2, name, sizeof name));
    else if (job->like.place && !job->like.sizes.size)
        fprintf(stream, "AR compares each element with its shape in %s\n",
                pl_text_fit(job->arguments->like, PL_TEXT_WIDTH / 2, name, sizeof name));
}

/** Put the first line of a mesh whose simplices alone matter. */
static void row_simplices(FILE *stream, const pl_job *job) {
    char counts[64];
    pl_cell_type_count(pl_job_element_dim(job) == 3 ? PLANISH_CELL_TETRAHEDRON
                                                    : PLANISH_CELL_TRIANGLE,
                       job->mesh.n_elements, counts, sizeof counts);
    row_mesh(stream, job, counts);
}

/** Put how many nodes may move, or could. */
static void row_free(FILE *stream, const pl_job *job) {
    const int64_t n = job->plan_info.n_free;
    char text[256], sliding[128] = "";
    if (job->is_surface) {
        fprintf(stream, "%" PRId64 " of %" PRId64 " nodes move on the surface\n",
                job->plan_info.n_sliding, job->mesh.n_nodes);
        return;
    }
    if (job->arguments->slide || job->onto.fit)
        snprintf(sliding, sizeof sliding, ", %" PRId64 " to slide", job->plan_info.n_sliding);
    else if (job->could_slide > 0)
        snprintf(sliding, sizeof sliding, ", %" PRId64 " could slide (--slide auto)",
                 job->could_slide);
    snprintf(text, sizeof text, "%" PRId64 " of %" PRId64 " %s free to move%s", n,
             job->mesh.n_nodes, word_for(n, "nodes is", "nodes are"), sliding);
    pl_terminal_wrap(stream, text);
}

/** Whether ratios and angles are of the same elements before (NULL: no matter) and after: they are
 *  those of the valid ones. */
static int are_of_same(const planish_quality *before, const planish_quality *after) {
    return !before || before->n_inverted == after->n_inverted;
}

static const double *number_at(const planish_quality *quality, size_t at) {
    return quality ? (const double *)(const void *)((const char *)quality + at) : NULL;
}

/** Put the rows of elements that are inverted: by their corners, or by their mid-side nodes. Where
 *  validity is not known, quality tells. */
static void rows_inverted(FILE *stream, const planish_quality *before, const planish_quality *after,
                          const pl_validity *validity_before, const pl_validity *validity) {
    const measure ratio = {"", MORE_IS_BETTER, ABSOLUTE};
    const planish_cell_measures *was = &validity_before->quality.all, *is = &validity->quality.all;
    const int64_t n = before ? pl_validity_faults(validity_before, before) : 0;
    if (is->n_curved > 0)
        row_real(stream, "least Jacobian / mean, curved", before ? &was->min_jacobian_ratio : NULL,
                 is->min_jacobian_ratio, &ratio);
    row_count(stream, "inverted elements", before ? &n : NULL, pl_validity_faults(validity, after));
    if (validity->n_inside > 0 || validity_before->n_inside > 0)
        row_count(stream, "  though their corners are right",
                  before ? &validity_before->n_inside : NULL, validity->n_inside);
    if (is->n_uncertified > 0 || was->n_uncertified > 0)
        row_count(stream, "  uncertified", before ? &was->n_uncertified : NULL, is->n_uncertified);
}

/** Put the measures of simplices; validity_before, validity: with their mid-side nodes. */
static void rows_quality(FILE *stream, int dim, const planish_quality *before,
                         const planish_quality *after, const pl_validity *validity_before,
                         const pl_validity *validity) {
    for (size_t i = 0; i < sizeof quality_rows / sizeof *quality_rows; i++) {
        const quality_row *row = &quality_rows[i];
        measure m = row->measure;
        if (row->meshes == WITH_FIXED && after->n_fixed_elements == 0)
            continue;
        if (row->of == OF_VALID && !are_of_same(before, after))
            m.change = NOT_COMPARED;
        row_real(stream, dim == 3 ? row->solid : row->plane, number_at(before, row->at),
                 *number_at(after, row->at), &m);
    }
    rows_inverted(stream, before, after, validity_before, validity);
    if (after->n_reversed > 0 || (before && before->n_reversed > 0))
        row_count(stream, "reversed in the file's order", before ? &before->n_reversed : NULL,
                  after->n_reversed);
}

/** Put a line for each type, where there are several: values before and after. */
static void rows_by_type(FILE *stream, const planish_cell_quality *before,
                         const planish_cell_quality *after) {
    enum {
        TYPE = 14,
        ELEMENTS = 8,
        INVERTED = 6,
        RATIO = 9,
        RMS = 7,
        JACOBIAN = 7,
        N = 6,
        LEAST = 4
    };
    const int is_narrow = widths_of(stream).is_narrow, n_values = is_narrow ? LEAST : N;
    const int elements = is_narrow ? 0 : ELEMENTS;
    const double large = 1e4; /* what would need more room */
    if (after->n_types < 2)
        return;
    fprintf(stream, "%s%-*s%*s%*s%*s%*s%*s%s\n", pl_style_begin(stream, PL_STYLE_HEADING), TYPE,
            "before, after", elements, is_narrow ? "" : "elements", 2 * INVERTED, "inverted",
            2 * RATIO, "worst AR", 2 * RMS, "RMS AR", is_narrow ? 0 : 2 * JACOBIAN,
            is_narrow ? "" : "least SJ", pl_style_end(stream, PL_STYLE_HEADING));
    for (int i = 0; i < after->n_types; i++) {
        const planish_cell_measures *was = &before->by_type[i], *is = &after->by_type[i];
        const double value[N] = {was->max_aspect_ratio,    is->max_aspect_ratio,
                                 was->rms_aspect_ratio,    is->rms_aspect_ratio,
                                 was->min_scaled_jacobian, is->min_scaled_jacobian};
        const int width[N] = {RATIO, RATIO, RMS, RMS, JACOBIAN, JACOBIAN};
        fprintf(stream, "%-*s", TYPE, pl_cell_type_name(after->type[i]));
        if (!is_narrow)
            fprintf(stream, "%*" PRId64, elements, is->n_elements);
        fprintf(stream, "%*" PRId64 "%*" PRId64, INVERTED, was->n_inverted + was->n_uncertified,
                INVERTED, is->n_inverted + is->n_uncertified);
        for (int k = 0; k < n_values; k++)
            if (isfinite(value[k]))
                fprintf(stream, " %*.*g", width[k] - 1,
                        value[k] >= large ? 1
                        : k < 4           ? 4
                                          : 3,
                        value[k]);
            else
                fprintf(stream, "%*s", width[k], "-");
        fputc('\n', stream);
    }
}

/** Put the sizes of elements against those that are wanted; before may be NULL. */
static void rows_sizes(FILE *stream, const planish_size_quality *before,
                       const planish_size_quality *after) {
    const measure off = {"", LESS_IS_BETTER, RELATIVE}, plain = {"", LESS_IS_BETTER, NOT_COMPARED};
    char text[160];
    row_real(stream, "RMS of log(size / wanted)", before ? &before->rms_log : NULL, after->rms_log,
             &off);
    row_real(stream, "  least size / wanted", before ? &before->least : NULL, after->least, &plain);
    row_real(stream, "  largest", before ? &before->most : NULL, after->most, &plain);
    snprintf(text, sizeof text,
             "Sizes are relative: times %.4g, those given are what as many elements can have.",
             after->factor);
    pl_terminal_wrap(stream, text);
}

/** Put the measures of a mesh with elements of other types, by cells; what the plan knows of those
 *  with movable nodes is its own. */
static void rows_aspect(FILE *stream, const pl_job *job, const pl_result *result) {
    const planish_quality *before = &result->before, *after = &result->after;
    const planish_cell_measures *was = &result->validity_before.quality.all;
    const planish_cell_measures *is = &result->validity_after.quality.all;
    const int is_of_same = pl_validity_faults(&result->validity_before, before) ==
                           pl_validity_faults(&result->validity_after, after);
    const measure ratio = {"", LESS_IS_BETTER, is_of_same ? RELATIVE : NOT_COMPARED};
    /* Elements whose targets may be sharp need not be more regular. */
    const measure jacobian = {"", MORE_IS_BETTER, pl_job_is_blunt(job) ? ABSOLUTE : NOT_COMPARED};
    if (pl_like_has_sizes(&job->like))
        rows_sizes(stream, &result->validity_before.sizes, &result->validity_after.sizes);
    row_real(stream, "worst aspect ratio (AR)", &was->max_aspect_ratio, is->max_aspect_ratio,
             &ratio);
    if (after->n_fixed_elements > 0)
        row_real(stream, "  of fixed elements", &before->fixed_max_radius_ratio,
                 after->fixed_max_radius_ratio, &ratio);
    row_real(stream, "RMS aspect ratio", &was->rms_aspect_ratio, is->rms_aspect_ratio, &ratio);
    if (after->n_fixed_elements > 0 && !(job->options.size_weight > 0)) /* else it is F */
        row_real(stream, "  of movable elements", &before->rms_radius_ratio_movable,
                 after->rms_radius_ratio_movable, &ratio);
    row_real(stream, "mean aspect ratio", &was->mean_aspect_ratio, is->mean_aspect_ratio, &ratio);
    row_real(stream, "least scaled Jacobian (SJ)", &was->min_scaled_jacobian,
             is->min_scaled_jacobian, &jacobian);
    rows_inverted(stream, before, after, &result->validity_before, &result->validity_after);
    if (after->n_reversed > 0 || before->n_reversed > 0)
        row_count(stream, "reversed in the file's order", &before->n_reversed, after->n_reversed);
    rows_by_type(stream, &result->validity_before.quality, &result->validity_after.quality);
    const planish_cells *cells = job->mesh.cells;
    /* Simplices come first in a file's mesh. */
    if (cells->n == 0 || job->like.place || !pl_cell_is_simplex((planish_cell_type)cells->type[0]))
        return;
    pl_terminal_wrap(stream,
                     pl_job_element_dim(job) == 3
                         ? "AR is the mean ratio of corners, also of tetrahedra: do not "
                           "compare AR with radius ratios."
                         : "AR is the mean ratio of corners, also of triangles: do not compare "
                           "AR with radius ratios.");
}

/** Elements below their minimum volume, where there is one. */
static void row_volumes(FILE *stream, const pl_job *job, const int64_t *before, int64_t after) {
    if (pl_arguments_bound_volumes(job->arguments))
        row_count(stream, "elements below minimum volume", before, after);
}

/** Put the objective, where it is not one of the measures, and why ratios are not compared. */
static void put_objective(FILE *stream, const pl_job *job, const pl_result *result) {
    const planish_quality *before = &result->before, *after = &result->after;
    const int64_t valid_before =
        before->n_elements - pl_validity_faults(&result->validity_before, before);
    const int64_t valid_after =
        after->n_elements - pl_validity_faults(&result->validity_after, after);
    const int same = job->has_types ? valid_before == valid_after : are_of_same(before, after);
    const measure f = {"", LESS_IS_BETTER, same ? RELATIVE : NOT_COMPARED};
    const char *name = pl_objective_name(pl_job_objective(job));
    char label[MOST_LABEL + 1], text[256];
    if (job->options.area_weight > 0)
        snprintf(label, sizeof label, "F (%s, mu2 = %.4g)", name, job->options.area_weight);
    else if (job->options.size_weight > 0)
        snprintf(label, sizeof label, "F (%s, sizes %.4g)", name, job->options.size_weight);
    else
        snprintf(label, sizeof label, "F (%s)", name);
    if (pl_job_changes_objective(job))
        row_real(stream, label, &result->smooth.objective_before, result->smooth.objective, &f);
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
             smooth->n_moved_nodes, word_for(smooth->n_moved_nodes, "node", "nodes"),
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

/** Put a proved distance between the surface and the original one. */
static void put_distance(FILE *stream, const char *start, const char *middle,
                         const planish_shape_distance *d) {
    char text[256];
    if (isfinite(d->distance) && isfinite(d->distance_back))
        snprintf(text, sizeof text,
                 "%s at most %.3g (%.3g h)%s at most %.3g (%.3g h) off (certified)", start,
                 d->distance, d->in_edges, middle, d->distance_back, d->back_in_edges);
    else
        snprintf(text, sizeof text, "%s an unknown distance: no bound is proved", start);
    pl_terminal_wrap(stream, text);
}

/** Put by how much the volumes changed: of all, and of the regions that changed most. */
static void put_volume_changes(FILE *stream, const pl_job *job, const pl_surface_state *state) {
    enum { MOST_REGIONS = 5 };
    double before = 0, after = 0;
    int64_t n = 0;
    int64_t worst[MOST_REGIONS];
    char text[320], tag[200];
    for (int64_t i = 0; i < state->n_regions; i++) {
        before += state->region[i].before;
        after += state->region[i].after;
        if (state->region[i].before == 0)
            continue;
        int64_t at = n < MOST_REGIONS ? n++ : MOST_REGIONS;
        for (; at > 0; at--) { /* the largest changes first */
            const pl_region_volume *a = &state->region[i], *b = &state->region[worst[at - 1]];
            if (fabs(a->after / a->before - 1) <= fabs(b->after / b->before - 1))
                break;
            if (at < MOST_REGIONS)
                worst[at] = worst[at - 1];
        }
        if (at < MOST_REGIONS)
            worst[at] = i;
    }
    size_t used = (size_t)snprintf(text, sizeof text, "volume changed by the fraction %+.2g",
                                   after / before - 1);
    for (int64_t k = 0; n > 1 && k < n && used < sizeof text; k++) {
        const pl_region_volume *of = &state->region[worst[k]];
        planish_file_element_region(job->file, of->element, tag, sizeof tag);
        used += (size_t)snprintf(text + used, sizeof text - used, "%s %s %+.2g",
                                 k ? "," : "; regions:", tag[0] ? tag : "(no name)",
                                 of->after / of->before - 1);
    }
    pl_terminal_wrap(stream, text);
}

/** Put what nodes slide on, and how far the surface has moved. */
static void put_surface(FILE *stream, const pl_job *job, const pl_result *result) {
    const int64_t *n = job->curved.n, n_refused = result->smooth.n_off_shape;
    char text[256];
    if (!result->surface.is_known)
        return;
    if (job->is_surface)
        pl_surface_print(stream, job);
    snprintf(text, sizeof text,
             "surface: %" PRId64 " nodes in planes, %" PRId64 " on lines, %" PRId64
             " on patches, %" PRId64 " on curves; %" PRId64 " corners",
             n[PLANISH_CONSTRAINT_ON_PLANE], n[PLANISH_CONSTRAINT_ON_LINE],
             n[PLANISH_CONSTRAINT_ON_PATCH], n[PLANISH_CONSTRAINT_ON_CURVE],
             job->curved.info.n_corners);
    pl_terminal_wrap(stream, text);
    put_distance(stream, "surface moved by", ", the original one is", &result->surface.after);
    if (n_refused > 0) {
        snprintf(text, sizeof text, "%" PRId64 " %s shortened or refused for the surface",
                 n_refused, word_for(n_refused, "move was", "moves were"));
        pl_terminal_wrap(stream, text);
    }
    if (!job->is_surface)
        put_volume_changes(stream, job, &result->surface);
    if (job->plan_info.n_fixed_elements > 0)
        fprintf(stream, "%" PRId64 " %s still no movable node\n", job->plan_info.n_fixed_elements,
                word_for(job->plan_info.n_fixed_elements, "element has", "elements have"));
}

/** Put how the surface was fitted to another one. */
static void put_onto(FILE *stream, const pl_job *job) {
    const planish_fit_info *before = &job->onto.before, *after = &job->onto.after;
    const int64_t n = before->n_on_patch + before->n_on_curve + before->n_on_corner;
    char text[512];
    if (!job->onto.fit)
        return;
    snprintf(text, sizeof text,
             "fitted to %s before smoothing: of %" PRId64 " %s %" PRId64
             " lay off that surface, by at most %.3g; now %" PRId64 " %s on it, %" PRId64
             " not yet",
             job->arguments->onto, n, word_for(n, "node", "nodes"), before->n_off, before->farthest,
             n - after->n_off, word_for(n - after->n_off, "is", "are"), after->n_off);
    pl_terminal_wrap(stream, text);
    put_distance(stream, "the surface is off that one by", ", that one is", &job->onto.distance);
}

/** Put what happened to single nodes. */
static void put_notes(FILE *stream, const pl_job *job, const planish_result *smooth) {
    const int64_t n_outside = smooth->n_held_outside, n_back = smooth->n_put_back;
    if (n_outside > 0)
        pl_note(stream, "%" PRId64 " %s outside the bounds and stayed there", n_outside,
                word_for(n_outside, "node was", "nodes were"));
    if (smooth->n_released_mids > 0)
        pl_note(stream, "%" PRId64 " mid-side %s on %s own", smooth->n_released_mids,
                word_for(smooth->n_released_mids, "node has moved", "nodes have moved"),
                word_for(smooth->n_released_mids, "its", "their"));
    if (smooth->n_refused > 0 && job->mesh.cells)
        pl_note(stream, "%" PRId64 " %s refused, because elements would have been inverted",
                smooth->n_refused, word_for(smooth->n_refused, "move was", "moves were"));
    if (n_back > 0)
        pl_note(stream, "%" PRId64 " %s put back: the %s", n_back,
                word_for(n_back, "node was", "nodes were"),
                !pl_job_is_blunt(job) ? "worst aspect ratio became larger"
                : job->has_types      ? "least scaled Jacobian became smaller"
                                      : "smallest angle became smaller");
}

static void put_heading_of_both(FILE *stream) {
    const widths w = widths_of(stream);
    fprintf(stream, "%s%-*s%*s%*s%*s%s\n", pl_style_begin(stream, PL_STYLE_HEADING), w.label, "",
            w.value, "before", w.value, "after", w.is_narrow ? 0 : UNIT_WIDTH + CHANGE_WIDTH,
            w.is_narrow ? "" : "change", pl_style_end(stream, PL_STYLE_HEADING));
}

/** Put the measures before and after, side by side. */
static void put_both(FILE *stream, const pl_job *job, const pl_result *result) {
    if (result->validity_after.is_known)
        rows_cells(stream, job, &result->validity_before);
    else
        row_simplices(stream, job);
    row_target(stream, job);
    put_heading_of_both(stream);
    if (job->has_types)
        rows_aspect(stream, job, result);
    else
        rows_quality(stream, pl_job_element_dim(job), &result->before, &result->after,
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
    row_free(stream, job);
    put_surface(stream, job, result);
    put_onto(stream, job);
    put_end(stream, &result->smooth);
    pl_heights_put(stream, job, &result->heights);
    put_worst(stream, job, &result->smooth);
    snprintf(text, sizeof text,
             "%.3f s: read %.3f, set up %.3f, smooth %.3f, write %.3f; %d thread%s",
             result->total_seconds, job->read_seconds, job->setup_seconds, result->smooth_seconds,
             result->write_seconds, job->plan_info.threads, job->plan_info.threads == 1 ? "" : "s");
    pl_terminal_wrap(stream, text);
}

static void row_spread(FILE *stream, const char *label, const planish_spread *spread,
                       const char *range) {
    const widths w = widths_of(stream);
    put_label(stream, label);
    put_real(stream, w.spread, spread->min);
    put_real(stream, w.spread, spread->mean);
    put_real(stream, w.spread, spread->max);
    fprintf(stream, "%s%s\n", w.is_narrow ? "" : "  ", w.is_narrow ? "" : range);
}

/* ---- elements of every type ----------------------------------------------------------------- */

enum {
    TYPE_WIDTH = 15,
    ELEMENTS_WIDTH = 10,
    FAULTS_WIDTH = 9,
    CORNERS_WIDTH = 8,
    AR_WIDTH = 9,
    SJ_WIDTH = 11
};

static void put_heading(FILE *stream, const char *text) {
    fprintf(stream, "%s%s%s\n", pl_style_begin(stream, PL_STYLE_HEADING), text,
            pl_style_end(stream, PL_STYLE_HEADING));
}

static void put_counts(FILE *stream, const planish_cell_measures *of, int is_narrow) {
    fprintf(stream, "%*" PRId64 "%*" PRId64, ELEMENTS_WIDTH, of->n_elements, FAULTS_WIDTH,
            of->n_inverted);
    if (!is_narrow)
        fprintf(stream, "%*" PRId64, CORNERS_WIDTH, of->n_inverted_corners);
}

/** Put a line for each type; on narrow terminals, of a part of the measures. */
static void put_types(FILE *stream, const planish_cell_quality *q) {
    const int is_narrow = widths_of(stream).is_narrow;
    char heading[192], spared[64] = "", corners[32] = "";
    if (!is_narrow) {
        snprintf(corners, sizeof corners, "%*s", CORNERS_WIDTH, "corners");
        snprintf(spared, sizeof spared, "%*s%*s", AR_WIDTH, "RMS", AR_WIDTH, "mean");
    }
    snprintf(heading, sizeof heading, "%-*s%*s%*s%s%*s%s%*s", TYPE_WIDTH, "type", ELEMENTS_WIDTH,
             "elements", FAULTS_WIDTH, "inverted", corners, AR_WIDTH, "worst AR", spared, SJ_WIDTH,
             "least SJ");
    put_heading(stream, heading);
    for (int i = 0; i < q->n_types; i++) {
        const planish_cell_measures *of = &q->by_type[i];
        const double ratios[] = {of->max_aspect_ratio, of->rms_aspect_ratio, of->mean_aspect_ratio};
        fprintf(stream, "%-*s", TYPE_WIDTH, pl_cell_type_name(q->type[i]));
        put_counts(stream, of, is_narrow);
        for (size_t k = 0; k < (is_narrow ? 1 : sizeof ratios / sizeof *ratios); k++)
            if (isfinite(ratios[k]))
                fprintf(stream, " %*.4g", AR_WIDTH - 1, ratios[k]);
            else
                fprintf(stream, "%*s", AR_WIDTH, "-");
        fprintf(stream, " %*.4g\n", SJ_WIDTH - 1, of->min_scaled_jacobian);
    }
}

/** Put the measures of elements of every type. */
static void put_cells(FILE *stream, const pl_job *job, const pl_cells *cells) {
    static const measure real = {"", LESS_IS_BETTER, NOT_COMPARED};
    const planish_cell_measures *all = &cells->quality.all;
    row_real(stream, "worst aspect ratio (AR)", NULL, all->max_aspect_ratio, &real);
    row_real(stream, "RMS aspect ratio", NULL, all->rms_aspect_ratio, &real);
    row_real(stream, "mean aspect ratio", NULL, all->mean_aspect_ratio, &real);
    row_real(stream, "least scaled Jacobian (SJ)", NULL, all->min_scaled_jacobian, &real);
    if (all->n_curved > 0)
        row_real(stream, "least Jacobian / mean, curved", NULL, all->min_jacobian_ratio, &real);
    row_real(stream, "largest edge ratio", NULL, all->max_edge_ratio, &real);
    row_count(stream, "inverted elements", NULL, all->n_inverted);
    row_count(stream, "inverted corners", NULL, all->n_inverted_corners);
    row_count(stream, "uncertified elements", NULL, all->n_uncertified);
    if (all->n_curved > 0) { /* no fault */
        put_label(stream, "curved elements");
        fprintf(stream, "%*" PRId64 "\n", widths_of(stream).value, all->n_curved);
    }
    if (all->worst_element >= 0)
        fprintf(stream, "the worst valid element is %" PRId64 " (%s)\n",
                planish_file_element_number(job->file, all->worst_element),
                pl_cell_type_name((planish_cell_type)cells->cells.type[all->worst_element]));
    put_types(stream, &cells->quality);
}

/* ---- one mesh ------------------------------------------------------------------------------- */

/** Put all measures of simplices (docs/measures.md); the range begins with the value of the regular
 *  element, but for R / longest edge, where that is 1. */
static void put_spreads(FILE *stream, int solid, const planish_quality *q) {
    const widths w = widths_of(stream);
    fprintf(stream, "%s%-*s%*s%*s%*s%s%s\n", pl_style_begin(stream, PL_STYLE_HEADING), w.label,
            "over the elements", w.spread, "smallest", w.spread, "mean", w.spread, "largest",
            w.is_narrow ? "" : "  best .. worst", pl_style_end(stream, PL_STYLE_HEADING));
    row_spread(stream, solid ? "radius ratio R/(3r)" : "radius ratio R/(2r)", &q->radius_ratio,
               "1 .. inf");
    row_spread(stream, "R / longest edge (regular: 1)", &q->circumradius_to_edge,
               solid ? "0.8165 .. inf" : "0.8660 .. inf");
    row_spread(stream, "longest edge / r", &q->edge_to_inradius, "1 .. inf");
    row_spread(stream, "longest edge / shortest", &q->edge_ratio, "1 .. inf");
    row_spread(stream, "mean ratio", &q->mean_ratio, "1 .. 0");
    row_spread(stream, "scaled Jacobian", &q->scaled_jacobian, "1 .. 0");
    row_spread(stream, solid ? "smallest dihedral angle, deg" : "smallest angle, deg",
               &q->smallest_angle_deg, solid ? "70.53 .. 0" : "60 .. 0");
    row_spread(stream, solid ? "largest dihedral angle, deg" : "largest angle, deg",
               &q->largest_angle_deg, solid ? "70.53 .. 180" : "60 .. 180");
}

void pl_table_quality(FILE *stream, const pl_job *job, const pl_measured *measured) {
    const planish_quality *q = &measured->quality;
    const pl_cells *cells = &measured->cells;
    const pl_validity none = {.is_known = 0}; /* simplices are measured by their corners */
    const int solid = pl_job_element_dim(job) == 3;
    if (cells->has_others) {
        char counts[256];
        pl_cells_count(&cells->cells, counts, sizeof counts);
        row_mesh(stream, job, counts);
        row_target(stream, job);
        put_cells(stream, job, cells);
        if (pl_like_has_sizes(&job->like))
            rows_sizes(stream, NULL, &cells->sizes);
        pl_heights_put(stream, job, &measured->heights);
        if (job->is_surface)
            pl_surface_print(stream, job);
        if (job->mesh.n_elements == 0)
            return;
        put_heading(stream, job->mesh.cells ? solid ? "tetrahedra alone, by their corners"
                                                    : "triangles alone, by their corners"
                            : solid         ? "straight tetrahedra alone"
                                            : "straight triangles alone");
    } else {
        row_simplices(stream, job);
    }
    rows_quality(stream, pl_job_element_dim(job), NULL, q, &none, &none);
    row_volumes(stream, job, NULL, measured->volumes.n_below);
    if (q->worst_element >= 0)
        fprintf(stream, "the worst element is %" PRId64 "\n",
                planish_file_element_number(job->file, q->worst_element));
    if (!pl_job_lacks_types(job)) /* it would tell of the simplices alone */
        row_free(stream, job);
    if (job->is_surface && !cells->has_others)
        pl_surface_print(stream, job);
    if (measured->surface.is_known)
        put_distance(stream, "the surface is off the original one by", ", the original one is",
                     &measured->surface.after);
    put_spreads(stream, solid, q);
    pl_histogram_print(stream, "radius ratio", NULL, q);
}

/** Arrays that were taken for regions by their values: the user is told which. */
static void note_regions(FILE *stream, const pl_job *job) {
    const char *const *name = pl_job_region_arrays(job);
    char list[256] = "";
    size_t used = 0;
    int n = 0, is_expected = 1;
    for (; name[n]; n++) {
        is_expected &= planish_region_name(name[n]) > 0;
        if (used < sizeof list)
            used +=
                (size_t)snprintf(list + used, sizeof list - used, "%s'%s'", n ? ", " : "", name[n]);
    }
    if (n == 0 || (n == 1 && is_expected) || job->arguments->n_regions > 0)
        return;
    pl_note(stream,
            "planish takes the values of %s %s for regions and holds the nodes between them; "
            "choose an array by --regions NAME, or let these nodes move by --regions none",
            n == 1 ? "array" : "arrays", list);
}

void pl_table_oddities(FILE *stream, const pl_job *job) {
    const planish_plan_info *info = &job->plan_info;
    const int64_t facets = info->n_nonmanifold_facets, copies = info->n_duplicate_elements;
    const int64_t others = job->file_info.n_other_elements;
    if (facets > 0)
        pl_note(stream, "%" PRId64 " %s to more than two elements; %s nodes are held", facets,
                pl_job_element_dim(job) == 3 ? word_for(facets, "face belongs", "faces belong")
                                             : word_for(facets, "edge belongs", "edges belong"),
                word_for(facets, "its", "their"));
    if (copies > 0)
        pl_note(stream, "%" PRId64 " %s the nodes of another element; %s held", copies,
                word_for(copies, "element has", "elements have"),
                word_for(copies, "it is", "they are"));
    if (info->n_wrapped > 0)
        pl_note(stream,
                "%" PRId64 " %s around a periodic domain, from one side to the other; %s "
                "nodes are held",
                info->n_wrapped, word_for(info->n_wrapped, "element wraps", "elements wrap"),
                word_for(info->n_wrapped, "its", "their"));
    if (others > 0)
        pl_note(stream, "%" PRId64 " %s; %s nodes are held", others,
                word_for(others, "element of a type that planish does not smooth is copied",
                         "elements of types that planish does not smooth are copied"),
                word_for(others, "its", "their"));
    if (job->is_surface)
        pl_surface_note(stream, job);
    else
        note_regions(stream, job);
    if (job->file_info.is_unterminated) {
        /* Of several inputs the notes of each are named. */
        const char *open = planish_file_unterminated_path(job->file);
        const int is_named =
            job->arguments->n_inputs == 1 || strcmp(open, job->arguments->input) != 0;
        pl_note(stream,
                "the last line%s%s has no line end; if the file was cut there, the last number may "
                "be wrong",
                is_named ? " of " : "", is_named ? open : "");
    }
}

void pl_table_reversed(FILE *stream, const planish_quality *quality) {
    const int64_t n = quality->n_reversed;
    if (n > 0 && n > quality->n_inverted)
        pl_note(stream,
                "%" PRId64 " %s their nodes in the opposite order to most; planish does not "
                "renumber elements, and a solver may take these for inverted",
                n, word_for(n, "element lists", "elements list"));
}

/* ---- the worst elements --------------------------------------------------------------------- */

enum { NUMBER_WIDTH = 10, RATIO_WIDTH = 14, ANGLE_WIDTH = 10, PLACE_WIDTH = 12 };

static void put_angle(FILE *stream, double degrees) {
    if (isfinite(degrees))
        fprintf(stream, "%*.4g", ANGLE_WIDTH, degrees);
    else
        fprintf(stream, "%*s", ANGLE_WIDTH, "-");
}

/** Put text behind width columns, on a new line if there is no room. Returns the columns then. */
static int put_further(FILE *stream, const char *text, int width) {
    enum { INDENT = NUMBER_WIDTH + 7 };
    if (width + pl_text_columns(text) > pl_terminal_text_width(stream))
        width = fprintf(stream, "\n%*s", INDENT, "") - 1;
    fputs(text, stream);
    return width + pl_text_columns(text);
}

/** Put two lines or, of elements of many nodes, more: the measures and the place of an element; its nodes, its region and whether it
 * can change. */
static void put_bad_element(FILE *stream, const pl_bad_element *bad, const pl_worst *worst) {
    char region[4 * PL_TEXT_WIDTH + 1];
    fprintf(stream, "%*" PRId64, NUMBER_WIDTH, bad->number);
    if (worst->is_aspect_ratio)
        fprintf(stream, "  %-*s", TYPE_WIDTH, pl_cell_type_name(bad->type));
    if (bad->ratio > 0)
        fprintf(stream, "%*.5g", RATIO_WIDTH, bad->ratio);
    else
        fprintf(stream, "%s%*s%s", pl_style_begin(stream, PL_STYLE_WORSE), RATIO_WIDTH, "inverted",
                pl_style_end(stream, PL_STYLE_WORSE));
    if (!worst->is_aspect_ratio) {
        put_angle(stream, bad->smallest_angle_deg);
        put_angle(stream, bad->largest_angle_deg);
    }
    for (int d = 0; d < (widths_of(stream).is_narrow ? 0 : worst->columns); d++)
        fprintf(stream, "%*.5g", PLACE_WIDTH, bad->place[d]);
    int width = fprintf(stream, "\n%*s  nodes", NUMBER_WIDTH, "") - 1;
    for (int k = 0; k < bad->n_nodes; k++) {
        char number[32];
        snprintf(number, sizeof number, " %" PRId64, bad->node[k]);
        width = put_further(stream, number, width);
    }
    if (!bad->is_movable)
        width = put_further(stream, ", all fixed", width);
    if (bad->region) {
        const char *word = ", in ";
        const int room = pl_terminal_text_width(stream) - width - (int)strlen(word);
        fprintf(stream, "%s%s", word,
                pl_text_fit(bad->region, room > 4 ? room : 4, region, sizeof region));
    }
    fputc('\n', stream);
}

void pl_table_worst(FILE *stream, const pl_worst *worst, int64_t n) {
    if (n > worst->n)
        n = worst->n;
    if (n == 0)
        return;
    fprintf(stream, "%s%*s", pl_style_begin(stream, PL_STYLE_HEADING), NUMBER_WIDTH, "element");
    if (worst->is_aspect_ratio)
        fprintf(stream, "  %-*s%*s", TYPE_WIDTH, "type", RATIO_WIDTH, "aspect ratio");
    else
        fprintf(stream, "%*s%*s", RATIO_WIDTH, "radius ratio", 2 * ANGLE_WIDTH,
                worst->dim == 3 ? "dihedral angles" : "angles");
    for (int d = 0; d < (widths_of(stream).is_narrow ? 0 : worst->columns); d++)
        fprintf(stream, "%*c", PLACE_WIDTH, "xyz"[d]);
    fprintf(stream, "%s\n", pl_style_end(stream, PL_STYLE_HEADING));
    for (int64_t i = 0; i < n; i++)
        put_bad_element(stream, &worst->bad[i], worst);
}
