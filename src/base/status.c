/* status: fill in a planish_error in one line. */
#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>

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

int pl_fail_memory(planish_error *error, const char *what) {
    return pl_fail(error, PLANISH_ERROR_MEMORY, "out of memory for %s", what);
}
