/* child: Windows has no fork, and planish no HDF5 there: nothing is isolated. */
#include "io/child.h"

int io_child_run(io_child_fn *function, void *data, const char *name, planish_error *error) {
    (void)name;
    return function(data, error);
}
