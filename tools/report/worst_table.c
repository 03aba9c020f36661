/* worst_table: the worst elements for people. */
#include "job/worst.h"

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

static void put_measures(FILE *stream, const pl_bad_element *bad, int columns) {
    fprintf(stream, "%*" PRId64, NUMBER_WIDTH, bad->number);
    if (bad->radius_ratio > 0)
        fprintf(stream, "%*.5g", RATIO_WIDTH, bad->radius_ratio);
    else
        fprintf(stream, "%s%*s%s", pl_style_begin(stream, PL_STYLE_WORSE), RATIO_WIDTH, "inverted",
                pl_style_end(stream, PL_STYLE_WORSE));
    put_angle(stream, bad->smallest_angle_deg);
    put_angle(stream, bad->largest_angle_deg);
    for (int d = 0; d < columns; d++)
        fprintf(stream, "%*.5g", PLACE_WIDTH, bad->place[d]);
    fputc('\n', stream);
}

/** Put its nodes, its region and whether it can change. */
static void put_surroundings(FILE *stream, const pl_bad_element *bad, int dim) {
    char region[4 * PL_TEXT_WIDTH + 1];
    int width = fprintf(stream, "%*s  nodes", NUMBER_WIDTH, "");
    for (int k = 0; k <= dim; k++)
        width += fprintf(stream, " %" PRId64, bad->node[k]);
    if (!bad->is_movable)
        width += fprintf(stream, ", all fixed");
    if (bad->region) {
        const char *word = ", in ";
        const int room = PL_TEXT_WIDTH - width - (int)strlen(word);
        fprintf(stream, "%s%s", word,
                pl_text_fit(bad->region, room > 4 ? room : 4, region, sizeof region));
    }
    fputc('\n', stream);
}

void pl_worst_print(FILE *stream, const pl_worst *worst, int64_t n) {
    if (n > worst->n)
        n = worst->n;
    if (n == 0)
        return;
    fprintf(stream, "%s%*s%*s%*s%*s%*s", pl_style_begin(stream, PL_STYLE_HEADING), NUMBER_WIDTH,
            "element", RATIO_WIDTH, "radius ratio", 2 * ANGLE_WIDTH,
            worst->dim == 3 ? "dihedral angles" : "angles", PLACE_WIDTH, "x", PLACE_WIDTH, "y");
    if (worst->columns == 3)
        fprintf(stream, "%*s", PLACE_WIDTH, "z");
    fprintf(stream, "%s\n", pl_style_end(stream, PL_STYLE_HEADING));
    for (int64_t i = 0; i < n; i++) {
        put_measures(stream, &worst->bad[i], worst->columns);
        put_surroundings(stream, &worst->bad[i], worst->dim);
    }
}
