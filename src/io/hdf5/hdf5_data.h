/* hdf5_data: open datasets: arrays of values; for hdf5*.c only. */
#ifndef PL_IO_HDF5_HDF5_DATA_H
#define PL_IO_HDF5_HDF5_DATA_H

#include "io/hdf5/hdf5_object.h"

/** An open dataset that may be read. */
typedef struct hdf5_dataset {
    hid_t id, type, list; /* list: of the properties that it was made with */
    io_hdf5_shape shape;
    int64_t size;             /* bytes of a value in the file */
    int64_t offset;           /* of its bytes, which stand there one after another; or -1 */
    int64_t row_block;        /* rows (of the first dimension) that are stored together */
    int is_chunked, is_plain; /* is_plain: no filters */
    hsize_t chunk[2];         /* rows and columns of one; 1, 1 without */
} hdf5_dataset;

/** Open the dataset at path and check that it can be read. Close in any case. */
int hdf5_dataset_open(io_hdf5 *file, const char *path, hdf5_dataset *dataset);
void hdf5_dataset_close(hdf5_dataset *dataset);

/** Read all values as type of size bytes: *values [n], owned by the caller; NULL on failure. */
int hdf5_dataset_read(io_hdf5 *file, const char *path, const hdf5_dataset *dataset, hid_t type,
                      size_t size, void **values);

/** Count the chunks whose places the library tells; 0: there is none, or it does not. */
hsize_t hdf5_count_chunks(const io_hdf5 *file, const hdf5_dataset *dataset);

/** Find the place in the file of chunk i of these, and the row and column at [2] where it
 * begins; -1: all of it is nowhere. */
int64_t hdf5_chunk_place(const io_hdf5 *file, const hdf5_dataset *dataset, hsize_t i,
                         hsize_t at[2]);

/** Match a type with two, of 4 and 8 bytes: its size, or 0: it is neither. *swapped: it has not
 *  this machine's byte order. */
int hdf5_match_type(hid_t type, const hid_t little[2], const hid_t big[2], int *swapped);

#endif
