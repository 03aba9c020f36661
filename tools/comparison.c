/* comparison: several meshes side by side, a row each. */
#include "comparison.h"

#include "terminal.h"
#include "text.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

enum { COUNT_WIDTH = 10, FAULT_WIDTH = 9, REAL_WIDTH = 10, N_COLUMNS = 7, BELOW = 2 };

typedef struct column {
    const char *head[2];
    int width, is_count, more_is_better;
} column;

static const column columns[N_COLUMNS] = {
    {{"", "elements"}, COUNT_WIDTH, 1, 0},     {{"", "inverted"}, FAULT_WIDTH, 1, 0},
    {{"below", "minimum"}, FAULT_WIDTH, 1, 0}, {{"worst", "RR"}, REAL_WIDTH, 0, 0},
    {{"smallest", "angle"}, REAL_WIDTH, 0, 1}, {{"RMS", "RR"}, REAL_WIDTH, 0, 0},
    {{"mean", "RR"}, REAL_WIDTH, 0, 0},
};

static double value_of(const pl_compared *mesh, int c) {
    const planish_quality *q = &mesh->measured.quality;
    const double values[N_COLUMNS] = {
        (double)mesh->n_elements, (double)q->inverted, (double)mesh->measured.volumes.n_below,
        q->max_radius_ratio,      q->min_angle_deg,    q->rms_radius_ratio,
        q->mean_radius_ratio};
    return values[c];
}

/** The best value of a column, NAN if all are the same; that of c = 0 says nothing. */
static double best_of(const pl_compared *mesh, int n, int c) {
    double least = INFINITY, most = -INFINITY;
    for (int i = 0; i < n; i++) {
        const double value = value_of(&mesh[i], c);
        if (isfinite(value)) {
            least = fmin(least, value);
            most = fmax(most, value);
        }
    }
    if (c == 0 || !(least < most))
        return NAN;
    return columns[c].more_is_better ? most : least;
}

static void put_head(FILE *stream, int name_width, int has_volumes) {
    for (int line = 0; line < 2; line++) {
        fprintf(stream, "%s%-*s", pl_style_begin(stream, PL_STYLE_HEADING), name_width,
                line ? "file" : "");
        for (int c = 0; c < N_COLUMNS; c++)
            if (c != BELOW || has_volumes)
                fprintf(stream, "%*s", columns[c].width, columns[c].head[line]);
        fprintf(stream, "%s\n", pl_style_end(stream, PL_STYLE_HEADING));
    }
}

static void put_value(FILE *stream, int c, double value, double best) {
    const pl_style style = value == best ? PL_STYLE_HEADING : PL_STYLE_PLAIN;
    fputs(pl_style_begin(stream, style), stream);
    if (columns[c].is_count)
        fprintf(stream, "%*.0f", columns[c].width, value);
    else if (isfinite(value))
        fprintf(stream, "%*.4g", columns[c].width, value);
    else
        fprintf(stream, "%*s", columns[c].width, "-");
    fputs(pl_style_end(stream, style), stream);
}

static void put_row(FILE *stream, const pl_compared *mesh, const double *best, int name_width,
                    int has_volumes) {
    char name[4 * PL_TEXT_WIDTH + 1];
    pl_text_fit(mesh->name, name_width, name, sizeof name);
    fprintf(stream, "%s%*s", name, name_width - pl_text_columns(name), "");
    for (int c = 0; c < N_COLUMNS; c++)
        if (c != BELOW || has_volumes)
            put_value(stream, c, value_of(mesh, c), best[c]);
    fputc('\n', stream);
}

void pl_comparison_print(FILE *stream, const pl_compared *mesh, int n, int has_volumes) {
    double best[N_COLUMNS];
    int name_width = PL_TEXT_WIDTH;
    if (n == 0)
        return;
    for (int c = 0; c < N_COLUMNS; c++) {
        best[c] = best_of(mesh, n, c);
        name_width -= c != BELOW || has_volumes ? columns[c].width : 0;
    }
    put_head(stream, name_width, has_volumes);
    for (int i = 0; i < n; i++)
        put_row(stream, &mesh[i], best, name_width, has_volumes);
}
