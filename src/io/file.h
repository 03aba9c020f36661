/* file: the object behind planish_file; for file.c, constraints.c, splice.c and tests. */
#ifndef PL_IO_FILE_H
#define PL_IO_FILE_H

#include "io/model.h"

struct planish_file {
    io_model model;
    const io_format *format;
    int64_t n_regions; /* distinct ones among the elements smoothed */
};

/** The format called name, or NULL. */
const io_format *io_format_by_name(const char *name);

/** The format that the extension of path is of, or NULL. */
const io_format *io_format_by_extension(const char *path);

/** The format that the content, else the extension of path, is of; NULL if neither tells. */
const io_format *io_format_find(const char *path, const char *data, int64_t size);

/** Whether path ends in one of the format's extensions, letter case ignored. */
int io_format_has_extension(const io_format *format, const char *path);

/** Where the extension of path begins (its dot), or its end. */
const char *io_extension(const char *path);

/** planish_file_open that maps files of more than largest_copy bytes: for tests. */
int io_file_open(const char *path, int threads, int64_t largest_copy, planish_file **file,
                 planish_error *error);

/** Read size bytes at data (borrowed) as a file of format called path: for fuzzing and tests. */
int io_file_from_memory(const io_format *format, const char *path, const char *data, int64_t size,
                        int threads, planish_file **file, planish_error *error);

/** How far nodes of a plane may be off it by the digits that the file gives them, as a part of the
 *  diagonal of the bounding box; 0: what the library takes by itself. */
double io_tolerance_of_digits(const io_model *model, const io_format *format);

/** The simplices that are smoothed. */
const io_cells *io_file_elements(const planish_file *file);

#endif
