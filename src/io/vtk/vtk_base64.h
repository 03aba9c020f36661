/* vtk_base64: bytes from base64 text and back, as a stream: white space is passed over, and a
 * segment that ends in padding may be followed by another (VTK's headers are segments of their
 * own).
 *
 *   io_base64_read      read bytes
 *   io_base64_replace   replace bytes in a text
 */
#ifndef PL_IO_VTK_VTK_BASE64_H
#define PL_IO_VTK_VTK_BASE64_H

#include "io/core/text.h"

/** A stream of bytes from text. */
typedef struct io_base64 {
    io_cursor cursor;
    unsigned char pending[3]; /* decoded, and not asked for yet */
    int n_pending;
} io_base64;

/** Read the next n bytes to out. 0, or -1: the text ends before or is no base64 (the cursor stands
 *  there). */
int io_base64_read(io_base64 *stream, int64_t n, char *out);

/** Replace bytes first .. first + n - 1 of the stream that text [length] is by data [n], in the
 *  same characters: groups of four whose bytes do not change, white space and padding stay. Return
 *  how many characters, from the first, these bytes and those before them are. */
int64_t io_base64_replace(char *text, int64_t length, int64_t first, int64_t n, const char *data);

#endif
