/* companions: the files of a mesh that is in several files beside one another (TetGen's .node,
 * .ele,
 * ...): what they are called, and which of those that are there belong to it. */
#ifndef PL_IO_FILE_COMPANIONS_H
#define PL_IO_FILE_COMPANIONS_H

#include "io/file/file.h"

/** The file with the coordinates of the mesh at path, which may name a companion that the format
 *  is known by (.ele). Owned; NULL without memory. */
char *io_main_path(const io_format *format, const char *path);

/** The i-th path that a file of the mesh at path can have; format: its name, or NULL: told by the
 *  extension. Owned; NULL behind the last, of meshes that are one file, and without memory. */
char *io_mesh_file(const char *path, const char *format, int i);

/** How many companions planish_file_write to path writes: none into a pipe or device, nor where the
 *  input itself is replaced, beside which they are. */
int io_companions_to_write(const planish_file *file, const char *path);

/** Of what is beside path, nothing may be read along with the mesh that is written there and not be
 *  of it, and nothing be overwritten that is no companion: fails where that is so. */
int io_check_strangers(const planish_file *file, const char *path, planish_error *error);

#endif
