/* table_simplices: measures of simplices. The lines are the same of one mesh and of two states: before is
 * NULL where there is but one. */
#include "report/table_simplices.h"

#include "report/table_rows.h"
#include "terminal/terminal.h"

#include <stddef.h>

/** A row for a measure of planish_quality. */
typedef struct quality_row {
    const char *solid, *plane; /* its label in 3-D and 2-D */
    size_t at;                 /* offset of the number */
    pl_table_measure measure;
    enum { EVERY, WITH_FIXED } meshes; /* those that have it: with fixed elements */
    enum { OF_ANY, OF_VALID } of;      /* valid elements may be others before than after */
} quality_row;

#define AT(field) offsetof(planish_quality, field)
static const quality_row quality_rows[] = {
    {"worst radius ratio",
     "worst radius ratio",
     AT(max_radius_ratio),
     {"", PL_LESS_IS_BETTER, PL_CHANGE_RELATIVE},
     EVERY,
     OF_VALID},
    /* Their elements stay as they are, whatever the others do. */
    {"  of fixed elements",
     "  of fixed elements",
     AT(fixed_max_radius_ratio),
     {"", PL_LESS_IS_BETTER, PL_CHANGE_RELATIVE},
     WITH_FIXED,
     OF_ANY},
    {"smallest dihedral angle",
     "smallest angle",
     AT(min_angle_deg),
     {" deg", PL_MORE_IS_BETTER, PL_CHANGE_ABSOLUTE},
     EVERY,
     OF_VALID},
    {"  of movable elements",
     "  of movable elements",
     AT(min_angle_deg_movable),
     {" deg", PL_MORE_IS_BETTER, PL_CHANGE_ABSOLUTE},
     WITH_FIXED,
     OF_VALID},
    {"largest dihedral angle",
     "largest angle",
     AT(max_angle_deg),
     {" deg", PL_LESS_IS_BETTER, PL_CHANGE_ABSOLUTE},
     EVERY,
     OF_VALID},
    {"RMS radius ratio",
     "RMS radius ratio",
     AT(rms_radius_ratio),
     {"", PL_LESS_IS_BETTER, PL_CHANGE_RELATIVE},
     EVERY,
     OF_VALID},
    {"  of movable elements",
     "  of movable elements",
     AT(rms_radius_ratio_movable),
     {"", PL_LESS_IS_BETTER, PL_CHANGE_RELATIVE},
     WITH_FIXED,
     OF_VALID},
    {"mean radius ratio",
     "mean radius ratio",
     AT(mean_radius_ratio),
     {"", PL_LESS_IS_BETTER, PL_CHANGE_RELATIVE},
     EVERY,
     OF_VALID},
    {"smallest volume",
     "smallest area",
     AT(min_volume),
     {"", PL_MORE_IS_BETTER, PL_CHANGE_RELATIVE},
     EVERY,
     OF_ANY},
};

int pl_table_are_of_same(const planish_quality *before, const planish_quality *after) {
    return !before || before->n_inverted == after->n_inverted;
}

static const double *number_at(const planish_quality *quality, size_t at) {
    return quality ? (const double *)(const void *)((const char *)quality + at) : NULL;
}

void pl_table_rows_inverted(FILE *stream, const planish_quality *before,
                            const planish_quality *after, const pl_cells_validity *validity_before,
                            const pl_cells_validity *validity) {
    const pl_table_measure ratio = {"", PL_MORE_IS_BETTER, PL_CHANGE_ABSOLUTE};
    const planish_cell_measures *was = &validity_before->quality.all, *is = &validity->quality.all;
    const int64_t n = before ? pl_cells_validity_faults(validity_before, before) : 0;
    if (is->n_curved > 0)
        pl_table_row_real(stream, "least Jacobian / mean, curved",
                          before ? &was->min_jacobian_ratio : NULL, is->min_jacobian_ratio, &ratio);
    pl_table_row_count(stream, "inverted elements", before ? &n : NULL,
                       pl_cells_validity_faults(validity, after));
    if (validity->n_inside > 0 || validity_before->n_inside > 0)
        pl_table_row_count(stream, "  though their corners are right",
                           before ? &validity_before->n_inside : NULL, validity->n_inside);
    if (is->n_uncertified > 0 || was->n_uncertified > 0)
        pl_table_row_count(stream, "  uncertified", before ? &was->n_uncertified : NULL,
                           is->n_uncertified);
}

void pl_table_rows_quality(FILE *stream, int dim, const planish_quality *before,
                           const planish_quality *after, const pl_cells_validity *validity_before,
                           const pl_cells_validity *validity) {
    for (size_t i = 0; i < sizeof quality_rows / sizeof *quality_rows; i++) {
        const quality_row *row = &quality_rows[i];
        pl_table_measure m = row->measure;
        if (row->meshes == WITH_FIXED && after->n_fixed_elements == 0)
            continue;
        if (row->of == OF_VALID && !pl_table_are_of_same(before, after))
            m.change = PL_NOT_COMPARED;
        pl_table_row_real(stream, dim == 3 ? row->solid : row->plane, number_at(before, row->at),
                          *number_at(after, row->at), &m);
    }
    pl_table_rows_inverted(stream, before, after, validity_before, validity);
    if (after->n_reversed > 0 || (before && before->n_reversed > 0))
        pl_table_row_count(stream, "reversed in the file's order",
                           before ? &before->n_reversed : NULL, after->n_reversed);
}

static void row_spread(FILE *stream, const char *label, const planish_spread *spread,
                       const char *range) {
    const pl_table_widths w = pl_table_widths_of(stream);
    pl_table_put_label(stream, label);
    pl_table_put_real(stream, w.spread, spread->min);
    pl_table_put_real(stream, w.spread, spread->mean);
    pl_table_put_real(stream, w.spread, spread->max);
    fprintf(stream, "%s%s\n", w.is_narrow ? "" : "  ", w.is_narrow ? "" : range);
}

void pl_table_put_spreads(FILE *stream, int solid, const planish_quality *q) {
    const pl_table_widths w = pl_table_widths_of(stream);
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
