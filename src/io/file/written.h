/* written: the files that planish_file_write makes, and their sources.
 *
 *   io_written, io_written_list      files, the one that was opened first
 *   io_written_find, _release        find them
 */
#ifndef PL_IO_FILE_WRITTEN_H
#define PL_IO_FILE_WRITTEN_H

#include "io/core/format.h"

/** A file to be written. */
typedef struct io_written {
    const io_bytes *from; /* the bytes, or NULL: of the file at source */
    char *source;         /* owned, or NULL */
    char *path;           /* owned */
    int has_coordinates;  /* they are written anew */
    io_edits edits;       /* made in other bytes; owned */
} io_written;

typedef struct io_written_list {
    io_written *file; /* [n] owned */
    int64_t n, capacity;
} io_written_list;

/** Find the files of a mesh that is no folder, written to path: the first has that name, or is the
 *  one with the coordinates. Fails where a file that is there already would be lost. Release in any
 *  case. Errors: _FILE, _MEMORY. */
int io_written_find(const planish_file *file, const char *path, io_written_list *list,
                    planish_error *error);
void io_written_release(io_written_list *list);

#endif
