/* comparison: several meshes side by side, a row each. */
#ifndef PL_TOOLS_COMPARISON_H
#define PL_TOOLS_COMPARISON_H

#include "report/result.h"

#include <stdio.h>

/** A mesh that was measured. */
typedef struct pl_compared {
    const char *name; /* the caller's */
    char *notes;      /* lines "note: TEXT" of what is odd about it, owned, or NULL */
    int64_t n_elements;
    pl_measured measured;
} pl_compared;

/** A row for each of mesh [n]; the best value of each column stands out on a terminal. has_volumes:
 *  with the elements below their minimum volume. The folder that all are in is left out of their
 *  names; names are cut only on a terminal that has no room for them, and stand on lines of their
 *  own where cut ones would be the same. Returns 0, or -1 without memory. */
int pl_comparison_print(FILE *stream, const pl_compared *mesh, int n, int has_volumes);

#endif
