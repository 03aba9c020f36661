/* vtu_builder: a small mesh in every encoding of VTU. */
#include "support/vtu_builder.h"

#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/base64.h"

const double vtu_points[N_NODES][3] = {{0, 0, 0}, {1, 0, 0},         {0, 1, 0},
                                       {0, 0, 1}, {0.1, 0.125, 0.2}, {5, 5, 5}};
const int vtu_cells[N_CELLS][4] = {{0, 1, -1, -1}, {0, 1, 2, 4}, {0, 1, 2, -1},
                                   {0, 1, 3, 4},   {0, 2, 3, 4}, {1, 2, 3, 4}};
const int vtu_types[N_CELLS] = {3, 10, 5, 10, 10, 10};
const int vtu_regions[N_CELLS] = {1, 7, 2, 7, 8, 8};

void vtu_make_arrays(const variant *v, array a[N_ARRAYS]) {
    memset(a, 0, N_ARRAYS * sizeof *a);
    a[0] = (array){"PointData", "fixed", "UInt8", 1, 0, N_NODES, {0, 0, 0, 1}};
    a[1] = (array){.section = "Points",
                   .name = "Points",
                   .type = v->is_float ? "Float32" : "Float64",
                   .size = v->is_float ? 4 : 8,
                   .is_real = 1,
                   .n = 3 * N_NODES};
    memcpy(a[1].value, vtu_points, sizeof vtu_points);
    a[2] = (array){"Cells", "connectivity", "Int64", 8, 0, 0, {0}};
    a[3] = (array){"Cells", "offsets", "Int32", 4, 0, N_CELLS, {0}};
    a[4] = (array){"Cells", "types", "UInt8", 1, 0, N_CELLS, {0}};
    a[5] = (array){"CellData", "material", "Int16", 2, 0, N_CELLS, {0}};
    a[6] = (array){"CellData", "region", "Float64", 8, 1, N_CELLS, {0}};
    a[7] = (array){"PointData", "size", "Float32", 4, 1, N_NODES, {0.5, 1, 1.5, 2, 2.5, 3}};
    for (int c = 0; c < N_CELLS; c++) {
        for (int k = 0; k < 4 && vtu_cells[c][k] >= 0; k++)
            a[2].value[a[2].n++] = vtu_cells[c][k];
        a[3].value[c] = a[2].n;
        a[4].value[c] = vtu_types[c];
        a[5].value[c] = c;
        a[6].value[c] = vtu_regions[c];
    }
    for (int i = 0; i < N_ARRAYS; i++)
        for (int k = 0; k < v->surplus; k++)
            a[i].value[a[i].n++] = 77 + k;
}

void vtu_put_values(file_builder *f, const array *a) {
    for (int i = 0; i < a->n; i++)
        if (a->is_real)
            builder_real(f, a->value[i], a->size);
        else
            builder_integer(f, (int64_t)a->value[i], a->size);
}

void vtu_put_bytes(file_builder *f, const char *data, int64_t n) {
    const int binary = f->binary;
    f->binary = 1;
    for (int64_t i = 0; i < n; i++)
        builder_integer(f, data[i], 1);
    f->binary = binary;
}

file_builder vtu_encode_array(const variant *v, const array *a, int64_t *header) {
    file_builder values = {.binary = 1, .swapped = io_machine_is_little() == v->is_big};
    file_builder out = {.binary = 1, .swapped = values.swapped};
    vtu_put_values(&values, a);
    if (v->compression == IO_PLAIN) {
        builder_integer(&out, values.size, v->header_size);
        *header = out.size;
        vtu_put_bytes(&out, values.data, values.size);
    } else {
        char packed[1 << 14];
        const int64_t n = (values.size + v->block - 1) / v->block;
        int64_t size[1 << 9], total = 0;
        for (int64_t i = 0; i < n; i++) {
            const int64_t left = values.size - i * v->block;
            size[i] = io_pack(v->compression, values.data + i * v->block,
                              left < v->block ? left : v->block, "\x78\x9c", packed + total);
            assert_true(size[i] > 0);
            total += size[i];
        }
        builder_integer(&out, n, v->header_size);
        builder_integer(&out, v->block, v->header_size);
        const int64_t last = values.size % v->block;
        builder_integer(&out, last == 0 && v->tells_whole ? v->block : last, v->header_size);
        for (int64_t i = 0; i < n; i++)
            builder_integer(&out, size[i], v->header_size);
        *header = out.size;
        vtu_put_bytes(&out, packed, total);
    }
    builder_release(&values);
    return out;
}

file_builder vtu_written(const variant *v, const array *a) {
    int64_t header;
    if (v->form == ASCII) {
        file_builder text = {0};
        vtu_put_values(&text, a);
        return text;
    }
    file_builder bytes = vtu_encode_array(v, a, &header);
    if (v->form == APPENDED_RAW)
        return bytes;
    /* Packed arrays have their header apart. */
    if (v->compression == IO_PLAIN)
        header = 0;
    file_builder text = {0};
    char *out = malloc((size_t)(pl_base64_length(header) + pl_base64_length(bytes.size)) + 1);
    int64_t length = pl_base64_write(bytes.data, header, out);
    length += pl_base64_write(bytes.data + header, bytes.size - header, out + length);
    vtu_put_bytes(&text, out, length);
    free(out);
    builder_release(&bytes);
    return text;
}

int vtu_is_appended(const variant *v) {
    return v->form >= APPENDED_RAW;
}

static const char *compressor(const variant *v) {
    static const char *const names[] = {"", " compressor=\"vtkZLibDataCompressor\"",
                                        " compressor='vtkLZ4DataCompressor'",
                                        " compressor = \"vtkLZMADataCompressor\""};
    return names[v->compression];
}

file_builder vtu_make_file(const variant *v) {
    static const char key[] = "<InformationKey name=\"x\"><Value index=\"0\">1</Value>"
                              "</InformationKey>\n";
    array a[N_ARRAYS];
    file_builder f = {0}, data = {0};
    vtu_make_arrays(v, a);
    builder_text(
        &f,
        "<?xml version=\"1.0\"?>\n<!-- <DataArray offset=\"7\"> -->\n<VTKFile "
        "type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"%s\" header_type=\"%s\"%s>\n",
        v->is_big ? "BigEndian" : "LittleEndian", v->header_size == 8 ? "UInt64" : "UInt32",
        compressor(v));
    builder_text(&f, "<UnstructuredGrid><Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n",
                 N_NODES, N_CELLS);
    for (int i = 0; i < N_ARRAYS; i++) {
        file_builder values = vtu_written(v, &a[i]);
        builder_text(&f, "<%s><DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" ",
                     a[i].section, a[i].type, a[i].name, i == 1 ? 3 : 1);
        if (vtu_is_appended(v)) {
            builder_text(&f,
                         "RangeMin=\"a 'b' offset=0\" format='appended' offset=\"%" PRId64
                         "%s\"></DataArray>",
                         data.size, i == 6 ? "    " : "");
            vtu_put_bytes(&data, values.data, values.size);
        } else {
            builder_text(&f, "format=\"%s\">\n", v->form == ASCII ? "ascii" : "binary");
            if (v->keys == 1)
                builder_text(&f, key);
            vtu_put_bytes(&f, values.data, values.size);
            if (v->keys == 2)
                builder_text(&f, key);
            builder_text(&f, "</DataArray>");
        }
        builder_text(&f, "</%s>\n", a[i].section);
        builder_release(&values);
    }
    builder_text(&f, "</Piece></UnstructuredGrid>\n");
    if (vtu_is_appended(v)) {
        builder_text(&f, "<AppendedData encoding=\"%s\">\n  _",
                     v->form == APPENDED_RAW ? "raw" : "base64");
        vtu_put_bytes(&f, data.data, data.size);
        builder_text(&f, "\n</AppendedData>\n");
    }
    builder_text(&f, "</VTKFile>\n");
    builder_release(&data);
    return f;
}
