/* table_worst: the worst elements of a mesh. */
#include "report/table.h"

#include "job/held.h"
#include "report/table_rows.h"
#include "terminal/terminal.h"
#include "terminal/text.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

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
        fprintf(stream, "  %-*s", PL_TYPE_WIDTH, pl_cell_type_name(bad->type));
    if (bad->ratio > 0)
        fprintf(stream, "%*.5g", RATIO_WIDTH, bad->ratio);
    else
        fprintf(stream, "%s%*s%s", pl_style_begin(stream, PL_STYLE_WORSE), RATIO_WIDTH, "inverted",
                pl_style_end(stream, PL_STYLE_WORSE));
    if (!worst->is_aspect_ratio) {
        put_angle(stream, bad->smallest_angle_deg);
        put_angle(stream, bad->largest_angle_deg);
    }
    for (int d = 0; d < (pl_table_widths_of(stream).is_narrow ? 0 : worst->columns); d++)
        fprintf(stream, "%*.5g", PLACE_WIDTH, bad->place[d]);
    int width = fprintf(stream, "\n%*s  nodes", NUMBER_WIDTH, "") - 1;
    for (int k = 0; k < bad->n_nodes; k++) {
        char number[32];
        snprintf(number, sizeof number, " %" PRId64, bad->node[k]);
        width = put_further(stream, number, width);
    }
    if (bad->is_movable == 0)
        width = put_further(stream, ", all fixed", width);
    if (bad->held_by) {
        width = put_further(stream, ", all ", width);
        width = put_further(stream, pl_held_text_in_run(pl_held_name_in_run(bad->held_by)), width);
    }
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
        fprintf(stream, "  %-*s%*s", PL_TYPE_WIDTH, "type", RATIO_WIDTH, "aspect ratio");
    else
        fprintf(stream, "%*s%*s", RATIO_WIDTH, "radius ratio", 2 * ANGLE_WIDTH,
                worst->dim == 3 ? "dihedral angles" : "angles");
    for (int d = 0; d < (pl_table_widths_of(stream).is_narrow ? 0 : worst->columns); d++)
        fprintf(stream, "%*c", PLACE_WIDTH, "xyz"[d]);
    fprintf(stream, "%s\n", pl_style_end(stream, PL_STYLE_HEADING));
    for (int64_t i = 0; i < n; i++)
        put_bad_element(stream, &worst->bad[i], worst);
}
