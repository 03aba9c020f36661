/* status: fill in a planish_error in one line. */
#include "base/status.h"

#include "base/parallel.h"
#include "base/system.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/** Fill *error; a text that is longer than there is room for becomes its first and its last bytes:
 *  long is a path, and behind it stands what is wrong. */
static int fail(planish_error *error, planish_status code, int64_t element, int64_t node,
                const char *format, va_list arguments) {
    enum { LONGEST = 8192, HEAD = 100, SIZE = sizeof error->text }; /* a path or two, and words */
    char text[LONGEST];
    if (!error)
        return code;
    vsnprintf(text, sizeof text, format, arguments);
    error->code = code;
    error->element = element;
    error->node = node;
    const size_t length = strlen(text);
    if (length < SIZE) {
        memcpy(error->text, text, length + 1);
        return code;
    }
    const char *tail = text + length - (SIZE - HEAD - sizeof " ... ");
    size_t head = HEAD;
    while (head > 0 && (text[head] & 0xC0) == 0x80) /* no character of UTF-8 is cut */
        head--;
    while ((*tail & 0xC0) == 0x80)
        tail++;
    snprintf(error->text, SIZE, "%.*s ... %s", (int)head, text, tail);
    return code;
}

int(pl_fail)(planish_error *error, planish_status code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fail(error, code, -1, -1, format, arguments);
    va_end(arguments);
    return code;
}

int(pl_fail_at)(planish_error *error, planish_status code, int64_t element, int64_t node,
                const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fail(error, code, element, node, format, arguments);
    va_end(arguments);
    return code;
}

int pl_fail_errno(planish_error *error, const char *path, const char *what) {
    const int number = errno;
    char text[128];
    if (number == ENOMEM)
        return pl_fail_memory(error, path);
    pl_system_explain(number, text, sizeof text);
    return pl_fail(error, PLANISH_ERROR_FILE, "%s: %s: %s", path, what, text);
}

int pl_check_reserved(const char *name, const void *reserved, size_t size, planish_error *error) {
    const unsigned char *byte = reserved;
    for (size_t i = 0; i < size; i++)
        if (byte[i])
            return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                           "%s.reserved is not 0: zero the structure before you fill it in, with "
                           "the header of the library that is linked",
                           name);
    return PLANISH_OK;
}

int pl_check_threads(int threads, planish_error *error) {
    if (threads < 0 || threads > PL_MAX_THREADS)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "threads is %d; give 1 to %d, or 0 for as many as OpenMP would use", threads,
                       PL_MAX_THREADS);
    return PLANISH_OK;
}
