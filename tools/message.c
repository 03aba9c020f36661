/* message: exit statuses and the one-line messages on standard error. */
#include "message.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { MESSAGE_SIZE = 1024 };

/** "planish: " + text + tail on one line, whatever file names or tags brought into text. */
static void print_line(const char *format, va_list arguments, const char *tail) {
    char text[MESSAGE_SIZE];
    vsnprintf(text, sizeof text, format, arguments);
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 127)
            *c = '?';
    fprintf(stderr, "planish: %s%s\n", text, tail);
}

int pl_complain(int status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_line(format, arguments, "");
    va_end(arguments);
    return status;
}

int pl_complain_usage(const char *command, const char *format, ...) {
    char hint[64];
    snprintf(hint, sizeof hint, "; try 'planish %s%s--help'", command ? command : "",
             command ? " " : "");
    va_list arguments;
    va_start(arguments, format);
    print_line(format, arguments, hint);
    va_end(arguments);
    return PL_EXIT_USAGE;
}

int pl_flush_stdout(int status, int failed) {
    if (fflush(stdout) == 0 && !ferror(stdout))
        return status;
    return pl_complain(failed, "cannot write to standard output: %s", strerror(errno));
}
