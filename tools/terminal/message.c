/* message: exit statuses and the one-line messages on standard error. */
#include "terminal/message.h"

#include "terminal/terminal.h"
#include "terminal/text.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { MESSAGE_SIZE = 1024 };

/** Whether text ends as a question does. */
static int is_question(const char *text) {
    const size_t length = strlen(text);
    return length > 0 && text[length - 1] == '?';
}

/** Print text on one line, whatever file names or tags brought into it; the word before it, or all of it,
 *  in style. hint: the command that helps further, or NULL. */
static void print_line(FILE *stream, pl_style style, const char *word, const char *format,
                       va_list arguments, const char *hint) {
    char text[MESSAGE_SIZE];
    const int is_whole = style == PL_STYLE_NOTE;
    vsnprintf(text, sizeof text, format, arguments);
    pl_text_clean(text);
    pl_line_clear();
    const char *begin = pl_style_begin(stream, style), *end = pl_style_end(stream, style);
    fprintf(stream, "%s%s%s %s", begin, word, is_whole ? "" : end, text);
    if (hint)
        fprintf(stream, "%s '%s'", is_question(text) ? " Try" : "; try", hint);
    fprintf(stream, "%s\n", is_whole ? end : "");
}

int pl_complain(int status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_line(stderr, PL_STYLE_ERROR, "planish:", format, arguments, NULL);
    va_end(arguments);
    return status;
}

int pl_complain_usage(const char *command, const char *format, ...) {
    char hint[64];
    snprintf(hint, sizeof hint, "planish %s%s--help", command ? command : "", command ? " " : "");
    va_list arguments;
    va_start(arguments, format);
    print_line(stderr, PL_STYLE_ERROR, "planish:", format, arguments, hint);
    va_end(arguments);
    return PL_EXIT_USAGE;
}

void pl_note(FILE *stream, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_line(stream, PL_STYLE_NOTE, "note:", format, arguments, NULL);
    va_end(arguments);
}

int pl_flush_stdout(int status, int failed) {
    if (fflush(stdout) == 0 && !ferror(stdout))
        return status;
    if (errno == EPIPE) /* a reader that has seen enough, as head */
        return failed;
    return pl_complain(failed, "cannot write to standard output: %s", strerror(errno));
}
