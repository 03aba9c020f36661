/* bytes: the content of a file, mapped where it can be. */
#ifndef PL_IO_BYTES_H
#define PL_IO_BYTES_H

#include "io/model.h"

/** Map the regular file at path, or read anything else (a pipe) to its end. Errors (_FILE) say why;
 *  a folder and an empty file are errors. */
int io_bytes_open(const char *path, io_bytes *bytes, planish_error *error);

/** Borrow size bytes at data under the name path: nothing is released but the name. */
int io_bytes_borrow(const char *path, const char *data, int64_t size, io_bytes *bytes,
                    planish_error *error);

/** The bytes will not be read for some time: of a mapped file, the process's memory need not hold
 *  them until then. */
void io_bytes_rest(const io_bytes *bytes);

/** Whether nobody has written to a mapped file since it was opened, as far as its size and time
 * tell. Error: _FILE. */
int io_bytes_check_unchanged(const io_bytes *bytes, planish_error *error);

/** Whether fd leads to the mapped file itself. */
int io_bytes_are_of(const io_bytes *bytes, int fd);

void io_bytes_close(io_bytes *bytes);

#endif
