/* bent_elements: an element of each type, bent so that it is valid in one order of its nodes alone. */
#ifndef TEST_SUPPORT_BENT_ELEMENTS_H
#define TEST_SUPPORT_BENT_ELEMENTS_H

/** An element of a type. The places of nodes are those of VTK's GetParametricCoords (the mids of a
 *  pyramid's upright edges halfway). */
typedef struct bent_element {
    int type; /* planish_cell_type */
    int dim, n_nodes, n_corners;
    const char *places; /* of its nodes, in VTK's order: x y z in quarters, and a blank */
} bent_element;

enum { BENT_MOST_NODES = 27, N_BENT_ELEMENTS = 13 };

extern const bent_element bent_elements[N_BENT_ELEMENTS];

/** Find the place of node i of the bent element. */
void bent_element_place(const bent_element *element, int i, double place[3]);

#endif
