/* file: the formats that there are, and opening a file. */
#ifndef PL_IO_FILE_FILE_H
#define PL_IO_FILE_FILE_H

#include "io/core/format.h"

/** The format called name, or NULL. */
const io_format *io_format_by_name(const char *name);

/** The format that the extension of path is of, or NULL. */
const io_format *io_format_by_extension(const char *path);

/** The format that the content, else the extension of path, is of; NULL if neither tells. */
const io_format *io_format_find(const char *path, const char *data, int64_t size);

/** planish_file_open that maps files of more than largest_copy bytes: for tests. */
int io_file_open(const char *path, int threads, int64_t largest_copy, planish_file **file,
                 planish_error *error);

/** Read size bytes at data (borrowed) as a file of format called path: for fuzzing and tests. */
int io_file_from_memory(const io_format *format, const char *path, const char *data, int64_t size,
                        int threads, planish_file **file, planish_error *error);

#endif
