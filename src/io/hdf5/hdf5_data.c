/* hdf5_data: datasets of an HDF5 file: whether they can be read, and their numbers and text. */
#ifdef PL_HDF5
#include "io/hdf5/hdf5_data.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"

/* What a filter may make of the bytes of a file. */
enum { LARGEST_EXPANSION = 256, SMALL_DATA = 1 << 20 };

/* ---- datasets ----------------------------------------------------------------------------- */

static int take_shape(io_hdf5 *file, const char *path, hdf5_dataset *d) {
    hid_t space = H5Dget_space(d->id);
    hsize_t dims[2] = {1, 1};
    int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
    if (rank >= 0 && rank <= 2 && H5Sget_simple_extent_dims(space, dims, NULL) < 0)
        rank = -1;
    const H5S_class_t class = space < 0 ? H5S_NO_CLASS : H5Sget_simple_extent_type(space);
    hdf5_release(space);
    if (rank < 0 || rank > 2)
        return io_hdf5_fail(file, path, "an array of one or two dimensions was expected");
    if (dims[0] > INT64_MAX || dims[1] > INT64_MAX ||
        (dims[1] > 0 && dims[0] > INT64_MAX / dims[1]))
        return io_hdf5_fail(file, path, "its size is too large");
    d->shape = (io_hdf5_shape){.rank = rank, .dims = {(int64_t)dims[0], (int64_t)dims[1]}};
    d->shape.n = class == H5S_NULL ? 0 : d->shape.dims[0] * d->shape.dims[1];
    return PLANISH_OK;
}

/** Refuse a dataset whose bytes are not all there: the library would read elsewhere. */
static int fail_place(io_hdf5 *file, const char *path, const hdf5_dataset *d) {
    return io_hdf5_fail(file, path,
                        "its %lld values are not where they should be; the file is damaged or cut "
                        "short",
                        (long long)d->shape.n);
}

/** Check that the data are in the file itself, with filters that the library has by itself. */
static int check_layout(io_hdf5 *file, const char *path, hdf5_dataset *d) {
    const hid_t list = d->list;
    const H5D_layout_t layout = H5Pget_layout(list);
    if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
        return io_hdf5_fail(file, path,
                            "its data are put together from others (a virtual dataset), which is "
                            "not read; h5repack -l CONTI IN OUT makes them its own");
    if (layout == H5D_CONTIGUOUS && H5Pget_external_count(list) != 0)
        return io_hdf5_fail(file, path,
                            "its data are stored in other files, which is not read; h5repack -l "
                            "CONTI IN OUT puts them into one");
    if (layout == H5D_COMPACT &&
        H5Dget_storage_size(d->id) != (hsize_t)d->shape.n * (hsize_t)d->size)
        return fail_place(file, path, d);
    d->is_chunked = layout == H5D_CHUNKED;
    d->chunk[0] = d->chunk[1] = 1;
    if (d->is_chunked && H5Pget_chunk(list, 2, d->chunk) != d->shape.rank)
        return hdf5_fail_library(file, path, "its chunks cannot be read");
    d->row_block = d->is_chunked ? (int64_t)d->chunk[0] : d->shape.dims[0];
    const int n = H5Pget_nfilters(list);
    d->is_plain = n == 0;
    for (int i = 0; i < n; i++) {
        unsigned flags, config;
        size_t n_values = 0;
        char name[64] = "";
        H5Z_filter_t filter =
            H5Pget_filter2(list, (unsigned)i, &flags, &n_values, NULL, sizeof name, name, &config);
        if (filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_SHUFFLE &&
            filter != H5Z_FILTER_FLETCHER32)
            return io_hdf5_fail(file, path,
                                "filter %d (%.40s) is not read; h5repack -f GZIP=4 IN OUT makes a "
                                "file with another",
                                (int)filter, name);
    }
    return n < 0 ? hdf5_fail_library(file, path, "its filters cannot be read") : PLANISH_OK;
}

/** Check that what is allocated for the values is in a proportion to the file. */
static int check_size(io_hdf5 *file, const char *path, const hdf5_dataset *d) {
    const int64_t bytes = file->model->input.size;
    const int64_t most =
        d->is_plain ? bytes
                    : (bytes < INT64_MAX / LARGEST_EXPANSION / 2 ? LARGEST_EXPANSION * bytes
                                                                 : INT64_MAX / 2) +
                          SMALL_DATA;
    /* Numbers are read as such of 8 bytes: packed ones of fewer could become many times more. */
    const int64_t least = d->is_plain ? 1 : (int64_t)sizeof(double);
    const int64_t values = most / (d->size > least ? d->size : least);
    if (d->shape.n > values)
        return io_hdf5_fail(file, path,
                            "%lld values of %lld bytes cannot be in a file of %lld bytes; it is "
                            "damaged or cut short",
                            (long long)d->shape.n, (long long)d->size, (long long)bytes);
    /* A chunk may be larger than what there is, but not without limit. */
    const hsize_t largest = (hsize_t)(values < SMALL_DATA ? SMALL_DATA : values);
    if (d->is_chunked && (d->chunk[0] == 0 || d->chunk[1] == 0 || d->chunk[0] > largest ||
                          d->chunk[1] > largest / d->chunk[0]))
        return io_hdf5_fail(file, path, "its chunks of %llu x %llu values are larger than the file",
                            (unsigned long long)d->chunk[0], (unsigned long long)d->chunk[1]);
    return PLANISH_OK;
}

hsize_t hdf5_count_chunks(const io_hdf5 *file, const hdf5_dataset *d) {
    hsize_t n = 0;
#if H5_VERSION_GE(1, 10, 5)
    const int may_tell = d->is_chunked && d->is_plain && !file->has_user_block;
    const hid_t space = may_tell ? H5Dget_space(d->id) : -1;
    if (space < 0 || H5Dget_num_chunks(d->id, space, &n) < 0)
        n = 0;
    hdf5_release(space);
#else
    (void)file, (void)d;
#endif
    return n;
}

int64_t hdf5_chunk_place(const io_hdf5 *file, const hdf5_dataset *d, hsize_t i, hsize_t at[2]) {
    const haddr_t there = (haddr_t)file->model->input.size;
    const hsize_t bytes = d->chunk[0] * d->chunk[1] * (hsize_t)d->size;
    hsize_t size = 0;
    haddr_t offset = HADDR_UNDEF;
    at[0] = at[1] = 0;
#if H5_VERSION_GE(1, 10, 5)
    unsigned mask = 0;
    const hid_t space = H5Dget_space(d->id);
    if (space < 0 || H5Dget_chunk_info(d->id, space, i, at, &mask, &offset, &size) < 0)
        offset = HADDR_UNDEF;
    hdf5_release(space);
#else
    (void)i;
#endif
    return offset <= there && size == bytes && size <= there - offset ? (int64_t)offset : -1;
}

/** Find where the bytes are, if they are in one piece (or the only chunk has all values) and have
 *  been written: all in the file then, and as many as its values need. The library takes both for
 *  granted, and reads what is not there. */
static int find_place(io_hdf5 *file, const char *path, hdf5_dataset *d) {
    const haddr_t size = (haddr_t)file->model->input.size;
    const haddr_t needed = (haddr_t)(d->shape.n * d->size);
    d->offset = -1;
    if (d->shape.n == 0)
        return PLANISH_OK;
    if (d->is_chunked) {
        hsize_t at[2] = {0, 0};
        if (d->chunk[0] >= (hsize_t)d->shape.dims[0] && d->chunk[1] == (hsize_t)d->shape.dims[1] &&
            hdf5_count_chunks(file, d) == 1)
            d->offset = hdf5_chunk_place(file, d, 0, at);
        d->offset = at[0] == 0 ? d->offset : -1;
        return PLANISH_OK;
    }
    const haddr_t offset = H5Dget_offset(d->id);
    if (offset == HADDR_UNDEF)
        return PLANISH_OK;
    if (offset > size || needed > size - offset || H5Dget_storage_size(d->id) != needed)
        return fail_place(file, path, d);
    d->offset = (int64_t)offset;
    return PLANISH_OK;
}

int hdf5_dataset_open(io_hdf5 *file, const char *path, hdf5_dataset *d) {
    *d = (hdf5_dataset){.id = -1, .type = -1, .list = -1};
    if (io_hdf5_kind_of(file, path) != IO_HDF5_DATASET)
        return io_hdf5_fail(file, path, "there is no such array of data");
    d->id = H5Oopen(file->id, path, file->access);
    d->type = d->id < 0 ? -1 : H5Dget_type(d->id);
    d->list = d->id < 0 ? -1 : H5Dget_create_plist(d->id);
    if (d->type < 0 || d->list < 0)
        return hdf5_fail_library(file, path, "cannot be read");
    d->size = (int64_t)H5Tget_size(d->type);
    int status = take_shape(file, path, d);
    if (!status)
        status = check_layout(file, path, d);
    if (!status)
        status = check_size(file, path, d);
    return status ? status : find_place(file, path, d);
}

void hdf5_dataset_close(hdf5_dataset *d) {
    hdf5_release(d->list);
    hdf5_release(d->type);
    hdf5_release(d->id);
    *d = (hdf5_dataset){.id = -1, .type = -1, .list = -1};
}

int hdf5_dataset_read(io_hdf5 *file, const char *path, const hdf5_dataset *d, hid_t type,
                      size_t size, void **values) {
    *values = pl_alloc(d->shape.n, size);
    if (!*values)
        return pl_fail_memory(file->error, "the values of the file");
    if (d->shape.n == 0 || H5Dread(d->id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *values) >= 0)
        return PLANISH_OK;
    pl_free(*values);
    *values = NULL;
    return hdf5_fail_library(file, path, "its values cannot be read");
}

int hdf5_match_type(hid_t type, const hid_t little[2], const hid_t big[2], int *swapped) {
    for (int i = 0; i < 2; i++) {
        const int is_little = H5Tequal(type, little[i]) > 0;
        if (!is_little && H5Tequal(type, big[i]) <= 0)
            continue;
        *swapped = is_little != io_machine_is_little();
        return i ? 8 : 4;
    }
    return 0;
}

int io_hdf5_shape_of(io_hdf5 *file, const char *path, io_hdf5_shape *shape) {
    hdf5_dataset d;
    int status = hdf5_dataset_open(file, path, &d);
    *shape = d.shape;
    hdf5_dataset_close(&d);
    return status;
}

/* ---- values ------------------------------------------------------------------------------- */

int io_hdf5_integers_read(io_hdf5 *file, const char *path, io_hdf5_integers *a) {
    const hid_t little[] = {H5T_STD_I32LE, H5T_STD_I64LE}, big[] = {H5T_STD_I32BE, H5T_STD_I64BE};
    hdf5_dataset d;
    *a = (io_hdf5_integers){.size = sizeof(int64_t)};
    int status = hdf5_dataset_open(file, path, &d);
    if (!status && H5Tget_class(d.type) != H5T_INTEGER)
        status = io_hdf5_fail(file, path, "whole numbers were expected");
    if (!status) {
        const int size = d.offset >= 0 ? hdf5_match_type(d.type, little, big, &a->swapped) : 0;
        a->n = d.shape.n;
        if (size > 0) {
            a->size = size;
            a->data = file->model->input.data + d.offset;
        } else {
            status =
                hdf5_dataset_read(file, path, &d, H5T_NATIVE_INT64, sizeof(int64_t), &a->owned);
            a->data = a->owned;
        }
    }
    hdf5_dataset_close(&d);
    return status;
}

void io_hdf5_integers_release(io_hdf5_integers *a) {
    pl_free(a->owned);
    *a = (io_hdf5_integers){.size = sizeof(int64_t)};
}

int io_hdf5_strings_read(io_hdf5 *file, const char *path, char **text, int64_t *n,
                         int64_t *length) {
    hdf5_dataset d;
    void *values = NULL;
    int status = hdf5_dataset_open(file, path, &d);
    /* Text is characters, or numbers of one byte, or a fixed number of these. */
    const H5T_class_t class = status ? H5T_NO_CLASS : H5Tget_class(d.type);
    const hid_t of = class == H5T_ARRAY ? H5Tget_super(d.type) : -1;
    const int is_list = of >= 0 && H5Tget_class(of) == H5T_INTEGER && H5Tget_size(of) == 1;
    const int is_text = is_list || (class == H5T_STRING && H5Tis_variable_str(d.type) == 0) ||
                        (class == H5T_INTEGER && d.size == 1);
    hdf5_release(of);
    if (!status && !is_text)
        status = io_hdf5_fail(file, path, "text was expected");
    if (!status)
        status = hdf5_dataset_read(file, path, &d, d.type, (size_t)d.size, &values);
    *text = values;
    *n = d.shape.n;
    *length = d.size;
    hdf5_dataset_close(&d);
    return status;
}

int io_hdf5_reals_read(io_hdf5 *file, const char *path, double **values, io_hdf5_shape *shape) {
    hdf5_dataset d;
    void *reals = NULL;
    int status = hdf5_dataset_open(file, path, &d);
    H5T_class_t class = status ? H5T_NO_CLASS : H5Tget_class(d.type);
    if (!status && class != H5T_INTEGER && class != H5T_FLOAT)
        status = io_hdf5_fail(file, path, "numbers were expected");
    if (!status)
        status = hdf5_dataset_read(file, path, &d, H5T_NATIVE_DOUBLE, sizeof(double), &reals);
    *values = reals;
    *shape = d.shape;
    hdf5_dataset_close(&d);
    return status;
}

int io_hdf5_is_numbers(io_hdf5 *file, const char *path, io_hdf5_shape *shape, int *is_integer) {
    hdf5_dataset d;
    const int is_open = !hdf5_dataset_open(file, path, &d);
    const H5T_class_t class = is_open ? H5Tget_class(d.type) : H5T_NO_CLASS;
    *shape = d.shape;
    *is_integer = class == H5T_INTEGER;
    hdf5_dataset_close(&d);
    return class == H5T_INTEGER || class == H5T_FLOAT;
}

/** Read the first n values of an open dataset of real numbers. */
static int read_first(io_hdf5 *file, const char *path, const hdf5_dataset *d, int64_t n,
                      double *values) {
    const hsize_t start[] = {0, 0}, count[] = {1, (hsize_t)n}, *all = count + (d->shape.rank < 2);
    const hid_t from = H5Dget_space(d->id), to = H5Screate_simple(1, count + 1, NULL);
    const int is_read = from >= 0 && to >= 0 &&
                        H5Sselect_hyperslab(from, H5S_SELECT_SET, start, NULL, all, NULL) >= 0 &&
                        H5Dread(d->id, H5T_NATIVE_DOUBLE, to, from, H5P_DEFAULT, values) >= 0;
    hdf5_release(from);
    hdf5_release(to);
    return is_read ? PLANISH_OK : hdf5_fail_library(file, path, "its values cannot be read");
}

int io_hdf5_row_read(io_hdf5 *file, const char *path, int64_t n, double *values) {
    hdf5_dataset d;
    int status = hdf5_dataset_open(file, path, &d);
    const int64_t *dims = d.shape.dims;
    const int is_there =
        d.shape.rank == 2 ? dims[0] > 0 && dims[1] == n : d.shape.rank == 1 && dims[0] == n;
    if (!status && (H5Tget_class(d.type) != H5T_FLOAT || !is_there))
        status = io_hdf5_fail(file, path, "%lld real numbers were expected", (long long)n);
    if (!status && n > 0)
        status = read_first(file, path, &d, n, values);
    hdf5_dataset_close(&d);
    return status;
}

int io_hdf5_cell_array(io_hdf5 *file, const char *path, const char *name, int64_t n, int by_element,
                       const int32_t *element) {
    hdf5_dataset d;
    io_array_filler filler;
    io_hdf5_integers whole = {0};
    double *real = NULL;
    const int is_open = !hdf5_dataset_open(file, path, &d);
    const H5T_class_t class = is_open ? H5Tget_class(d.type) : H5T_NO_CLASS;
    const int is_real = class == H5T_FLOAT, is_read = is_real || class == H5T_INTEGER;
    io_hdf5_shape shape = d.shape;
    hdf5_dataset_close(&d);
    if (!is_read || shape.n != n)
        return PLANISH_OK;
    int status = is_real ? io_hdf5_reals_read(file, path, &real, &shape)
                         : io_hdf5_integers_read(file, path, &whole);
    if (!status)
        status = by_element ? io_array_begin_elements(file->model, name, &filler, file->error)
                            : io_array_begin(file->model, name, n, &filler, file->error);
    const int is_begun = !status;
    for (int64_t i = 0; i < n && !status && !filler.is_broken; i++) {
        int64_t value = is_real ? 0 : io_hdf5_integer(&whole, i);
        const int is_whole = is_real ? io_array_whole(real[i], &value) : 1;
        status = by_element ? io_array_put_element(&filler, element ? element[i] : i, is_whole,
                                                   value, file->error)
                            : io_array_put(&filler, i, is_whole, value, file->error);
    }
    if (!status)
        status = io_array_end(file->model, &filler, file->error);
    else if (is_begun)
        io_array_drop(&filler);
    io_hdf5_integers_release(&whole);
    pl_free(real);
    return status;
}

#endif
