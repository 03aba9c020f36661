/* comparison: several meshes side by side, a row each. */
#ifndef PL_TOOLS_COMPARISON_H
#define PL_TOOLS_COMPARISON_H

#include "result.h"

#include <stdio.h>

/** A mesh that was measured. */
typedef struct pl_compared {
    const char *name; /* the caller's */
    int64_t n_elements;
    pl_measured measured;
} pl_compared;

/** A row for each of mesh [n]; the best value of each column stands out on a terminal. has_volumes:
 *  with the elements below their least volume. */
void pl_comparison_print(FILE *stream, const pl_compared *mesh, int n, int has_volumes);

#endif
