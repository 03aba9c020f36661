/* data: arrays of numbers that a file has for nodes or elements, read when somebody asks for them.
 *
 *   io_data_note, io_data_find    the places of arrays, noted while the file is read
 *   io_data_fail                  errors of an array
 *   io_data_pick                  values of cells become values of elements
 *
 * A reader notes the arrays that it passes over (model->data). io_format.read_data then goes back to
 * one of them. Its own bounds hold for bytes that have changed meanwhile, too.
 */
#ifndef PL_IO_CORE_DATA_H
#define PL_IO_CORE_DATA_H

#include "io/core/model.h"

/* Sections that are kept, and numbers that a value has at most: a tensor of 3 rows. */
enum { IO_MOST_DATA = 4096, IO_MOST_WIDTH = 9 };

/** Note an array behind the others: a copy of data, its name copied, too. A further array of a name is
 *  noted as more of the first. Those beyond IO_MOST_DATA are passed over. Error: _MEMORY. */
int io_data_note(io_model *model, io_data data, planish_error *error);

/** Find the first array of that name, of elements or of nodes; NULL: there is none. */
const io_data *io_data_find(const io_model *model, const char *name, int of_elements);

/** Fail with _FORMAT about an array: "FILE:LINE: array 'NAME': text", at byte at. */
int io_data_fail(const io_model *model, const io_data *data, int64_t at, planish_error *error,
                 const char *text);

/** Copy the values of the elements, whose numbers in the file are indices of cells, from those of all
 *  cells [n_cells][width]. */
void io_data_pick(const io_model *model, const double *cells, int64_t n_cells, int64_t width,
                  double *values);

#endif
