/* vtk_write: a mesh as a legacy VTK file, binary, of version 3, which all programs read. The names of
 * groups stand in its title, as far as that is long.
 */
#include "io/vtk/vtk_arrays.h"
#include "io/vtk/vtk_write.h"

#include "io/core/binary.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { MOST_TITLE = 256 }; /* with the end of the line, as VTK says */

static void put_array(io_writer *writer, const io_view *view, const vtk_out_array *array) {
    vtk_put_array(writer, view, array, io_machine_is_little());
    io_put_text(writer, "\n");
}

/** Make the title; return 0 if not all groups are in it. */
static int make_title(const io_model *model, char title[MOST_TITLE]) {
    size_t length = (size_t)snprintf(title, MOST_TITLE, "planish");
    for (int32_t i = 0; i < model->n_groups; i++) {
        char text[MOST_TITLE];
        const int of_group = io_view_group_text(model, i, text, sizeof text);
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

/** Put the name of an array, in which legacy files have %20 for a blank. */
static void put_name(io_writer *writer, const char *name) {
    for (const char *c = name; *c; c++)
        if ((unsigned char)*c <= ' ' || *c == '%' || *c == '"')
            io_put_format(writer, "%%%02X", (unsigned char)*c);
        else
            io_put_bytes(writer, c, 1);
}

static void put_data(io_writer *writer, const io_view *view, const char *section, int64_t n,
                     const vtk_out_array *arrays, int n_arrays) {
    static const char *const types[] = {"unsigned_char", "int", "vtktypeint64", "float", "double"};
    io_put_format(writer, "%s %" PRId64 "\nFIELD FieldData %d\n", section, n, n_arrays);
    for (int i = 0; i < n_arrays; i++) {
        put_name(writer, arrays[i].name);
        io_put_format(writer, " %d %" PRId64 " %s\n", arrays[i].width, n, types[arrays[i].type]);
        put_array(writer, view, &arrays[i]);
    }
}

static void put_mesh(io_writer *writer, const io_view *view, const char *title,
                     const vtk_out_arrays *a) {
    const int64_t n_nodes = view->model->n_nodes, n_cells = view->n_cells;
    io_put_text(writer, "# vtk DataFile Version 3.0\n");
    io_put_text(writer, title);
    io_put_format(writer, "\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS %" PRId64 " %s\n", n_nodes,
                  a->points.type == VTK_OUT_F32 ? "float" : "double");
    put_array(writer, view, &a->points);
    io_put_format(writer, "CELLS %" PRId64 " %" PRId64 "\n", n_cells, a->counted.n);
    put_array(writer, view, &a->counted);
    io_put_format(writer, "CELL_TYPES %" PRId64 "\n", n_cells);
    put_array(writer, view, &a->wide_types);
    put_data(writer, view, "POINT_DATA", n_nodes, a->point_data, a->n_point_data);
    put_data(writer, view, "CELL_DATA", n_cells, a->cell_data, a->n_cell_data);
}

int vtk_write(const io_view *view, pl_output *output, io_losses *losses, planish_error *error) {
    vtk_out_arrays a;
    io_writer writer;
    char title[MOST_TITLE];
    if (!make_title(view->model, title))
        io_losses_add(losses, "names of groups (there are too many)");
    const int status = vtk_arrays_begin(view, losses, &a, error);
    io_writer_begin(&writer, output, error);
    if (!status)
        put_mesh(&writer, view, title, &a);
    vtk_arrays_end(&a);
    return io_writer_end(&writer) ? writer.status : status;
}
