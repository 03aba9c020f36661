/* exodus_format: the definitions that the reader and the writer of Exodus files share.
 *
 *   exodus_name, exodus_name_of, exodus_values_name    names of variables
 *   exodus_node_orders                                 orders of nodes
 *   exodus_side_faces                                  sides of solids
 */
#ifndef PL_IO_EXODUS_EXODUS_FORMAT_H
#define PL_IO_EXODUS_EXODUS_FORMAT_H

#include "io/core/model.h"

/** Name of a variable. */
typedef struct exodus_name {
    char text[40];
} exodus_name;

/** Return the name of variable k (from 0) of a kind: connect1, connect2, ... */
exodus_name exodus_name_of(const char *kind, int64_t k);

/** Return the name of the values of variable k (from 0): of the nodes, or of the elements of a block. */
exodus_name exodus_values_name(int of_elements, int64_t k, int64_t block);

/** Orders of nodes, as io_model.node_order. */
extern const io_node_order exodus_node_orders[];

/** Faces of io_parts that the sides of solids of so many corners are, -1: there is none. */
extern const int8_t exodus_side_faces[9][6];

#endif
