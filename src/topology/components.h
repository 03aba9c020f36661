/* components: of elements that facets join, where several processes have parts of one.
 *
 * link [m] says of each element the root of its component among the elements here, an element, << 1
 * | its parity: 1 if its order is opposite to that of the root. In a mesh in parts a component may
 * have several roots, in one process or in several. pl_components_settle and _sum are collective
 * there.
 */
#ifndef PL_TOPOLOGY_COMPONENTS_H
#define PL_TOPOLOGY_COMPONENTS_H

#include "topology/topology.h"

/** A number for the nodes of an element, by which they are known in all processes: two elements
 * have the same if they are duplicates, or by one chance in 2^62. */
int64_t pl_element_id(const planish_mesh *mesh, int64_t element);

/** Facts that processes exchange about components. In arrays [m] only the entries of roots
 *  count. */
typedef struct pl_settlement {
    int64_t *label;    /* the same of all roots of a component, and of no other one; owned */
    uint8_t *reversed; /* 1: parities here are opposite to those that all processes agree on: of the
                          element of the smallest id it is 0; owned */
    int8_t *conflict;  /* given: 1 where parities contradict one another; then in all processes */
} pl_settlement;

/** Settle the components of a mesh in parts. s->conflict is given. Errors: _MEMORY. */
int pl_components_settle(const planish_mesh *mesh, const pl_incidence *incidence,
                         const uint32_t *link, pl_settlement *s, planish_error *error);

/** Free the arrays of s. */
void pl_settlement_destroy(pl_settlement *s);

/** Sum the measures of each component, exactly, rounded once: measure [m] of elements becomes, at
 *  roots, that of the component. s: in a mesh in parts; else NULL. *n: how many components there
 *  are. Errors: _MEMORY. */
int pl_components_sum(const planish_mesh *mesh, const uint32_t *link, const pl_settlement *s,
                      double *measure, int64_t *n, planish_error *error);

#endif
