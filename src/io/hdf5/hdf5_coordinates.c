/* hdf5_coordinates: coordinates of HDF5 files, where their bytes are, and how those are changed
 * that have no place of their own (compressed, or among the library's own records).
 */
#ifdef PL_HDF5
#include "io/hdf5/hdf5_data.h"
#include "io/hdf5/hdf5_image.h"

#include "base/memory.h"
#include "base/round.h"
#include "base/status.h"
#include "io/core/bytes.h"
#include "io/core/child.h"
#include "io/core/components.h"
#include "base/output.h"

#include <stdlib.h>
#include <string.h>

/* Asking for the place of a chunk walks over all of them: with more the copy is amended. */
enum { MOST_CHUNKS = 4096 };

/** Coordinates that the library changes: io_model.of_format. */
typedef struct amended {
    io_hdf5_place *place; /* [n] */
    int64_t n, capacity;
} amended;

void io_hdf5_release(io_model *model) {
    amended *a = model->of_format;
    if (a)
        pl_free(a->place);
    pl_free(a);
    model->of_format = NULL;
}

/* ---- places ------------------------------------------------------------------------------- */

/** Return how many nodes the place is of. */
static int64_t count_nodes(const io_model *model, const io_hdf5_place *place) {
    return place->n_nodes > 0 ? place->n_nodes : model->n_nodes;
}

/** Add spans of the nodes that values first .. last - 1 of the dataset are of; these stand at
 * offset.
 */
static int add_run(io_hdf5 *file, const io_hdf5_place *place, io_span like, int64_t first,
                   int64_t last, int64_t offset) {
    const int size = like.encoding == IO_FLOAT32 ? 4 : 8;
    const int64_t step = place->node_step, n_nodes = count_nodes(file->model, place);
    const int side_by_side = place->component_step == 1 && place->n_components > 1;
    int status = PLANISH_OK;
    like.stride = step * size;
    for (int c = 0; c < (side_by_side ? 1 : place->n_components) && !status; c++) {
        const int64_t begin = c * place->component_step;
        int64_t from = first > begin ? (first - begin) / step : 0;
        int64_t to = last > begin ? (last - begin + step - 1) / step : 0;
        to = to < n_nodes ? to : n_nodes;
        io_span span = like;
        span.first_node = place->first_node + from;
        span.n_nodes = to > from ? to - from : 0;
        span.offset = offset + (begin + from * step - first) * size;
        span.component = place->component + c;
        span.n_components = side_by_side ? place->n_components : 1;
        if (span.n_nodes > 0)
            status = io_model_span(file->model, span, file->error);
    }
    return status;
}

/** Add spans of what stands in the file, in one piece or in chunks of whole rows; the library
 * changes all other coordinates. */
static int add_places(io_hdf5 *file, const io_hdf5_place *place, const hdf5_dataset *d,
                      io_span like) {
    const hsize_t rows = (hsize_t)d->shape.dims[0], width = (hsize_t)d->shape.dims[1];
    const int64_t before = file->model->n_spans;
    if (d->offset >= 0)
        return add_run(file, place, like, 0, d->shape.n, d->offset);
    const hsize_t n = d->chunk[1] == width ? hdf5_count_chunks(file, d) : 0;
    int status = PLANISH_OK;
    int is_added = n > 0 && n == (rows + d->chunk[0] - 1) / d->chunk[0] && n <= MOST_CHUNKS;
    for (hsize_t i = 0; is_added && !status && i < n; i++) {
        hsize_t at[2];
        const int64_t offset = hdf5_chunk_place(file, d, i, at);
        const hsize_t end = at[0] + d->chunk[0] < rows ? at[0] + d->chunk[0] : rows;
        is_added = offset >= 0 && at[0] < rows && at[0] % d->chunk[0] == 0;
        if (is_added)
            status = add_run(file, place, like, (int64_t)(at[0] * width), (int64_t)(end * width),
                             offset);
    }
    if (status || is_added)
        return status;
    file->model->n_spans = before;
    amended *list = file->model->of_format;
    if (!list)
        list = file->model->of_format = pl_alloc_zero(1, sizeof *list);
    return list && pl_append(&list->place, &list->n, &list->capacity, place, sizeof *place)
               ? PLANISH_OK
               : pl_fail_memory(file->error, "the places of coordinates");
}

int io_hdf5_coordinates_end(io_hdf5 *file) {
    return io_components_end(file->model, file->error);
}

/* ---- values ------------------------------------------------------------------------------- */

/** Find how the numbers of a type stand in the file. */
static int take_encoding(io_hdf5 *file, const char *path, hid_t type, io_span *like) {
    const hid_t little[] = {H5T_IEEE_F32LE, H5T_IEEE_F64LE};
    const hid_t big[] = {H5T_IEEE_F32BE, H5T_IEEE_F64BE};
    const int size = hdf5_match_type(type, little, big, &like->swapped);
    like->encoding = size == 4 ? IO_FLOAT32 : IO_FLOAT64;
    return size ? PLANISH_OK
                : io_hdf5_fail(file, path,
                               "coordinates of 4 or 8 bytes (float, double) were expected");
}

static int take_values(io_hdf5 *file, const io_hdf5_place *place, const io_span *like,
                       const char *data) {
    const int size = like->encoding == IO_FLOAT32 ? 4 : 8;
    for (int c = 0; c < place->n_components; c++) {
        const io_strided from = {.data = data + c * place->component_step * size,
                                 .stride = place->node_step * size,
                                 .size = size,
                                 .swapped = like->swapped,
                                 .first = place->first_node,
                                 .n = place->n_nodes};
        const int64_t bad = io_load_component(file->model, from, place->component + c);
        if (bad >= 0)
            return io_hdf5_fail(file, place->path.text,
                                "node %lld has a coordinate that is not finite",
                                (long long)bad + 1);
    }
    return PLANISH_OK;
}

static int read_values(io_hdf5 *file, const io_hdf5_place *place, const hdf5_dataset *d) {
    io_model *model = file->model;
    const io_span of_copy = {.encoding = IO_FLOAT64};
    io_span like = {0};
    void *copy = NULL;
    const int64_t n = count_nodes(model, place);
    if (d->shape.n / place->n_components != n || d->shape.n % place->n_components)
        return io_hdf5_fail(file, place->path.text, "%lld coordinates for %lld nodes",
                            (long long)d->shape.n, (long long)n);
    if (d->shape.n == 0)
        return PLANISH_OK;
    int status = take_encoding(file, place->path.text, d->type, &like);
    if (status)
        return status;
    const planish_precision precision =
        like.encoding == IO_FLOAT32 ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
    if (file->has_precision && model->precision != precision)
        return io_hdf5_fail(file, place->path.text,
                            "this coordinate is of another precision than those before; give all "
                            "the same");
    file->has_precision = 1;
    model->precision = precision;
    if (d->offset >= 0) {
        status = take_values(file, place, &like, model->input.data + d->offset);
    } else { /* through the library, as the bytes are not at hand */
        status =
            hdf5_dataset_read(file, place->path.text, d, H5T_NATIVE_DOUBLE, sizeof(double), &copy);
        if (!status)
            status = take_values(file, place, &of_copy, copy);
        pl_free(copy);
    }
    return status ? status : add_places(file, place, d, like);
}

int io_hdf5_coordinates(io_hdf5 *file, const io_hdf5_place *place) {
    hdf5_dataset d;
    int status = hdf5_dataset_open(file, place->path.text, &d);
    if (!status)
        status = read_values(file, place, &d);
    hdf5_dataset_close(&d);
    return status;
}

/* ---- copies ------------------------------------------------------------------------------- */

/** Open what may well be something else: nothing is said of that. */
static int open_quietly(io_hdf5 *file, const char *path, hdf5_dataset *d) {
    planish_error *const error = file->error;
    file->error = NULL;
    const int status = hdf5_dataset_open(file, path, d);
    file->error = error;
    return status;
}

int io_hdf5_is_as_long(io_hdf5 *file, const char *path, int64_t n) {
    hdf5_dataset d;
    const int status = open_quietly(file, path, &d);
    const int64_t there = status ? -1 : d.shape.n;
    hdf5_dataset_close(&d);
    return there == n;
}

int io_hdf5_coordinates_again(io_hdf5 *file, const io_hdf5_place *place, int *is_copy) {
    const io_model *model = file->model;
    hdf5_dataset d;
    io_span like = {0};
    void *values = NULL;
    int status = open_quietly(file, place->path.text, &d);
    const int may_be = !status && H5Tget_class(d.type) == H5T_FLOAT && d.shape.n > 0 &&
                       d.shape.n == model->n_nodes * place->n_components &&
                       (d.size == sizeof(float)) == (model->precision == PLANISH_PRECISION_FLOAT);
    status = may_be ? hdf5_dataset_read(file, place->path.text, &d, H5T_NATIVE_DOUBLE,
                                        sizeof(double), &values)
                    : PLANISH_OK;
    *is_copy = may_be && !status;
    for (int c = 0; c < place->n_components && *is_copy; c++)
        for (int64_t i = 0; i < model->n_nodes && *is_copy; i++)
            *is_copy = ((const double *)values)[c * place->component_step + i * place->node_step] ==
                       model->xyz[3 * i + place->component + c];
    /* Its bytes may be coordinates already, by another link to them. */
    int is_known = 0;
    for (int64_t i = 0; i < model->n_spans && d.offset >= 0; i++)
        is_known |= model->span[i].offset == d.offset;
    if (*is_copy && !is_known)
        status = take_encoding(file, place->path.text, d.type, &like);
    if (!status && *is_copy && !is_known)
        status = add_places(file, place, &d, like);
    pl_free(values);
    hdf5_dataset_close(&d);
    return status;
}

/* ---- rows of a file that is no mesh of ours ------------------------------------------------- */

int io_hdf5_find_rows(const char *path, const char *dataset, int64_t n, int width, io_span **span,
                      int64_t *n_spans, planish_error *error) {
    io_model model = {.n_nodes = n};
    io_hdf5 *file = NULL;
    hdf5_dataset d = {.id = -1, .type = -1, .list = -1};
    io_span like = {0};
    int status = io_bytes_open(path, INT64_MAX, &model.input, error);
    if (!status)
        status = io_hdf5_open(&model, &file, error);
    const int is_there = !status && io_hdf5_kind_of(file, dataset) == IO_HDF5_DATASET;
    if (is_there)
        status = hdf5_dataset_open(file, dataset, &d);
    if (is_there && !status && (d.shape.rank == 1 || d.shape.dims[1] == width) &&
        d.shape.n == n * width)
        status = take_encoding(file, dataset, d.type, &like);
    if (!status && like.encoding == IO_FLOAT64 && !like.swapped) {
        const io_hdf5_place place = {
            io_hdf5_path_of(file, "%s", dataset), 0, width, width, 1, 0, 0};
        status = add_places(file, &place, &d, like);
    }
    hdf5_dataset_close(&d);
    io_hdf5_end(file, status); /* what cannot be looked at stands nowhere, too */
    io_hdf5_release(&model);
    *span = model.span;
    *n_spans = model.n_spans;
    io_bytes_close(&model.input);
    return status;
}

/* ---- changing a finished copy -------------------------------------------------------------- */

/** Arguments of io_hdf5_amend. */
typedef struct amend_request {
    const io_model *model;
    const double *coordinates; /* [n_nodes][written] */
    pl_output *output;
} amend_request;

/** Put the coordinates that differ among the dataset's values; not 0: there are any. */
static int put_values(const amend_request *r, const io_hdf5_place *place, int is_float,
                      double *values) {
    const io_model *model = r->model;
    int changed = 0;
    for (int c = 0; c < place->n_components && place->component + c < model->written; c++) {
        for (int64_t i = 0; i < count_nodes(model, place); i++) {
            double *value = &values[c * place->component_step + i * place->node_step];
            double wanted =
                r->coordinates[(place->first_node + i) * model->written + place->component + c];
            wanted = is_float ? pl_round_to_float(wanted) : wanted;
            if (!pl_is_same(*value, wanted)) {
                *value = wanted;
                changed = 1;
            }
        }
    }
    return changed;
}

/** Write the blocks of rows in which a value is not what it was. 0 or -1. */
static int write_blocks(const hdf5_dataset *d, const double *before, const double *after) {
    const int64_t rows = d->shape.dims[0], width = d->shape.dims[1];
    int is_written = 1;
    for (int64_t begin = 0; begin < rows && is_written; begin += d->row_block) {
        const int64_t n = rows - begin < d->row_block ? rows - begin : d->row_block;
        if (memcmp(before + begin * width, after + begin * width,
                   (size_t)(n * width) * sizeof *before) == 0)
            continue;
        const hsize_t start[2] = {(hsize_t)begin, 0}, count[2] = {(hsize_t)n, (hsize_t)width};
        hid_t there = H5Dget_space(d->id), here = H5Screate_simple(d->shape.rank, count, NULL);
        is_written = there >= 0 && here >= 0 &&
                     (d->shape.rank == 0 ||
                      H5Sselect_hyperslab(there, H5S_SELECT_SET, start, NULL, count, NULL) >= 0) &&
                     H5Dwrite(d->id, H5T_NATIVE_DOUBLE, here, there, H5P_DEFAULT,
                              after + begin * width) >= 0;
        hdf5_release(there);
        hdf5_release(here);
    }
    return is_written ? 0 : -1;
}

/** Change the coordinates in a dataset, or only look whether any differ: *is_changed then. */
static int amend_place(const amend_request *r, io_hdf5 *file, const io_hdf5_place *place,
                       int is_writing, int *is_changed) {
    /* Where in the dataset the last coordinate of the last node is. */
    const int64_t last = (place->n_components - 1) * place->component_step +
                         (count_nodes(r->model, place) - 1) * place->node_step;
    hdf5_dataset d;
    void *values = NULL;
    double *before = NULL;
    int status = hdf5_dataset_open(file, place->path.text, &d);
    if (!status && last >= d.shape.n)
        status = io_bytes_fail_changed(&r->model->input, file->error);
    if (!status)
        status = hdf5_dataset_read(file, place->path.text, &d, H5T_NATIVE_DOUBLE, sizeof(double),
                                   &values);
    if (!status && is_writing) {
        before = pl_alloc(d.shape.n, sizeof *before);
        if (before)
            memcpy(before, values, (size_t)d.shape.n * sizeof *before);
        else
            status = pl_fail_memory(file->error, "coordinates");
    }
    const int is_other = !status && put_values(r, place, d.size == sizeof(float), values);
    *is_changed |= is_other;
    if (is_other && is_writing && write_blocks(&d, before, values))
        status = hdf5_fail_library(file, place->path.text, "its coordinates cannot be changed");
    pl_free(before);
    pl_free(values);
    hdf5_dataset_close(&d);
    return status;
}

/** Find whether coordinates in the file in the bytes at data [size] differ: *is_changed. If changed
 *  is not NULL, change them all: *changed [*n_changed], to be released by pl_free. */
static int amend_bytes(const amend_request *r, const char *data, int64_t size, char **changed,
                       int64_t *n_changed, int *is_changed, planish_error *error) {
    const amended *list = r->model->of_format;
    const int is_writing = changed != NULL;
    hdf5_copy copy = {.written = NULL};
    io_hdf5 file = {
        .model = (io_model *)(uintptr_t)r->model, .error = error, .access = hdf5_link_access()};
    int status = PLANISH_OK;
    file.id = is_writing ? hdf5_open_copy(data, size, &copy) : hdf5_open_bytes(data, size);
    if (file.id < 0 || file.access < 0)
        status = hdf5_fail_library(&file, "/", "cannot be opened");
    for (int64_t i = 0; i < list->n && !status && (is_writing || !*is_changed); i++)
        status = amend_place(r, &file, &list->place[i], is_writing, is_changed);
    if (!status && is_writing)
        status = hdf5_take_bytes(&file, &copy, changed, n_changed);
    hdf5_release(file.access);
    if (file.id >= 0)
        H5Fclose(file.id);
    free(copy.written);
    return status;
}

/** Change the coordinates in the finished copy of the file to *bytes [*size], and read them there. */
static int amend_finished(const amend_request *r, char **bytes, int64_t *size,
                          planish_error *error) {
    io_bytes finished; /* it will be copied */
    int is_changed = 0;
    int status = io_bytes_open(r->output->temporary, 0, &finished, error);
    if (status)
        return status;
    status = amend_bytes(r, finished.data, finished.size, bytes, size, &is_changed, error);
    io_bytes_close(&finished);
    is_changed = 0;
    if (!status)
        status = amend_bytes(r, *bytes, *size, NULL, NULL, &is_changed, error);
    if (!status && is_changed)
        status = pl_fail(error, PLANISH_ERROR_FILE,
                         "%s: its coordinates cannot be changed: the HDF5 library wrote others",
                         r->model->input.path);
    return status;
}

static int amend(void *data, planish_error *error) {
    const amend_request *r = data;
    const io_bytes *input = &r->model->input;
    const amended *list = r->model->of_format;
    char *bytes = NULL;
    int64_t size = 0;
    int is_changed = 0;
    hdf5_voice voice = hdf5_silence();
    int status = amend_bytes(r, input->data, input->size, NULL, NULL, &is_changed, error);
    if (!status && is_changed && !r->output->temporary)
        status = pl_fail(error, PLANISH_ERROR_FILE,
                         "%s: its coordinates (%s) are compressed or packed, so that the result "
                         "cannot be written to a pipe or device; give the name of a file",
                         input->path, list->place[0].path.text);
    if (!status && is_changed)
        status = amend_finished(r, &bytes, &size, error);
    hdf5_restore(voice);
    if (!status && is_changed)
        status = pl_output_rewrite(r->output, bytes, size, error);
    pl_free(bytes);
    return status;
}

int io_hdf5_amend(const io_model *model, const double *coordinates, pl_output *output,
                  planish_error *error) {
    const amended *list = model->of_format;
    amend_request r = {model, coordinates, output};
    if (!list || list->n == 0)
        return PLANISH_OK;
    return model->is_isolated ? io_child_run(amend, &r, &model->input, error) : amend(&r, error);
}

#endif
