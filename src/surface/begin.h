/* begin: begin and end of a call that smooths a surface mesh. */
#ifndef PL_SURFACE_BEGIN_H
#define PL_SURFACE_BEGIN_H

#include "surface/smooth.h"

/** Check that shape was made of the elements of mesh. Errors: _ARGUMENT. */
int pl_surface_check_elements(const planish_mesh *mesh, const planish_shape *shape,
                              planish_error *error);

/** Find the nodes that may move: moves [shape->n_nodes] becomes 0 or 1. */
void pl_surface_find_moves(const planish_mesh *mesh, const planish_shape *shape, uint8_t *moves);

/** Begin a run that has mesh, coordinates, options, result, threads and start_seconds. Errors: _ARGUMENT,
 *  _MESH, _MEMORY. */
int pl_surface_run_begin(pl_surface_run *r, planish_error *error);

/** Fill held [nodes of the mesh] with the planish_held_by of each in a run that has begun. */
void pl_surface_run_get_held(const pl_surface_run *r, uint8_t *held);

/** Write the nodes that have moved to the caller's coordinates, and fill in the result. */
void pl_surface_run_end(pl_surface_run *r);

/** Free the memory of a run, also after an error. */
void pl_surface_run_destroy(pl_surface_run *r);

#endif
