/* no_node: messages on nodes that the mesh does not have. */
#ifndef PL_TOPOLOGY_NO_NODE_H
#define PL_TOPOLOGY_NO_NODE_H

#include <stdint.h>

/** Return the end of a message on a wrong node: a node n_nodes suggests that the caller counts from 1. */
static inline const char *pl_no_node_hint(int64_t node, int64_t n_nodes) {
    return node == n_nodes ? ", or are nodes counted from 1? They begin with 0 here" : "";
}

#endif
