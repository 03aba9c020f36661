/* bytes: the content of a file, in memory of its own or mapped.
 *
 *   io_bytes_open, io_bytes_borrow, io_bytes_close   take and release content
 *   io_bytes_own, io_bytes_can_change, _rest         private memory and mapped files
 *   io_bytes_check_unchanged, _fail_changed          changes by others
 *   io_bytes_are_of                                  compare with an open file
 */
#ifndef PL_IO_CORE_BYTES_H
#define PL_IO_CORE_BYTES_H

#include "io/core/model.h"

/* Readers look at some bytes several times. Their conclusions from the first look must hold at the
 * second one, although others may write to the file in between. So files of up to this size are
 * read into private memory, where nobody can change or shorten them: most meshes are smaller, and
 * the copy costs some milliseconds. Larger files are mapped, as the copy would be a good part of
 * the memory that smoothing takes; readers bound every second look by the first one. */
#define IO_LARGEST_COPY ((int64_t)64 << 20)

/** Read the regular file at path if it has at most largest_copy bytes, or map it; read anything
 * else (a pipe) to its end. Errors (_FILE) say why; a folder and an empty file are errors. */
int io_bytes_open(const char *path, int64_t largest_copy, io_bytes *bytes, planish_error *error);

/** Read a file that the user has not named, but that belongs to one: as io_bytes_open, but anything
 *  else than a regular file is an error, as reading a pipe there would wait without end. */
int io_bytes_open_beside(const char *path, int64_t largest_copy, io_bytes *bytes,
                         planish_error *error);

/** Read a mapped file into private memory, for code that cannot bound its second look. A file
 * larger than a quarter of the machine's memory stays mapped. */
int io_bytes_own(io_bytes *bytes, planish_error *error);

/** Return whether others can change the bytes: those of a mapped file. */
int io_bytes_can_change(const io_bytes *bytes);

/** Borrow size bytes at data under the name path: nothing is released but the name. */
int io_bytes_borrow(const char *path, const char *data, int64_t size, io_bytes *bytes,
                    planish_error *error);

/** Let the process's memory do without the bytes of a mapped file until they are read again. */
void io_bytes_rest(const io_bytes *bytes);

/** Check that nobody has written to a regular file since it was opened, as far as its size and time
 *  tell. Error: _FILE. */
int io_bytes_check_unchanged(const io_bytes *bytes, planish_error *error);

/** Fail with _FILE: the bytes of the file are others than before. */
int io_bytes_fail_changed(const io_bytes *bytes, planish_error *error);

/** Return whether fd leads to the regular file itself. */
int io_bytes_are_of(const io_bytes *bytes, int fd);

/** Release the bytes and the name. */
void io_bytes_close(io_bytes *bytes);

#endif
