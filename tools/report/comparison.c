/* comparison: several meshes side by side, a row each. */
#include "report/comparison.h"

#include "terminal/terminal.h"
#include "terminal/text.h"

#include "base/system.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    COUNT_WIDTH = 10,
    FAULT_WIDTH = 9,
    REAL_WIDTH = 10,
    N_COLUMNS = 11,
    BELOW = 2,
    LEAST_NAME = 10
};

/* Meshes that have a column: any; those compared where all have straight simplices alone; those
 * compared where some have elements of other types. */
typedef enum column_use { ALWAYS, OF_SIMPLICES, OF_TYPES } column_use;

typedef struct column {
    const char *head[2];
    int width, is_count, more_is_better;
    column_use use;
    int needs_room; /* not on narrow terminals */
} column;

static const column columns[N_COLUMNS] = {
    {{"", "elements"}, COUNT_WIDTH, 1, 0, ALWAYS, 0},
    {{"", "inverted"}, FAULT_WIDTH, 1, 0, ALWAYS, 0},
    {{"below", "minimum"}, FAULT_WIDTH, 1, 0, ALWAYS, 0},
    {{"worst", "RR"}, REAL_WIDTH, 0, 0, OF_SIMPLICES, 0},
    {{"smallest", "angle"}, REAL_WIDTH, 0, 1, OF_SIMPLICES, 0},
    {{"RMS", "RR"}, REAL_WIDTH, 0, 0, OF_SIMPLICES, 0},
    {{"mean", "RR"}, REAL_WIDTH, 0, 0, OF_SIMPLICES, 1},
    {{"worst", "AR"}, REAL_WIDTH, 0, 0, OF_TYPES, 0},
    {{"least", "SJ"}, REAL_WIDTH, 0, 1, OF_TYPES, 0},
    {{"RMS", "AR"}, REAL_WIDTH, 0, 0, OF_TYPES, 0},
    {{"mean", "AR"}, REAL_WIDTH, 0, 0, OF_TYPES, 1},
};

/** Which columns a comparison has. */
typedef struct selection {
    int is_shown[N_COLUMNS];
} selection;

static selection select_columns(const pl_compared *mesh, int n, int has_volumes, int is_narrow) {
    selection of;
    int has_others = 0;
    for (int i = 0; i < n; i++)
        has_others |= mesh[i].measured.cells.has_others;
    for (int c = 0; c < N_COLUMNS; c++)
        of.is_shown[c] = (c != BELOW || has_volumes) && !(columns[c].needs_room && is_narrow) &&
                         columns[c].use != (has_others ? OF_SIMPLICES : OF_TYPES);
    return of;
}

/** Value of a column; NAN: the mesh has none. AR of a simplex is 1 / mean ratio. */
static double value_of(const pl_compared *mesh, int c) {
    const planish_quality *q = &mesh->measured.quality;
    const planish_cell_measures *all = &mesh->measured.cells.quality.all;
    const int has_others = mesh->measured.cells.has_others;
    const double values[N_COLUMNS] = {
        (double)mesh->n_elements,
        (double)(has_others ? all->n_inverted + all->n_uncertified : q->n_inverted),
        (double)mesh->measured.volumes.n_below,
        q->max_radius_ratio,
        q->min_angle_deg,
        q->rms_radius_ratio,
        q->mean_radius_ratio,
        has_others ? all->max_aspect_ratio : 1 / q->mean_ratio.min,
        has_others ? all->min_scaled_jacobian : q->scaled_jacobian.min,
        has_others ? all->rms_aspect_ratio : NAN,
        has_others ? all->mean_aspect_ratio : NAN};
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

static void put_head(FILE *stream, int name_width, const selection *shown) {
    for (int line = 0; line < 2; line++) {
        fprintf(stream, "%s%-*s", pl_style_begin(stream, PL_STYLE_HEADING), name_width,
                line && name_width >= LEAST_NAME ? "file" : "");
        for (int c = 0; c < N_COLUMNS; c++)
            if (shown->is_shown[c])
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

/* ---- names ----------------------------------------------------------------------------------- */

/** The names of a comparison. */
typedef struct names {
    size_t folder; /* bytes of each that are left out */
    int width;     /* columns of theirs */
    char **shown;  /* [n] what fits there, owned */
} names;

/** least, most: columns that the names may take. Returns 0, or -1 without memory. */
static int make_names(const pl_compared *mesh, int n, int least, int most, names *of) {
    int widest = least;
    size_t common = n > 1 ? strlen(mesh[0].name) : 0; /* bytes that all names begin with, */
    for (int i = 1; i < n; i++) {
        size_t same = 0;
        while (same < common && mesh[i].name[same] == mesh[0].name[same])
            same++;
        common = same;
    }
    while (common > 0 && !pl_path_is_separator(mesh[0].name[common - 1])) /* of a folder */
        common--;
    *of = (names){.folder = common > 1 ? common : 0, .shown = calloc((size_t)n, sizeof *of->shown)};
    for (int i = 0; i < n; i++) {
        const int wanted = pl_text_columns(mesh[i].name + of->folder);
        widest = wanted > widest ? wanted : widest;
    }
    of->width = widest < most ? widest : most;
    for (int i = 0; i < n && of->shown; i++) {
        const char *name = mesh[i].name + of->folder;
        const size_t size = strlen(name) + 4;
        of->shown[i] = malloc(size);
        if (!of->shown[i])
            return -1;
        pl_text_fit(name, of->width, of->shown[i], size);
    }
    return of->shown ? 0 : -1;
}

/* ---- rows ------------------------------------------------------------------------------------ */

/** Put the name in its column, or if it would say too little there on a line before; and the
 * values.
 */
static void put_row(FILE *stream, const pl_compared *mesh, int n, int i, const names *of,
                    const double *best, const selection *columns_shown) {
    const char *name = mesh[i].name + of->folder, *shown = of->shown[i];
    const int is_cut = pl_text_columns(name) > of->width;
    int is_unclear = is_cut && of->width < LEAST_NAME; /* or another one looks the same */
    for (int j = 0; j < n && is_cut; j++)
        is_unclear |= strcmp(of->shown[j], shown) == 0 && strcmp(mesh[j].name, mesh[i].name) != 0;
    if (is_unclear) {
        pl_text_put(stream, name);
        fputc('\n', stream);
        shown = "";
    }
    fprintf(stream, "%s%*s", shown, of->width - pl_text_columns(shown), "");
    for (int c = 0; c < N_COLUMNS; c++)
        if (columns_shown->is_shown[c])
            put_value(stream, c, value_of(&mesh[i], c), best[c]);
    fputc('\n', stream);
}

int pl_comparison_print(FILE *stream, const pl_compared *mesh, int n, int has_volumes) {
    const int text_width = pl_terminal_text_width(stream);
    const selection columns_shown =
        select_columns(mesh, n, has_volumes, text_width < PL_TEXT_WIDTH);
    double best[N_COLUMNS];
    int width = 0; /* of the values */
    names of;
    if (n == 0)
        return 0;
    for (int c = 0; c < N_COLUMNS; c++) {
        best[c] = best_of(mesh, n, c);
        width += columns_shown.is_shown[c] ? columns[c].width : 0;
    }
    const int room = pl_terminal_room(stream), least = text_width - width;
    const int status = make_names(mesh, n, least, room > PL_TEXT_WIDTH ? room - width : least, &of);
    if (!status)
        put_head(stream, of.width, &columns_shown);
    for (int i = 0; i < n && !status; i++)
        put_row(stream, mesh, n, i, &of, best, &columns_shown);
    for (int i = 0; i < n && of.shown; i++)
        free(of.shown[i]);
    free(of.shown);
    return status;
}
