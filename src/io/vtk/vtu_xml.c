/* vtu_xml: the markup of VTK's XML files, by Expat.
 *
 * Expat is given the file in pieces, without the text of data arrays (from behind a start tag to
 * the next '<', where nothing but numbers can be), and nothing of appended data. So gigabytes of
 * numbers are not looked at twice. Document types, and with them entities, are refused.
 */
#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"
#include "io/vtk/vtu_parts.h"

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

int vtu_read_markup(vtu_document *document) {
    return pl_fail(document->error, PLANISH_ERROR_FORMAT,
                   "%s: this planish was built without Expat, which VTK's XML files need: install "
                   "it (Debian, Ubuntu: libexpat1-dev) and build again, or write the mesh as "
                   "legacy .vtk",
                   document->model->input.path);
}

#else

#include <expat.h>

enum { PIECE_BYTES = 1 << 16 };

/** Elements of a piece that have arrays. */
typedef enum vtu_section { OUTSIDE, POINTS, CELLS, POINT_DATA, CELL_DATA, N_SECTIONS } vtu_section;

static const char *const section_names[N_SECTIONS] = {"", "Points", "Cells", "PointData",
                                                      "CellData"};

/** The state of a walk over the markup. */
typedef struct xml_walk {
    XML_Parser parser;
    vtu_document *document;
    const io_bytes *input;
    int status;              /* the first failure, or 0 */
    vtu_section section;     /* of the piece */
    const char **attributes; /* of the element that begins: name, value, ..., NULL */
    int in_file, in_piece;
    int array_depth;  /* elements within a DataArray, itself included; 0: in none */
    int64_t text_end; /* of the text that Expat is not given, */
    int64_t skipped;  /* bytes that it was not given until now */
} xml_walk;

/* ---- places and failures ------------------------------------------------------------------- */

/** Byte of the file where the tag begins that a handler is called for, and behind it. */
static int64_t tag_begin(const xml_walk *w) {
    return XML_GetCurrentByteIndex(w->parser) + w->skipped;
}

static int64_t tag_end(const xml_walk *w) {
    return tag_begin(w) + XML_GetCurrentByteCount(w->parser);
}

/** Fail at the tag. */
static int fail_here(const xml_walk *w, const char *text) {
    return io_fail_at(w->document->model, w->input->data + tag_begin(w), w->document->error, "%s",
                      text);
}

/** Let the text of an array run from here, behind a tag, to the next '<' or the end. */
static void take_text(xml_walk *w, vtu_array *array) {
    const io_bytes *input = w->input;
    array->begin = tag_end(w);
    const char *at = array->begin < input->size ? memchr(input->data + array->begin, '<',
                                                         (size_t)(input->size - array->begin))
                                                : NULL;
    array->end = w->text_end = at ? at - input->data : input->size;
}

/** Skip control characters and blanks from byte at on. */
static int64_t skip_blank(const xml_walk *w, int64_t at, int64_t end) {
    while (at < end && (unsigned char)w->input->data[at] <= ' ')
        at++;
    return at;
}

/* ---- attributes ---------------------------------------------------------------------------- */

/** Return the attribute called name, or NULL. */
static const char *attribute(const xml_walk *w, const char *name) {
    for (int i = 0; w->attributes[i]; i += 2)
        if (strcmp(w->attributes[i], name) == 0)
            return w->attributes[i + 1];
    return NULL;
}

static int same(const char *a, const char *b) {
    return a && strcmp(a, b) == 0;
}

/** Return the whole number that text is, at least 0, else -1. */
static int64_t number(const char *text) {
    int64_t value;
    io_cursor cursor = {text, text ? text + strlen(text) : text};
    if (!text || io_integer(&cursor, &value))
        return -1;
    io_skip_space(&cursor);
    return cursor.at == cursor.end && value >= 0 ? value : -1;
}

/** Find where the value of the attribute stands in the tag; -1: nowhere. Expat has seen that the
 *  tag is well formed. */
static void find_value(const xml_walk *w, const char *name, int64_t *value_begin,
                       int64_t *value_end) {
    const char *data = w->input->data;
    const char *at = data + tag_begin(w), *end = data + tag_end(w);
    const size_t length = strlen(name);
    *value_begin = *value_end = -1;
    while (at < end) {
        const char *equals = memchr(at, '=', (size_t)(end - at));
        if (!equals)
            return;
        const char *last = equals, *quote = equals + 1;
        while (last > at && (unsigned char)last[-1] <= ' ')
            last--;
        while (quote < end && *quote != '"' && *quote != '\'')
            quote++;
        const char *close = quote < end ? memchr(quote + 1, *quote, (size_t)(end - quote - 1)) : 0;
        if (!close)
            return;
        if (last - at > (int64_t)length && memcmp(last - length, name, length) == 0 &&
            (unsigned char)last[-(int64_t)length - 1] <= ' ') {
            *value_begin = quote + 1 - data;
            *value_end = close - data;
            return;
        }
        at = close + 1;
    }
}

/* ---- elements ------------------------------------------------------------------------------ */

/* Functions of elements that begin return a status; not 0 stops the walk. */

static int begin_file(xml_walk *w) {
    static const struct {
        const char *compressor, *library;
        io_compression compression;
    } packed[] = {{"vtkZLibDataCompressor", "zlib", IO_ZLIB},
                  {"vtkLZ4DataCompressor", "LZ4", IO_LZ4},
                  {"vtkLZMADataCompressor", "LZMA", IO_LZMA}};
    const char *compressor = attribute(w, "compressor");
    const char *order = attribute(w, "byte_order"), *header = attribute(w, "header_type");
    vtu_document *document = w->document;
    if (!same(attribute(w, "type"), "UnstructuredGrid"))
        return fail_here(w, "type is not UnstructuredGrid: other VTK files (surfaces, structured "
                            "grids, lists of pieces) are not read; write the mesh as one .vtu");
    w->in_file = 1;
    document->swapped = same(order, "BigEndian") == io_machine_is_little();
    document->header_size = same(header, "UInt64") ? 8 : 4;
    if ((order && !same(order, "BigEndian") && !same(order, "LittleEndian")) ||
        (header && !same(header, "UInt32") && !same(header, "UInt64")))
        return fail_here(w, "byte_order must be LittleEndian or BigEndian, header_type UInt32 or "
                            "UInt64");
    for (int i = 0; i < 3; i++) {
        if (!same(compressor, packed[i].compressor))
            continue;
        document->compression = packed[i].compression;
        if (io_compression_is_built(document->compression))
            return PLANISH_OK;
        char text[160];
        snprintf(text, sizeof text,
                 "packed by %s, without which this planish was built; write the file without "
                 "compression, or build planish with it",
                 packed[i].library);
        return fail_here(w, text);
    }
    if (compressor && *compressor)
        return fail_here(w, "this compressor is unknown; there are vtkZLibDataCompressor, "
                            "vtkLZ4DataCompressor and vtkLZMADataCompressor");
    return PLANISH_OK;
}

static int begin_piece(xml_walk *w) {
    vtu_document *document = w->document;
    vtu_piece piece = {number(attribute(w, "NumberOfPoints")),
                       number(attribute(w, "NumberOfCells")), 0, 0, document->n_arrays};
    if (piece.n_points < 0 || piece.n_cells < 0 || piece.n_points > INT32_MAX ||
        piece.n_cells > INT32_MAX)
        return fail_here(w, "NumberOfPoints and NumberOfCells must be whole numbers below 2^31");
    if (document->n_pieces > 0) {
        const vtu_piece *before = &document->piece[document->n_pieces - 1];
        piece.first_point = before->first_point + before->n_points;
        piece.first_cell = before->first_cell + before->n_cells;
    }
    w->in_piece = 1;
    return document->n_pieces < INT32_MAX &&
                   pl_append(&document->piece, &document->n_pieces, &document->piece_capacity,
                             &piece, sizeof piece)
               ? PLANISH_OK
               : pl_fail_memory(document->error, "the pieces of the file");
}

static vtu_role role_of(const xml_walk *w, const char *name) {
    int role = VTU_CONNECTIVITY;
    switch (w->section) {
    case POINTS:
        return VTU_POINTS;
    case CELLS:
        while (role <= VTU_FACE_NODES && !same(name, vtu_role_names[role]))
            role++;
        return role <= VTU_FACE_NODES ? (vtu_role)role : VTU_OTHER;
    case POINT_DATA:
        return same(name, "fixed") ? VTU_FIXED : name ? VTU_POINT_DATA : VTU_OTHER;
    case CELL_DATA:
        return name ? VTU_CELL_DATA : VTU_OTHER;
    default:
        return VTU_OTHER;
    }
}

static int begin_array(xml_walk *w) {
    vtu_document *document = w->document;
    const char *components = attribute(w, "NumberOfComponents"), *name = attribute(w, "Name");
    const char *type = attribute(w, "type"), *form = attribute(w, "format");
    vtu_array array = {.role = role_of(w, name),
                       .piece = w->in_piece ? (int)document->n_pieces - 1 : -1,
                       .n_components = components ? number(components) : 1,
                       .tag = tag_begin(w)};
    if (type)
        array.type = vtk_find_xml_type((io_slice){type, type + strlen(type)});
    if (same(form, "appended")) {
        array.is_appended = 1;
        array.offset = number(attribute(w, "offset"));
        find_value(w, "offset", &array.offset_begin, &array.offset_end);
        if (array.offset < 0 || array.offset_begin < 0)
            return fail_here(w, "offset must be a whole number");
    } else if (!form || same(form, "ascii") || same(form, "binary")) {
        array.form = same(form, "binary") ? VTU_BASE64 : VTU_ASCII;
        take_text(w, &array);
    } else {
        return fail_here(w, "format must be ascii, binary or appended");
    }
    const int is_data = array.role == VTU_POINT_DATA || array.role == VTU_CELL_DATA;
    if (is_data)
        array.name = pl_copy_text(name);
    w->array_depth = 1;
    if ((!is_data || array.name) && pl_append(&document->array, &document->n_arrays,
                                              &document->array_capacity, &array, sizeof array))
        return PLANISH_OK;
    pl_free(array.name);
    return pl_fail_memory(document->error, "the arrays of the file");
}

/** Data follow its first underscore; Expat is given nothing more. */
static int begin_appended(xml_walk *w) {
    const int64_t at = skip_blank(w, tag_end(w), w->input->size);
    if (at == w->input->size || w->input->data[at] != '_')
        return fail_here(w, "appended data must begin with '_' (the file may be cut short)");
    w->document->appended = at + 1;
    w->document->appended_form = same(attribute(w, "encoding"), "base64") ? VTU_BASE64 : VTU_RAW;
    XML_StopParser(w->parser, XML_FALSE);
    return PLANISH_OK;
}

static void XMLCALL on_start(void *data, const char *name, const char **attributes) {
    xml_walk *w = data;
    if (w->status)
        return;
    if (w->array_depth > 0) {
        w->array_depth++;
        return;
    }
    w->attributes = attributes;
    if (!w->in_file)
        w->status = same(name, "VTKFile") ? begin_file(w)
                                          : fail_here(w, "VTKFile expected: this is no VTK file");
    else if (same(name, "UnstructuredGrid"))
        w->document->is_grid = 1;
    else if (same(name, "Piece"))
        w->status = begin_piece(w);
    else if (same(name, "AppendedData"))
        w->status = begin_appended(w);
    else if (same(name, "DataArray") || same(name, "Array"))
        w->status = begin_array(w);
    if (w->status)
        XML_StopParser(w->parser, XML_FALSE);
    for (int i = POINTS; i < N_SECTIONS && w->in_piece; i++)
        if (same(name, section_names[i]))
            w->section = (vtu_section)i;
}

static void XMLCALL on_end(void *data, const char *name) {
    xml_walk *w = data;
    if (w->status)
        return;
    if (w->array_depth > 0) {
        vtu_array *array = &w->document->array[w->document->n_arrays - 1];
        w->array_depth--;
        /* Keys may stand before the numbers. */
        if (w->array_depth > 0 && !array->is_appended &&
            skip_blank(w, array->begin, array->end) == array->end)
            take_text(w, array);
        return;
    }
    if (same(name, "Piece"))
        w->in_piece = 0;
    if (same(name, "Piece") || same(name, section_names[w->section]))
        w->section = OUTSIDE;
}

static void XMLCALL on_doctype(void *data, const char *name, const char *system, const char *public,
                               int has_subset) {
    xml_walk *w = data;
    (void)name, (void)system, (void)public, (void)has_subset;
    w->status = fail_here(
        w, "a document type is declared; VTK files have none, and its entities are not read");
    XML_StopParser(w->parser, XML_FALSE);
}

/* ---- the walk ------------------------------------------------------------------------------ */

/** Fail with what Expat found wrong. */
static int fail_xml(const xml_walk *w) {
    const enum XML_Error code = XML_GetErrorCode(w->parser);
    if (code == XML_ERROR_NO_MEMORY)
        return pl_fail_memory(w->document->error, "the markup of the file");
    int64_t at = tag_begin(w);
    if (at < 0 || at > w->input->size)
        at = w->input->size;
    return io_fail_at(w->document->model, w->input->data + at, w->document->error,
                      "XML: %s (the file may be cut short)", XML_ErrorString(code));
}

/** Expat looks at bytes more than once: it is given a copy, which cannot change meanwhile. */
static enum XML_Status parse_copy(const xml_walk *w, const char *bytes, int size, int is_last) {
    if (size == 0)
        return XML_Parse(w->parser, bytes, 0, is_last);
    void *copy = XML_GetBuffer(w->parser, size);
    if (!copy)
        return XML_STATUS_ERROR;
    memcpy(copy, bytes, (size_t)size);
    return XML_ParseBuffer(w->parser, size, is_last);
}

/** Give Expat the file up to appended data. */
static int feed_expat(xml_walk *w) {
    int64_t at = 0;
    while (!w->status && w->document->appended < 0) {
        if (at < w->text_end) {
            w->skipped += w->text_end - at;
            at = w->text_end;
        }
        const int64_t left = w->input->size - at;
        const int size = left < PIECE_BYTES ? (int)left : PIECE_BYTES;
        const enum XML_Status status = parse_copy(w, w->input->data + at, size, size == left);
        if (status != XML_STATUS_OK && !w->status && w->document->appended < 0)
            return fail_xml(w);
        at += size;
        if (size == left)
            break;
    }
    return w->status;
}

int vtu_read_markup(vtu_document *document) {
    const io_model *model = document->model;
    xml_walk w = {.document = document, .input = &model->input};
    document->appended = -1;
    w.parser = XML_ParserCreate(NULL);
    if (!w.parser)
        return pl_fail_memory(document->error, "the markup of the file");
    XML_SetUserData(w.parser, &w);
    XML_SetElementHandler(w.parser, on_start, on_end);
    XML_SetStartDoctypeDeclHandler(w.parser, on_doctype);
    const int status = feed_expat(&w);
    XML_ParserFree(w.parser);
    if (status)
        return status;
    if (!document->is_grid)
        return io_fail_at(model, io_input_end(model), document->error,
                          "there is no UnstructuredGrid (the file may be cut short)");
    for (int64_t i = 0; i < document->n_arrays; i++) {
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
    return PLANISH_OK;
}

#endif
