/* hdf5_object: what hdf5.c, hdf5_image.c and hdf5_coordinates.c share: open objects of the HDF5
 * library.
 *
 *   hdf5_silence, hdf5_restore, hdf5_fail_library    errors of the library
 *   hdf5_open_bytes, hdf5_take_bytes, hdf5_user_block    a file in memory
 *   hdf5_release, hdf5_link_access                   objects of the library, links to other files
 *   hdf5_dataset_..., hdf5_chunk_place, hdf5_match_type    an array of values
 */
#ifndef PL_IO_HDF5_HDF5_OBJECT_H
#define PL_IO_HDF5_HDF5_OBJECT_H

#include "io/hdf5/hdf5.h"

#include <hdf5.h>

/** Handlers of the library's errors before it was silenced. */
typedef struct hdf5_voice {
    unsigned is_new;
    H5E_auto1_t old_function;
    H5E_auto2_t function;
    void *data;
} hdf5_voice;

struct io_hdf5 {
    io_model *model;
    planish_error *error;
    hdf5_voice voice;
    hid_t id;     /* of the file */
    hid_t access; /* of links: none to other files are followed */
    int has_precision;
    char unknown[IO_HDF5_PATH_SIZE]; /* an object that is there and could not be looked at; or "" */
    int is_too_long;                 /* that is a path cut off, of a name that is too long */
    void **kept;                     /* [n_kept] memory that io_hdf5_end releases */
    int64_t n_kept, kept_capacity;
    int has_user_block; /* bytes before HDF5's own: chunks are elsewhere than the library says */
};

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

/** Let the library tell nothing of errors, until hdf5_restore. */
hdf5_voice hdf5_silence(void);
void hdf5_restore(hdf5_voice voice);

/** Fail with "FILE: PATH: text (what the library says)". */
int hdf5_fail_library(io_hdf5 *file, const char *path, const char *text);

/** Open the bytes as a file, to be read, or changed in a copy in memory; negative on failure. */
hid_t hdf5_open_bytes(const char *data, int64_t size, int is_writing);

/** Find the bytes before the library's own, which are not part of its image; -1 on failure. */
int64_t hdf5_user_block(hid_t file);

/** Take what has become of a file that was opened to be changed: *bytes [*size], to be released by
 *  pl_free. before: the bytes that it was made of. */
int hdf5_take_bytes(io_hdf5 *file, const char *before, char **bytes, int64_t *size);

/** Close an object of the library, of whatever kind but a file; a negative one is none. */
void hdf5_release(hid_t id);

/** Make access to links that stays in the file; negative on failure. */
hid_t hdf5_link_access(void);

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
