/* view_vtk: a mesh that is shown, as a legacy VTK file, binary, of version 3, which all programs
 * read; the names of groups stand in its title, as far as that is long. */
#include "io/view/view.h"

#include "base/status.h"
#include "io/core/binary.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { MOST_TITLE = 256 }; /* with the end of the line, as VTK says */

/** Write text and then the values of an array. */
static int put(const io_view *view, const char *text, const io_view_array *array, pl_output *output,
               planish_error *error) {
    int status = pl_output_write(output, text, (int64_t)strlen(text), error);
    if (!status && array)
        status = io_view_write(view, array, io_machine_is_little(), output, error);
    return status ? status : pl_output_write(output, "\n", 1, error);
}

/** Make the title; return 0 if not all groups are in it. */
static int make_title(const io_model *model, char title[MOST_TITLE]) {
    size_t length = (size_t)snprintf(title, MOST_TITLE, "planish");
    for (int32_t i = 0; i < model->n_groups; i++) {
        char text[MOST_TITLE];
        const int of_group = io_view_group(model, i, text, sizeof text);
        if (of_group < 0 || length + (size_t)of_group + 2 >= MOST_TITLE - 1)
            return 0;
        for (char *c = text; *c; c++) /* the title is one line */
            if ((unsigned char)*c < ' ')
                *c = ' ';
        length +=
            (size_t)snprintf(title + length, MOST_TITLE - length, "%s%s", i ? ", " : ": ", text);
    }
    return 1;
}

static int put_data(const io_view *view, const char *section, int64_t n,
                    const io_view_array *arrays, int n_arrays, pl_output *output,
                    planish_error *error) {
    static const char *const types[] = {"unsigned_char", "int", "vtktypeint64", "float", "double"};
    char text[160];
    snprintf(text, sizeof text, "%s %" PRId64 "\nFIELD FieldData %d", section, n, n_arrays);
    int status = put(view, text, NULL, output, error);
    for (int i = 0; i < n_arrays && !status; i++) {
        snprintf(text, sizeof text, "%s 1 %" PRId64 " %s\n", arrays[i].name, n,
                 types[arrays[i].type]);
        status = put(view, text, &arrays[i], output, error);
    }
    return status;
}

int io_view_write_vtk(const io_view *view, pl_output *output, const char **lost,
                      planish_error *error) {
    const io_view_arrays a = io_view_arrays_of(view);
    const int64_t n_nodes = view->model->n_nodes, n_cells = view->n_cells;
    char title[MOST_TITLE], text[MOST_TITLE + 160];
    *lost = make_title(view->model, title) ? NULL : "names of groups (there are too many)";
    snprintf(text, sizeof text,
             "# vtk DataFile Version 3.0\n%s\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS %" PRId64
             " %s\n",
             title, n_nodes, a.points.type == IO_VIEW_F32 ? "float" : "double");
    int status = put(view, text, &a.points, output, error);
    snprintf(text, sizeof text, "CELLS %" PRId64 " %" PRId64 "\n", n_cells, a.counted.n);
    if (!status)
        status = put(view, text, &a.counted, output, error);
    snprintf(text, sizeof text, "CELL_TYPES %" PRId64 "\n", n_cells);
    if (!status)
        status = put(view, text, &a.wide_types, output, error);
    if (!status)
        status = put_data(view, "POINT_DATA", n_nodes, a.point_data, a.n_point_data, output, error);
    return status ? status
                  : put_data(view, "CELL_DATA", n_cells, a.cell_data, a.n_cell_data, output, error);
}
