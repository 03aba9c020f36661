/* hdf5_image: bytes in memory as a file of the HDF5 library; for hdf5*.c only. */
#ifndef PL_IO_HDF5_HDF5_IMAGE_H
#define PL_IO_HDF5_HDF5_IMAGE_H

#include "io/hdf5/hdf5_object.h"

/** Open the bytes as a file, to be read, or changed in a copy in memory; negative on failure. */
hid_t hdf5_open_bytes(const char *data, int64_t size, int is_writing);

/** Find the bytes before the library's own, which are not part of its image; -1 on failure. */
int64_t hdf5_user_block(hid_t file);

/** Take the changed bytes of a file that was opened for changes: *bytes [*size], to be released by
 *  pl_free. before: the bytes that it was made of. */
int hdf5_take_bytes(io_hdf5 *file, const char *before, char **bytes, int64_t *size);

#endif
