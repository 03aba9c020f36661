/* writer: text and bytes on their way into a file, in pieces.
 *
 *   io_writer_begin, _end            begin; write what waits
 *   io_put_format, _text, _bytes     put text
 *   io_put_integer, _real            put a number
 *
 * After an error nothing more is written; io_writer_end returns the error.
 */
#ifndef PL_IO_VIEW_WRITER_H
#define PL_IO_VIEW_WRITER_H

#include "base/output.h"
#include "base/printf.h"

enum { IO_WRITER_SIZE = 1 << 16 };

typedef struct io_writer {
    pl_output *output;
    planish_error *error;
    int status;
    size_t length; /* of the bytes that wait in */
    char *bytes;   /* [IO_WRITER_SIZE] owned */
} io_writer;

/** Begin to write to output. To be ended in any case. */
void io_writer_begin(io_writer *writer, pl_output *output, planish_error *error);
/** Write what waits. Return the status of all that was written. */
int io_writer_end(io_writer *writer);

/** Put size bytes. */
void io_put_bytes(io_writer *writer, const void *bytes, size_t size);
/** Put a text. */
void io_put_text(io_writer *writer, const char *text);
/** Put a text of at most 511 bytes as printf does. */
void io_put_format(io_writer *writer, const char *format, ...) PL_PRINTF(2, 3);
/** Put lead (0: nothing) and a whole number. */
void io_put_integer(io_writer *writer, char lead, int64_t value);
/** Put lead (0: nothing) and the shortest text of a real number; is_float: of the float. */
void io_put_real(io_writer *writer, char lead, double value, int is_float);

#endif
