/* table_rows: lines of a table, and the change that each tells. */
#include "report/table_rows.h"

#include "terminal/terminal.h"
#include "terminal/text.h"

#include <inttypes.h>
#include <math.h>

pl_table_widths pl_table_widths_of(FILE *stream) {
    static const pl_table_widths wide = {PL_MOST_LABEL, 13, 11, 0}, narrow = {29, 10, 10, 1};
    return pl_terminal_text_width(stream) < PL_TEXT_WIDTH ? narrow : wide;
}

/* Changes below this fraction of a value are not seen in the digits of it that are shown. */
static const double INVISIBLE = 5e-6;

static const pl_table_measure fault = {"", PL_LESS_IS_BETTER, PL_CHANGE_COUNTED};

void pl_table_put_label(FILE *stream, const char *label) {
    fprintf(stream, "%-*s", pl_table_widths_of(stream).label, label);
}

void pl_table_put_real(FILE *stream, int width, double value) {
    char text[32] = "-";
    if (isfinite(value) && snprintf(text, sizeof text, "%.5g", value) >= width)
        snprintf(text, sizeof text, "%.3g", value); /* a blank stays before it */
    fprintf(stream, "%*s", width, text);
}

void pl_table_put_heading(FILE *stream, const char *text) {
    fprintf(stream, "%s%s%s\n", pl_style_begin(stream, PL_STYLE_HEADING), text,
            pl_style_end(stream, PL_STYLE_HEADING));
}

/** Better or worse than before, beyond rounding; PL_STYLE_PLAIN: neither. */
static pl_style style_of_change(const pl_table_measure *m, double before, double after) {
    const double change = m->sense == PL_LESS_IS_BETTER ? before - after : after - before;
    const double size = fmax(fabs(before), fabs(after));
    if (m->change == PL_NOT_COMPARED || !isfinite(change) || fabs(change) <= INVISIBLE * size)
        return PL_STYLE_PLAIN;
    return change > 0 ? PL_STYLE_BETTER : PL_STYLE_WORSE;
}

/** The change in its column, and a word for it. */
static void put_change(FILE *stream, const pl_table_measure *m, double before, double after) {
    const pl_style style = style_of_change(m, before, after);
    char change[32] = "";
    if (style == PL_STYLE_PLAIN)
        return;
    if (m->change == PL_CHANGE_ABSOLUTE)
        snprintf(change, sizeof change, "%+.4g", after - before);
    else if (m->change == PL_CHANGE_COUNTED)
        snprintf(change, sizeof change, "%+.0f", after - before);
    else if (before > 0 && after >= 2 * before) /* no percentages above 100 */
        snprintf(change, sizeof change, "x %.3g", after / before);
    else if (before > 0 && after > 0)
        snprintf(change, sizeof change, "%+.3g %%", 100 * (after / before - 1));
    fprintf(stream, "%*s%s", PL_UNIT_WIDTH - pl_text_columns(m->unit), "",
            pl_style_begin(stream, style));
    if (!pl_table_widths_of(stream).is_narrow)
        fprintf(stream, "%*s ", PL_CHANGE_WIDTH, change);
    fprintf(stream, " %s%s", style == PL_STYLE_BETTER ? "better" : "worse",
            pl_style_end(stream, style));
}

void pl_table_row_real(FILE *stream, const char *label, const double *before, double after,
                       const pl_table_measure *m) {
    const pl_style style = before ? style_of_change(m, *before, after) : PL_STYLE_PLAIN;
    const int width = pl_table_widths_of(stream).value;
    pl_table_put_label(stream, label);
    if (before)
        pl_table_put_real(stream, width, *before);
    fputs(pl_style_begin(stream, style), stream);
    pl_table_put_real(stream, width, after);
    fprintf(stream, "%s%s", pl_style_end(stream, style), isfinite(after) ? m->unit : "");
    if (before)
        put_change(stream, m, *before, after);
    fputc('\n', stream);
}

void pl_table_row_count(FILE *stream, const char *label, const int64_t *before, int64_t after) {
    pl_style style = after > 0 ? PL_STYLE_WORSE : PL_STYLE_PLAIN;
    const int width = pl_table_widths_of(stream).value;
    pl_table_put_label(stream, label);
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

const char *pl_table_word_for(int64_t n, const char *one, const char *many) {
    return n == 1 ? one : many;
}
