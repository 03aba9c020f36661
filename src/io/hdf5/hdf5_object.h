/* hdf5_object: declarations that the files of hdf5*.c share: errors of the HDF5 library, and its objects.
 *
 *   hdf5_silence, hdf5_restore, hdf5_fail_library    errors of the library
 *   hdf5_release, hdf5_link_access                   objects of the library, links to other files
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
    int is_outside;                  /* that is a link to another file */
    int is_too_long;                 /* that is a path cut off, of a name that is too long */
    void **kept;                     /* [n_kept] memory that io_hdf5_end releases */
    int64_t n_kept, kept_capacity;
    int has_user_block; /* bytes before HDF5's own: chunks are elsewhere than the library says */
};

/** Stop the library from printing errors, until hdf5_restore. */
hdf5_voice hdf5_silence(void);
void hdf5_restore(hdf5_voice voice);

/** Fail with "FILE: PATH: text (what the library says)". */
int hdf5_fail_library(io_hdf5 *file, const char *path, const char *text);

/** Close an object of the library, of whatever kind but a file; a negative one is none. */
void hdf5_release(hid_t id);

/** Make access to links that stays in the file; negative on failure. */
hid_t hdf5_link_access(void);

#endif
