/* divide: a proved bound of the distance of a triangle from a surface, as sharp as is asked for.
 *
 * A facet of the surface is no farther off a part of the triangle than its farthest corner is: the distance from
 * a triangle is convex. Where a part lies over several facets their overlay says more. Parts whose bounds are
 * above the distances that points of the triangle have are divided on. */
#ifndef PL_SHAPE_DIVIDE_H
#define PL_SHAPE_DIVIDE_H

#include "shape/curved.h"
#include "shape/tree.h"

/** Bounds of the distances of triangles from a surface. Unit: the shape's. */
typedef struct pl_division {
    const planish_shape *shape;
    const pl_tree *tree; /* of its facets; NULL: the nearest one is walked to */
    int32_t patch; /* the distance is that from this one; -1: from all facets but interfaces */
    int turns;     /* -1: the triangle turns the other way round; */
    const int8_t
        *turn;    /* [patches] and likewise the surface; NULL: the patch turns as the triangle */
    double close; /* bounds are sharp enough at so many times the distance of a point, */
    double fine;  /* or so small */
    double known; /* bounds that are no larger count for nothing; rises with distances of points */
    int64_t n_pieces;    /* that were looked at */
    int64_t most_pieces; /* nothing is divided beyond */
} pl_division;

/** Return the facet nearest to a point, and set *square to the square of its distance; -1: none is asked for. */
int32_t pl_division_find(const pl_division *division, const double point[3], double *square);

/** Return a distance within which every point of the triangle x is by an overlay from a facet near by; infinite:
 *  the overlay says nothing. */
double pl_division_overlay(const pl_division *division, const double x[3][3], int32_t near);

/** Return a distance within which every point of the triangle x is; or known, as it is then, if that is more.
 *  near: a facet near by. The triangle is divided depth times at most. */
double pl_divide(pl_division *division, const double x[3][3], int32_t near, int depth);

#endif
