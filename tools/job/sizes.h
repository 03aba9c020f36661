/* sizes: the sizes that elements are to have, --size NAME, --size-from FILE and --keep-sizes.
 *
 *     pl_sizes_source       what they are from
 *     pl_sizes_read         sizes or metrics at all nodes of a mesh
 *     pl_sizes_free         free them
 */
#ifndef PL_TOOLS_SIZES_H
#define PL_TOOLS_SIZES_H

#include "options/options.h"

#include <planish/planish_io.h>

/** Return the array, or the file, that has the sizes. */
const char *pl_sizes_source(const pl_arguments *arguments);

/** Sizes at the nodes of a mesh. Arrays are owned. */
typedef struct pl_sizes {
    double *size;   /* [n_nodes] lengths of edges, or NULL */
    double *metric; /* [n_nodes][dim (dim + 1) / 2] as planish_mesh.metric, or NULL */
} pl_sizes;

/** Find the sizes that the options ask for at the nodes of mesh, which has all elements of file: lengths of
 *  edges above 0, or where values are tensors, metrics. Values of elements become those of nodes: the mean
 *  of their logarithms, or of metrics the mean. Nodes of no element have the mean of all others. sizes is to
 *  be freed also after an error. Returns 0, or an exit status after a message. */
int pl_sizes_read(const pl_arguments *arguments, planish_file *file, int threads,
                  const planish_mesh *mesh, pl_sizes *sizes);

void pl_sizes_free(pl_sizes *sizes);

#endif
