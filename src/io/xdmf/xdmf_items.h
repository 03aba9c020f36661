/* xdmf_items: the numbers of an XDMF file: in its text, in files of HDF5, and in files of bytes.
 *
 *   xdmf_file, xdmf_reader                     files while they are read
 *   xdmf_item, xdmf_items_in, xdmf_compare     DataItem elements
 *   xdmf_open, xdmf_take_input, xdmf_close     files beside
 *   xdmf_check_count, xdmf_integers, xdmf_reals    values
 *   xdmf_hdf5_...                              those in HDF5 (xdmf_hdf5.c)
 */
#ifndef PL_IO_XDMF_XDMF_ITEMS_H
#define PL_IO_XDMF_XDMF_ITEMS_H

#include "io/hdf5/hdf5.h"
#include "io/vtk/vtk_numbers.h"
#include "io/xdmf/xdmf_markup.h"

typedef enum xdmf_form { XDMF_TEXT, XDMF_HDF5, XDMF_BYTES } xdmf_form;

/** A file that the XML names. */
typedef struct xdmf_file {
    io_slice name;   /* in the XML */
    xdmf_form form;  /* that it was opened as: of HDF5 the bytes are a copy */
    io_model own;    /* its bytes, for errors; or */
    io_model *model; /* the reader's, if it has the coordinates */
    io_hdf5 *hdf5;   /* NULL: it is no HDF5 file, or has not been opened as one */
} xdmf_file;

typedef struct xdmf_reader {
    io_model *model;
    planish_error *error;
    xdmf_document document;
    xdmf_file **file; /* [n_files] owned */
    int64_t n_files, file_capacity;
    int64_t n_counted; /* values that are to be read, once for each reference to them */
} xdmf_reader;

/** A DataItem. */
typedef struct xdmf_item {
    int64_t element;
    xdmf_form form;
    int64_t n;     /* values, as Dimensions say; -1: they are not there */
    int64_t width; /* the last of several dimensions; else 1 */
    vtk_type type;
    int swapped;
    int64_t seek;   /* of XDMF_BYTES: the first byte */
    io_slice file;  /* its name, not of XDMF_TEXT, */
    io_slice place; /* and the path in a file of HDF5 */
} xdmf_item;

enum { XDMF_MOST_ITEMS = 4 };

/** Read the markup of the input. Close in any case. */
int xdmf_begin(io_model *model, xdmf_reader *reader, planish_error *error);

/** Close all files after a reader has come to status; return that or, where it is 0, what
 *  io_hdf5_end says. */
int xdmf_close(xdmf_reader *reader, int status);

/** Find the attributes of a DataItem. */
int xdmf_item_of(xdmf_reader *reader, int64_t element, xdmf_item *item);

/** Find the DataItem elements in an element: item [XDMF_MOST_ITEMS], *n of them. */
int xdmf_items_in(xdmf_reader *reader, int64_t element, xdmf_item *item, int *n);

/** Compare the places of numbers: 0 if both are the same, else their order. */
int xdmf_compare(const xdmf_item *a, const xdmf_item *b);

/** Open the file of an item, which is not XDMF_TEXT. */
int xdmf_open(xdmf_reader *reader, const xdmf_item *item, xdmf_file **file);

/** Make the file of the item, which has the coordinates, the input of the model; none is open yet. */
int xdmf_take_input(xdmf_reader *reader, const xdmf_item *item);

/** Find the number of values of an item, and check that they can be there before there is room for
 *  them. */
int xdmf_check_count(xdmf_reader *reader, const xdmf_item *item, int64_t *n);

/** Read n values, which have been checked, to whole numbers of 32 bits; those that do not fit are an
 *  error or -1. */
int xdmf_integers(xdmf_reader *reader, const xdmf_item *item, int64_t n, int32_t *values);
/** Read n values to real numbers. */
int xdmf_reals(xdmf_reader *reader, const xdmf_item *item, int64_t n, double *values);

/** Read n records of tokens words from an item of XDMF_TEXT, and nothing else may be there. */
int xdmf_read_text(xdmf_reader *reader, const xdmf_item *item, int64_t n, int64_t tokens,
                   io_records_fn *read, void *context);

/* ---- xdmf_hdf5.c: as above, of items of XDMF_HDF5 ------------------------------------------- */

/** Open a file of HDF5; fail if planish was built without that library. */
int xdmf_hdf5_open(xdmf_reader *reader, const xdmf_item *item, xdmf_file *file);
/** Close the file, as io_hdf5_end does. */
int xdmf_hdf5_end(xdmf_file *file, int status);
int xdmf_hdf5_count(const xdmf_file *file, const xdmf_item *item, int64_t *n);
int xdmf_hdf5_integers(const xdmf_file *file, const xdmf_item *item, int64_t n, int32_t *values);
int xdmf_hdf5_reals(const xdmf_file *file, const xdmf_item *item, int64_t n, double *values);

/** Read coordinates component .. + n_components - 1 of n nodes from first on. */
int xdmf_hdf5_coordinates(const xdmf_file *file, const xdmf_item *item, int component,
                          int n_components, int64_t first, int64_t n);

#endif
