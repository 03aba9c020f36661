/* message: exit statuses and the one-line messages on standard error.
 *
 *     pl_complain, pl_complain_usage, pl_note        messages
 *     pl_flush_stdout                                the end of standard output
 */
#ifndef PL_TOOLS_MESSAGE_H
#define PL_TOOLS_MESSAGE_H

#include "base/printf.h"

#include <stdio.h>

/** Exit statuses of the program. */
enum {
    PL_EXIT_DONE = 0,   /* all that was asked for */
    PL_EXIT_PARTLY = 1, /* a usable mesh was written, but something asked for was not reached */
    PL_EXIT_FAILED = 2, /* nothing was written */
    PL_EXIT_USAGE = 64  /* the command line makes no sense (EX_USAGE of sysexits.h) */
};

/** Each takes the line of the progress away first (terminal.h). */

/** Print "planish: text" as one line (control characters become '?'); returns status. */
int pl_complain(int status, const char *format, ...) PL_PRINTF(2, 3);

/** Print it for a bad command line, with a hint to the help of command (NULL: of the program);
 *  returns PL_EXIT_USAGE. */
int pl_complain_usage(const char *command, const char *format, ...) PL_PRINTF(2, 3);

/** Print "note: text" as one line on stream. */
void pl_note(FILE *stream, const char *format, ...) PL_PRINTF(2, 3);

/** Write out what is buffered on stdout; returns status, or failed if it cannot: with a message,
 *  unless it is that nobody reads on. */
int pl_flush_stdout(int status, int failed);

#endif
