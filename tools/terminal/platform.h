/* platform: the operating system for the program, without files and signals. One of
 * platform_posix.c and platform_windows.c is built. base/system.h is for the libraries.
 *
 *     pl_platform_begin             streams, environment and arguments
 *     pl_console_*                  what a terminal can do
 *     pl_peak_memory_bytes          memory of this process
 *     pl_memory_stream_*            text that is printed into memory
 */
#ifndef PL_TOOLS_PLATFORM_H
#define PL_TOOLS_PLATFORM_H

#include <stdint.h>
#include <stdio.h>

/** First of all, for the standard streams and the environment; argv [argc + 1] as bytes, of UTF-8
 *  where the system has its own, or NULL: the program cannot run. */
char **pl_platform_begin(int argc, char **argv);

/** Whether stream is a terminal. */
int pl_console_is(FILE *stream);

/** Whether terminals here move the cursor and show colours when told so. */
int pl_console_obeys(void);

/** Whether the characters that terminals here show are those of UTF-8. */
int pl_console_is_utf8(void);

/** Columns of the terminal that stream is, or 0. */
int pl_console_columns(FILE *stream);

/** The most memory that this process has had so far, or 0: not known. */
int64_t pl_peak_memory_bytes(void);

/** A stream whose text there is once it is closed. */
typedef struct pl_memory_stream {
    FILE *file; /* NULL: it could not be opened */
    char *text;
    size_t length;
} pl_memory_stream;

void pl_memory_stream_open(pl_memory_stream *stream);
/** The text, to be freed; NULL: there was not enough memory, for opening, either. */
char *pl_memory_stream_close(pl_memory_stream *stream);

#endif
