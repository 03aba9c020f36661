/* vtu: VTK's XML files of unstructured grids: arrays as text, base64 or raw appended bytes, packed
 * or not, of any byte order; several pieces.
 *
 * As in legacy files point data called `fixed` hold nodes, and cell data may tell regions. Others are
 * read when they are asked for (data.h). Without Expat the format is known and refused.
 */
#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"
#include "io/core/data.h"
#include "io/core/format.h"
#include "io/vtk/vtk_write.h"
#include "io/vtk/vtk_cells.h"
#include "io/vtk/vtu_parts.h"

#include <stdlib.h>
#include <string.h>

/** Find the array of a piece with that role (and name, if not NULL), or NULL. */
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

static int fail_end(const vtu_document *document, const char *text) {
    return io_fail_at(document->model, io_input_end(document->model), document->error,
                      "%s (the file may be cut short)", text);
}

/* ---- points -------------------------------------------------------------------------------- */

/** Read the points of a piece, and note where they stand if they can be replaced there. */
static int read_piece_points(io_model *model, vtu_document *document, vtu_array *array) {
    const vtu_piece *piece = &document->piece[array->piece];
    const int64_t first = piece->first_point, n = piece->n_points;
    if (!array->type || array->type->kind != VTK_REAL)
        return vtu_fail(document, array, "Float32 or Float64 expected");
    if (array->n_components != 3)
        return vtu_fail(document, array, "NumberOfComponents must be 3");
    if (find_array(document, array->piece, VTU_POINTS, NULL) != array)
        return vtu_fail(document, array, "there is a second array of points");
    const int size = array->type->size;
    if (n > 0 && (size == 4) != (model->precision == PLANISH_PRECISION_FLOAT))
        return vtu_fail(document, array,
                        "some pieces are of Float32 and some of Float64: write them as one");
    io_span span = {.first_node = first, .n_nodes = n, .encoding = IO_TEXT, .offset = array->begin};
    if (array->form == VTU_ASCII) {
        io_node_records points = {.model = model, .first = first};
        const int status = vtu_read_text(document, array, n, 3, io_read_nodes, &points);
        return status ? status : io_model_span(model, span, document->error);
    }
    vtu_values values;
    int status = vtu_decode(document, array, 3 * n, &values);
    for (int64_t i = 0; i < 3 * n && !status; i++) {
        const double x = vtk_real(values.data + i * size, array->type, document->swapped);
        model->xyz[3 * first + i] = x;
        if (!isfinite(x))
            status = pl_fail_at(document->error, PLANISH_ERROR_FORMAT, -1, first + i / 3,
                                "%s: node %lld has a coordinate that is not finite",
                                model->input.path, (long long)(first + i / 3));
    }
    if (!status && !values.owned) {
        span = (io_span){.first_node = first,
                         .n_nodes = n,
                         .encoding = size == 4 ? IO_FLOAT32 : IO_FLOAT64,
                         .swapped = document->swapped,
                         .offset = values.data - model->input.data,
                         .stride = 3 * size};
        status = io_model_span(model, span, document->error);
    }
    vtu_values_release(&values);
    return status;
}

static int read_points(io_model *model, vtu_document *document) {
    const vtu_piece *last = &document->piece[document->n_pieces - 1];
    const int64_t n = last->first_point + last->n_points;
    int64_t n_found = 0, n_points = 0;
    /* Refuse more points than the file can hold before there is room for them. */
    int64_t most = vtu_most_unpacked(document) / (3 * (int64_t)sizeof(float));
    int with_text = 0;
    for (int64_t i = 0; i < document->n_arrays; i++)
        with_text |= document->array[i].role == VTU_POINTS && document->array[i].form == VTU_ASCII;
    if (with_text) /* three numbers of two characters */
        most = most > model->input.size / 6 ? most : model->input.size / 6;
    if (n > most)
        return pl_fail(document->error, PLANISH_ERROR_FORMAT,
                       "%s: %lld points cannot be in this file (a wrong NumberOfPoints, no Points, "
                       "or it is cut short)",
                       model->input.path, (long long)n);
    int status = io_model_alloc_nodes(model, n, with_text, document->error);
    model->precision = PLANISH_PRECISION_DOUBLE;
    for (int64_t i = 0; i < document->n_arrays && !status; i++) {
        vtu_array *array = &document->array[i];
        if (array->role != VTU_POINTS || array->piece < 0)
            continue;
        const int64_t here = document->piece[array->piece].n_points;
        if (n_points == 0 && here > 0 && array->type && array->type->size == 4)
            model->precision = PLANISH_PRECISION_FLOAT;
        n_points += here;
        n_found++;
        status = read_piece_points(model, document, array);
    }
    if (status)
        return status;
    /* The writer goes through the file, whatever the order of the pieces is. */
    io_model_sort_spans(model);
    return n_found < document->n_pieces ? fail_end(document, "a Piece has no Points") : PLANISH_OK;
}

/** Bytes of the file that an array has. */
typedef struct byte_range {
    int64_t begin, end;
    const vtu_array *array;
} byte_range;

static int compare_ranges(const void *a, const void *b) {
    const int64_t p = ((const byte_range *)a)->begin, q = ((const byte_range *)b)->begin;
    return (p > q) - (p < q);
}

/** Check that the bytes of appended points are theirs alone, so that they can be replaced. */
static int check_overlaps(const vtu_document *document) {
    byte_range *all = pl_alloc(document->n_arrays, sizeof *all);
    int64_t n = 0, end = 0, points_end = 0;
    int status = all ? PLANISH_OK : pl_fail_memory(document->error, "the arrays of the file");
    for (int64_t i = 0; i < document->n_arrays && !status; i++) {
        const vtu_array *array = &document->array[i];
        /* Of those that were not read it is known where they begin. */
        if (array->is_appended)
            all[n++] = (byte_range){
                array->begin, array->data_end > 0 ? array->data_end : array->begin + 1, array};
    }
    if (n > 0)
        qsort(all, (size_t)n, sizeof *all, compare_ranges);
    for (int64_t i = 0; i < n && !status; i++) {
        const int is_points = all[i].array->role == VTU_POINTS && all[i].array->piece >= 0;
        if (all[i].begin < (is_points ? end : points_end))
            status = vtu_fail(document, all[i].array,
                              "appended points share bytes with another array, so that they cannot "
                              "be moved alone");
        end = all[i].end > end ? all[i].end : end;
        if (is_points)
            points_end = end;
    }
    pl_free(all);
    return status;
}

/* ---- cells --------------------------------------------------------------------------------- */

/** Hold the nodes of the faces of polyhedra: their streams stand one after another. */
static int hold_streams(io_model *model, vtu_document *document, int64_t piece,
                        const vtk_grid *grid) {
    vtu_array *faces = find_array(document, piece, VTU_FACES, NULL);
    vtu_array *offsets = find_array(document, piece, VTU_FACE_OFFSETS, NULL);
    int64_t *ends = NULL, last = 0;
    int32_t *stream = NULL;
    if (!faces || !offsets)
        return PLANISH_OK;
    int status = vtu_read_numbers(document, offsets, grid->n, &ends, NULL, NULL);
    for (int64_t i = 0; i < grid->n && !status; i++) {
        if (ends[i] >= 0 && ends[i] < last) /* -1: no polyhedron */
            status = vtu_fail(document, offsets, "they do not rise");
        last = ends[i] > last ? ends[i] : last;
    }
    if (!status)
        status = vtu_read_numbers(document, faces, last, NULL, &stream, NULL);
    last = 0;
    for (int64_t i = 0; i < grid->n && !status; i++) {
        if (ends[i] > last && vtk_faces_hold(model, grid, stream + last, ends[i] - last))
            status = vtu_fail(document, faces,
                              "the faces of a polyhedron must be: the number of faces, then for "
                              "each face the number of nodes and its points");
        last = ends[i] > last ? ends[i] : last;
    }
    pl_free(stream);
    pl_free(ends);
    return status;
}

/** Hold the nodes of the faces of polyhedra as version 2.3 lists them: a list refers to the numbers
 *  of the next list, by ends of stretches or by indices; the last one has nodes. */
static int hold_face_nodes(io_model *model, vtu_document *document, int64_t piece,
                           const vtk_grid *grid) {
    static const vtu_role roles[] = {VTU_POLYHEDRON_OFFSETS, VTU_POLYHEDRON_TO_FACES, VTU_FACE_ENDS,
                                     VTU_FACE_NODES};
    vtu_array *lists[4];
    int64_t n = grid->n;
    int status = PLANISH_OK;
    for (int k = 0; k < 4; k++)
        if (!(lists[k] = find_array(document, piece, roles[k], NULL)))
            return PLANISH_OK;
    for (int k = 0; k < 3 && !status; k++) {
        const int are_ends = roles[k] != VTU_POLYHEDRON_TO_FACES;
        int64_t *values = NULL, extent = 0;
        status = vtu_read_numbers(document, lists[k], n, &values, NULL, NULL);
        for (int64_t i = 0; i < n && !status; i++) {
            if (values[i] < 0 || (are_ends && values[i] < extent) || values[i] == INT64_MAX)
                status = vtu_fail(document, lists[k],
                                  "they do not rise, or one is negative or too large");
            else if (are_ends || values[i] >= extent)
                extent = values[i] + !are_ends;
        }
        n = extent;
        pl_free(values);
    }
    int32_t *nodes = NULL;
    if (!status)
        status = vtu_read_numbers(document, lists[3], n, NULL, &nodes, NULL);
    if (!status && vtk_nodes_hold(model, grid, nodes, n))
        status = vtu_fail(document, lists[3], "a node is not among the points");
    pl_free(nodes);
    return status;
}

/** Read the lists of a piece's cells, which has some, to grid. */
static int read_lists(vtu_document *document, int64_t piece, vtk_grid *grid) {
    vtu_array *connectivity = find_array(document, piece, VTU_CONNECTIVITY, NULL);
    vtu_array *offsets = find_array(document, piece, VTU_OFFSETS, NULL);
    vtu_array *types = find_array(document, piece, VTU_TYPES, NULL);
    int64_t *ends = NULL;
    if (!connectivity || !offsets || !types)
        return fail_end(document, "Cells must have connectivity, offsets and types");
    /* Offsets of the file are ends of cells; ours begin with 0. */
    int status = vtu_read_numbers(document, offsets, grid->n, &ends, NULL, NULL);
    if (!status && !(grid->offset = pl_alloc(grid->n + 1, sizeof *grid->offset)))
        status = pl_fail_memory(document->error, "the cells");
    if (!status) {
        grid->offset[0] = 0;
        memcpy(grid->offset + 1, ends, (size_t)grid->n * sizeof *ends);
        grid->n_connectivity = ends[grid->n - 1];
    }
    pl_free(ends);
    if (!status && grid->n_connectivity < 0)
        status = vtu_fail(document, offsets, "they do not rise");
    if (!status)
        status = vtu_read_numbers(document, connectivity, grid->n_connectivity, NULL,
                                  &grid->connectivity, NULL);
    return status ? status : vtu_read_numbers(document, types, grid->n, NULL, &grid->type, NULL);
}

static int read_piece_cells(io_model *model, vtu_document *document, int64_t index) {
    const vtu_piece *piece = &document->piece[index];
    vtk_grid grid = {.n = piece->n_cells,
                     .n_points = piece->n_points,
                     .first_point = piece->first_point,
                     .first_cell = piece->first_cell,
                     .is_piece = document->n_pieces > 1};
    if (grid.n == 0)
        return PLANISH_OK;
    int status = read_lists(document, index, &grid), has_polyhedra = 0;
    if (!status)
        status = vtk_cells_store(model, &grid, document->error);
    for (int64_t i = 0; i < grid.n && !status; i++)
        has_polyhedra |= grid.type[i] == VTK_POLYHEDRON;
    if (has_polyhedra)
        status = hold_streams(model, document, index, &grid);
    if (has_polyhedra && !status)
        status = hold_face_nodes(model, document, index, &grid);
    vtk_grid_release(&grid);
    return status;
}

/* ---- data ---------------------------------------------------------------------------------- */

static int read_fixed(io_model *model, vtu_document *document, int64_t index) {
    const vtu_piece *piece = &document->piece[index];
    vtu_array *array = find_array(document, index, VTU_FIXED, NULL);
    double *values = NULL;
    if (!array || array->n_components < 1 || array->n_components > 9)
        return PLANISH_OK;
    const int64_t n = piece->n_points * array->n_components;
    const int status = vtu_read_numbers(document, array, n, NULL, NULL, &values);
    for (int64_t i = 0; i < n && !status; i++)
        if (values[i] != 0)
            io_hold_node(model, piece->first_point + i / array->n_components, IO_HELD_MARKED);
    pl_free(values);
    return status;
}

/** Put the values of one piece's cells. What is no array of one number for each cell can tell no
 *  regions; of one with a name that tells regions it is an error. */
static int put_piece(vtu_document *document, int64_t index, const char *name,
                     io_array_filler *filler) {
    const vtu_piece *piece = &document->piece[index];
    vtu_array *array = find_array(document, index, VTU_CELL_DATA, name);
    int64_t *whole = NULL;
    double *real = NULL;
    if (piece->n_cells == 0)
        return PLANISH_OK;
    filler->is_broken |= !array || array->n_components != 1 || !array->type;
    if (filler->is_broken)
        return PLANISH_OK;
    const int is_real = array->type->kind == VTK_REAL;
    int status = vtu_read_numbers(document, array, piece->n_cells, is_real ? NULL : &whole, NULL,
                                  is_real ? &real : NULL);
    if (status == PLANISH_ERROR_FORMAT && planish_rank_region_name(name) <= 0) {
        filler->is_broken = 1;
        status = PLANISH_OK;
    }
    for (int64_t i = 0; i < piece->n_cells && !status && !filler->is_broken; i++) {
        int64_t value = is_real ? 0 : whole[i];
        const int is_whole = is_real ? io_array_whole(real[i], &value) : 1;
        status = io_array_put(filler, piece->first_cell + i, is_whole, value, document->error);
    }
    pl_free(whole);
    pl_free(real);
    return status;
}

/** Read cell data. The first piece that has cells has all arrays that can be whole. */
static int read_cell_data(io_model *model, vtu_document *document) {
    const vtu_piece *last = &document->piece[document->n_pieces - 1];
    int64_t piece = 0;
    int status = PLANISH_OK, n = 0;
    while (piece + 1 < document->n_pieces && document->piece[piece].n_cells == 0)
        piece++;
    for (int64_t i = 0; i < document->n_arrays && n < IO_MOST_ARRAYS && !status; i++) {
        const vtu_array *array = &document->array[i];
        io_array_filler filler;
        if (array->role != VTU_CELL_DATA || array->piece != piece)
            continue;
        status = io_array_begin(model, array->name, last->first_cell + last->n_cells, &filler,
                                document->error);
        if (status)
            return status;
        for (int64_t k = 0; k < document->n_pieces && !status && !filler.is_broken; k++)
            status = put_piece(document, k, array->name, &filler);
        if (status)
            io_array_drop(&filler);
        else
            status = io_array_end(model, &filler, document->error);
        n++;
    }
    return status;
}

/** Note the arrays of data, each by the first piece that has it. */
static int note_data(io_model *model, const vtu_document *document) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < document->n_arrays && !status; i++) {
        const vtu_array *array = &document->array[i];
        const int of_elements = array->role == VTU_CELL_DATA;
        if (array->piece >= 0 && array->name && !io_data_find(model, array->name, of_elements))
            status = io_data_note(
                model,
                (io_data){.name = array->name,
                          .of_elements = of_elements,
                          .width = array->n_components,
                          .is_integer = array->type && array->type->kind <= VTK_UNSIGNED},
                document->error);
    }
    return status;
}

/** Read the values of one piece to all [n][width], from its first point or cell on. */
static int read_piece_data(vtu_document *document, int64_t index, const io_data *data,
                           double *all) {
    const vtu_piece *piece = &document->piece[index];
    const int64_t first = data->of_elements ? piece->first_cell : piece->first_point;
    const int64_t n = (data->of_elements ? piece->n_cells : piece->n_points) * data->width;
    vtu_array *array =
        find_array(document, index, data->of_elements ? VTU_CELL_DATA : VTU_POINT_DATA, data->name);
    double *values = NULL;
    if (n == 0)
        return PLANISH_OK;
    if (!array)
        return pl_fail(document->error, PLANISH_ERROR_FORMAT,
                       "%s: piece %lld has no array '%s', which other pieces have",
                       document->model->input.path, (long long)index, data->name);
    if (array->n_components != data->width)
        return vtu_fail(document, array, "NumberOfComponents is another one than in other pieces");
    const int status = vtu_read_numbers(document, array, n, NULL, NULL, &values);
    if (!status)
        memcpy(all + first * data->width, values, (size_t)n * sizeof *values);
    pl_free(values);
    return status;
}

static int vtu_read_data(io_model *model, const io_data *data, double *values,
                         planish_error *error) {
    vtu_document *document = model->of_format;
    const vtu_piece *last = &document->piece[document->n_pieces - 1];
    const int64_t n_cells = last->first_cell + last->n_cells, unpacked = document->unpacked;
    double *all = data->of_elements ? pl_alloc(n_cells * data->width, sizeof *all) : values;
    int status = all ? PLANISH_OK : pl_fail_memory(error, "an array of the file");
    document->model = model;
    document->error = error;
    document->unpacked = 0; /* this array alone is in memory, which may have been read before */
    for (int64_t k = 0; k < document->n_pieces && !status; k++)
        status = read_piece_data(document, k, data, all);
    document->unpacked = unpacked;
    if (!status && data->of_elements)
        io_data_pick(model, all, n_cells, data->width, values);
    if (!status)
        vtk_order_tensors(values, data->of_elements ? io_model_n_elements(model) : model->n_nodes,
                          data->width);
    if (data->of_elements)
        pl_free(all);
    return status;
}

/* ---- the format ---------------------------------------------------------------------------- */

static int vtu_read(io_model *model, planish_error *error) {
    vtu_document *document = pl_alloc_zero(1, sizeof *document);
    if (!document)
        return pl_fail_memory(error, model->input.path);
    model->of_format = document;
    document->model = model;
    document->error = error;
    int status = vtu_read_markup(document);
    if (!status && document->n_pieces == 0)
        status = fail_end(document, "there is no Piece");
    if (!status)
        status = read_points(model, document);
    for (int64_t i = 0; i < document->n_pieces && !status; i++)
        status = read_piece_cells(model, document, i);
    for (int64_t i = 0; i < document->n_pieces && !status; i++)
        status = read_fixed(model, document, i);
    if (!status)
        status = read_cell_data(model, document);
    if (!status)
        status = note_data(model, document);
    return status ? status : check_overlaps(document);
}

static void vtu_release(io_model *model) {
    if (model->of_format)
        vtu_document_release(model->of_format);
    pl_free(model->of_format);
    model->of_format = NULL;
}

static int vtu_recognise(const char *data, int64_t size) {
    enum { LOOKED_AT = 4096 };
    static const char mark[] = "<VTKFile";
    const int64_t length = (int64_t)sizeof mark - 1, most = size < LOOKED_AT ? size : LOOKED_AT;
    for (int64_t i = 0; i + length <= most; i++)
        if (data[i] == '<' && memcmp(data + i, mark, (size_t)length) == 0)
            return 1;
    return 0;
}

static const char *const vtu_extensions[] = {".vtu", NULL};

static const io_target vtu_targets[] = {{"vtu", vtu_write}, {NULL, NULL}};

const io_format io_format_vtu = {.name = "vtu",
                                 .extensions = vtu_extensions,
                                 .recognise = vtu_recognise,
                                 .read = vtu_read,
                                 .read_data = vtu_read_data,
                                 .encode = vtu_encode_points,
                                 .release = vtu_release,
                                 .targets = vtu_targets};
