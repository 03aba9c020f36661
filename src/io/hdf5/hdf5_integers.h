/* hdf5_integers: whole numbers of a file in HDF5, or of a classic netCDF file, which needs no library. */
#ifndef PL_IO_HDF5_HDF5_INTEGERS_H
#define PL_IO_HDF5_HDF5_INTEGERS_H

#include "io/core/binary.h"

/** Whole numbers: where they stand in the file, or a copy. */
typedef struct io_hdf5_integers {
    const char *data;
    int64_t n;
    int size, swapped; /* 4 or 8 bytes, signed */
    void *owned;       /* the copy, or NULL */
} io_hdf5_integers;

/** Return number i, from 0. */
static inline int64_t io_hdf5_integer(const io_hdf5_integers *integers, int64_t i) {
    return integers->size == 4 ? io_load_i32(integers->data + 4 * i, integers->swapped)
                               : io_load_i64(integers->data + 8 * i, integers->swapped);
}

#endif
