/* angles: the extreme angles of simplices, in degrees: dihedral ones of tetrahedra.
 *
 *     pl_angles_find             of one whose vertices have as many coordinates as it has dimensions
 *     pl_angles_find_in_space    of a triangle in space
 */
#ifndef PL_TOOLS_ANGLES_H
#define PL_TOOLS_ANGLES_H

/** Smallest and largest angle in degrees; NAN where the element is too flat. */
typedef struct pl_angles {
    double smallest, largest;
} pl_angles;

/** Find the angles of the simplex of dimension dim at vertex [dim + 1][dim], whatever its sign. */
pl_angles pl_angles_find(int dim, const double *const vertex[]);

/** Find the angles of the triangle at vertex [3][3]. */
pl_angles pl_angles_find_in_space(const double *const vertex[]);

#endif
