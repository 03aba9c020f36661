/* meshes: small meshes for tests, made by rule or by hand. */
#ifndef TEST_SUPPORT_MESHES_H
#define TEST_SUPPORT_MESHES_H

#include <planish/planish.h>

/** A mesh that owns its arrays: mesh.coordinates and mesh.elements are the same ones, read-only. */
typedef struct test_mesh {
    planish_mesh mesh;
    double *coordinates; /* [n_nodes][dim] */
    int32_t *elements;   /* [n_elements][dim + 1] */
} test_mesh;

/** A copy of what is given; coordinates NULL: random ones in the unit box. */
void test_mesh_create(test_mesh *mesh, int dim, int64_t n_nodes, const double *coordinates,
                      int64_t n_elements, const int32_t *elements);
void test_mesh_destroy(test_mesh *mesh);

/** The box [0, cells] in each direction, cut into unit cubes (squares) and these into 6 tetrahedra
 *  (2 triangles) along a diagonal; all positive, nodes and elements in lexicographic order. */
void test_mesh_box(test_mesh *mesh, int dim, int cells);

/** Make that box periodic in directions (bits): elements have the nodes of the low side for those
 *  of the high side, and so lie across the box. is_wrapped [n_elements], may be NULL, is filled
 * with 1 for these. Nodes of no element are left. */
void test_mesh_wrap(test_mesh *box, int cells, unsigned directions, uint8_t *is_wrapped);

/** n_elements elements of random distinct nodes: facets of any number of elements, duplicates. */
void test_mesh_garbage(test_mesh *mesh, int dim, int64_t n_nodes, int64_t n_elements,
                       unsigned seed);

/** Append a copy of other, moved by shift in every direction, that shares no node. */
void test_mesh_append(test_mesh *mesh, const test_mesh *other, double shift);

/** A node with a closed link: a double pyramid around node 0, between two tips and n nodes in a
 *  circle; 2 n elements, all positive. */
void test_mesh_double_pyramid(test_mesh *mesh, int32_t n);

/** Make one node of two: the elements of b become those of a. */
void test_mesh_join(test_mesh *mesh, int32_t a, int32_t b);

/** Move the nodes inside the box by up to amount in every direction: a box of test_mesh_box stays
 *  valid up to about 0.15. */
void test_mesh_perturb(test_mesh *mesh, double amount, unsigned seed);

/** Make a box 0 .. cells whose nodes inside are drawn to corner 0, by a power that grows from 1 at the
 *  surface: a smooth error of the whole mesh, which stays valid. */
void test_mesh_squeezed_box(test_mesh *mesh, int dim, int cells);

/** Number nodes and elements at random; new_number (may be NULL) [n_nodes] of the old ones. */
void test_mesh_renumber(test_mesh *mesh, unsigned seed, int32_t *new_number);

/** Reverse the order of one element, or of about one in every elements. */
void test_mesh_reverse(test_mesh *mesh, int64_t element);
void test_mesh_reverse_some(test_mesh *mesh, unsigned every, unsigned seed);

/** Multiply the coordinates by scale, then add shift. */
void test_mesh_transform(test_mesh *mesh, double scale, double shift);

/* ---- elements of any types ------------------------------------------------------------------ */

/** A mesh of elements of any types that owns its arrays; mesh.cells is NULL: the caller sets it. */
typedef struct test_cells {
    planish_mesh mesh;
    planish_cells cells;
    double *coordinates;
    uint8_t *type;
    int64_t *offset;
    int32_t *node;
    int *row; /* [cells.n] of the box */
} test_cells;

/** Make the box [0, cells] in each direction of elements of a type, a triangle or tetrahedron or
 *  with edges in the last direction, whose mids are missing. From row n_rows of that direction on
 *  they are simplices. Element 0 is a line. */
void test_cells_box(test_cells *m, int cells, int type, int n_rows);

/** Make cells of order 1 or 2, without mids, of simplices. */
void test_cells_of_simplices(test_cells *m, const test_mesh *simplices, int order);
void test_cells_destroy(test_cells *m);

/* ---- helpers -------------------------------------------------------------------------------- */

/** The next of a sequence of random numbers in [0, 1). */
double test_random(unsigned *state);

/** Volume (area in 2-D) of the elements of a box of unit cells before it was perturbed. */
double test_regular_volume(int dim);

/** Make a box of unit cells whose nodes are perturbed; it has no inverted elements. */
void test_bad_box(test_mesh *mesh, int dim, int cells, unsigned seed);

/** Whether the node at x is not on the boundary of a box of unit cells. */
int test_is_inside_box(const double *x, int dim, int cells);

/** Signed volume (area in 2-D) of an element with its nodes at coordinates. */
double test_measure_of(const planish_mesh *mesh, const double *coordinates, int64_t element);

/** Distance of x and y. */
double test_distance(const double *x, const double *y, int dim);

/** Make a box of test_mesh_box whose colours are more than one thread takes at a time: as it is,
 *  perturbed but valid, or tangled. */
enum { TEST_THREADS_CELLS = 7 };
void test_box_for_threads(test_mesh *mesh, int dim);
void test_bad_box_for_threads(test_mesh *mesh, int dim);
void test_tangled_box_for_threads(test_mesh *mesh, int dim);

#endif
