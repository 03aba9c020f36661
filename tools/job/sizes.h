/* sizes: the sizes that elements are to have, --size NAME, --size-from FILE and --keep-sizes.
 *
 *     pl_sizes_are_asked    whether an option asks for sizes
 *     pl_sizes_read         sizes or metrics of all nodes of a mesh
 *     pl_sizes_free         what that keeps
 */
#ifndef PL_TOOLS_SIZES_H
#define PL_TOOLS_SIZES_H

#include "options/options.h"

#include <planish/planish_io.h>

/** Wanted sizes at the nodes of a mesh: one of these is not NULL. */
typedef struct pl_sizes {
    double *size; /* [n_nodes] wanted length of edges, above 0, owned */
    double
        *metric; /* [n_nodes][dim (dim + 1) / 2] symmetric tensors in the mesh's coordinates, lower
                       triangle by rows, finite, owned: whether they are positive definite the
                       library finds out */
} pl_sizes;

/** Whether an option asks for sizes. */
int pl_sizes_are_asked(const pl_arguments *arguments);

/** Find the sizes that the options ask for, at the nodes of mesh, which has all elements of file. Values
 *  of elements become those of nodes: the mean of their logarithms. Nodes of no element have the mean of all
 *  others. sizes is to be freed also after an error. Returns 0, or an exit status after a message. */
int pl_sizes_read(const pl_arguments *arguments, planish_file *file, const planish_mesh *mesh,
                  pl_sizes *sizes);

void pl_sizes_free(pl_sizes *sizes);

#endif
