/* message: exit statuses and the one-line messages on standard error. */
#include "terminal/message.h"

#include "terminal/terminal.h"
#include "terminal/text.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { MESSAGE_SIZE = 1024 };

/** Text and tail on one line, whatever file names or tags brought into text; the word before it, or
 *  all of it, in style. */
static void print_line(FILE *stream, pl_style style, const char *word, const char *format,
                       va_list arguments, const char *tail) {
    char text[MESSAGE_SIZE];
    const int is_whole = style == PL_STYLE_NOTE;
    vsnprintf(text, sizeof text, format, arguments);
    pl_text_clean(text);
    pl_line_clear();
    const char *begin = pl_style_begin(stream, style), *end = pl_style_end(stream, style);
    fprintf(stream, "%s%s%s %s%s%s\n", begin, word, is_whole ? "" : end, text, tail,
            is_whole ? end : "");
}

int pl_complain(int status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_line(stderr, PL_STYLE_ERROR, "planish:", format, arguments, "");
    va_end(arguments);
    return status;
}

int pl_complain_usage(const char *command, const char *format, ...) {
    char hint[64];
    const size_t length = strlen(format);
    const int is_question = length > 0 && format[length - 1] == '?';
    snprintf(hint, sizeof hint, "%s 'planish %s%s--help'", is_question ? " Try" : "; try",
             command ? command : "", command ? " " : "");
    va_list arguments;
    va_start(arguments, format);
    print_line(stderr, PL_STYLE_ERROR, "planish:", format, arguments, hint);
    va_end(arguments);
    return PL_EXIT_USAGE;
}

void pl_note(FILE *stream, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_line(stream, PL_STYLE_NOTE, "note:", format, arguments, "");
    va_end(arguments);
}

int pl_flush_stdout(int status, int failed) {
    if (fflush(stdout) == 0 && !ferror(stdout))
        return status;
    if (errno == EPIPE) /* a reader that has seen enough, as head */
        return failed;
    return pl_complain(failed, "cannot write to standard output: %s", strerror(errno));
}
