/* components: coordinates of files that have all x, then all y, then all z.
 *
 *   io_load_component     read one coordinate of all nodes
 *   io_components_end     end the coordinates
 */
#ifndef PL_IO_CORE_COMPONENTS_H
#define PL_IO_CORE_COMPONENTS_H

#include "io/core/model.h"

/** Binary numbers at equal distances. */
typedef struct io_strided {
    const char *data; /* of the first node, */
    int64_t stride;   /* and bytes from node to node */
    int size;         /* of a number: 4 or 8 bytes */
    int swapped;      /* it has not this machine's byte order */
    int64_t first, n; /* nodes that they are of; n 0: all */
} io_strided;

/** Read coordinate component (0, 1, 2) of the nodes. Return the first node whose coordinate is not
 *  finite, or -1. */
int64_t io_load_component(io_model *model, io_strided from, int component);

/** Put the spans in the file's order, after all coordinates, and check that none share bytes; z of
 *  nodes that have none is 0. Error: _FORMAT. */
int io_components_end(io_model *model, planish_error *error);

#endif
