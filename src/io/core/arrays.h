/* arrays: arrays of one number per cell of a file, which may be regions.
 *
 *   io_array_begin, _put, _end, _drop           an array of values by cell
 *   io_array_begin_elements, _put_element ...   or by element
 *   io_arrays_find_regions, io_arrays_choose    arrays make regions
 *
 * A reader fills in those whose values are whole numbers at all elements (io_model_elements and
 * io_model_other_elements, one after the other). When all has been read, planish_find_regions, or
 * the user, decides which of them are regions. They split the regions that the file's entities
 * make, if it has entities of its own (Gmsh, CGNS); a reader that fills in io_cells.region itself
 * has no arrays.
 */
#ifndef PL_IO_CORE_ARRAYS_H
#define PL_IO_CORE_ARRAYS_H

#include "io/core/model.h"

/** Arrays that are kept; further ones are passed over. */
enum { IO_MOST_ARRAYS = 256 };

/** An array while it is read: its values are put in the file's order of cells, or in any order
 *  by element. */
typedef struct io_array_filler {
    const io_model *model;
    int64_t next[2]; /* of the elements: the next simplex, and the next other one */
    io_array array;
    uint8_t *has;  /* by element: [n] whether an element has a value, */
    int64_t n_has; /* and how many have; NULL and 0 else */
    int is_broken; /* a value at an element is not whole: nothing more is kept */
} io_array_filler;

/** Begin an array of n_cells cells; the cells of the model have been read. */
int io_array_begin(const io_model *model, const char *name, int64_t n_cells,
                   io_array_filler *filler, planish_error *error);

/** Put the value of cell (from 0, ascending); is_whole: it is a whole number. */
int io_array_put(io_array_filler *filler, int64_t cell, int is_whole, int64_t value,
                 planish_error *error);

/** Begin an array whose values are put by element, in any order; the elements' numbers are reduced.
 */
int io_array_begin_elements(const io_model *model, const char *name, io_array_filler *filler,
                            planish_error *error);

/** Put the value of an element (its index); of several the last one counts. */
int io_array_put_element(io_array_filler *filler, int64_t element, int is_whole, int64_t value,
                         planish_error *error);

/** Return whether each element has a value. */
int io_array_is_full(const io_array_filler *filler);

/** Convert a real number to a whole one: 1, or 0 where it is none of 64 bits. */
int io_array_whole(double real, int64_t *value);

/** Give the array to the model, or release it where it is broken or an element has no value. */
int io_array_end(io_model *model, io_array_filler *filler, planish_error *error);

/** Release an array of io_array_begin without giving it to the model. */
void io_array_drop(io_array_filler *filler);

/** Make the regions of cells from the arrays that are regions. All has been read, and the model is
 *  to be finished. cells: all elements; NULL: simplices alone. */
int io_arrays_find_regions(io_model *model, const planish_cells *cells, planish_error *error);

/** Let the arrays called names [n_names], along with the file's own entities, make the regions, and
 *  release the values of all. Error: _ARGUMENT (no such array; the text lists those that there
 *  are). */
int io_arrays_choose(io_model *model, const char *const *names, int n_names, planish_error *error);

#endif
