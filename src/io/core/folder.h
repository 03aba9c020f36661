/* folder: files of a mesh that is a folder, for its reader.
 *
 *   io_folder_path       the path of a file
 *   io_folder_file       a file that is read beside the one with the coordinates
 *   io_folder_open, _close
 */
#ifndef PL_IO_CORE_FOLDER_H
#define PL_IO_CORE_FOLDER_H

#include "io/core/model.h"

/** A file of the folder, as it is read. */
typedef struct io_folder_file {
    io_model
        view; /* input: its bytes, unpacked; threads: for io_fail_at, io_text_init. Set is_binary */
    int is_unpacked; /* they are the file's own; else the companion's */
} io_folder_file;

enum { IO_FOLDER_FILES = 8 }; /* that are read, at most */

/** Join the folder of the model, the place of its files in it, and a name. Owned; NULL without memory. */
char *io_folder_path(const io_model *model, const char *name);

/** Open the file called name of the model's folder, or NAME.gz if it may be packed, and note it
 *  as a companion. Without it (view.input.data NULL) it is an error if needed. An empty file counts as
 *  none where it is not needed. Errors: _FILE, _FORMAT, _MEMORY. */
int io_folder_open(io_model *model, const char *name, int may_be_packed, int needed,
                   io_folder_file *file, planish_error *error);

/** Release the memory of the file. */
void io_folder_close(io_folder_file *file);

#endif
