/* sizes: the sizes that elements are to have, --size NAME, --size-from FILE and --keep-sizes.
 *
 *     pl_sizes_source       what they are from
 *     pl_sizes_read         sizes at all nodes of a mesh
 */
#ifndef PL_TOOLS_SIZES_H
#define PL_TOOLS_SIZES_H

#include "options/options.h"

#include <planish/planish_io.h>

/** Return the array, or the file, that has the sizes. */
const char *pl_sizes_source(const pl_arguments *arguments);

/** Find the sizes that the options ask for, lengths of edges above 0, at the nodes of mesh, which has all
 *  elements of file: *size [n_nodes], to be freed also after an error. Values of elements become those of
 *  nodes: the mean of their logarithms. Nodes of no element have the mean of all others. Returns 0, or an
 *  exit status after a message. */
int pl_sizes_read(const pl_arguments *arguments, planish_file *file, int threads,
                  const planish_mesh *mesh, double **size);

#endif
