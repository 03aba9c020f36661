/* delaunay: Delaunay meshes of few points on a grid, by exact arithmetic: simple, and slow. */
#ifndef TEST_SUPPORT_DELAUNAY_H
#define TEST_SUPPORT_DELAUNAY_H

#include "support/meshes.h"

/** Coordinates are 0 .. this, so that all determinants fit into 64 bits. */
enum { DELAUNAY_GRID = 1024 };

/** A mesh of the box [0, DELAUNAY_GRID]^dim. */
typedef struct delaunay {
    int dim;
    int32_t n_points;
    int64_t n_elements, room; /* room of element, and of scratch */
    int32_t *point;           /* [n_points][3] */
    int32_t *element;         /* [n_elements][4], dim + 1 of them used; positive */
    uint8_t *is_hit;          /* [n_elements] scratch */
} delaunay;

/** The corners of the box. */
void delaunay_begin(delaunay *d, int dim);
void delaunay_end(delaunay *d);

/** Insert point [dim] (Bowyer, Watson 1981). 0: not done, as it is there already, or on the plane
 *  of a facet that it would be joined to. */
int delaunay_insert(delaunay *d, const int32_t *point);

/** Above 0 if p is inside of the circumsphere of an element, 0 if it is on it. */
int64_t delaunay_depth(const delaunay *d, int64_t element, const int32_t *p);

/** The mesh, with coordinates in [0, 1]. */
void delaunay_take(const delaunay *d, test_mesh *mesh);

#endif
