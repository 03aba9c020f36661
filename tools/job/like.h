/* like: the target of each element is its shape in another file, --like FILE.
 *
 *     pl_like_read      read FILE, and check that it fits
 *     pl_like_free      what that keeps
 *
 * Where there is such a file all ratios are aspect ratios AR against the targets, of simplices, too, and
 * the mesh has cells.
 */
#ifndef PL_TOOLS_LIKE_H
#define PL_TOOLS_LIKE_H

#include "options/options.h"

#include <planish/planish_io.h>

/** The mesh of another file, whose elements are the targets. */
typedef struct pl_like {
    double *place;       /* [n_nodes][dim] of the nodes there, owned; NULL: there is no such file */
    uint64_t checksum;   /* planish_checksum of the file's coordinates */
    planish_cells cells; /* all elements of the mesh */
} pl_like;

/** Read the file of --like for mesh, which has all elements of file, the input: they must be the same
 *  there. mesh has cells then. like is to be freed also after an error. Returns 0, or an exit status after
 *  a message. */
int pl_like_read(const pl_arguments *arguments, planish_file *file, int threads, planish_mesh *mesh,
                 pl_like *like);

void pl_like_free(pl_like *like);

#endif
