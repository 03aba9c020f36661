/* child: Windows has no fork, and planish no HDF5 there: nothing is isolated. */
#include "io/core/child.h"

int io_child_run(io_child_fn *function, void *data, const io_bytes *input, planish_error *error) {
    (void)input;
    return function(data, error);
}
