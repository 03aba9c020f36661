/* disc: a bound of the distance of small triangles from a patch, for next to nothing.
 *
 * Around a node the patch is a graph over the plane through the node, as far as a disc: each of its
 * points is at a height q + r above that, q a quadratic function, lowest <= r <= highest. A
 * triangle with its corners over the disc has the heights of its corners. Between these it is lower
 * than q by the bend of q: so both heights differ by no more than the two ranges do. On a smooth
 * surface that is hardly more than the distance. Where it is too much, or a feature is near,
 * overlay.h tells.
 */
#ifndef PL_SHAPE_DISC_H
#define PL_SHAPE_DISC_H

#include "shape/curved.h"

/** A graph around a node on a patch. Lengths are in the shape's units. */
typedef struct pl_disc {
    float curve[3];        /* q(u, v) = curve[0] u^2 + curve[1] u v + curve[2] v^2 */
    float lowest, highest; /* r of all points of the patch that are over the disc */
    float radius2;         /* square of the disc's radius; 0: there is none */
} pl_disc;

/** The frame of a disc. */
typedef struct pl_disc_frame {
    const pl_disc *disc;
    const double *origin;
    double axis[3][3];
} pl_disc_frame;

/** A point seen from a disc: over u, v, at r above q. */
typedef struct pl_disc_point {
    double u, v, r;
} pl_disc_point;

/** Find the disc of a node on a patch. */
void pl_disc_find(const planish_shape *shape, int32_t node, pl_disc *disc);

/** Set the frame of the disc of a node, that has one, on a patch. */
void pl_disc_set_frame(const planish_shape *shape, int32_t node, const pl_disc *disc,
                       pl_disc_frame *frame);

/** Set point to where x is; 0: it is not over the disc. */
static inline int pl_disc_see(const pl_disc_frame *f, const double x[3], pl_disc_point *point) {
    double way[3];
    pl_from_to(3, f->origin, x, way);
    const double u = pl_dot(3, way, f->axis[0]), v = pl_dot(3, way, f->axis[1]);
    const float *c = f->disc->curve;
    point->u = u;
    point->v = v;
    point->r = pl_dot(3, way, f->axis[2]) - (u * (c[0] * u + c[1] * v) + v * v * c[2]);
    return u * u + v * v <= f->disc->radius2;
}

/** Bound how far the triangle of three points over the disc is off the patch. */
double pl_disc_bound(const pl_disc_frame *f, const pl_disc_point *a, const pl_disc_point *b,
                     const pl_disc_point *c);

#endif
