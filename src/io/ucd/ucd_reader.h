/* ucd_reader: declarations that the readers of AVS UCD's text and binary files share.
 *
 *   ucd.c          the format, and its text
 *   ucd_binary.c   ucd_binary_recognise, ucd_binary_read: its binary files
 */
#ifndef PL_IO_UCD_UCD_READER_H
#define PL_IO_UCD_UCD_READER_H

#include "io/core/elements.h"

enum { UCD_N_COUNTS = 5, UCD_N_BINARY_TYPES = 8, UCD_N_TYPES = 15, UCD_MOST_NODES = 20 };

/** Types of cells; the first UCD_N_BINARY_TYPES by their numbers in binary files. */
extern const io_element_type ucd_types[UCD_N_TYPES];

/** Return whether the bytes begin a binary file. */
int ucd_binary_recognise(const char *data, int64_t size);

/** Read a binary file, and its counts. */
int ucd_binary_read(io_model *model, int64_t count[UCD_N_COUNTS], planish_error *error);

#endif
