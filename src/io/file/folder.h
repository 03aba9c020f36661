/* folder: meshes that are folders: which files they are, and where they are written.
 *
 *   io_folder_is, io_folder_trim       whether a path is one of a folder; without separators at its end
 *   io_folder_find_mesh                open the file with the coordinates
 *   io_folder_mesh_file                files of the mesh, by number
 *   io_folder_can_write, _check, _write
 */
#ifndef PL_IO_FILE_FOLDER_H
#define PL_IO_FILE_FOLDER_H

#include "io/core/format.h"

/** Return whether there is a folder at path. */
int io_folder_is(const char *path);

/** Copy path without separators at its end. Owned; NULL without memory. */
char *io_folder_trim(const char *path);

/** Find the one mesh in the folder at path, of the format called name (NULL: any); set file->format,
 *  model->folder, inner and packed, and open model->input. Errors: _FILE (no mesh, or several: the text
 *  lists them), _ARGUMENT (unknown format), and those of io_bytes_open. */
int io_folder_find_mesh(planish_file *file, const char *path, const char *name,
                        planish_error *error);

/** Return the path of the i-th file that a mesh in the folder at path can have, or NULL behind the
 *  last. Owned. */
char *io_folder_mesh_file(const char *path, int i);

/** Return whether the mesh, a folder, may be written to path: as planish_file_can_write. */
int io_folder_can_write(const planish_file *file, const char *path);

/** Return whether path is the folder that the mesh was read from. */
int io_folder_is_input(const planish_file *file, const char *path);

/** Check path as planish_file_check_output does. */
int io_folder_check(const planish_file *file, const char *path, planish_error *error);

/** Write the mesh to a new folder, with coordinates of places [n_places][written]. */
int io_folder_write(const planish_file *file, const char *path, const double *coordinates,
                    int threads, pl_temporaries temporaries, planish_error *error);

#endif
