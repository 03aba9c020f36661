/* vtu_xml: the markup of VTK's XML files.
 *
 * The walk (src/io/xml) is given neither the text of data arrays nor appended data. Document types,
 * and with them entities, are refused.
 */
#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"
#include "io/vtk/vtu_parts.h"
#include "io/xml/xml.h"

#include <stdio.h>
#include <string.h>

void vtu_document_release(vtu_document *document) {
    for (int64_t i = 0; i < document->n_arrays; i++)
        pl_free(document->array[i].name);
    pl_free(document->piece);
    pl_free(document->array);
    *document = (vtu_document){0};
}

/** Elements of a piece that have arrays. */
typedef enum vtu_section { OUTSIDE, POINTS, CELLS, POINT_DATA, CELL_DATA, N_SECTIONS } vtu_section;

static const char *const section_names[N_SECTIONS] = {"", "Points", "Cells", "PointData",
                                                      "CellData"};

/** The state of a walk over the markup. */
typedef struct vtu_walk {
    io_xml xml;
    vtu_document *document;
    vtu_section section; /* of the piece */
    int in_file, in_piece;
    int array_depth; /* elements within a DataArray, itself included; 0: in none */
} vtu_walk;

/* ---- elements ------------------------------------------------------------------------------ */

/* Functions of elements that begin return a status; not 0 stops the walk. */

static int begin_file(vtu_walk *w) {
    static const struct {
        const char *compressor, *library;
        io_compression compression;
    } packed[] = {{"vtkZLibDataCompressor", "zlib", IO_ZLIB},
                  {"vtkLZ4DataCompressor", "LZ4", IO_LZ4},
                  {"vtkLZMADataCompressor", "LZMA", IO_LZMA}};
    const char *compressor = io_xml_attribute(&w->xml, "compressor");
    const char *order = io_xml_attribute(&w->xml, "byte_order"),
               *header = io_xml_attribute(&w->xml, "header_type");
    vtu_document *document = w->document;
    if (!io_xml_is(io_xml_attribute(&w->xml, "type"), "UnstructuredGrid"))
        return io_xml_fail(&w->xml,
                           "type is not UnstructuredGrid: other VTK files (surfaces, structured "
                           "grids, lists of pieces) are not read; write the mesh as one .vtu");
    w->in_file = 1;
    document->swapped = io_xml_is(order, "BigEndian") == io_machine_is_little();
    document->header_size = io_xml_is(header, "UInt64") ? 8 : 4;
    if ((order && !io_xml_is(order, "BigEndian") && !io_xml_is(order, "LittleEndian")) ||
        (header && !io_xml_is(header, "UInt32") && !io_xml_is(header, "UInt64")))
        return io_xml_fail(&w->xml,
                           "byte_order must be LittleEndian or BigEndian, header_type UInt32 or "
                           "UInt64");
    for (int i = 0; i < 3; i++) {
        if (!io_xml_is(compressor, packed[i].compressor))
            continue;
        document->compression = packed[i].compression;
        if (io_compression_is_built(document->compression))
            return PLANISH_OK;
        char text[160];
        snprintf(text, sizeof text,
                 "packed by %s, without which this planish was built; write the file without "
                 "compression, or build planish with it",
                 packed[i].library);
        return io_xml_fail(&w->xml, text);
    }
    if (compressor && *compressor)
        return io_xml_fail(&w->xml, "this compressor is unknown; there are vtkZLibDataCompressor, "
                                    "vtkLZ4DataCompressor and vtkLZMADataCompressor");
    return PLANISH_OK;
}

static int begin_piece(vtu_walk *w) {
    vtu_document *document = w->document;
    vtu_piece piece = {io_xml_whole(io_xml_attribute(&w->xml, "NumberOfPoints")),
                       io_xml_whole(io_xml_attribute(&w->xml, "NumberOfCells")), 0, 0,
                       document->n_arrays};
    if (piece.n_points < 0 || piece.n_cells < 0 || piece.n_points > INT32_MAX ||
        piece.n_cells > INT32_MAX)
        return io_xml_fail(&w->xml,
                           "NumberOfPoints and NumberOfCells must be whole numbers below 2^31");
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

static vtu_role role_of(const vtu_walk *w, const char *name) {
    int role = VTU_CONNECTIVITY;
    switch (w->section) {
    case POINTS:
        return VTU_POINTS;
    case CELLS:
        while (role <= VTU_FACE_NODES && !io_xml_is(name, vtu_role_names[role]))
            role++;
        return role <= VTU_FACE_NODES ? (vtu_role)role : VTU_OTHER;
    case POINT_DATA:
        return io_xml_is(name, "fixed") ? VTU_FIXED : name ? VTU_POINT_DATA : VTU_OTHER;
    case CELL_DATA:
        return name ? VTU_CELL_DATA : VTU_OTHER;
    default:
        return VTU_OTHER;
    }
}

static int begin_array(vtu_walk *w) {
    vtu_document *document = w->document;
    const char *components = io_xml_attribute(&w->xml, "NumberOfComponents"),
               *name = io_xml_attribute(&w->xml, "Name");
    const char *type = io_xml_attribute(&w->xml, "type"),
               *form = io_xml_attribute(&w->xml, "format");
    vtu_array array = {.role = role_of(w, name),
                       .piece = w->in_piece ? (int)document->n_pieces - 1 : -1,
                       .n_components = components ? io_xml_whole(components) : 1,
                       .tag = w->xml.tag_begin};
    if (type)
        array.type = vtk_find_xml_type((io_slice){type, type + strlen(type)});
    if (io_xml_is(form, "appended")) {
        array.is_appended = 1;
        array.offset = io_xml_whole(io_xml_attribute(&w->xml, "offset"));
        io_xml_find_value(&w->xml, "offset", &array.offset_begin, &array.offset_end);
        if (array.offset < 0 || array.offset_begin < 0)
            return io_xml_fail(&w->xml, "offset must be a whole number");
    } else if (!form || io_xml_is(form, "ascii") || io_xml_is(form, "binary")) {
        array.form = io_xml_is(form, "binary") ? VTU_BASE64 : VTU_ASCII;
        io_xml_take_text(&w->xml, &array.begin, &array.end);
    } else {
        return io_xml_fail(&w->xml, "format must be ascii, binary or appended");
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
static int begin_appended(vtu_walk *w) {
    const io_bytes *input = &w->document->model->input;
    const int64_t at = io_xml_skip_blank(&w->xml, w->xml.tag_end, input->size);
    if (at == input->size || input->data[at] != '_')
        return io_xml_fail(&w->xml,
                           "appended data must begin with '_' (the file may be cut short)");
    w->document->appended = at + 1;
    w->document->appended_form =
        io_xml_is(io_xml_attribute(&w->xml, "encoding"), "base64") ? VTU_BASE64 : VTU_RAW;
    io_xml_stop(&w->xml);
    return PLANISH_OK;
}

static int on_begin(io_xml *xml, const char *name) {
    vtu_walk *w = xml->user;
    int status = PLANISH_OK;
    if (w->array_depth > 0) {
        w->array_depth++;
        return PLANISH_OK;
    }
    if (!w->in_file)
        status = io_xml_is(name, "VTKFile")
                     ? begin_file(w)
                     : io_xml_fail(xml, "VTKFile expected: this is not a VTK file");
    else if (io_xml_is(name, "UnstructuredGrid"))
        w->document->is_grid = 1;
    else if (io_xml_is(name, "Piece"))
        status = begin_piece(w);
    else if (io_xml_is(name, "AppendedData"))
        status = begin_appended(w);
    else if (io_xml_is(name, "DataArray") || io_xml_is(name, "Array"))
        status = begin_array(w);
    for (int i = POINTS; i < N_SECTIONS && w->in_piece; i++)
        if (io_xml_is(name, section_names[i]))
            w->section = (vtu_section)i;
    return status;
}

static int on_end(io_xml *xml, const char *name) {
    vtu_walk *w = xml->user;
    if (w->array_depth > 0) {
        vtu_array *array = &w->document->array[w->document->n_arrays - 1];
        w->array_depth--;
        /* Keys may stand before the numbers. */
        if (w->array_depth > 0 && !array->is_appended &&
            io_xml_skip_blank(xml, array->begin, array->end) == array->end)
            io_xml_take_text(xml, &array->begin, &array->end);
        return PLANISH_OK;
    }
    if (io_xml_is(name, "Piece"))
        w->in_piece = 0;
    if (io_xml_is(name, "Piece") || io_xml_is(name, section_names[w->section]))
        w->section = OUTSIDE;
    return PLANISH_OK;
}

/* ---- the walk ------------------------------------------------------------------------------ */

int vtu_read_markup(vtu_document *document) {
    const io_model *model = document->model;
    vtu_walk w = {.xml = {.model = model,
                          .error = document->error,
                          .begin = on_begin,
                          .end = on_end,
                          .user = &w,
                          .format = "VTK's XML"},
                  .document = document};
    document->appended = -1;
    const int status = io_xml_read(&w.xml);
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
