/* file: the formats that there are, and opening and writing a file of any.
 *
 *   io_format_at, _by_name, _by_extension, io_format_find    one of the formats
 *   io_file_open, io_file_from_memory     open a file: for tests and fuzzing
 *   io_file_read_data, _has_integers      arrays of numbers (data.c)
 *   io_model_finish                       a model that was read becomes a mesh (finish.c)
 *   io_mesh_file                          paths of the files of a mesh (write.c)
 *   io_write_coordinates                  the input's bytes with other coordinates (splice.c)
 *   io_check_inputs_unchanged             whether all files are what was read (splice.c)
 */
#ifndef PL_IO_FILE_FILE_H
#define PL_IO_FILE_FILE_H

#include "io/core/format.h"

/** Return format i, 0 and up, or NULL behind the last. */
const io_format *io_format_at(int i);

/** Find the format called name, or NULL. */
const io_format *io_format_by_name(const char *name);

/** Find the format that the extension of path is of, or NULL. */
const io_format *io_format_by_extension(const char *path);

/** Find the format that the content, else the extension of path, is of; NULL if neither tells. */
const io_format *io_format_find(const char *path, const char *data, int64_t size);

/** Open a file as planish_file_open does, but map files of more than largest_copy bytes: for
 *  tests. */
int io_file_open(const char *path, int threads, int64_t largest_copy, planish_file **file,
                 planish_error *error);

/** Read size bytes at data (borrowed) as a file of format called path: for fuzzing and tests. */
int io_file_from_memory(const io_format *format, const char *path, const char *data, int64_t size,
                        int threads, planish_file **file, planish_error *error);

/** Read an array as planish_file_data does, of nodes or of elements as of_elements says; values may be
 *  not finite. */
int io_file_read_data(planish_file *file, const char *name, int of_elements, planish_data *data,
                      planish_error *error);

/** Return whether the numbers of array i, as of planish_file_data_info, are whole by their type. */
int io_file_has_integers(const planish_file *file, int64_t i);

/** Decide the dimension (3 if there is a solid element, else 2), set plain cells apart, let lines,
 *  facets, and elements that are not smoothed hold their nodes, find the plane of flat elements (plane.h;
 *  without one they are a surface in space), lay out coordinates. Fails if there is nothing to smooth.
 *  format: that it was read as; NULL: text has as many digits as it needs. */
int io_model_finish(io_model *model, const io_format *format, planish_error *error);

/** Decide again which lines and facets are plain, and which hold their nodes, as arrays have given them other
 *  tags. Entities of the file's own stay, and so does what they hold. */
int io_model_hold_again(io_model *model, planish_error *error);

/** Return the i-th path that a file of the mesh at path can have. format: its name, or NULL: told
 *  by the extension. Owned; NULL behind the last, of meshes that are one file, and without
 *  memory. */
char *io_mesh_file(const char *path, const char *format, int i);

/** Write the bytes of the input with coordinates of places [n_places][written] to output, packed where
 *  the input is packed, and finish it. Where no coordinate differs, a packed input is copied. */
int io_write_coordinates(const planish_file *file, const double *coordinates, int threads,
                         pl_output *output, planish_error *error);

/** Check that no file has changed since it was read. Error: _FILE. */
int io_check_inputs_unchanged(const planish_file *file, planish_error *error);

#endif
