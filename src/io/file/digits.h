/* digits: how exact coordinates are, by the digits that a file gives them. */
#ifndef PL_IO_FILE_DIGITS_H
#define PL_IO_FILE_DIGITS_H

#include "io/core/format.h"

/** How far nodes of a plane may be off it by the digits that the file gives them, as a part of the
 *  diagonal of the bounding box; 0: what the library takes by itself. */
double io_tolerance_of_digits(const io_model *model, const io_format *format);

#endif
