/* vtu: VTK's XML files of unstructured grids: arrays as text, base64 or raw appended bytes, packed
 * or not, of any byte order; several pieces.
 *
 * As in legacy files point data called `fixed` hold nodes, and cell data may tell regions. Without
 * Expat the format is known and refused.
 */
#include "io/core/format.h"
#include "io/vtk/vtu_parts.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"
#include "io/vtk/vtk_cells.h"

#include <string.h>

/** The array of a piece with that role (and name, if not NULL), or NULL. */
static vtu_array *find_array(const vtu_document *document, int64_t piece, vtu_role role,
                             const char *name) {
    const int64_t end = piece + 1 < document->n_pieces ? document->piece[piece + 1].first_array
                                                       : document->n_arrays;
    for (int64_t i = document->piece[piece].first_array; i < end; i++) {
        vtu_array *array = &document->array[i];
        if (array->piece == piece && array->role == role &&
            (name == NULL || strcmp(array->name, name) == 0))
            return array;
    }
    return NULL;
}

/* ---- cells --------------------------------------------------------------------------------- */

/** Offsets of the file are ends of cells; ours begin with 0. */
static int read_offsets(io_model *model, vtu_document *document, vtu_array *array, vtk_grid *cells,
                        planish_error *error) {
    int64_t *ends = NULL;
    int status = vtu_read_integers(model, document, array, cells->n, &ends, NULL, error);
    cells->offset = status ? NULL : pl_alloc(cells->n + 1, sizeof *cells->offset);
    if (!status && !cells->offset)
        status = pl_fail_memory(error, "the cells");
    for (int64_t i = 0, last = 0; i < cells->n && !status; last = ends[i++]) {
        cells->offset[i] = last;
        if (ends[i] < last)
            status = vtu_fail(model, array, error, "they do not rise");
        cells->offset[i + 1] = ends[i];
    }
    if (!status && cells->n == 0)
        cells->offset[0] = 0;
    if (!status)
        cells->n_connectivity = cells->offset[cells->n];
    pl_free(ends);
    return status;
}

/** Hold the nodes of the faces of polyhedra: their streams stand one after another. */
static int hold_streams(io_model *model, vtu_document *document, int64_t index,
                        const vtk_grid *cells, planish_error *error) {
    vtu_array *faces = find_array(document, index, VTU_FACES, NULL);
    vtu_array *offsets = find_array(document, index, VTU_FACE_OFFSETS, NULL);
    int64_t *ends = NULL, last = 0;
    int32_t *stream = NULL;
    if (!faces || !offsets)
        return PLANISH_OK;
    int status = vtu_read_integers(model, document, offsets, cells->n, &ends, NULL, error);
    for (int64_t i = 0; i < cells->n && !status; i++) {
        if (ends[i] >= 0 && ends[i] < last) /* -1: no polyhedron */
            status = vtu_fail(model, offsets, error, "they do not rise");
        last = ends[i] > last ? ends[i] : last;
    }
    if (!status)
        status = vtu_read_integers(model, document, faces, last, NULL, &stream, error);
    last = 0;
    for (int64_t i = 0; i < cells->n && !status; i++) {
        if (ends[i] > last && vtk_faces_hold(model, cells, stream + last, ends[i] - last))
            status = vtu_fail(model, faces, error,
                              "a polyhedron's are not: how many faces, and of each how many nodes, "
                              "and which of the points");
        last = ends[i] > last ? ends[i] : last;
    }
    pl_free(stream);
    pl_free(ends);
    return status;
}

/** How many numbers of the next list these n refer to: ends of stretches (the last), or indices. */
static int read_extent(io_model *model, vtu_document *document, int64_t index, vtu_role role,
                       int64_t *n, planish_error *error) {
    vtu_array *array = find_array(document, index, role, NULL);
    int64_t *values = NULL, extent = 0;
    int status = vtu_read_integers(model, document, array, *n, &values, NULL, error);
    const int are_ends = role != VTU_POLYHEDRON_TO_FACES;
    for (int64_t i = 0; i < *n && !status; i++) {
        if (values[i] < 0 || (are_ends && values[i] < extent) || values[i] == INT64_MAX)
            status = vtu_fail(model, array, error, "they do not rise, or one is none");
        else if (are_ends || values[i] >= extent)
            extent = values[i] + !are_ends;
    }
    *n = extent;
    pl_free(values);
    return status;
}

/** The same of version 2.3: faces have lists of nodes. */
static int hold_face_nodes(io_model *model, vtu_document *document, int64_t index,
                           const vtk_grid *cells, planish_error *error) {
    static const vtu_role lists[] = {VTU_POLYHEDRON_OFFSETS, VTU_POLYHEDRON_TO_FACES,
                                     VTU_FACE_ENDS};
    vtu_array *nodes = find_array(document, index, VTU_FACE_NODES, NULL);
    int64_t n = cells->n;
    int32_t *list = NULL;
    int status = PLANISH_OK, all = nodes != NULL;
    for (int i = 0; i < 3; i++)
        all &= find_array(document, index, lists[i], NULL) != NULL;
    if (!all)
        return PLANISH_OK;
    for (int i = 0; i < 3 && !status; i++)
        status = read_extent(model, document, index, lists[i], &n, error);
    if (!status)
        status = vtu_read_integers(model, document, nodes, n, NULL, &list, error);
    if (!status && vtk_nodes_hold(model, cells, list, n))
        status = vtu_fail(model, nodes, error, "a node is not among the points");
    pl_free(list);
    return status;
}

static int hold_faces(io_model *model, vtu_document *document, int64_t index, const vtk_grid *cells,
                      planish_error *error) {
    enum { POLYHEDRON = 42 };
    for (int64_t i = 0; i < cells->n; i++) {
        if (cells->type[i] != POLYHEDRON)
            continue;
        const int status = hold_streams(model, document, index, cells, error);
        return status ? status : hold_face_nodes(model, document, index, cells, error);
    }
    return PLANISH_OK;
}

static int read_piece_cells(io_model *model, vtu_document *document, int64_t index,
                            planish_error *error) {
    const vtu_piece *piece = &document->piece[index];
    vtu_array *connectivity = find_array(document, index, VTU_CONNECTIVITY, NULL);
    vtu_array *offsets = find_array(document, index, VTU_OFFSETS, NULL);
    vtu_array *types = find_array(document, index, VTU_TYPES, NULL);
    int32_t *type = NULL;
    vtk_grid cells = {.n = piece->n_cells,
                      .n_points = piece->n_points,
                      .first_point = piece->first_point,
                      .first_cell = piece->first_cell,
                      .is_piece = document->n_pieces > 1};
    if (piece->n_cells == 0)
        return PLANISH_OK;
    if (!connectivity || !offsets || !types)
        return io_fail_at(model, model->input.data + model->input.size, error,
                          "Cells must have connectivity, offsets and types (the file may be cut "
                          "short)");
    int status = read_offsets(model, document, offsets, &cells, error);
    if (!status)
        status = vtu_read_integers(model, document, connectivity, cells.n_connectivity, NULL,
                                   &cells.connectivity, error);
    if (!status)
        status = vtu_read_integers(model, document, types, cells.n, NULL, &type, error);
    cells.type = type;
    if (!status)
        status = vtk_cells_store(model, &cells, error);
    if (!status)
        status = hold_faces(model, document, index, &cells, error);
    pl_free(cells.connectivity);
    pl_free(cells.offset);
    pl_free(type);
    return status;
}

/* ---- data ---------------------------------------------------------------------------------- */

static int read_fixed(io_model *model, vtu_document *document, int64_t index,
                      planish_error *error) {
    const vtu_piece *piece = &document->piece[index];
    vtu_array *array = find_array(document, index, VTU_FIXED, NULL);
    double *values = NULL;
    if (!array || array->n_components < 1 || array->n_components > 9)
        return PLANISH_OK;
    const int64_t n = piece->n_points * array->n_components;
    int status = vtu_read_reals(model, document, array, n, &values, error);
    for (int64_t i = 0; i < n && !status; i++)
        if (values[i] != 0)
            io_hold_node(model, piece->first_point + i / array->n_components, IO_HELD_MARKED);
    pl_free(values);
    return status;
}

/** The numbers of one piece's array: one of the two is allocated. */
typedef struct numbers {
    int64_t *whole;
    double *real;
} numbers;

static int read_numbers(io_model *model, vtu_document *document, vtu_array *array, int64_t n,
                        numbers *values, planish_error *error) {
    *values = (numbers){.whole = NULL};
    return array->type->kind == VTK_REAL
               ? vtu_read_reals(model, document, array, n, &values->real, error)
               : vtu_read_integers(model, document, array, n, &values->whole, NULL, error);
}

/** Put the values of one piece's cells. What is no array of one number for each cell can tell no
 *  regions; of one with a name that tells regions it is an error. */
static int put_piece(io_model *model, vtu_document *document, int64_t index, const char *name,
                     io_array_filler *filler, planish_error *error) {
    const vtu_piece *piece = &document->piece[index];
    vtu_array *array = find_array(document, index, VTU_CELL_DATA, name);
    numbers values;
    if (piece->n_cells == 0)
        return PLANISH_OK;
    filler->is_broken |= !array || array->n_components != 1 || !array->type;
    if (filler->is_broken)
        return PLANISH_OK;
    int status = read_numbers(model, document, array, piece->n_cells, &values, error);
    if (status == PLANISH_ERROR_FORMAT && planish_region_name(name) <= 0) {
        filler->is_broken = 1;
        status = PLANISH_OK;
    }
    for (int64_t i = 0; i < piece->n_cells && !status && !filler->is_broken; i++) {
        int64_t value = values.real ? 0 : values.whole[i];
        const int is_whole = values.real ? io_array_whole(values.real[i], &value) : 1;
        status = io_array_put(filler, piece->first_cell + i, is_whole, value, error);
    }
    pl_free(values.whole);
    pl_free(values.real);
    return status;
}

/** Read the array of cell data called name. */
static int read_cell_array(io_model *model, vtu_document *document, const char *name,
                           planish_error *error) {
    const vtu_piece *last = &document->piece[document->n_pieces - 1];
    io_array_filler filler;
    int status = io_array_begin(model, name, last->first_cell + last->n_cells, &filler, error);
    if (status)
        return status;
    for (int64_t i = 0; i < document->n_pieces && !status && !filler.is_broken; i++)
        status = put_piece(model, document, i, name, &filler, error);
    if (!status)
        return io_array_end(model, &filler, error);
    io_array_drop(&filler);
    return status;
}

/** The first piece that has cells: it has all arrays that can be whole. */
static int64_t first_with_cells(const vtu_document *document) {
    int64_t piece = 0;
    while (piece + 1 < document->n_pieces && document->piece[piece].n_cells == 0)
        piece++;
    return piece;
}

static int read_cell_data(io_model *model, vtu_document *document, planish_error *error) {
    const int64_t piece = first_with_cells(document);
    int status = PLANISH_OK, n = 0;
    for (int64_t i = 0; i < document->n_arrays && n < IO_MOST_ARRAYS && !status; i++) {
        const vtu_array *array = &document->array[i];
        if (array->role != VTU_CELL_DATA || array->piece != piece)
            continue;
        status = read_cell_array(model, document, array->name, error);
        n++;
    }
    return status;
}

/* ---- the format ---------------------------------------------------------------------------- */

static int read_document(io_model *model, vtu_document *document, planish_error *error) {
    int status = vtu_read_markup(model, document, error);
    if (!status && document->n_pieces == 0)
        status = io_fail_at(model, model->input.data + model->input.size, error,
                            "there is no Piece (the file may be cut short)");
    if (!status)
        status = vtu_read_points(model, document, error);
    for (int64_t i = 0; i < document->n_pieces && !status; i++)
        status = read_piece_cells(model, document, i, error);
    for (int64_t i = 0; i < document->n_pieces && !status; i++)
        status = read_fixed(model, document, i, error);
    if (!status)
        status = read_cell_data(model, document, error);
    return status ? status : vtu_check_overlaps(model, document, error);
}

static int read_vtu(io_model *model, planish_error *error) {
    vtu_document *document = pl_alloc_zero(1, sizeof *document);
    if (!document)
        return pl_fail_memory(error, model->input.path);
    model->encoding = document;
    model->columns = 3;
    model->first_number = 0;
    return read_document(model, document, error);
}

static void release_vtu(io_model *model) {
    if (model->encoding)
        vtu_document_release(model->encoding);
    pl_free(model->encoding);
    model->encoding = NULL;
}

static int recognise_vtu(const char *data, int64_t size) {
    enum { LOOKED_AT = 4096 };
    static const char mark[] = "<VTKFile";
    const int64_t length = (int64_t)sizeof mark - 1, most = size < LOOKED_AT ? size : LOOKED_AT;
    for (int64_t i = 0; i + length <= most; i++)
        if (data[i] == '<' && memcmp(data + i, mark, (size_t)length) == 0)
            return 1;
    return 0;
}

static const char *const vtu_extensions[] = {".vtu", NULL};

const io_format io_format_vtu = {.name = "vtu",
                                 .extensions = vtu_extensions,
                                 .recognise = recognise_vtu,
                                 .read = read_vtu,
                                 .encode = vtu_encode_points,
                                 .release = release_vtu};
