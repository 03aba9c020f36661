/* view_vtu: a mesh that is shown, as VTK's XML file: raw appended data, not packed, and the names
 * of groups as strings of the field data. */
#include "io/view/view.h"

#include "base/memory.h"
#include "base/printf.h"
#include "base/status.h"
#include "io/core/binary.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { BUFFER = 1 << 14 };

/** Markup under way. */
typedef struct markup {
    const io_view *view;
    pl_output *output;
    planish_error *error;
    int status;
    int64_t offset; /* of the next array in the appended data */
    size_t length;  /* of what waits in */
    char text[BUFFER];
} markup;

static void flush_text(markup *m) {
    if (!m->status)
        m->status = pl_output_write(m->output, m->text, (int64_t)m->length, m->error);
    m->length = 0;
}

static void put(markup *m, const char *format, ...) PL_PRINTF(2, 3);
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

static void put_section(markup *m, const char *name, const io_view_array *arrays, int n) {
    static const char *const types[] = {"UInt8", "Int32", "Int64", "Float32", "Float64"};
    put(m, "<%s>\n", name);
    for (int i = 0; i < n; i++) {
        put(m,
            "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"appended\" "
            "offset=\"%" PRId64 "\"/>\n",
            types[arrays[i].type], arrays[i].name, arrays[i].n_components, m->offset);
        m->offset += (int64_t)sizeof(uint64_t) + bytes_of(&arrays[i]);
    }
    put(m, "</%s>\n", name);
}

/** Return the bytes of the UTF-8 character at text, 0 if there is none (RFC 3629). */
static int utf8_length(const unsigned char *text) {
    const int length = text[0] < 0x80   ? 1
                       : text[0] < 0xC2 ? 0
                       : text[0] < 0xE0 ? 2
                       : text[0] < 0xF0 ? 3
                       : text[0] < 0xF5 ? 4
                                        : 0;
    for (int i = 1; i < length; i++)
        if ((text[i] & 0xC0) != 0x80)
            return 0;
    if ((text[0] == 0xE0 && text[1] < 0xA0) || (text[0] == 0xED && text[1] > 0x9F) ||
        (text[0] == 0xF0 && text[1] < 0x90) || (text[0] == 0xF4 && text[1] > 0x8F))
        return 0;
    return length;
}

/** Put a name as an attribute's value. Bytes that are no UTF-8 are taken for Latin-1, which older
 *  files have. */
static void put_name(markup *m, const char *name) {
    static const char special[] = "\"<>&", *const texts[] = {"&quot;", "&lt;", "&gt;", "&amp;"};
    const unsigned char *c = (const unsigned char *)name;
    while (*c) {
        const int length = utf8_length(c);
        const char *found = strchr(special, *c);
        /* XML knows no control characters, and not U+FFFE and U+FFFF. */
        const int is_unknown =
            *c < ' ' || (length == 3 && c[0] == 0xEF && c[1] == 0xBF && (c[2] & 0xFE) == 0xBE);
        if (found)
            put(m, "%s", texts[found - special]);
        else if (length == 0)
            put(m, "%c%c", 0xC0 | *c >> 6, 0x80 | (*c & 0x3F));
        else
            put(m, "%.*s", length, is_unknown ? " " : (const char *)c);
        c += length > 0 ? length : 1;
    }
}

/** Put groups as field data called by their names, with tag and dimension, as meshio has them. */
static void put_groups(markup *m) {
    const io_model *model = m->view->model;
    if (model->n_groups == 0)
        return;
    put(m, "<FieldData>\n");
    for (int32_t i = 0; i < model->n_groups; i++) {
        const io_group *group = &model->group[i];
        int32_t before = 0;
        while (before < i && strcmp(model->group[before].name, group->name) != 0)
            before++;
        put(m, "<DataArray type=\"Int32\" Name=\"");
        put_name(m, group->name);
        if (before < i) /* arrays of one name would be one */
            put(m, " %d:%ld", group->dim, (long)group->tag);
        put(m, "\" NumberOfTuples=\"2\" format=\"ascii\">%ld %d</DataArray>\n", (long)group->tag,
            group->dim);
    }
    put(m, "</FieldData>\n");
}

static void put_values(markup *m, const io_view_array *arrays, int n) {
    flush_text(m);
    for (int i = 0; i < n && !m->status; i++) {
        const uint64_t bytes = (uint64_t)bytes_of(&arrays[i]);
        m->status = pl_output_write(m->output, (const char *)&bytes, sizeof bytes, m->error);
        if (!m->status)
            m->status = io_view_write(m->view, &arrays[i], 0, m->output, m->error);
    }
}

int io_view_write_vtu(const io_view *view, pl_output *output, const char **lost,
                      planish_error *error) {
    const io_view_arrays a = io_view_arrays_of(view);
    const io_view_array cells[] = {a.connectivity, a.offsets, a.types};
    markup m = {.view = view, .output = output, .error = error};
    *lost = NULL;
    put(&m,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
        "byte_order=\"%s\" header_type=\"UInt64\">\n<UnstructuredGrid>\n",
        io_machine_is_little() ? "LittleEndian" : "BigEndian");
    put_groups(&m);
    put(&m, "<Piece NumberOfPoints=\"%" PRId64 "\" NumberOfCells=\"%" PRId64 "\">\n",
        view->model->n_nodes, view->n_cells);
    put_section(&m, "PointData", a.point_data, a.n_point_data);
    put_section(&m, "CellData", a.cell_data, a.n_cell_data);
    put_section(&m, "Points", &a.points, 1);
    put_section(&m, "Cells", cells, 3);
    put(&m, "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
    put_values(&m, a.point_data, a.n_point_data);
    put_values(&m, a.cell_data, a.n_cell_data);
    put_values(&m, &a.points, 1);
    put_values(&m, cells, 3);
    put(&m, "\n</AppendedData>\n</VTKFile>\n");
    flush_text(&m);
    return m.status;
}
