/* same: whether two files have one mesh but for coordinates. */
#ifndef PL_TOOLS_SAME_H
#define PL_TOOLS_SAME_H

#include <planish/planish_io.h>

/** A mesh, and the file that it is of. */
typedef struct pl_same_mesh {
    const char *path;
    const planish_file *file;
    const planish_mesh *mesh; /* both of a comparison with cells, or both without */
} pl_same_mesh;

/** Check that two meshes have as many nodes, and the same elements in the same order. Returns 0, or an exit
 *  status after a message that ends in advice. */
int pl_same_check(const pl_same_mesh *mine, const pl_same_mesh *other, const char *advice);

/** Return whether that is so. */
int pl_same_meshes(const planish_mesh *a, const planish_mesh *b);

#endif
