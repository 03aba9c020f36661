/* netcdf: netCDF files of all kinds, as readers of formats in netCDF see them: variables by their
 * names, their whole numbers, texts, and coordinates with their places.
 *
 *   netcdf_recognise, _open, _end, _fail       a file
 *   netcdf_shape_of, _dimension                variables and dimensions
 *   netcdf_kind                                what a kind of files has functions for
 *   netcdf_integers_read, _texts_read, _text_attribute    values
 *   netcdf_coordinates, _coordinates_end       coordinates
 *   netcdf_values                              real numbers, of the first time step
 *
 * A file is a classic one (netcdf_classic.c), or one in HDF5 (netcdf_hdf5.c): netCDF-4. Groups of
 * netCDF-4 are not looked at.
 */
#ifndef PL_IO_NETCDF_NETCDF_H
#define PL_IO_NETCDF_NETCDF_H

#include "base/printf.h"

#include "io/core/text.h"
#include "io/hdf5/hdf5.h"

typedef struct netcdf netcdf;

/** Return whether the bytes are a classic netCDF file, or an HDF5 file with a dataset of that name. */
int netcdf_recognise(const char *data, int64_t size, const char *name);

/** Open model->input; is_binary is set. All functions fail with *error of here, which must stay. */
int netcdf_open(io_model *model, netcdf **file, planish_error *error);

/** Close the file, which may be NULL, after a reader has come to status; return that, or, where it
 *  is 0, what io_hdf5_end says. */
int netcdf_end(netcdf *file, int status);

/** Fail with "FILE: NAME: text" as a _FORMAT error. */
int netcdf_fail(netcdf *file, const char *name, const char *format, ...) PL_PRINTF(3, 4);

/** Dimensions of a variable: rank 0 to 2 (others are refused), n values in all; of one by time
 *  steps those of one step. */
typedef struct netcdf_shape {
    int is_there; /* else all is 0 */
    int rank;
    int64_t dims[2], n;
} netcdf_shape;
int netcdf_shape_of(netcdf *file, const char *name, netcdf_shape *shape);

/** Find the length of a dimension, or 0: there is none. */
int netcdf_dimension(netcdf *file, const char *name, int64_t *length);

/** Read the whole numbers of a variable, none if there is no such variable; io_hdf5_integer takes one
 *  of them. Release in any case. */
int netcdf_integers_read(netcdf *file, const char *name, io_hdf5_integers *integers);
void netcdf_integers_release(io_hdf5_integers *integers);

/** Texts of one length, one after another, that zeros or blanks fill up. */
typedef struct netcdf_texts {
    char *data; /* [n][length] owned */
    int64_t n, length;
} netcdf_texts;

/** Read the texts of a variable, none if there is no such variable. Released by pl_free. */
int netcdf_texts_read(netcdf *file, const char *name, netcdf_texts *texts);

/** Return text i without what fills it up; nothing if there is none. */
io_slice netcdf_text_slice(const netcdf_texts *texts, int64_t i);

/** Copy text i, without what fills it up, into text [size], cut off there; "" if there is none. Return
 *  its length. */
int64_t netcdf_text(const netcdf_texts *texts, int64_t i, char *text, int64_t size);

/** Read the text attribute of a variable (cut off at size); "" if there is none. */
int netcdf_text_attribute(netcdf *file, const char *variable, const char *name, char *text,
                          int64_t size);

/** Read a variable of coordinates, n_components planes of all nodes, as those from component on, and
 *  tell the model their places; io_model_alloc_nodes has been called. */
int netcdf_coordinates(netcdf *file, const char *name, int component, int n_components);

/** Put the places in the model in order, after all coordinates; z of nodes that have none is 0. */
int netcdf_coordinates_end(netcdf *file);

/** Read n real numbers: a variable, or its first time step. */
int netcdf_values(netcdf *file, const char *name, int64_t n, double *values);

/* ---- for netcdf*.c -------------------------------------------------------------------------- */

/** Functions of a kind of files: what they read has been set to nothing, and a variable that is not
 *  there leaves it at that. */
typedef struct netcdf_kind {
    int (*open)(netcdf *file); /* has set model->is_binary */
    int (*close)(netcdf *file, int status);
    int (*shape_of)(netcdf *file, const char *name, netcdf_shape *shape);
    int (*dimension)(netcdf *file, const char *name, int64_t *length);
    int (*integers_read)(netcdf *file, const char *name, io_hdf5_integers *integers);
    int (*texts_read)(netcdf *file, const char *name, netcdf_texts *texts);
    int (*text_attribute)(netcdf *file, const char *variable, const char *name, char *text,
                          int64_t size);
    int (*coordinates)(netcdf *file, const char *name, int component, int n_components);
    int (*values)(netcdf *file, const char *name, int64_t n, double *values);
} netcdf_kind;

extern const netcdf_kind netcdf_kind_classic, netcdf_kind_hdf5;

struct netcdf {
    io_model *model;
    planish_error *error;
    const netcdf_kind *kind;
    void *content; /* of the kind */
};

#endif
