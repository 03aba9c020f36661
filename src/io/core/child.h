/* child: a function run in a process of its own, so that it may crash. */
#ifndef PL_IO_CORE_CHILD_H
#define PL_IO_CORE_CHILD_H

#include "io/core/model.h"

#include <planish/planish.h>

/** Return 0, or a negative planish_status with *error filled in. */
typedef int io_child_fn(void *data, planish_error *error);

/** Fork, and call function(data, error), which reads input, in the child; return its result, with
 *  its error. Nothing but that and files come back; the child has one thread, and prints nothing.
 *  It gets a minute of CPU, more for large inputs; on Linux no more memory than any mesh in so many
 *  bytes can need. Errors besides: _FORMAT: it crashed on the input, or did not end; _MEMORY: no
 *  process could be started. */
int io_child_run(io_child_fn *function, void *data, const io_bytes *input, planish_error *error);

#endif
