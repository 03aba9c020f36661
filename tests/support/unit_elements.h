/* unit_elements: one element of each type, deformed so that a wrong order of its nodes shows.
 *
 * A format lists the corners of an element, and mids of edges, faces and the cell. A test says what
 * each mid is between, as the documentation of the format does; nodes stand there, before a
 * polynomial map that bends edges. What is read must then have its nodes where VTK's order has
 * them, and be valid.
 */
#ifndef TEST_SUPPORT_UNIT_ELEMENTS_H
#define TEST_SUPPORT_UNIT_ELEMENTS_H

#include "support/file_builder.h"

enum { UNIT_NODES = 27 };

/** An element type of a format. */
typedef struct unit_element {
    int type;          /* planish_cell_type */
    int code;          /* of the format */
    const char *nodes; /* in the format's order, apart by blanks: the VTK corners that each is
                          between, "0" a corner, "01" the mid of an edge, "0123" that of a face;
                          or counted from 1: "1", "12", "1234". The first node is the first
                          corner. */
} unit_element;

/** The nodes of a type in VTK's order, as in unit_element. */
const char *unit_vtk_nodes(int type);

/** Dimension of a type: 2 or 3. */
int unit_dim(int type);

/** Return whether planish smooths elements of a type. */
int unit_is_smoothed(int type);

/** Return whether elements of a type are simplices, which a file has before all others. */
int unit_is_simplex(int type);

/** Find the places x of the nodes of an element in the order of nodes. Returns their number. */
int unit_places(int type, const char *nodes, double x[UNIT_NODES][3]);

/** Let two of n nodes change places, so that an element of any type is invalid. */
void unit_swap(int type, int n, double x[UNIT_NODES][3]);

/** Mirror n nodes, so that the element is of the other handedness. */
void unit_mirror(int n, double x[UNIT_NODES][3]);

/** Check that cell i of the file's cells is of that type, with its nodes where VTK's order has
 *  them, or mirrored. */
void unit_expect(planish_file *file, int64_t i, int type);

/** Measure all n cells of the file; none may be undecided. */
planish_cell_quality unit_measure(planish_file *file, int64_t n);

/** Check that the file has n cells of its dimension, and that all of them are valid. */
void unit_expect_valid(planish_file *file, int64_t n);

/** Check that n elements of the file, all of which are the mesh's, are not smoothed, and that n_held
 *  nodes are held for that. */
void unit_expect_others(planish_file *file, int64_t n, int64_t n_held);

/** Check the one element of a file, and close it: its type, its number, that its n_held nodes are
 *  held and it is not smoothed (0: it is), and whether it is valid. */
void unit_expect_alone(planish_file *file, int type, int64_t number, int n_held, int is_valid);

/** Check the simplices of a file of nodes 1 .. 11 in any format: a straight tetrahedron 1 2 3 4; one
 *  of second order, 2 3 4 5 with the mids 6 .. 11 in VTK's order; on it a triangle of second order,
 *  3 4 5 with the mids 7 11 10, and has_line a line 4 5 with the mid 11. */
void unit_expect_both_orders(const planish_file *file, int has_line);
enum { UNIT_BOTH_NODES = 11 };
extern const double unit_both_places[UNIT_BOTH_NODES][3];

/** Check a file of two hexahedra side by side, of the nodes 1 2 5 4 7 8 11 10 and 2 3 6 5 8 9 12 11,
 *  and of a quadrilateral, 1 2 5 4, below the first; in two dimensions of the quadrilaterals 1 2 5 4
 *  and 2 3 6 5 and a line, 1 2. Node 1 is at the origin, 2, 4 and 7 along the axes, 3 at x = 2. The
 *  elements are regions. facet: the tag of the quadrilateral or line, second: of the second element;
 *  NULL: the file has no groups, and one region. */
void unit_expect_bricks(planish_file *file, const char *facet, const char *second);
enum { UNIT_BRICK_NODES = 12 };
extern const double unit_brick_places[UNIT_BRICK_NODES][3];

/** Check the nodes that the file holds, and that a group holds, whatever the regions: digits, 1 for held.
 *  tag: or NULL. */
void unit_expect_held(const planish_file *file, const char *tag, const char *expected);

/** Check that a reader understands n types: make writes a file of two elements with the nodes x [m]
 *  of row i, the second with a number of its own; in two variants, from which its number follows.
 *  Both handednesses are tried. */
typedef file_builder unit_make(int i, int m, double x[UNIT_NODES][3], int variant,
                               int64_t *second_number);
void unit_expect_types(const io_format *format, const unit_element *elements, int n,
                       unit_make *make);

#endif
