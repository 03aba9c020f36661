/* facets: match the facets of the elements, each at its smallest node. For topology, shape,
 * reports and planish-mpi.
 *
 *   pl_facets_match         match facets
 *   pl_facet_joins          whether a facet joins elements
 *   pl_facet_is_here        whether all elements of a facet are here
 *   pl_sort_element         the nodes of an element, ascending
 */
#ifndef PL_TOPOLOGY_FACETS_H
#define PL_TOPOLOGY_FACETS_H

#include "base/parts.h"
#include "topology/topology.h"

/** Facet with the first two of its elements, in ascending order. */
typedef struct pl_facet {
    int32_t node[2];    /* its nodes above the smallest, ascending; node[1] < 0 in 2-D */
    int32_t count;      /* elements it is a facet of */
    int32_t element[2]; /* the first two of them; element[1] only if count > 1 */
    int32_t opposite;   /* the node of element[0] opposite the facet */
    uint8_t parity[2];  /* how element[i] traverses it; the same: in the same direction */
    uint8_t twin;       /* 1: another element has element[0]'s nodes */
} pl_facet;

/** Whether two elements meet at facet, and no more, and are not duplicates: such a facet joins. */
static inline int pl_facet_joins(const pl_facet *facet) {
    return facet->count == 2 && !facet->twin;
}

/** Whether all elements of a facet, of which node is the smallest node, are in this process: part
 *  has only some of those whose nodes all belong to others. */
static inline int pl_facet_is_here(const planish_part *part, int32_t node, const pl_facet *facet) {
    return pl_is_own(part, node) || pl_is_own(part, facet->node[0]) ||
           (facet->node[1] >= 0 && pl_is_own(part, facet->node[1]));
}

/** Called for each node that is the smallest of a facet, with all those facets, on thread 0 ..
 *  threads-1; distinct nodes are visited at the same time on several. */
typedef void pl_facets_fn(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                          int thread);

/** Call body for every node. is_inside [n]: facets of nodes for which it is not 0 are left out;
 * NULL: none are. */
int pl_facets_match(const planish_mesh *mesh, const pl_incidence *incidence,
                    const uint8_t *is_inside, int threads, pl_facets_fn *body, void *context,
                    planish_error *error);

/** Sort the nodes of element into sorted [dim + 1]; returns the parity of the permutation. */
static inline int pl_sort_element(int dim, const int32_t *element, int32_t *sorted) {
    int parity = 0;
    for (int i = 0; i <= dim; i++)
        sorted[i] = element[i];
    for (int last = dim; last > 0; last--)
        for (int i = 0; i < last; i++) {
            int32_t a = sorted[i], b = sorted[i + 1];
            int swap = a > b;
            sorted[i] = swap ? b : a;
            sorted[i + 1] = swap ? a : b;
            parity ^= swap;
        }
    return parity;
}

#endif
