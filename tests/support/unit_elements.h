/* unit_elements: one element of each type, deformed so that a wrong order of its nodes shows.
 *
 * A format lists the corners of an element, and mids of edges, faces and the cell. A test says what
 * each mid is between, as the documentation of the format does; nodes stand there, before a smooth
 * map that bends all edges. What is read must then have its nodes where VTK's order has them, and
 * be valid.
 */
#ifndef TEST_SUPPORT_UNIT_ELEMENTS_H
#define TEST_SUPPORT_UNIT_ELEMENTS_H

#include <planish/planish_io.h>

enum { UNIT_NODES = 27 };

/** An element type of a format. */
typedef struct unit_element {
    int type;          /* planish_cell_type */
    int code;          /* of the format */
    const char *nodes; /* in the format's order, apart by blanks: the VTK corners that each is
                          between, "0" a corner, "01" the mid of an edge, "0123" that of a face */
} unit_element;

/** The nodes of a type in VTK's order, as in unit_element. */
const char *unit_vtk_nodes(int type);

/** Dimension of a type: 2 or 3. */
int unit_dim(int type);

/** Find the places x of the nodes of an element in the order of nodes. Returns their number. */
int unit_places(int type, const char *nodes, double x[UNIT_NODES][3]);

/** Check that cell i of the file's cells is of that type, with its nodes where VTK's order has
 *  them. */
void unit_expect(planish_file *file, int64_t i, int type);

/** Check that the file has n cells of its dimension, and that all of them are valid. */
void unit_expect_valid(planish_file *file, int64_t n);

#endif
