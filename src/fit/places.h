/* places: the places of nodes on the other shape. */
#ifndef PL_FIT_PLACES_H
#define PL_FIT_PLACES_H

#include "fit/fit.h"

/** Find the places of all nodes, which are at points. Errors: _MEMORY. */
int pl_fit_find_places(planish_fit *fit, const pl_points *points, planish_error *error);

/** Whether x, in the mesh's units, is a place on the other shape of a node that slides. */
int pl_fit_is_place(const planish_fit *fit, int32_t node, const double x[3]);

/** Bring x, in the mesh's units, to the place of a node near it, and set direction there. Returns as a
 *  planish_project_fn. */
planish_constraint pl_fit_project(const planish_fit *fit, int32_t node, double x[3],
                                  double direction[3]);

#endif
