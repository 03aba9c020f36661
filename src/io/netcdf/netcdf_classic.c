/* netcdf_classic: values of classic netCDF files: they stand in the file as they are, big-endian. */
#include "io/netcdf/netcdf_header.h"
#include "io/netcdf/netcdf.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/components.h"

#include <string.h>

static int open_classic(netcdf *file) {
    netcdf_header *header = file->content = pl_alloc_zero(1, sizeof *header);
    return header ? netcdf_header_read(file->model, header, file->error)
                  : pl_fail_memory(file->error, file->model->input.path);
}

static int close_classic(netcdf *file, int status) {
    if (file->content)
        netcdf_header_release(file->content);
    pl_free(file->content);
    return status;
}

static const char *data_of(const netcdf *file, const netcdf_variable *v) {
    return file->model->input.data + v->begin;
}

static int shape_of(netcdf *file, const char *name, netcdf_shape *shape) {
    const netcdf_header *header = file->content;
    const netcdf_variable *v = netcdf_header_find(header, name);
    if (!v || (v->is_record && header->n_records < 1)) /* no byte says how many values it has */
        return PLANISH_OK;
    if (v->rank > 2)
        return netcdf_fail(file, name, "an array of one or two dimensions was expected");
    *shape = (netcdf_shape){1, v->rank, {v->dims[0], v->dims[1]}, v->n};
    return PLANISH_OK;
}

static int find_dimension(netcdf *file, const char *name, int64_t *length) {
    *length = netcdf_header_dimension(file->content, name);
    return PLANISH_OK;
}

/** Find a variable that has one value for all time steps: *v, or NULL, there is none. */
static int find_plain(netcdf *file, const char *name, const netcdf_variable **v) {
    *v = netcdf_header_find(file->content, name);
    return *v && (*v)->is_record
               ? netcdf_fail(file, name, "it has values for each time step, which are not read")
               : PLANISH_OK;
}

static int read_integers(netcdf *file, const char *name, io_hdf5_integers *integers) {
    const netcdf_variable *v;
    const int status = find_plain(file, name, &v);
    if (status || !v)
        return status;
    if (v->type != NETCDF_INT && v->type != NETCDF_INT64)
        return netcdf_fail(file, name, "whole numbers of 4 or 8 bytes were expected");
    *integers = (io_hdf5_integers){.data = data_of(file, v),
                                   .n = v->n,
                                   .size = v->type == NETCDF_INT ? 4 : 8,
                                   .swapped = io_machine_is_little()};
    return PLANISH_OK;
}

static int read_texts(netcdf *file, const char *name, netcdf_texts *texts) {
    const netcdf_variable *v;
    const int status = find_plain(file, name, &v);
    if (status || !v || v->n == 0)
        return status;
    if (v->type != NETCDF_CHAR || v->rank < 1 || v->rank > 2)
        return netcdf_fail(file, name, "text was expected");
    texts->data = pl_alloc(v->n, 1);
    if (!texts->data)
        return pl_fail_memory(file->error, "the names of the file");
    memcpy(texts->data, data_of(file, v), (size_t)v->n);
    texts->n = v->dims[0];
    texts->length = v->n / v->dims[0];
    return PLANISH_OK;
}

static int read_attribute(netcdf *file, const char *variable, const char *name, char *text,
                          int64_t size) {
    const netcdf_variable *v = netcdf_header_find(file->content, variable);
    const io_slice value =
        v ? netcdf_header_text_attribute(file->content, v, name) : (io_slice){NULL, NULL};
    const netcdf_texts all = {(char *)(uintptr_t)value.begin, 1, io_slice_length(value)};
    if (value.begin)
        netcdf_text(&all, 0, text, size);
    return PLANISH_OK;
}

static int read_coordinates(netcdf *file, const char *name, int component, int n_components) {
    const netcdf_variable *v;
    io_model *model = file->model;
    int status = find_plain(file, name, &v);
    if (!status && (!v || (v->type != NETCDF_FLOAT && v->type != NETCDF_DOUBLE)))
        status = netcdf_fail(file, name, "coordinates (float or double) were expected");
    if (!status && v->n != model->n_nodes * n_components)
        status = netcdf_fail(file, name, "%lld coordinates for %lld nodes", (long long)v->n,
                             (long long)model->n_nodes);
    if (status)
        return status;
    const int size = v->type == NETCDF_FLOAT ? 4 : 8;
    const planish_precision precision =
        size == 4 ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
    if (model->n_spans > 0 && model->precision != precision)
        return netcdf_fail(file, name,
                           "this coordinate is of another precision than those before; give all "
                           "the same");
    model->precision = precision;
    for (int c = 0; c < n_components && !status; c++) {
        const int64_t begin = v->begin + c * model->n_nodes * size;
        const io_strided from = {model->input.data + begin, size, size,
                                 io_machine_is_little(),    0,    0};
        const io_span span = {.n_nodes = model->n_nodes,
                              .encoding = size == 4 ? IO_FLOAT32 : IO_FLOAT64,
                              .swapped = from.swapped,
                              .offset = begin,
                              .stride = size,
                              .component = component + c,
                              .n_components = 1};
        const int64_t bad = io_load_component(model, from, component + c);
        status = bad < 0 ? io_model_span(model, span, file->error)
                         : netcdf_fail(file, name, "node %lld has a coordinate that is not finite",
                                       (long long)bad + 1);
    }
    return status;
}

static int read_values(netcdf *file, const char *name, int64_t n, double *values) {
    const netcdf_header *header = file->content;
    const netcdf_variable *v = netcdf_header_find(header, name);
    const int swapped = io_machine_is_little();
    if (!v || (v->type != NETCDF_FLOAT && v->type != NETCDF_DOUBLE) || v->n != n ||
        (v->is_record && header->n_records < 1))
        return netcdf_fail(file, name, "%lld real numbers were expected", (long long)n);
    for (int64_t i = 0; i < n; i++)
        values[i] = v->type == NETCDF_FLOAT ? (double)io_load_f32(data_of(file, v) + 4 * i, swapped)
                                            : io_load_f64(data_of(file, v) + 8 * i, swapped);
    return PLANISH_OK;
}

const netcdf_kind netcdf_kind_classic = {.open = open_classic,
                                         .close = close_classic,
                                         .shape_of = shape_of,
                                         .dimension = find_dimension,
                                         .integers_read = read_integers,
                                         .texts_read = read_texts,
                                         .text_attribute = read_attribute,
                                         .coordinates = read_coordinates,
                                         .values = read_values};
