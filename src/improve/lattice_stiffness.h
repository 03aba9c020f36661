/* lattice_stiffness: stiffness and forces of nodes and elements at the vertices of a lattice.
 *
 *   pl_lattice_assemble              Hessian of the sum of RR^2, or AR^2, for displacements of vertices
 *   pl_lattice_restrict, _prolong    from forces of the nodes to those of vertices; displacements back
 */
#ifndef PL_IMPROVE_LATTICE_STIFFNESS_H
#define PL_IMPROVE_LATTICE_STIFFNESS_H

#include "improve/lattice.h"

/** Assemble, for what is sorted. Blocks that are not positive definite are shifted until they are. */
void pl_lattice_assemble(pl_lattice *lattice);

/** Set the forces of vertices from those of the stars' nodes, [n_stars][dim], finite and along the
 *  planes and lines. Returns 0 if all
 *  are 0 or they are too large. */
int pl_lattice_restrict(pl_lattice *lattice, const double *force);

/** Set the displacements at the stars' nodes, [n_stars][dim]: not yet along the planes and lines. */
void pl_lattice_prolong(const pl_lattice *lattice, double *move);

#endif
