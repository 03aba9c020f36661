/* vtk: legacy VTK files, ASCII and binary, versions 1 to 4.2 (CELLS with counts) and 5 (CELLS with
 * OFFSETS and CONNECTIVITY): unstructured grids of tetrahedra or triangles.
 *
 * A point-data array called "fixed" (Mesquite's convention) marks nodes that must not move; arrays
 * of one whole number per cell may tell regions (arrays.h). All other attributes are passed over;
 * the walk ends, without error, at anything unknown behind the mesh. Binary data are big-endian.
 * Cells and points are numbered from 0, as VTK does.
 */
#include "io/core/format.h"
#include "io/vtk/vtk.h"

#include <string.h>

#include "base/memory.h"
#include "io/core/binary.h"

static const vtk_type number_types[] = {
    {"float", VTK_REAL, 4},
    {"double", VTK_REAL, 8},
    {"int", VTK_SIGNED, 4},
    {"vtktypeint64", VTK_SIGNED, 8},
    {"vtktypeint32", VTK_SIGNED, 4},
    {"vtkidtype", VTK_SIGNED, 4}, /* written as int */
    {"char", VTK_SIGNED, 1},
    {"signed_char", VTK_SIGNED, 1},
    {"unsigned_char", VTK_UNSIGNED, 1},
    {"short", VTK_SIGNED, 2},
    {"unsigned_short", VTK_UNSIGNED, 2},
    {"unsigned_int", VTK_UNSIGNED, 4},
    {"long", VTK_SIGNED, 8},
    {"unsigned_long", VTK_UNSIGNED, 8},
    {"vtktypeuint64", VTK_UNSIGNED, 8},
    {"vtktypeuint32", VTK_UNSIGNED, 4},
    {"vtktypeint16", VTK_SIGNED, 2},
    {"vtktypeuint16", VTK_UNSIGNED, 2},
    {"vtktypeint8", VTK_SIGNED, 1},
    {"vtktypeuint8", VTK_UNSIGNED, 1},
    {"bit", VTK_BIT, 0},
    {"string", VTK_STRING, 0},
};

/* ---- words and lines ---------------------------------------------------------------------- */

int vtk_fail_here(const vtk_reader *reader, const char *text) {
    return io_fail_at(reader->model, reader->cursor.at, reader->error, "%s", text);
}

void vtk_end_line(io_cursor *cursor) {
    const char *newline = memchr(cursor->at, '\n', (size_t)io_left(cursor));
    cursor->at = !newline ? cursor->end : newline + 1;
}

int vtk_take_words(io_cursor *cursor, vtk_word *words) {
    io_cursor line = *cursor;
    int n = 0;
    vtk_end_line(cursor);
    line.end = cursor->at;
    while (n < VTK_MAX_WORDS) {
        words[n].at = io_word(&line, &words[n].length);
        if (words[n].length == 0)
            break;
        n++;
    }
    return n;
}

int vtk_word_number(vtk_word text, int64_t *value) {
    io_cursor cursor = {text.at, text.at + text.length};
    return io_integer(&cursor, value);
}

const vtk_type *vtk_find_type(vtk_word name) {
    for (size_t i = 0; i < sizeof number_types / sizeof number_types[0]; i++)
        if (io_word_is(name.at, name.length, number_types[i].name, 1))
            return &number_types[i];
    return NULL;
}

int vtk_take_if(vtk_reader *reader, const char *name) {
    io_cursor ahead = reader->cursor;
    int64_t length;
    const char *at = io_word(&ahead, &length);
    if ((reader->model->is_binary && at != reader->cursor.at) || !io_word_is(at, length, name, 1))
        return 0;
    reader->cursor = ahead;
    return 1;
}

/* ---- header and keywords ------------------------------------------------------------------ */

static int read_dataset(vtk_reader *reader) {
    int64_t length;
    const char *at = io_word(&reader->cursor, &length);
    if (io_word_is(at, length, "UNSTRUCTURED_GRID", 1))
        return 0;
    return io_fail_at(reader->model, at, reader->error,
                      "DATASET is not an UNSTRUCTURED_GRID; convert the file, for instance with "
                      "meshio convert IN.vtk OUT.msh");
}

typedef struct known_keyword {
    const char *name;
    int (*read)(vtk_reader *reader);
} known_keyword;

static const known_keyword keywords[] = {
    {"DATASET", read_dataset},
    {"POINTS", vtk_points},
    {"CELLS", vtk_cells},
    {"CELL_TYPES", vtk_cell_types},
    {"POINT_DATA", vtk_point_data},
    {"CELL_DATA", vtk_cell_data},
    {"SCALARS", vtk_scalars},
    {"VECTORS", vtk_vectors},
    {"NORMALS", vtk_vectors},
    {"TENSORS", vtk_tensors},
    {"TENSORS6", vtk_symmetric_tensors},
    {"TEXTURE_COORDINATES", vtk_texture},
    {"COLOR_SCALARS", vtk_colours},
    {"LOOKUP_TABLE", vtk_lookup_table},
    {"GLOBAL_IDS", vtk_ids},
    {"PEDIGREE_IDS", vtk_ids},
    {"EDGE_FLAGS", vtk_ids},
    {"FIELD", vtk_field},
    {"METADATA", vtk_metadata},
};

static int read_keyword(vtk_reader *reader, const char *at, int64_t length) {
    for (size_t i = 0; i < sizeof keywords / sizeof keywords[0]; i++)
        if (io_word_is(at, length, keywords[i].name, 1))
            return keywords[i].read(reader);
    reader->cursor.at = at;
    return vtk_stop(reader);
}

/** The first three lines: version, title, ASCII or BINARY. */
static int read_header(vtk_reader *reader) {
    int64_t length;
    vtk_end_line(&reader->cursor);
    vtk_end_line(&reader->cursor);
    const char *at = io_word(&reader->cursor, &length);
    reader->model->is_binary = io_word_is(at, length, "BINARY", 1);
    if (!reader->model->is_binary && !io_word_is(at, length, "ASCII", 1))
        return io_fail_at(reader->model, at, reader->error,
                          "ASCII or BINARY expected in the third line");
    vtk_end_line(&reader->cursor);
    return 0;
}

static int read_keywords(vtk_reader *reader) {
    int status = read_header(reader);
    while (!status && !reader->done) {
        int64_t length;
        const char *at = io_word(&reader->cursor, &length);
        if (length == 0)
            break;
        status = read_keyword(reader, at, length);
    }
    if (!status && !reader->have_types)
        return vtk_fail_here(reader, "the file ends before CELL_TYPES (it may be cut short)");
    return status;
}

static int read_vtk(io_model *model, planish_error *error) {
    vtk_reader reader = {.model = model, .error = error, .n_tuples = -1};
    reader.cursor.at = model->input.data;
    reader.cursor.end = model->input.data + model->input.size;
    reader.swapped = io_machine_is_little();
    io_text_init(&reader.text, model);
    model->columns = 3;
    model->first_number = 0;
    int status = read_keywords(&reader);
    vtk_release_lists(&reader);
    io_text_release(&reader.text);
    return status;
}

static int recognise_vtk(const char *data, int64_t size) {
    static const char mark[] = "# vtk DataFile";
    int64_t length = (int64_t)sizeof mark - 1;
    return size >= length && io_word_is(data, length, mark, 1);
}

static const char *const vtk_extensions[] = {".vtk", NULL};

const io_format io_format_vtk = {
    .name = "vtk", .extensions = vtk_extensions, .recognise = recognise_vtk, .read = read_vtk};
