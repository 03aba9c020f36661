/* status: fill in a planish_error in one line; checks that many public functions share.
 *
 *   pl_fail, pl_fail_at            any error; an error at an element or node
 *   pl_fail_memory, pl_fail_errno  a failed allocation; a failed operation on a file
 *   pl_check_reserved, pl_check_threads    what callers of many functions give
 */
#ifndef PL_BASE_STATUS_H
#define PL_BASE_STATUS_H

#include "base/printf.h"

#include <planish/planish.h>

/** Write code and text into *error (may be NULL), element and node as none; returns code. */
int pl_fail(planish_error *error, planish_status code, const char *format, ...) PL_PRINTF(3, 4);

/** Fill *error as pl_fail does for an error at an element and/or node (-1: none); returns code. */
int pl_fail_at(planish_error *error, planish_status code, int64_t element, int64_t node,
               const char *format, ...) PL_PRINTF(5, 6);

#ifdef __clang_analyzer__ /* It sees one file at a time. Here it learns that these return code. */
#define pl_fail(error, code, ...)    ((pl_fail)(error, code, __VA_ARGS__), (int)(code))
#define pl_fail_at(error, code, ...) ((pl_fail_at)(error, code, __VA_ARGS__), (int)(code))
#endif

/** Fail with the usual error for an allocation of what (a noun). Returns PLANISH_ERROR_MEMORY. */
static inline int pl_fail_memory(planish_error *error, const char *what) {
    pl_fail(error, PLANISH_ERROR_MEMORY, "out of memory for %s", what);
    return PLANISH_ERROR_MEMORY;
}

/** Fill *error from errno after an operation (what) on the file at path has failed; returns the
 *  code. */
int pl_fail_errno(planish_error *error, const char *path, const char *what);

/** Check that the reserved fields of a structure, of size bytes, are 0, so that later versions can give
 *  them a meaning. Errors: _ARGUMENT, with the structure's name. */
int pl_check_reserved(const char *name, const void *reserved, size_t size, planish_error *error);

/** Check a number of threads, 0 .. PL_MAX_THREADS (parallel.h). Errors: _ARGUMENT. */
int pl_check_threads(int threads, planish_error *error);

#endif
