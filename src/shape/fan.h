/* fan: a bound of how far a facet is off its patch, by the fans at its corners: the facets there as they
 * were first. In planes that is next to nothing, where overlay.h has to look at all facets under it.
 */
#ifndef PL_SHAPE_FAN_H
#define PL_SHAPE_FAN_H

#include "shape/overlay.h"

/** The fan of a node. */
typedef struct pl_fan {
    float height; /* the least one of a facet; 0: the fan is not closed, or turns too much */
    float turn;   /* no kept normal is farther from that of the first facet */
} pl_fan;

/** Find the fan of a node of a shape that is not of second order. */
void pl_fan_find(const planish_shape *shape, int32_t node, pl_fan *fan);

/** Return a distance within which of its patch every point of a moved facet is; infinite: its fans do not
 *  tell. fan [n_nodes]. Units: the shape's. */
double pl_fan_bound(const planish_shape *shape, const pl_fan *fan, const pl_moved_facet *t);

#endif
