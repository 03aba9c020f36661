/* writer: text and bytes on their way into a file. */
#include "io/view/writer.h"

#include "io/core/number.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void write_waiting(io_writer *writer) {
    if (!writer->status)
        writer->status =
            pl_output_write(writer->output, writer->bytes, (int64_t)writer->length, writer->error);
    writer->length = 0;
}

/** Make room for size bytes, at most IO_WRITER_SIZE; NULL after an error. */
static char *make_room(io_writer *writer, size_t size) {
    if (writer->length + size > IO_WRITER_SIZE)
        write_waiting(writer);
    return writer->status ? NULL : writer->bytes + writer->length;
}

void io_writer_begin(io_writer *writer, pl_output *output, planish_error *error) {
    *writer = (io_writer){.output = output, .error = error, .bytes = pl_alloc(IO_WRITER_SIZE, 1)};
    if (!writer->bytes)
        writer->status = pl_fail_memory(error, "the file to be written");
}

int io_writer_end(io_writer *writer) {
    write_waiting(writer);
    pl_free(writer->bytes);
    writer->bytes = NULL;
    return writer->status;
}

void io_put_bytes(io_writer *writer, const void *bytes, size_t size) {
    const char *from = bytes;
    while (size > 0 && !writer->status) {
        const size_t n = size < IO_WRITER_SIZE ? size : IO_WRITER_SIZE;
        char *at = make_room(writer, n);
        if (!at)
            return;
        memcpy(at, from, n);
        writer->length += n;
        from += n;
        size -= n;
    }
}

void io_put_text(io_writer *writer, const char *text) {
    io_put_bytes(writer, text, strlen(text));
}

void io_put_format(io_writer *writer, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    io_put_text(writer, text);
}

void io_put_integer(io_writer *writer, char lead, int64_t value) {
    char digits[24];
    size_t n = 0;
    uint64_t rest = value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
    do {
        digits[sizeof digits - ++n] = (char)('0' + rest % 10);
        rest /= 10;
    } while (rest > 0);
    if (value < 0)
        digits[sizeof digits - ++n] = '-';
    if (lead)
        digits[sizeof digits - ++n] = lead;
    io_put_bytes(writer, digits + sizeof digits - n, n);
}

void io_put_real(io_writer *writer, char lead, double value, int is_float) {
    char text[1 + IO_REAL_SIZE];
    text[0] = lead;
    const int n = io_format_real(text + 1, value, is_float);
    io_put_bytes(writer, lead ? text : text + 1, (size_t)n + (lead != 0));
}
