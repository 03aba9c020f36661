/* create: the nodes of a fit, and the elements around them. */
#ifndef PL_FIT_CREATE_H
#define PL_FIT_CREATE_H

#include "fit/fit.h"

/** Make fit, whose shapes, threads and reach are set, of a mesh that was checked: its elements are cells or
 *  of 32 bits, its coordinates dense. Errors: _ARGUMENT (elements of order 2), _MEMORY. fit is to be
 *  destroyed in any case. */
int pl_fit_create(const planish_mesh *mesh, planish_fit *fit, planish_error *error);

/** Free the arrays of fit. */
void pl_fit_destroy(planish_fit *fit);

#endif
