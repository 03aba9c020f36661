/* no_node: messages on nodes that the mesh does not have. */
#ifndef PL_TOPOLOGY_NO_NODE_H
#define PL_TOPOLOGY_NO_NODE_H

#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>

/** Room for the text of pl_nodes_there. */
enum { PL_NODES_TEXT = 64 };

/** Return which nodes a mesh of n_nodes nodes has, for a message; written to text if need be. */
static inline const char *pl_nodes_there(int64_t n_nodes, char text[PL_NODES_TEXT]) {
    if (n_nodes <= 0)
        return "no nodes";
    snprintf(text, PL_NODES_TEXT, "the nodes 0 to %" PRId64, n_nodes - 1);
    return text;
}

/** Return the end of a message on a wrong node: a node n_nodes suggests that the caller counts from 1. */
static inline const char *pl_no_node_hint(int64_t node, int64_t n_nodes) {
    return node == n_nodes ? ", or are nodes counted from 1? They begin with 0 here" : "";
}

#endif
