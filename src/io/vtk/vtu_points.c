/* vtu_points: the points of VTK's XML files, read, and where they stand. */
#include "io/vtk/vtu_parts.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <stdlib.h>

/* ---- reading ------------------------------------------------------------------------------- */

static int check_points(const io_model *model, const vtu_document *document, const vtu_array *array,
                        planish_error *error) {
    if (!array->type || array->type->kind != VTK_REAL)
        return vtu_fail(model, array, error, "Float32 or Float64 expected");
    if (array->n_components != 3)
        return vtu_fail(model, array, error, "NumberOfComponents must be 3");
    const int64_t first = vtu_piece_of(document, array)->first_array;
    for (const vtu_array *other = document->array + first; other < array; other++)
        if (other->role == VTU_POINTS && other->piece == array->piece)
            return vtu_fail(model, array, error, "there is a second array of points");
    if (vtu_piece_of(document, array)->n_points > 0 &&
        (array->type->size == 4) != (model->precision == PLANISH_FLOAT))
        return vtu_fail(model, array, error,
                        "some pieces are of Float32 and some of Float64: write them as one");
    return PLANISH_OK;
}

/** The texts of points, read by several threads. */
typedef struct text_points {
    io_model *model;
    int64_t first;
} text_points;

static int read_text_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                            planish_error *error) {
    const text_points *p = context;
    int status = PLANISH_OK;
    for (int64_t i = begin; i < end && !status; i++)
        status = io_read_point(p->model, cursor, p->first + i, error);
    return status;
}

static int read_ascii(io_model *model, const vtu_array *array, const vtu_piece *piece,
                      planish_error *error) {
    const char *data = model->input.data;
    io_cursor cursor = {data + array->begin, data + array->end};
    io_text text;
    io_text_init(&text, model);
    text.begin = cursor.at;
    text.end = cursor.end;
    text_points p = {model, piece->first_point};
    int status = io_text_records(&text, &cursor, piece->n_points, 3, read_text_points, &p, error);
    io_text_release(&text);
    if (!status)
        status = io_model_span(model,
                               (io_span){.first_node = piece->first_point,
                                         .n_nodes = piece->n_points,
                                         .encoding = IO_TEXT,
                                         .offset = array->begin},
                               error);
    return status;
}

static int read_binary(io_model *model, vtu_document *document, vtu_array *array,
                       const vtu_piece *piece, planish_error *error) {
    vtu_values values;
    int status = vtu_decode(model, document, array, 3 * piece->n_points, &values, error);
    if (status)
        return status;
    double *xyz = model->xyz + 3 * piece->first_point;
    for (int64_t i = 0; i < values.n && !status; i++) {
        xyz[i] = vtu_real(&values, i);
        if (!isfinite(xyz[i]))
            status = pl_fail_at(error, PLANISH_ERROR_FORMAT, -1, piece->first_point + i / 3,
                                "%s: point %lld has a coordinate that is not finite",
                                model->input.path, (long long)(piece->first_point + i / 3));
    }
    if (!status && !values.owned)
        status =
            io_model_span(model,
                          (io_span){.first_node = piece->first_point,
                                    .n_nodes = piece->n_points,
                                    .encoding = array->type->size == 4 ? IO_FLOAT32 : IO_FLOAT64,
                                    .swapped = document->swapped,
                                    .offset = values.data - model->input.data,
                                    .stride = 3 * array->type->size},
                          error);
    vtu_values_release(&values);
    return status;
}

/** Refuse more points than the file can hold before there is room for them. */
static int make_nodes(io_model *model, const vtu_document *document, planish_error *error) {
    const vtu_piece *last = &document->piece[document->n_pieces - 1];
    const int64_t n = last->first_point + last->n_points;
    int64_t most = vtu_most_unpacked(model, document) / (3 * (int64_t)sizeof(float));
    int with_text = 0;
    for (int64_t i = 0; i < document->n_arrays; i++)
        with_text |= document->array[i].role == VTU_POINTS && document->array[i].form == VTU_ASCII;
    if (with_text) /* three numbers of two characters */
        most = most > model->input.size / 6 ? most : model->input.size / 6;
    if (n > most)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: %lld points cannot be in this file (a wrong NumberOfPoints, no Points, "
                       "or it is cut short)",
                       model->input.path, (long long)n);
    return io_model_nodes(model, n, with_text, error);
}

static int compare_spans(const void *a, const void *b) {
    const int64_t p = ((const io_span *)a)->offset, q = ((const io_span *)b)->offset;
    return (p > q) - (p < q);
}

int vtu_read_points(io_model *model, vtu_document *document, planish_error *error) {
    int64_t found = 0, n_points = 0;
    int status = make_nodes(model, document, error);
    if (status)
        return status;
    model->precision = PLANISH_DOUBLE;
    for (int64_t i = 0; i < document->n_arrays && !status; i++) {
        vtu_array *array = &document->array[i];
        if (array->role != VTU_POINTS || array->piece < 0)
            continue;
        const vtu_piece *piece = vtu_piece_of(document, array);
        if (n_points == 0 && piece->n_points > 0 && array->type && array->type->size == 4)
            model->precision = PLANISH_FLOAT;
        n_points += piece->n_points;
        status = check_points(model, document, array, error);
        if (status)
            return status;
        status = array->form == VTU_ASCII ? read_ascii(model, array, piece, error)
                                          : read_binary(model, document, array, piece, error);
        found++;
    }
    /* The writer goes through the file, whatever the order of the pieces is. */
    if (!status && model->n_spans > 1)
        qsort(model->span, (size_t)model->n_spans, sizeof *model->span, compare_spans);
    if (!status && found < document->n_pieces)
        status = io_fail_at(model, model->input.data + model->input.size, error,
                            "a Piece has no Points (the file may be cut short)");
    return status;
}

/* ---- places -------------------------------------------------------------------------------- */

/** Bytes of the file that an array has. */
typedef struct range {
    int64_t begin, end;
    const vtu_array *array;
} range;

static int compare_ranges(const void *a, const void *b) {
    const int64_t p = ((const range *)a)->begin, q = ((const range *)b)->begin;
    return (p > q) - (p < q);
}

int vtu_check_overlaps(const io_model *model, const vtu_document *document, planish_error *error) {
    range *all = pl_alloc(document->n_arrays, sizeof *all);
    int64_t n = 0, end = 0, points_end = 0;
    int status = all ? PLANISH_OK : pl_fail_memory(error, "the arrays of the file");
    for (int64_t i = 0; i < document->n_arrays && !status; i++) {
        const vtu_array *array = &document->array[i];
        /* Of those that were not read it is known where they begin. */
        if (array->is_appended)
            all[n++] = (range){array->begin,
                               array->data_end > 0 ? array->data_end : array->begin + 1, array};
    }
    if (!status && n > 0)
        qsort(all, (size_t)n, sizeof *all, compare_ranges);
    for (int64_t i = 0; i < n && !status; i++) {
        const int is_points = all[i].array->role == VTU_POINTS && all[i].array->piece >= 0;
        if (all[i].begin < (is_points ? end : points_end))
            status = vtu_fail(model, all[i].array, error,
                              "appended points share bytes with another array, so that they cannot "
                              "be moved alone");
        end = all[i].end > end ? all[i].end : end;
        if (is_points)
            points_end = end;
    }
    pl_free(all);
    return status;
}
