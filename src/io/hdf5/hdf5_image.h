/* hdf5_image: bytes in memory as a file of the HDF5 library; for hdf5*.c only. */
#ifndef PL_IO_HDF5_HDF5_IMAGE_H
#define PL_IO_HDF5_HDF5_IMAGE_H

#include "io/hdf5/hdf5_object.h"

/** Open the bytes as a file to be read; negative on failure. */
hid_t hdf5_open_bytes(const char *data, int64_t size);

/** A copy of bytes that the library changes. */
typedef struct hdf5_copy {
    void *of;      /* the bytes that it was made of */
    void *written; /* by malloc: all that the library wrote; NULL until it has closed the file, */
    int64_t size;  /* and the bytes there, of which some behind the file may be free */
} hdf5_copy;

/** Open a copy in memory of the bytes as a file to be changed; negative on failure. copy stays where it is
 *  until the file is closed; free(copy->written) then. */
hid_t hdf5_open_copy(const char *data, int64_t size, hdf5_copy *copy);

/** Find the bytes before the library's own, which are not part of its image; -1 on failure. */
int64_t hdf5_user_block(hid_t file);

/** Close a file that was opened by hdf5_open_copy, and take its bytes: *bytes [*size], to be released by
 *  pl_free. */
int hdf5_take_bytes(io_hdf5 *file, const hdf5_copy *copy, char **bytes, int64_t *size);

#endif
