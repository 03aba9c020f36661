/* slides: the nodes of a box that slide, for tests of planish_find_slides.
 *
 *   slides_find, _find_on, _release     constraints and directions of a mesh
 *   slides_is_side, _node_at            places of a box of SLIDES_CELLS cubes along each side
 *   slides_expect_node, _sides, _axis   whether nodes slide as expected
 */
#ifndef PL_TESTS_SLIDES_H
#define PL_TESTS_SLIDES_H

#include <planish/planish.h>

enum { SLIDES_CELLS = 4 };

/** Slides of a mesh, with arrays. */
typedef struct slides_found {
    uint8_t *constraint; /* [n] */
    double *direction;   /* [n][dim] */
    planish_slide_info info;
} slides_found;

/** Find the slides of mesh; release them in the end. */
slides_found slides_find_on(const planish_mesh *mesh, const planish_surface *surface, int threads);

/** Find the slides of mesh on one thread; release them in the end. */
slides_found slides_find(const planish_mesh *mesh, const planish_surface *surface);

/** Free the arrays of f. */
void slides_release(slides_found *f);

/** Whether a coordinate is that of a side of the box. */
int slides_is_side(double x);

/** The node at a place of a box in space. */
int64_t slides_node_at(const planish_mesh *mesh, double x, double y, double z);

/** Expect a direction [dim] of length 1, to the bit along an axis. */
void slides_expect_axis(const double *direction, int dim, int axis);

/** Expect of node i of a box that it is held, slides or is free as the planes through it say: crosses
 *  [dim], how many cross each axis. */
void slides_expect_node(const slides_found *f, int64_t i, int dim, const int *crosses);

/** Expect of all nodes of a box in space that they are held, slide or are free as its sides say. is_held: whether
 *  a node at x is held in any case; NULL: none is. */
void slides_expect_sides(const planish_mesh *mesh, const slides_found *f,
                         int (*is_held)(const double *x));

#endif
