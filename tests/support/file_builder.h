/* file_builder: mesh files in memory, the same numbers as text or as binary of either byte order.
 */
#ifndef TEST_SUPPORT_FILE_BUILDER_H
#define TEST_SUPPORT_FILE_BUILDER_H

#include "base/printf.h"

#include <planish/planish_io.h>

#include "io/file/file.h"

typedef struct file_builder {
    char *data; /* [size], owned */
    int64_t size, capacity;
    int binary;  /* 0: numbers are text */
    int swapped; /* binary: not this machine's byte order */
    int wrap;    /* text: a line ends after this many numbers; 0: where builder_line says */
    int on_line; /* numbers of the line so far */
} file_builder;

void builder_release(file_builder *builder);

/** Text as it is. */
void builder_text(file_builder *builder, const char *format, ...) PL_PRINTF(2, 3);

/** A number: text and a space, or size bytes (integers 1, 2, 4, 8; reals 4, 8). */
void builder_integer(file_builder *builder, int64_t value, int size);
void builder_real(file_builder *builder, double value, int size);

/** Text: the end of the line. Binary: nothing. */
void builder_line(file_builder *builder);

/** Where a number that is written next will begin. */
int64_t builder_place(const file_builder *builder);

/** Read the file; what io_file_from_memory returns. */
int builder_read(const file_builder *builder, const io_format *format, int threads,
                 planish_file **file, planish_error *error);

/** Return a builder of that text, which is borrowed: it needs no release. */
file_builder builder_of(const char *text);

/** Read the file, which must succeed; close with planish_file_close. */
planish_file *builder_file(const file_builder *builder, const io_format *format);

/** Fails the test unless reading text fails and the error has part in its text. */
void builder_expect_error(const file_builder *builder, const io_format *format, const char *part);

/** Reads every beginning of the file (behind its first few thousand bytes one in many), each from
 *  memory of just its size, with its data, and lets every allocation fail once: nothing but an error
 *  or a mesh may come of it. */
void builder_try_to_break(const file_builder *builder, const io_format *format);

/** The second half of that: every allocation fails once. */
void builder_let_allocations_fail(const file_builder *builder, const io_format *format);

/** Fails the test unless one and several threads read the same model. */
void builder_expect_same_on_threads(const file_builder *builder, const io_format *format);

#endif
