/* element_walk: walk over the elements of one node after the other, and compare their nodes.
 * Internal to topology.
 *
 *   pl_fetch_elements, _list, _ahead       ask for memory before it is needed
 *   pl_is_same, pl_is_less                 comparisons of nodes without a branch
 *   pl_place_in_element, pl_other_node     the nodes of an element but one
 *
 * The elements of a node lie all over memory. Who walks over many nodes asks for those of a node
 * some steps ahead, and waits for none: on a million tetrahedra that halves the time.
 */
#ifndef PL_TOPOLOGY_ELEMENT_WALK_H
#define PL_TOPOLOGY_ELEMENT_WALK_H

#include "base/fetch.h"
#include "topology/topology.h"

/** Numbers of nodes ahead to fetch the elements, the list of their numbers, where that begins, and
 * room for what is found. */
enum { PL_AHEAD_ELEMENTS = 2, PL_AHEAD_LIST = 6, PL_AHEAD_OFFSET = 16, PL_AHEAD_ROOM = 4 };

/** Fetch the elements of node; of a giant star only the first ones. */
PL_AT_ONCE void pl_fetch_elements(const planish_mesh *mesh, int dim, const pl_incidence *incidence,
                                  int64_t node) {
    enum { MOST = 64 };
    int64_t begin = incidence->offset[node], end = incidence->offset[node + 1];
    end = end - begin > MOST ? begin + MOST : end;
    for (int64_t i = begin; i < end; i++)
        __builtin_prefetch(mesh->elements + (int64_t)incidence->element[i] * (dim + 1));
}

/** Fetch the list of the elements of node. */
PL_AT_ONCE void pl_fetch_list(const pl_incidence *incidence, int64_t node) {
    enum { CACHE_LINE = 64 / sizeof(int32_t), MOST = 4 * CACHE_LINE };
    const int64_t begin = incidence->offset[node], n = incidence->offset[node + 1] - begin;
    const int32_t *last = incidence->element + begin + (n < MOST ? n : MOST) - 1;
    for (const int32_t *list = incidence->element + begin; list < last; list += CACHE_LINE)
        __builtin_prefetch(list);
    __builtin_prefetch(last);
}

/** Fetch what a walk over node[i], i < end, will need soon after node[i]. */
PL_AT_ONCE void pl_fetch_ahead(const planish_mesh *mesh, int dim, const pl_incidence *incidence,
                               const int32_t *node, int64_t i, int64_t end) {
    if (i + PL_AHEAD_ELEMENTS < end)
        pl_fetch_elements(mesh, dim, incidence, node[i + PL_AHEAD_ELEMENTS]);
    if (i + PL_AHEAD_LIST < end)
        pl_fetch_list(incidence, node[i + PL_AHEAD_LIST]);
    if (i + PL_AHEAD_OFFSET < end)
        __builtin_prefetch(incidence->offset + node[i + PL_AHEAD_OFFSET]);
}

/* ---- comparisons of nodes ----------------------------------------------------------------------
 *
 * Where == or < gives a number, compilers may write the low byte of a register alone: then what
 * comes next waits for what that held before, which can be the end of all that went before. */

/** 1 if two nodes are the same, or else 0. No number of a node is negative. */
static inline uint32_t pl_is_same(int32_t a, int32_t b) {
    return ((uint32_t)(a ^ b) - 1) >> 31;
}

/** 1 if a is less than b, or else 0. */
static inline uint32_t pl_is_less(int32_t a, int32_t b) {
    return (uint32_t)(a - b) >> 31;
}

/* ---- the nodes of an element but one; no branch depends on which, for nothing could predict it -
 */

/** Place of node in element, 0 .. dim. */
static inline int pl_place_in_element(int dim, const int32_t *element, int32_t node) {
    int place = 0;
    for (int j = 1; j <= dim; j++)
        place += j & -(element[j] == node);
    return place;
}

/** The i-th of the other nodes, i < dim, in the element's order. */
static inline int32_t pl_other_node(const int32_t *element, int place, int i) {
    return element[i + (i >= place)];
}

#endif
