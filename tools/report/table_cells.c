/* table_cells: measures of elements of every type, and their sizes. */
#include "report/table_cells.h"

#include "report/table_rows.h"
#include "report/table_simplices.h"
#include "terminal/terminal.h"

#include <inttypes.h>
#include <math.h>

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
    const int is_narrow = pl_table_widths_of(stream).is_narrow, n_values = is_narrow ? LEAST : N;
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

void pl_table_rows_sizes(FILE *stream, const planish_size_quality *before,
                         const planish_size_quality *after) {
    const pl_table_measure off = {"", PL_LESS_IS_BETTER, PL_CHANGE_RELATIVE},
                           plain = {"", PL_LESS_IS_BETTER, PL_NOT_COMPARED};
    char text[160];
    pl_table_row_real(stream, "RMS of log(size / wanted)", before ? &before->rms_log : NULL,
                      after->rms_log, &off);
    pl_table_row_real(stream, "  least size / wanted", before ? &before->min : NULL, after->min,
                      &plain);
    pl_table_row_real(stream, "  largest", before ? &before->max : NULL, after->max, &plain);
    snprintf(text, sizeof text,
             "Sizes are relative: times %.4g, the given sizes fit the number of elements.",
             after->factor);
    pl_terminal_wrap(stream, text);
}

void pl_table_rows_aspect(FILE *stream, const pl_job *job, const pl_result *result) {
    const planish_quality *before = &result->before, *after = &result->after;
    const planish_cell_measures *was = &result->validity_before.quality.all;
    const planish_cell_measures *is = &result->validity_after.quality.all;
    const int is_of_same = pl_cells_validity_faults(&result->validity_before, before) ==
                           pl_cells_validity_faults(&result->validity_after, after);
    const pl_table_measure ratio = {"", PL_LESS_IS_BETTER,
                                    is_of_same ? PL_CHANGE_RELATIVE : PL_NOT_COMPARED};
    /* Elements whose targets may be sharp need not be more regular. */
    const pl_table_measure jacobian = {"", PL_MORE_IS_BETTER,
                                       pl_job_is_blunt(job) ? PL_CHANGE_ABSOLUTE : PL_NOT_COMPARED};
    if (pl_like_has_sizes(&job->like))
        pl_table_rows_sizes(stream, &result->validity_before.sizes, &result->validity_after.sizes);
    pl_table_row_real(stream, "worst aspect ratio (AR)", &was->max_aspect_ratio,
                      is->max_aspect_ratio, &ratio);
    if (after->n_fixed_elements > 0)
        pl_table_row_real(stream, "  of fixed elements", &before->fixed_max_radius_ratio,
                          after->fixed_max_radius_ratio, &ratio);
    pl_table_row_real(stream, "RMS aspect ratio", &was->rms_aspect_ratio, is->rms_aspect_ratio,
                      &ratio);
    if (after->n_fixed_elements > 0 && !(job->options.size_weight > 0)) /* else it is F */
        pl_table_row_real(stream, "  of movable elements", &before->rms_radius_ratio_movable,
                          after->rms_radius_ratio_movable, &ratio);
    pl_table_row_real(stream, "mean aspect ratio", &was->mean_aspect_ratio, is->mean_aspect_ratio,
                      &ratio);
    pl_table_row_real(stream, "least scaled Jacobian (SJ)", &was->min_scaled_jacobian,
                      is->min_scaled_jacobian, &jacobian);
    pl_table_rows_inverted(stream, before, after, &result->validity_before,
                           &result->validity_after);
    if (after->n_reversed > 0 || before->n_reversed > 0)
        pl_table_row_count(stream, "reversed in the file's order", &before->n_reversed,
                           after->n_reversed);
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

enum { ELEMENTS_WIDTH = 10, FAULTS_WIDTH = 9, CORNERS_WIDTH = 8, AR_WIDTH = 9, SJ_WIDTH = 11 };

static void put_counts(FILE *stream, const planish_cell_measures *of, int is_narrow) {
    fprintf(stream, "%*" PRId64 "%*" PRId64, ELEMENTS_WIDTH, of->n_elements, FAULTS_WIDTH,
            of->n_inverted);
    if (!is_narrow)
        fprintf(stream, "%*" PRId64, CORNERS_WIDTH, of->n_inverted_corners);
}

/** Put a line for each type; on narrow terminals, of a part of the measures. */
static void put_types(FILE *stream, const planish_cell_quality *q) {
    const int is_narrow = pl_table_widths_of(stream).is_narrow;
    char heading[192], spared[64] = "", corners[32] = "";
    if (!is_narrow) {
        snprintf(corners, sizeof corners, "%*s", CORNERS_WIDTH, "corners");
        snprintf(spared, sizeof spared, "%*s%*s", AR_WIDTH, "RMS", AR_WIDTH, "mean");
    }
    snprintf(heading, sizeof heading, "%-*s%*s%*s%s%*s%s%*s", PL_TYPE_WIDTH, "type", ELEMENTS_WIDTH,
             "elements", FAULTS_WIDTH, "inverted", corners, AR_WIDTH, "worst AR", spared, SJ_WIDTH,
             "least SJ");
    pl_table_put_heading(stream, heading);
    for (int i = 0; i < q->n_types; i++) {
        const planish_cell_measures *of = &q->by_type[i];
        const double ratios[] = {of->max_aspect_ratio, of->rms_aspect_ratio, of->mean_aspect_ratio};
        fprintf(stream, "%-*s", PL_TYPE_WIDTH, pl_cell_type_name(q->type[i]));
        put_counts(stream, of, is_narrow);
        for (size_t k = 0; k < (is_narrow ? 1 : sizeof ratios / sizeof *ratios); k++)
            if (isfinite(ratios[k]))
                fprintf(stream, " %*.4g", AR_WIDTH - 1, ratios[k]);
            else
                fprintf(stream, "%*s", AR_WIDTH, "-");
        fprintf(stream, " %*.4g\n", SJ_WIDTH - 1, of->min_scaled_jacobian);
    }
}

void pl_table_put_cells(FILE *stream, const pl_job *job, const pl_cells *cells) {
    static const pl_table_measure real = {"", PL_LESS_IS_BETTER, PL_NOT_COMPARED};
    const planish_cell_measures *all = &cells->quality.all;
    pl_table_row_real(stream, "worst aspect ratio (AR)", NULL, all->max_aspect_ratio, &real);
    pl_table_row_real(stream, "RMS aspect ratio", NULL, all->rms_aspect_ratio, &real);
    pl_table_row_real(stream, "mean aspect ratio", NULL, all->mean_aspect_ratio, &real);
    pl_table_row_real(stream, "least scaled Jacobian (SJ)", NULL, all->min_scaled_jacobian, &real);
    if (all->n_curved > 0)
        pl_table_row_real(stream, "least Jacobian / mean, curved", NULL, all->min_jacobian_ratio,
                          &real);
    pl_table_row_real(stream, "largest edge ratio", NULL, all->max_edge_ratio, &real);
    pl_table_row_count(stream, "inverted elements", NULL, all->n_inverted);
    pl_table_row_count(stream, "inverted corners", NULL, all->n_inverted_corners);
    pl_table_row_count(stream, "uncertified elements", NULL, all->n_uncertified);
    if (all->n_curved > 0) { /* no fault */
        pl_table_put_label(stream, "curved elements");
        fprintf(stream, "%*" PRId64 "\n", pl_table_widths_of(stream).value, all->n_curved);
    }
    if (all->worst_element >= 0)
        fprintf(stream, "the worst valid element is %" PRId64 " (%s)\n",
                planish_file_element_number(job->file, all->worst_element),
                pl_cell_type_name((planish_cell_type)cells->cells.type[all->worst_element]));
    put_types(stream, &cells->quality);
}
