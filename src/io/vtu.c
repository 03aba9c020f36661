/* vtu: VTK's XML files of unstructured grids: arrays as text, base64 or raw appended bytes, packed
 * or not, of any byte order; several pieces.
 *
 * As in legacy files point data called `fixed` hold nodes, and cell data of some names tell
 * regions. Without Expat the format is known and refused.
 */
#include "io/vtu.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/vtk_cells.h"

#include <string.h>

/** The array of a piece with that role (and rank, if not 0), or NULL. */
static vtu_array *find_array(const vtu_document *document, int64_t piece, vtu_role role, int rank) {
    const int64_t end = piece + 1 < document->n_pieces ? document->piece[piece + 1].first_array
                                                       : document->n_arrays;
    for (int64_t i = document->piece[piece].first_array; i < end; i++) {
        vtu_array *array = &document->array[i];
        if (array->piece == piece && array->role == role && (rank == 0 || array->rank == rank))
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
    vtu_array *faces = find_array(document, index, VTU_FACES, 0);
    vtu_array *offsets = find_array(document, index, VTU_FACE_OFFSETS, 0);
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
    vtu_array *array = find_array(document, index, role, 0);
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
    vtu_array *nodes = find_array(document, index, VTU_FACE_NODES, 0);
    int64_t n = cells->n;
    int32_t *list = NULL;
    int status = PLANISH_OK, all = nodes != NULL;
    for (int i = 0; i < 3; i++)
        all &= find_array(document, index, lists[i], 0) != NULL;
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
    vtu_array *connectivity = find_array(document, index, VTU_CONNECTIVITY, 0);
    vtu_array *offsets = find_array(document, index, VTU_OFFSETS, 0);
    vtu_array *types = find_array(document, index, VTU_TYPES, 0);
    int32_t *type = NULL;
    vtk_grid cells = {.n = piece->n_cells,
                      .n_points = piece->n_points,
                      .first_point = piece->first_point,
                      .first_cell = piece->first_cell,
                      .is_piece = document->n_pieces > 1};
    if (piece->n_cells == 0)
        return PLANISH_OK;
    if (!connectivity || !offsets || !types)
        return io_fail_text(model, model->input.data + model->input.size, error,
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
    vtu_array *array = find_array(document, index, VTU_FIXED, 0);
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

/** The regions of one piece's cells; *whole: they are whole numbers until now. */
static int read_piece_regions(io_model *model, vtu_document *document, int64_t index, int rank,
                              int32_t *region, int *whole, planish_error *error) {
    const vtu_piece *piece = &document->piece[index];
    vtu_array *array = find_array(document, index, VTU_REGION, rank);
    double *values = NULL;
    if (!array || array->n_components != 1) {
        *whole &= piece->n_cells == 0;
        return PLANISH_OK;
    }
    int status = vtu_read_reals(model, document, array, piece->n_cells, &values, error);
    for (int64_t i = 0; i < piece->n_cells && !status; i++)
        *whole &= vtk_region_of(values[i], &region[piece->first_cell + i]) == 0;
    pl_free(values);
    return status;
}

/** The rank of the most telling array after the one of rank after; 0: there is none. */
static int next_rank(const vtu_document *document, int after) {
    int best = 0;
    for (int64_t i = 0; i < document->n_arrays; i++) {
        const vtu_array *array = &document->array[i];
        if (array->role == VTU_REGION && array->rank > after && (best == 0 || array->rank < best))
            best = array->rank;
    }
    return best;
}

static int read_regions(io_model *model, vtu_document *document, planish_error *error) {
    const vtu_piece *last = &document->piece[document->n_pieces - 1];
    const int64_t n_cells = last->first_cell + last->n_cells;
    int rank = next_rank(document, 0), status = PLANISH_OK, whole = 0;
    int32_t *region = rank ? pl_alloc_zero(n_cells, sizeof *region) : NULL;
    if (rank && !region)
        return pl_fail_memory(error, "the regions of cells");
    for (; rank && !whole && !status; rank = next_rank(document, rank)) {
        whole = 1;
        for (int64_t i = 0; i < document->n_pieces && !status; i++)
            status = read_piece_regions(model, document, i, rank, region, &whole, error);
    }
    if (whole && !status)
        status = vtk_regions_store(model, region, n_cells, error);
    pl_free(region);
    return status;
}

/* ---- the format ---------------------------------------------------------------------------- */

static int read_document(io_model *model, vtu_document *document, planish_error *error) {
    int status = vtu_read_markup(model, document, error);
    if (!status && document->n_pieces == 0)
        status = io_fail_text(model, model->input.data + model->input.size, error,
                              "there is no Piece (the file may be cut short)");
    if (!status)
        status = vtu_read_points(model, document, error);
    for (int64_t i = 0; i < document->n_pieces && !status; i++)
        status = read_piece_cells(model, document, i, error);
    for (int64_t i = 0; i < document->n_pieces && !status; i++)
        status = read_fixed(model, document, i, error);
    if (!status)
        status = read_regions(model, document, error);
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
