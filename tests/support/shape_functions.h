/* shape_functions: the shape functions of elements of every type, by their definitions. The order of nodes
 * and the reference elements, in [0, 1], are VTK's.
 *
 * A pyramid's map is the collapsed one: z is the share of the apex.
 */
#ifndef TEST_SUPPORT_SHAPE_FUNCTIONS_H
#define TEST_SUPPORT_SHAPE_FUNCTIONS_H

enum { SHAPE_NODES = 27 /* most of an element */ };

/** Return the table of the places of a type's nodes in the reference element. */
const double (*shape_place(int type))[3];

/** Return the shape function of a node at t. */
double shape_value(int type, int node, const double t[3]);

/** Find the slopes of all shape functions of a type at t, along each of its directions. They are exact at
 *  multiples of 1/8, of triangles and tetrahedra also of 1/512. */
void shape_slopes(int type, const double t[3], double slope[SHAPE_NODES][3]);

#endif
