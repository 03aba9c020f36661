/* vtu_xml: the markup of VTK's XML files, by Expat.
 *
 * Expat is given the file in pieces, without the text of data arrays (from behind a start tag to
 * the next '<', where nothing but numbers can be), and nothing of appended data. So gigabytes of
 * numbers are not looked at twice. Document types, and with them entities, are refused.
 */
#include "io/vtk/vtu_parts.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"
#include "io/vtk/vtk_cells.h"

#include <stdio.h>
#include <string.h>

void vtu_document_release(vtu_document *document) {
    for (int64_t i = 0; i < document->n_arrays; i++)
        pl_free(document->array[i].name);
    pl_free(document->piece);
    pl_free(document->array);
    *document = (vtu_document){0};
}

#ifndef PL_EXPAT

int vtu_read_markup(io_model *model, vtu_document *document, planish_error *error) {
    (void)document;
    return pl_fail(error, PLANISH_ERROR_FORMAT,
                   "%s: this planish was built without Expat, which VTK's XML files need: install "
                   "it (Debian, Ubuntu: libexpat1-dev) and build again, or write the mesh as "
                   "legacy .vtk",
                   model->input.path);
}

#else

#include <expat.h>

enum { PIECE_BYTES = 1 << 16 };

/** What element the walk is in. */
typedef enum section { OUTSIDE, POINTS, CELLS, POINT_DATA, CELL_DATA } section;

typedef struct walk {
    XML_Parser parser;
    io_model *model;
    vtu_document *document;
    planish_error *error;
    int status;      /* the first failure, or 0 */
    section section; /* of the piece */
    int in_file, in_piece;
    int array_depth;  /* elements within a DataArray, itself included; 0: in none */
    int64_t text_end; /* of the text that Expat is not given, */
    int64_t skipped;  /* bytes that it was not given until now */
} walk;

/* ---- places and failures ------------------------------------------------------------------- */

/** Where the tag that a handler is called for begins in the file, and behind it. */
static int64_t tag_begin(const walk *w) {
    return XML_GetCurrentByteIndex(w->parser) + w->skipped;
}

static int64_t tag_end(const walk *w) {
    return tag_begin(w) + XML_GetCurrentByteCount(w->parser);
}

/** Stop the walk. */
static void fail(walk *w, int status) {
    w->status = status;
    XML_StopParser(w->parser, XML_FALSE);
}

static void fail_here(walk *w, const char *text) {
    fail(w, io_fail_at(w->model, w->model->input.data + tag_begin(w), w->error, "%s", text));
}

/** The byte of the next '<' from there on, or the end. */
static int64_t next_markup(const walk *w, int64_t from) {
    const io_bytes *input = &w->model->input;
    const char *at =
        from < input->size ? memchr(input->data + from, '<', (size_t)(input->size - from)) : NULL;
    return at ? at - input->data : input->size;
}

/* ---- attributes ---------------------------------------------------------------------------- */

/** The attribute called name, or NULL. */
static const char *attribute(const char **attributes, const char *name) {
    for (int i = 0; attributes[i]; i += 2)
        if (strcmp(attributes[i], name) == 0)
            return attributes[i + 1];
    return NULL;
}

static int same(const char *attribute, const char *text) {
    return attribute && strcmp(attribute, text) == 0;
}

/** A whole number, at least 0, else -1. */
static int64_t number(const char *text) {
    int64_t value;
    io_cursor cursor = {text, text ? text + strlen(text) : text};
    if (!text || io_integer(&cursor, &value))
        return -1;
    io_skip_space(&cursor);
    return cursor.at == cursor.end && value >= 0 ? value : -1;
}

/** Where the value of an attribute stands in the tag that begins at byte begin. Expat has seen that
 *  the tag is well formed. */
static void find_value(const walk *w, const char *name, int64_t *value_begin, int64_t *value_end) {
    const char *data = w->model->input.data;
    const char *at = data + tag_begin(w), *end = data + tag_end(w);
    const size_t length = strlen(name);
    while (at < end) {
        const char *equals = memchr(at, '=', (size_t)(end - at));
        if (!equals)
            break;
        const char *last = equals, *quote = equals + 1;
        while (last > at && (unsigned char)last[-1] <= ' ')
            last--;
        while (quote < end && *quote != '"' && *quote != '\'')
            quote++;
        const char *close = quote < end ? memchr(quote + 1, *quote, (size_t)(end - quote - 1)) : 0;
        if (!close)
            break;
        if (last - at > (int64_t)length && memcmp(last - length, name, length) == 0 &&
            (unsigned char)last[-(int64_t)length - 1] <= ' ') {
            *value_begin = quote + 1 - data;
            *value_end = close - data;
            return;
        }
        at = close + 1;
    }
    *value_begin = *value_end = -1;
}

/* ---- elements ------------------------------------------------------------------------------ */

static void begin_file(walk *w, const char **attributes) {
    static const char *const compressors[] = {"vtkZLibDataCompressor", "vtkLZ4DataCompressor",
                                              "vtkLZMADataCompressor"};
    static const char *const libraries[] = {"zlib", "LZ4", "LZMA"};
    const char *compressor = attribute(attributes, "compressor");
    const char *order = attribute(attributes, "byte_order");
    const char *header = attribute(attributes, "header_type");
    vtu_document *document = w->document;
    if (!same(attribute(attributes, "type"), "UnstructuredGrid")) {
        fail_here(w, "type is not UnstructuredGrid: other VTK files (surfaces, structured grids, "
                     "lists of pieces) are not read; write the mesh as one .vtu");
        return;
    }
    w->in_file = 1;
    document->swapped = same(order, "BigEndian") == io_machine_is_little();
    document->header_size = same(header, "UInt64") ? 8 : 4;
    if ((order && !same(order, "BigEndian") && !same(order, "LittleEndian")) ||
        (header && !same(header, "UInt32") && !same(header, "UInt64"))) {
        fail_here(w, "byte_order must be LittleEndian or BigEndian, header_type UInt32 or UInt64");
        return;
    }
    for (int i = 0; i < 3; i++)
        if (same(compressor, compressors[i]))
            document->compression = (io_compression)(IO_ZLIB + i);
    if (compressor && *compressor && document->compression == IO_PLAIN) {
        fail_here(w, "this compressor is unknown; there are vtkZLibDataCompressor, "
                     "vtkLZ4DataCompressor and vtkLZMADataCompressor");
    } else if (!io_compression_is_built(document->compression)) {
        char text[160];
        snprintf(text, sizeof text,
                 "packed by %s, without which this planish was built; write the file without "
                 "compression, or build planish with it",
                 libraries[document->compression - IO_ZLIB]);
        fail_here(w, text);
    }
}

static void begin_piece(walk *w, const char **attributes) {
    vtu_document *document = w->document;
    vtu_piece piece = {number(attribute(attributes, "NumberOfPoints")),
                       number(attribute(attributes, "NumberOfCells")), 0, 0, document->n_arrays};
    if (piece.n_points < 0 || piece.n_cells < 0 || piece.n_points > INT32_MAX ||
        piece.n_cells > INT32_MAX) {
        fail_here(w, "NumberOfPoints and NumberOfCells must be whole numbers below 2^31");
        return;
    }
    if (document->n_pieces > 0) {
        const vtu_piece *before = &document->piece[document->n_pieces - 1];
        piece.first_point = before->first_point + before->n_points;
        piece.first_cell = before->first_cell + before->n_cells;
    }
    vtu_piece *grown = pl_grow(document->piece, document->n_pieces, document->n_pieces + 1,
                               &document->piece_capacity, sizeof *grown);
    if (!grown || document->n_pieces == INT32_MAX) {
        fail(w, pl_fail_memory(w->error, "the pieces of the file"));
        return;
    }
    document->piece = grown;
    document->piece[document->n_pieces++] = piece;
    w->in_piece = 1;
}

static vtu_role role_of(const walk *w, const char *name) {
    static const char *const of_cells[] = {"connectivity",
                                           "offsets",
                                           "types",
                                           "faces",
                                           "faceoffsets",
                                           "polyhedron_offsets",
                                           "polyhedron_to_faces",
                                           "face_offsets",
                                           "face_connectivity"};
    switch (w->section) {
    case POINTS:
        return VTU_POINTS;
    case CELLS:
        for (int i = 0; i < (int)(sizeof of_cells / sizeof *of_cells); i++)
            if (same(name, of_cells[i]))
                return (vtu_role)(VTU_CONNECTIVITY + i);
        return VTU_OTHER;
    case POINT_DATA:
        return same(name, "fixed") ? VTU_FIXED : VTU_OTHER;
    case CELL_DATA:
        return name ? VTU_CELL_DATA : VTU_OTHER;
    default:
        return VTU_OTHER;
    }
}

static const vtk_type *type_of(const char *name) {
    static const struct {
        const char *name;
        vtk_type type;
    } types[] = {{"Float32", {"Float32", VTK_REAL, 4}},   {"Float64", {"Float64", VTK_REAL, 8}},
                 {"Int64", {"Int64", VTK_SIGNED, 8}},     {"Int32", {"Int32", VTK_SIGNED, 4}},
                 {"UInt8", {"UInt8", VTK_UNSIGNED, 1}},   {"Int8", {"Int8", VTK_SIGNED, 1}},
                 {"UInt64", {"UInt64", VTK_UNSIGNED, 8}}, {"UInt32", {"UInt32", VTK_UNSIGNED, 4}},
                 {"UInt16", {"UInt16", VTK_UNSIGNED, 2}}, {"Int16", {"Int16", VTK_SIGNED, 2}}};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (same(name, types[i].name))
            return &types[i].type;
    return NULL;
}

/** Where its numbers are. */
static int place_array(walk *w, vtu_array *array, const char **attributes) {
    const char *form = attribute(attributes, "format");
    array->tag = tag_begin(w);
    if (same(form, "appended")) {
        array->is_appended = 1;
        array->offset = number(attribute(attributes, "offset"));
        find_value(w, "offset", &array->offset_begin, &array->offset_end);
        if (array->offset < 0 || array->offset_begin < 0) {
            fail_here(w, "offset must be a whole number");
            return -1;
        }
        return 0;
    }
    if (form && !same(form, "ascii") && !same(form, "binary")) {
        fail_here(w, "format must be ascii, binary or appended");
        return -1;
    }
    array->form = same(form, "binary") ? VTU_BASE64 : VTU_ASCII;
    array->begin = tag_end(w);
    array->end = w->text_end = next_markup(w, array->begin);
    return 0;
}

static void begin_array(walk *w, const char **attributes) {
    vtu_document *document = w->document;
    const char *components = attribute(attributes, "NumberOfComponents");
    vtu_array array = {.piece = w->in_piece ? (int)document->n_pieces - 1 : -1};
    array.role = role_of(w, attribute(attributes, "Name"));
    array.type = type_of(attribute(attributes, "type"));
    array.n_components = components ? number(components) : 1;
    if (place_array(w, &array, attributes))
        return;
    if (array.role == VTU_CELL_DATA)
        array.name = pl_copy_text(attribute(attributes, "Name"));
    vtu_array *grown = pl_grow(document->array, document->n_arrays, document->n_arrays + 1,
                               &document->array_capacity, sizeof *grown);
    if (grown)
        document->array = grown;
    if (!grown || (array.role == VTU_CELL_DATA && !array.name)) {
        pl_free(array.name);
        fail(w, pl_fail_memory(w->error, "the arrays of the file"));
        return;
    }
    document->array[document->n_arrays++] = array;
}

/** Data follow its first underscore; Expat is given nothing more. */
static void begin_appended(walk *w, const char **attributes) {
    const io_bytes *input = &w->model->input;
    int64_t at = tag_end(w);
    while (at < input->size && (unsigned char)input->data[at] <= ' ')
        at++;
    if (at == input->size || input->data[at] != '_') {
        fail_here(w, "appended data must begin with '_' (the file may be cut short)");
        return;
    }
    w->document->appended = at + 1;
    w->document->appended_form =
        same(attribute(attributes, "encoding"), "base64") ? VTU_BASE64 : VTU_RAW;
    XML_StopParser(w->parser, XML_FALSE);
}

/** An element within VTKFile. */
static void begin_element(walk *w, const char *name, const char **attributes) {
    static const struct {
        const char *name;
        section section;
    } sections[] = {
        {"Points", POINTS}, {"Cells", CELLS}, {"PointData", POINT_DATA}, {"CellData", CELL_DATA}};
    if (same(name, "UnstructuredGrid"))
        w->document->is_grid = 1;
    else if (same(name, "Piece"))
        begin_piece(w, attributes);
    else if (same(name, "AppendedData"))
        begin_appended(w, attributes);
    else if (same(name, "DataArray") || same(name, "Array"))
        begin_array(w, attributes);
    for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
        if (w->in_piece && same(name, sections[i].name))
            w->section = sections[i].section;
}

static void XMLCALL on_start(void *data, const char *name, const char **attributes) {
    walk *w = data;
    if (w->status)
        return;
    if (w->array_depth > 0) {
        w->array_depth++;
        return;
    }
    if (w->in_file)
        begin_element(w, name, attributes);
    else if (same(name, "VTKFile"))
        begin_file(w, attributes);
    else
        fail_here(w, "VTKFile expected: this is no VTK file");
    if (!w->status && (same(name, "DataArray") || same(name, "Array")))
        w->array_depth = 1;
}

/** Whether there is nothing but white space in the text of the last array. */
static int is_blank(const walk *w, const vtu_array *array) {
    const char *data = w->model->input.data;
    int64_t at = array->begin;
    while (at < array->end && (unsigned char)data[at] <= ' ')
        at++;
    return at == array->end;
}

static void XMLCALL on_end(void *data, const char *name) {
    walk *w = data;
    if (w->status)
        return;
    if (w->array_depth > 0) {
        vtu_array *array = &w->document->array[w->document->n_arrays - 1];
        w->array_depth--;
        /* Keys may stand before the numbers. */
        if (w->array_depth > 0 && !array->is_appended && is_blank(w, array)) {
            array->begin = tag_end(w);
            array->end = w->text_end = next_markup(w, array->begin);
        }
        return;
    }
    if (same(name, "Piece"))
        w->in_piece = 0;
    if (same(name, "Piece") || same(name, "Points") || same(name, "Cells") ||
        same(name, "PointData") || same(name, "CellData"))
        w->section = OUTSIDE;
}

static void XMLCALL on_doctype(void *data, const char *name, const char *system, const char *public,
                               int has_subset) {
    walk *w = data;
    (void)name;
    (void)system;
    (void)public;
    (void)has_subset;
    fail_here(w, "a document type is declared; VTK files have none, and its entities are not read");
}

/* ---- the walk ------------------------------------------------------------------------------ */

/** What Expat found wrong. */
static int fail_xml(walk *w) {
    const enum XML_Error code = XML_GetErrorCode(w->parser);
    if (code == XML_ERROR_NO_MEMORY)
        return pl_fail_memory(w->error, "the markup of the file");
    int64_t at = XML_GetCurrentByteIndex(w->parser) + w->skipped;
    if (at < 0 || at > w->model->input.size)
        at = w->model->input.size;
    return io_fail_at(w->model, w->model->input.data + at, w->error,
                      "XML: %s (the file may be cut short)", XML_ErrorString(code));
}

/** Expat looks at bytes more than once: it is given a copy, which cannot change meanwhile. */
static enum XML_Status parse_copy(const walk *w, const char *bytes, int size, int is_last) {
    if (size == 0)
        return XML_Parse(w->parser, bytes, 0, is_last);
    void *copy = XML_GetBuffer(w->parser, size);
    if (!copy)
        return XML_STATUS_ERROR;
    memcpy(copy, bytes, (size_t)size);
    return XML_ParseBuffer(w->parser, size, is_last);
}

/** Give Expat the file up to appended data. */
static int feed(walk *w) {
    const io_bytes *input = &w->model->input;
    int64_t at = 0;
    while (!w->status && w->document->appended < 0) {
        if (at < w->text_end) {
            w->skipped += w->text_end - at;
            at = w->text_end;
        }
        const int64_t left = input->size - at;
        const int size = left < PIECE_BYTES ? (int)left : PIECE_BYTES;
        const enum XML_Status status = parse_copy(w, input->data + at, size, size == left);
        if (status != XML_STATUS_OK && !w->status && w->document->appended < 0)
            return fail_xml(w);
        at += size;
        if (size == left)
            break;
    }
    return w->status;
}

int vtu_read_markup(io_model *model, vtu_document *document, planish_error *error) {
    walk w = {.model = model, .document = document, .error = error};
    document->appended = -1;
    w.parser = XML_ParserCreate(NULL);
    if (!w.parser)
        return pl_fail_memory(error, "the markup of the file");
    XML_SetUserData(w.parser, &w);
    XML_SetElementHandler(w.parser, on_start, on_end);
    XML_SetStartDoctypeDeclHandler(w.parser, on_doctype);
    int status = feed(&w);
    XML_ParserFree(w.parser);
    if (!status && !document->is_grid)
        status = io_fail_at(model, model->input.data + model->input.size, error,
                            "there is no UnstructuredGrid (the file may be cut short)");
    for (int64_t i = 0; i < document->n_arrays && !status; i++) {
        vtu_array *array = &document->array[i];
        if (!array->is_appended)
            continue;
        array->form = document->appended_form;
        array->begin = document->appended + array->offset;
        array->end = model->input.size;
        /* What is not used may be nowhere. */
        if (document->appended < 0 || array->offset > model->input.size - document->appended)
            array->begin = array->end;
    }
    return status;
}

#endif
