/* status: fill in a planish_error in one line. */
#include "base/status.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static int fail(planish_error *error, planish_status code, int64_t element, int64_t node,
                const char *format, va_list arguments) {
    if (error) {
        error->code = code;
        error->element = element;
        error->node = node;
        vsnprintf(error->text, sizeof error->text, format, arguments);
    }
    return code;
}

int pl_fail(planish_error *error, planish_status code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fail(error, code, -1, -1, format, arguments);
    va_end(arguments);
    return code;
}

int pl_fail_at(planish_error *error, planish_status code, int64_t element, int64_t node,
               const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fail(error, code, element, node, format, arguments);
    va_end(arguments);
    return code;
}

int pl_fail_errno(planish_error *error, const char *path, const char *what) {
    const int number = errno;
    char text[128]; /* strerror's own may be of another thread by now */
    if (number == ENOMEM)
        return pl_fail_memory(error, path);
    if (strerror_r(number, text, sizeof text) != 0)
        snprintf(text, sizeof text, "error %d of the system", number);
    return pl_fail(error, PLANISH_ERROR_FILE, "%s: %s: %s", path, what, text);
}
