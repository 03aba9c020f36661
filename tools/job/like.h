/* like: the target of each element is its shape in another file, --like FILE.
 *
 *     pl_like_read      read FILE, and check that it fits
 *     pl_like_layers, _sizes    targets by layers, or by sizes
 *     pl_like_free      what that keeps
 *
 * Where there is such a file all ratios are aspect ratios AR against the targets, of simplices, too, and
 * the mesh has cells.
 */
#ifndef PL_TOOLS_LIKE_H
#define PL_TOOLS_LIKE_H

#include "job/sizes.h"
#include "options/options.h"

#include <planish/planish_io.h>

/** The mesh of another file, or the layers of the input, whose elements are the targets. */
typedef struct pl_like {
    double *place; /* [n_nodes][dim] of the nodes there, owned; NULL: there are no targets */
    uint8_t
        *is_layer;  /* [elements] of layers in the input, which place is of then, owned; or NULL */
    pl_sizes sizes; /* that elements are to have at place, which is the input's, owned */
    uint64_t checksum;   /* planish_checksum of the file's coordinates */
    planish_cells cells; /* all elements of the mesh */
} pl_like;

/** Read the file of --like for mesh, which has all elements of file, the input: they must be the same
 *  there. mesh has cells then. like is to be freed also after an error. Returns 0, or an exit status after
 *  a message. */
int pl_like_read(const pl_arguments *arguments, planish_file *file, int threads, planish_mesh *mesh,
                 pl_like *like);

/** Let the marked elements is_layer of mesh, which has all elements of file, the input, be targets, with
 *  the heights that they have now. mesh has cells then; like owns is_layer. As pl_like_read. */
int pl_like_layers(const pl_arguments *arguments, planish_file *file, uint8_t *is_layer,
                   planish_mesh *mesh, pl_like *like);

/** Let the elements of mesh, which has all elements of file, the input, be of sizes that the arguments ask
 *  for. As pl_like_layers. */
int pl_like_sizes(const pl_arguments *arguments, planish_file *file, int threads,
                  planish_mesh *mesh, pl_like *like);

/** Whether elements are to have sizes. */
static inline int pl_like_has_sizes(const pl_like *like) {
    return like->sizes.size || like->sizes.metric;
}

/** Give mesh the targets of like. */
void pl_like_give(const pl_like *like, planish_mesh *mesh);

void pl_like_free(pl_like *like);

#endif
