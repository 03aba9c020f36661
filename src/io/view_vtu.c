/* view_vtu: a mesh that is shown, as VTK's XML file: raw appended data, not packed, and the names
 * of groups as strings of the field data. */
#include "io/view.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/binary.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { BUFFER = 1 << 14 };

/** Markup under way. */
typedef struct markup {
    const io_view *view;
    io_output *output;
    planish_error *error;
    int status;
    int64_t offset; /* of the next array in the appended data */
    size_t length;  /* of what waits in */
    char text[BUFFER];
} markup;

static void flush_text(markup *m) {
    if (!m->status)
        m->status = io_output_write(m->output, m->text, (int64_t)m->length, m->error);
    m->length = 0;
}

static void put(markup *m, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void put(markup *m, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (m->length + (size_t)length > BUFFER)
        flush_text(m);
    memcpy(m->text + m->length, text, (size_t)length);
    m->length += (size_t)length;
}

static int64_t bytes_of(const io_view_array *array) {
    return array->n * io_view_type_size(array->type);
}

static void put_array(markup *m, const io_view_array *array) {
    static const char *const types[] = {"UInt8", "Int32", "Int64", "Float32", "Float64"};
    put(m,
        "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"appended\" "
        "offset=\"%" PRId64 "\"/>\n",
        types[array->type], array->name, array->n_components, m->offset);
    m->offset += (int64_t)sizeof(uint64_t) + bytes_of(array);
}

static void put_section(markup *m, const char *name, const io_view_array *arrays, int n) {
    put(m, "<%s>\n", name);
    for (int i = 0; i < n; i++)
        put_array(m, &arrays[i]);
    put(m, "</%s>\n", name);
}

/** A name as an attribute's value. Bytes that are no UTF-8 text are up to who reads it. */
static void put_name(markup *m, const char *name) {
    for (const char *c = name; *c; c++) {
        const char *special = *c == '"'   ? "&quot;"
                              : *c == '<' ? "&lt;"
                              : *c == '&' ? "&amp;"
                                          : NULL;
        if (special || (unsigned char)*c < ' ')
            put(m, "%s", special ? special : " ");
        else
            put(m, "%c", *c);
    }
}

/** Groups as field data called by their names, with tag and dimension, as meshio has them. */
static void put_groups(markup *m) {
    const io_model *model = m->view->model;
    if (model->n_groups == 0)
        return;
    put(m, "<FieldData>\n");
    for (int32_t i = 0; i < model->n_groups; i++) {
        const io_group *group = &model->group[i];
        put(m, "<DataArray type=\"Int32\" Name=\"");
        put_name(m, group->name);
        put(m, "\" NumberOfTuples=\"2\" format=\"ascii\">%ld %d</DataArray>\n", (long)group->tag,
            group->dim);
    }
    put(m, "</FieldData>\n");
}

static void put_head(markup *m, const io_view_arrays *a) {
    put(m,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
        "byte_order=\"%s\" header_type=\"UInt64\">\n<UnstructuredGrid>\n",
        io_machine_is_little() ? "LittleEndian" : "BigEndian");
    put_groups(m);
    put(m, "<Piece NumberOfPoints=\"%" PRId64 "\" NumberOfCells=\"%" PRId64 "\">\n",
        m->view->model->n_nodes, m->view->n_cells);
    put_section(m, "PointData", a->point_data, a->n_point_data);
    put_section(m, "CellData", a->cell_data, a->n_cell_data);
    put_section(m, "Points", &a->points, 1);
    const io_view_array cells[] = {a->connectivity, a->offsets, a->types};
    put_section(m, "Cells", cells, 3);
    put(m, "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
}

static void put_values(markup *m, const io_view_array *array) {
    const uint64_t bytes = (uint64_t)bytes_of(array);
    flush_text(m);
    if (!m->status)
        m->status = io_output_write(m->output, (const char *)&bytes, sizeof bytes, m->error);
    if (!m->status)
        m->status = io_view_write(m->view, array, 0, m->output, m->error);
}

int io_view_write_vtu(const io_view *view, io_output *output, const char **lost,
                      planish_error *error) {
    const io_view_arrays a = io_view_arrays_of(view);
    markup m = {.view = view, .output = output, .error = error};
    *lost = NULL;
    put_head(&m, &a);
    for (int i = 0; i < a.n_point_data; i++)
        put_values(&m, &a.point_data[i]);
    for (int i = 0; i < a.n_cell_data; i++)
        put_values(&m, &a.cell_data[i]);
    put_values(&m, &a.points);
    put_values(&m, &a.connectivity);
    put_values(&m, &a.offsets);
    put_values(&m, &a.types);
    put(&m, "\n</AppendedData>\n</VTKFile>\n");
    flush_text(&m);
    return m.status;
}
