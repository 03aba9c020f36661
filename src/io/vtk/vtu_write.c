/* vtu_write: a mesh as VTK's XML file: raw appended data, not packed, and the names of groups as
 * strings of the field data.
 */
#include "io/vtk/vtk_arrays.h"
#include "io/vtk/vtk_write.h"
#include "io/vtk/vtu_groups.h"

#include "base/memory.h"
#include "io/core/binary.h"

#include <inttypes.h>
#include <string.h>

/** Markup under way. */
typedef struct markup {
    const io_view *view;
    io_writer writer;
    int64_t offset; /* of the next array in the appended data */
} markup;

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
static void put_name(io_writer *writer, const char *name) {
    static const char special[] = "\"<>&", *const texts[] = {"&quot;", "&lt;", "&gt;", "&amp;"};
    const unsigned char *c = (const unsigned char *)name;
    while (*c) {
        const int length = utf8_length(c);
        const char *found = strchr(special, *c);
        /* XML knows no control characters, and not U+FFFE and U+FFFF. */
        const int is_unknown =
            *c < ' ' || (length == 3 && c[0] == 0xEF && c[1] == 0xBF && (c[2] & 0xFE) == 0xBE);
        if (found)
            io_put_text(writer, texts[found - special]);
        else if (length == 0)
            io_put_format(writer, "%c%c", 0xC0 | *c >> 6, 0x80 | (*c & 0x3F));
        else
            io_put_format(writer, "%.*s", length, is_unknown ? " " : (const char *)c);
        c += length > 0 ? length : 1;
    }
}

/** Put groups as field data called by their names, with tag and dimension, as meshio has them. */
static void put_groups(markup *m, const vtu_groups *groups) {
    const io_model *model = m->view->model;
    io_writer *writer = &m->writer;
    if (model->n_groups == 0)
        return;
    io_put_text(writer, "<FieldData>\n");
    for (int32_t i = 0; i < model->n_groups; i++) {
        const io_group *group = &model->group[i];
        if (groups->one[i] != i)
            continue;
        io_put_text(writer, "<DataArray type=\"Int32\" Name=\"");
        put_name(writer, group->name);
        if (groups->first[i] < i) /* arrays of one name would be one */
            io_put_format(writer, " %d:%ld", group->dim, (long)group->tag);
        io_put_format(writer, "\" NumberOfTuples=\"2\" format=\"ascii\">%ld %d</DataArray>\n",
                      (long)group->tag, group->dim);
    }
    io_put_text(writer, "</FieldData>\n");
}

static void put_section(markup *m, const char *name, const vtk_out_array *arrays, int n) {
    static const char *const types[] = {"UInt8", "Int32", "Int64", "Float32", "Float64"};
    io_put_format(&m->writer, "<%s>\n", name);
    for (int i = 0; i < n; i++) {
        io_put_format(&m->writer, "<DataArray type=\"%s\" Name=\"", types[arrays[i].type]);
        put_name(&m->writer, arrays[i].name);
        io_put_format(&m->writer,
                      "\" NumberOfComponents=\"%d\" format=\"appended\" offset=\"%" PRId64 "\"/>\n",
                      arrays[i].width, m->offset);
        m->offset += (int64_t)sizeof(uint64_t) + vtk_array_bytes(&arrays[i]);
    }
    io_put_format(&m->writer, "</%s>\n", name);
}

static void put_values(markup *m, const vtk_out_array *arrays, int n) {
    for (int i = 0; i < n; i++) {
        const uint64_t bytes = (uint64_t)vtk_array_bytes(&arrays[i]);
        io_put_bytes(&m->writer, &bytes, sizeof bytes);
        vtk_put_array(&m->writer, m->view, &arrays[i], 0);
    }
}

static void put_mesh(markup *m, const vtu_groups *groups, const vtk_out_arrays *a) {
    const vtk_out_array cells[] = {a->connectivity, a->offsets, a->types};
    io_put_format(&m->writer,
                  "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
                  "byte_order=\"%s\" header_type=\"UInt64\">\n<UnstructuredGrid>\n",
                  io_machine_is_little() ? "LittleEndian" : "BigEndian");
    put_groups(m, groups);
    io_put_format(&m->writer,
                  "<Piece NumberOfPoints=\"%" PRId64 "\" NumberOfCells=\"%" PRId64 "\">\n",
                  m->view->model->n_nodes, m->view->n_cells);
    put_section(m, "PointData", a->point_data, a->n_point_data);
    put_section(m, "CellData", a->cell_data, a->n_cell_data);
    put_section(m, "Points", &a->points, 1);
    put_section(m, "Cells", cells, 3);
    io_put_text(&m->writer, "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
    put_values(m, a->point_data, a->n_point_data);
    put_values(m, a->cell_data, a->n_cell_data);
    put_values(m, &a->points, 1);
    put_values(m, cells, 3);
    io_put_text(&m->writer, "\n</AppendedData>\n</VTKFile>\n");
}

int vtu_write(const io_view *view, pl_output *output, io_losses *losses, planish_error *error) {
    vtk_out_arrays a;
    vtu_groups groups = {.first = NULL};
    markup m = {.view = view};
    int status = vtk_arrays_begin(view, losses, &a, error);
    if (!status)
        status = vtu_groups_make(view, vtk_arrays_can_have_groups(&a), &groups, error);
    io_writer_begin(&m.writer, output, error);
    if (!status) {
        if (groups.has_joined)
            vtk_arrays_set_groups(view, groups.number, &a);
        put_mesh(&m, &groups, &a);
        vtu_groups_lose(view, &groups, losses);
    }
    vtu_groups_release(&groups);
    vtk_arrays_end(&a);
    return io_writer_end(&m.writer) ? m.writer.status : status;
}
