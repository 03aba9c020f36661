/* xdmf_hdf5: numbers of an XDMF file that stand in files of HDF5. */
#include "io/xdmf/xdmf_items.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

#ifndef PL_HDF5

int xdmf_hdf5_open(xdmf_reader *r, const xdmf_item *item, xdmf_file *file) {
    (void)file;
    return xdmf_fail(&r->document, item->element,
                     "this planish was built without HDF5, in which its numbers are; install "
                     "libhdf5-dev and build again, or write them into the XML");
}

int xdmf_hdf5_end(xdmf_file *file, int status) {
    (void)file;
    return status;
}

/* Nothing is read where nothing can be opened. */
int xdmf_hdf5_count(const xdmf_file *file, const xdmf_item *item, int64_t *n) {
    (void)file, (void)item, (void)n;
    return PLANISH_ERROR_FORMAT;
}

int xdmf_hdf5_integers(const xdmf_file *file, const xdmf_item *item, int64_t n, int32_t *values) {
    (void)file, (void)item, (void)n, (void)values;
    return PLANISH_ERROR_FORMAT;
}

int xdmf_hdf5_reals(const xdmf_file *file, const xdmf_item *item, int64_t n, double *values) {
    (void)file, (void)item, (void)n, (void)values;
    return PLANISH_ERROR_FORMAT;
}

int xdmf_hdf5_coordinates(const xdmf_file *file, const xdmf_item *item, int component,
                          int n_components, int64_t first, int64_t n) {
    (void)file, (void)item, (void)component, (void)n_components, (void)first, (void)n;
    return PLANISH_ERROR_FORMAT;
}

#else

int xdmf_hdf5_open(xdmf_reader *r, const xdmf_item *item, xdmf_file *file) {
    (void)item;
    return io_hdf5_open(file->model, &file->hdf5, r->error);
}

int xdmf_hdf5_end(xdmf_file *file, int status) {
    return io_hdf5_end(file->hdf5, status);
}

/** Return the path of an item from the root. */
static io_hdf5_path path_of(const xdmf_file *file, const xdmf_item *item) {
    io_slice place = item->place;
    while (place.begin < place.end && *place.begin == '/')
        place.begin++;
    const int64_t n = io_slice_length(place);
    return io_hdf5_path_of(file->hdf5, "/%.*s", n < IO_HDF5_PATH_SIZE ? (int)n : IO_HDF5_PATH_SIZE,
                           place.begin);
}

int xdmf_hdf5_count(const xdmf_file *file, const xdmf_item *item, int64_t *n) {
    io_hdf5_shape shape;
    const int status = io_hdf5_shape_of(file->hdf5, path_of(file, item).text, &shape);
    *n = shape.n;
    return status;
}

static int fail_count(const xdmf_file *file, const xdmf_item *item, int64_t n, int64_t there) {
    return io_hdf5_fail(file->hdf5, path_of(file, item).text,
                        "%lld values were expected, and there are %lld", (long long)n,
                        (long long)there);
}

int xdmf_hdf5_integers(const xdmf_file *file, const xdmf_item *item, int64_t n, int32_t *values) {
    io_hdf5_integers list = {0};
    int status = io_hdf5_integers_read(file->hdf5, path_of(file, item).text, &list);
    if (!status && list.n < n)
        status = fail_count(file, item, n, list.n);
    for (int64_t i = 0; i < n && !status; i++) {
        const int64_t value = io_hdf5_integer(&list, i);
        values[i] = value >= 0 && value <= INT32_MAX ? (int32_t)value : -1;
    }
    io_hdf5_integers_release(&list);
    return status;
}

int xdmf_hdf5_reals(const xdmf_file *file, const xdmf_item *item, int64_t n, double *values) {
    io_hdf5_shape shape = {0};
    double *all = NULL;
    int status = io_hdf5_reals_read(file->hdf5, path_of(file, item).text, &all, &shape);
    if (!status && shape.n < n)
        status = fail_count(file, item, n, shape.n);
    if (!status)
        memcpy(values, all, (size_t)n * sizeof *values);
    pl_free(all);
    return status;
}

int xdmf_hdf5_coordinates(const xdmf_file *file, const xdmf_item *item, int component,
                          int n_components, int64_t first, int64_t n) {
    const io_hdf5_place place = {
        path_of(file, item), component, n_components, n_components, 1, first, n};
    return io_hdf5_coordinates(file->hdf5, &place);
}

#endif
