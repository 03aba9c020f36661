/* netcdf_hdf5: netCDF-4 files: variables are datasets in the root of an HDF5 file. */
#ifdef PL_HDF5
#include "io/netcdf/netcdf.h"

static io_hdf5_path path_of(netcdf *file, const char *name) {
    return io_hdf5_path_of(file->content, "/%s", name);
}

static int is_there(netcdf *file, const char *name) {
    return io_hdf5_kind_of(file->content, path_of(file, name).text) == IO_HDF5_DATASET;
}

static int open_hdf5(netcdf *file) {
    io_hdf5 *hdf5 = NULL;
    const int status = io_hdf5_open(file->model, &hdf5, file->error);
    file->content = hdf5;
    return status;
}

static int close_hdf5(netcdf *file, int status) {
    return io_hdf5_end(file->content, status);
}

static int shape_of(netcdf *file, const char *name, netcdf_shape *shape) {
    io_hdf5_shape found = {0};
    if (!is_there(file, name))
        return PLANISH_OK;
    const int status = io_hdf5_shape_of(file->content, path_of(file, name).text, &found);
    *shape = (netcdf_shape){1, found.rank, {found.dims[0], found.dims[1]}, found.n};
    return status;
}

/* A dimension without a variable of its name is a dataset as long as it, in which nothing is. */
static int find_dimension(netcdf *file, const char *name, int64_t *length) {
    netcdf_shape shape = {0};
    const int status = shape_of(file, name, &shape);
    *length = shape.is_there ? shape.dims[0] : 0;
    return status;
}

static int read_integers(netcdf *file, const char *name, io_hdf5_integers *integers) {
    return is_there(file, name)
               ? io_hdf5_integers_read(file->content, path_of(file, name).text, integers)
               : PLANISH_OK;
}

static int read_texts(netcdf *file, const char *name, netcdf_texts *texts) {
    int64_t n = 0, length = 0;
    netcdf_shape shape = {0};
    int status = shape_of(file, name, &shape);
    if (status || shape.n == 0)
        return status;
    status =
        io_hdf5_strings_read(file->content, path_of(file, name).text, &texts->data, &n, &length);
    texts->n = shape.dims[0];
    texts->length = n / texts->n * length;
    return status;
}

static int read_attribute(netcdf *file, const char *variable, const char *name, char *text,
                          int64_t size) {
    return io_hdf5_text_attribute(file->content, path_of(file, variable).text, name, text,
                                  (size_t)size, NULL);
}

static int read_coordinates(netcdf *file, const char *name, int component, int n_components) {
    const io_hdf5_place place = {
        path_of(file, name), component, n_components, 1, file->model->n_nodes, 0, 0};
    return io_hdf5_coordinates(file->content, &place);
}

static int read_values(netcdf *file, const char *name, int64_t n, double *values) {
    return io_hdf5_row_read(file->content, path_of(file, name).text, n, values);
}

const netcdf_kind netcdf_kind_hdf5 = {.open = open_hdf5,
                                      .close = close_hdf5,
                                      .shape_of = shape_of,
                                      .dimension = find_dimension,
                                      .integers_read = read_integers,
                                      .texts_read = read_texts,
                                      .text_attribute = read_attribute,
                                      .coordinates = read_coordinates,
                                      .values = read_values};

#endif
