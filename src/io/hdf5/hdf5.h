/* hdf5: declarations that the readers of formats in HDF5 share: objects by their path, numbers and
 * text of them, and coordinates with their places in the file's bytes.
 *
 *   io_hdf5_recognise, _open, _end, _fail                  a file (hdf5_file.c)
 *   io_hdf5_path_of, _kind_of, _list, _names_..., _check_only    objects
 *   io_hdf5_attribute, _text_attribute                     attributes
 *   io_hdf5_shape_of, _integers_..., _strings_read, _reals_read, _is_numbers, _row_read, _cell_array
 *                                                          datasets (hdf5_data.c)
 *   io_hdf5_coordinates, _coordinates_again, _is_as_long, _coordinates_end, _find_rows
 *                                                          coordinates (hdf5_coordinates.c)
 *   io_hdf5_amend, _release                                for io_format
 *
 * The HDF5 library gets the bytes that are in memory already. So planish writes back the bytes that
 * the library has read, also those of a pipe. It is used on one thread. Refused are links to other
 * files, data in other files, filters that the library does not have by itself, and data larger
 * than the file can hold.
 *
 * Coordinates that stand uncompressed in the file get spans. All others are changed by the HDF5
 * library in the finished copy (io_hdf5_amend).
 */
#ifndef PL_IO_HDF5_HDF5_H
#define PL_IO_HDF5_HDF5_H

#include "base/printf.h"

#include "io/core/format.h"
#include "io/hdf5/hdf5_integers.h"

typedef struct io_hdf5 io_hdf5;

/** Return whether the bytes are an HDF5 file that has an object at path. */
int io_hdf5_recognise(const char *data, int64_t size, const char *path);

/** Open model->input; is_binary is set. All functions fail with *error of here, which must stay. */
int io_hdf5_open(io_model *model, io_hdf5 **file, planish_error *error);
/** Close the file, which may be NULL, after a reader has come to status; return that. Where it is 0
 *  fail if a path was too long, or if io_hdf5_kind_of has called anything _NONE that is there, but
 *  could not be looked at (without memory, say). */
int io_hdf5_end(io_hdf5 *file, int status);

/** Fail with "FILE: PATH: text" as a _FORMAT error. */
int io_hdf5_fail(io_hdf5 *file, const char *path, const char *format, ...) PL_PRINTF(3, 4);

/* ---- objects: paths begin at the root ------------------------------------------------------ */

enum { IO_HDF5_PATH_SIZE = 1024 };

/** Path of an object. */
typedef struct io_hdf5_path {
    char text[IO_HDF5_PATH_SIZE];
} io_hdf5_path;

/** Return the path that format gives. One that is too long is cut off and remembered: the next
 *  error of the file, at the latest that of io_hdf5_end, says so. */
io_hdf5_path io_hdf5_path_of(io_hdf5 *file, const char *format, ...) PL_PRINTF(2, 3);

typedef enum io_hdf5_kind { IO_HDF5_NONE, IO_HDF5_GROUP, IO_HDF5_DATASET } io_hdf5_kind;
/** Find the kind of the object at path. */
io_hdf5_kind io_hdf5_kind_of(io_hdf5 *file, const char *path);

/** Names of the objects in a group, in the names' order. They belong to the file until it is closed.
 */
typedef struct io_hdf5_names {
    const char **name; /* [n] */
    int64_t n, capacity;
} io_hdf5_names;
/** List the names in the group at path. Fails on a link to another file. */
int io_hdf5_list(io_hdf5 *file, const char *path, io_hdf5_names *names);
/** Add a copy of a name. */
int io_hdf5_names_add(io_hdf5 *file, io_hdf5_names *names, const char *name);
/** Check that the group at path has one name; what: its meaning in messages (a mesh, say). */
int io_hdf5_check_only(io_hdf5 *file, const char *path, const char *what,
                       const io_hdf5_names *names);

/** Read the attribute of an object, a whole number or text (cut off at size). Without it value stays
 *  as it is. *found: it is there; found may be NULL. */
int io_hdf5_attribute(io_hdf5 *file, const char *path, const char *name, int64_t *value,
                      int *found);
int io_hdf5_text_attribute(io_hdf5 *file, const char *path, const char *name, char *text,
                           size_t size, int *found);

/* ---- data ---------------------------------------------------------------------------------- */

/** Dimensions of a dataset: rank 0 to 2 (others are refused), n values in all. */
typedef struct io_hdf5_shape {
    int rank;
    int64_t dims[2], n;
} io_hdf5_shape;
int io_hdf5_shape_of(io_hdf5 *file, const char *path, io_hdf5_shape *shape);

/** Read the dataset at path. Release in any case. */
int io_hdf5_integers_read(io_hdf5 *file, const char *path, io_hdf5_integers *integers);
void io_hdf5_integers_release(io_hdf5_integers *integers);

/** Read n strings of one length, one after another, as they stand there. *text is owned by the
 *  caller. Numbers of one byte are text, too. */
int io_hdf5_strings_read(io_hdf5 *file, const char *path, char **text, int64_t *n, int64_t *length);

/** Read numbers of any kind as doubles, and their shape; *values is owned by the caller. */
int io_hdf5_reals_read(io_hdf5 *file, const char *path, double **values, io_hdf5_shape *shape);

/** Return whether the object at path has numbers, and their shape. */
int io_hdf5_is_numbers(io_hdf5 *file, const char *path, io_hdf5_shape *shape, int *is_integer);

/** Read n real numbers as doubles: a dataset of so many, or the first row of one of rows of so many. */
int io_hdf5_row_read(io_hdf5 *file, const char *path, int64_t n, double *values);

/** Make an array called name (arrays.h) of a dataset of one number for each of n cells, in the
 *  file's order of cells. by_element: of the elements, which are n; value i is that of element
 *  element[i], or (NULL) of i. A dataset of another length, or that cannot be read as numbers, is
 *  passed over. */
int io_hdf5_cell_array(io_hdf5 *file, const char *path, const char *name, int64_t n, int by_element,
                       const int32_t *element);

/* ---- coordinates --------------------------------------------------------------------------- */

/** Components of nodes in a dataset: that of node first_node + i is value c * component_step +
 *  i * node_step, c = 0 .. n_components - 1, and becomes component + c of xyz. */
typedef struct io_hdf5_place {
    io_hdf5_path path;
    int component, n_components;
    int64_t node_step, component_step;
    int64_t first_node, n_nodes; /* n_nodes 0: all */
} io_hdf5_place;

/** Read coordinates, and tell the model their places; io_model_alloc_nodes has been called. The dataset
 * must have as many values as nodes and components say. */
int io_hdf5_coordinates(io_hdf5 *file, const io_hdf5_place *place);

/** Look at a possible copy of the coordinates that were read: of a copy the place is kept, too.
 *  *is_copy: it has the same values, of the same precision. */
int io_hdf5_coordinates_again(io_hdf5 *file, const io_hdf5_place *place, int *is_copy);

/** Return whether there is a dataset of n numbers at path that the readers can read. */
int io_hdf5_is_as_long(io_hdf5 *file, const char *path, int64_t n);

/** Put the places in the model in order, after all coordinates; z of nodes that have none is 0. */
int io_hdf5_coordinates_end(io_hdf5 *file);

/** Find where rows [n][width], or [n width], of doubles stand in the HDF5 file at path, whatever it
 * is, as they are in memory: *span [*n_spans], to be released by pl_free, in which nodes are rows.
 * None if they do not stand there like that, or there is no such dataset. */
int io_hdf5_find_rows(const char *path, const char *dataset, int64_t n, int width, io_span **span,
                      int64_t *n_spans, planish_error *error);

/* For io_format: what io_hdf5_coordinates has left in model->of_format. */
int io_hdf5_amend(const io_model *model, const double *coordinates, pl_output *output,
                  planish_error *error);
void io_hdf5_release(io_model *model);

#endif
