/* netcdf: netCDF files of all kinds behind one interface. */
#include "io/netcdf/netcdf.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/components.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static int is_classic(const char *data, int64_t size) {
    return size > 4 && memcmp(data, "CDF", 3) == 0 &&
           (data[3] == 1 || data[3] == 2 || data[3] == 5);
}

int netcdf_recognise(const char *data, int64_t size, const char *name) {
    if (is_classic(data, size))
        return 1;
#ifdef PL_HDF5
    return io_hdf5_recognise(data, size, name);
#else
    (void)name;
    return 0;
#endif
}

int netcdf_open(io_model *model, netcdf **out, planish_error *error) {
    const io_bytes *input = &model->input;
    const netcdf_kind *kind = &netcdf_kind_classic;
    *out = NULL;
    model->is_binary = 1;
    if (io_is_hdf5(input->data, input->size)) {
#ifdef PL_HDF5
        kind = &netcdf_kind_hdf5;
#else
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: this planish was built without HDF5, which this file (netCDF-4) needs: "
                       "install libhdf5-dev and build again, or convert it: nccopy -k cdf5 IN OUT",
                       input->path);
#endif
    } else if (!is_classic(input->data, input->size)) {
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: this is not a netCDF file (it begins neither with the mark of netCDF "
                       "nor with that of HDF5), but the format needs one",
                       input->path);
    }
    netcdf *file = pl_alloc_zero(1, sizeof *file);
    if (!file)
        return pl_fail_memory(error, input->path);
    *file = (netcdf){.model = model, .error = error, .kind = kind};
    const int status = kind->open(file);
    if (status)
        return netcdf_end(file, status);
    *out = file;
    return PLANISH_OK;
}

int netcdf_end(netcdf *file, int status) {
    if (!file)
        return status;
    status = file->kind->close(file, status);
    pl_free(file);
    return status;
}

int netcdf_fail(netcdf *file, const char *name, const char *format, ...) {
    char text[384];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return pl_fail(file->error, PLANISH_ERROR_FORMAT, "%s: %s: %s", file->model->input.path, name,
                   text);
}

int netcdf_shape_of(netcdf *file, const char *name, netcdf_shape *shape) {
    *shape = (netcdf_shape){0};
    return file->kind->shape_of(file, name, shape);
}

int netcdf_dimension(netcdf *file, const char *name, int64_t *length) {
    *length = 0;
    return file->kind->dimension(file, name, length);
}

int netcdf_integers_read(netcdf *file, const char *name, io_hdf5_integers *integers) {
    *integers = (io_hdf5_integers){.size = sizeof(int64_t)};
    return file->kind->integers_read(file, name, integers);
}

void netcdf_integers_release(io_hdf5_integers *integers) {
    pl_free(integers->owned);
    *integers = (io_hdf5_integers){.size = sizeof(int64_t)};
}

int netcdf_texts_read(netcdf *file, const char *name, netcdf_texts *texts) {
    *texts = (netcdf_texts){0};
    return file->kind->texts_read(file, name, texts);
}

io_slice netcdf_text_slice(const netcdf_texts *texts, int64_t i) {
    int64_t n = 0;
    const char *from = i < texts->n ? texts->data + i * texts->length : "";
    while (i < texts->n && n < texts->length && from[n])
        n++;
    while (n > 0 && from[n - 1] == ' ')
        n--;
    return (io_slice){from, from + n};
}

int64_t netcdf_text(const netcdf_texts *texts, int64_t i, char *text, int64_t size) {
    const io_slice all = netcdf_text_slice(texts, i);
    const int64_t length = io_slice_length(all), n = length < size - 1 ? length : size - 1;
    memcpy(text, all.begin, (size_t)n);
    text[n] = '\0';
    return n;
}

int netcdf_text_attribute(netcdf *file, const char *variable, const char *name, char *text,
                          int64_t size) {
    text[0] = '\0';
    return file->kind->text_attribute(file, variable, name, text, size);
}

int netcdf_coordinates(netcdf *file, const char *name, int component, int n_components) {
    return file->kind->coordinates(file, name, component, n_components);
}

int netcdf_coordinates_end(netcdf *file) {
    return io_components_end(file->model, file->error);
}

int netcdf_values(netcdf *file, const char *name, int64_t n, double *values) {
    return file->kind->values(file, name, n, values);
}
