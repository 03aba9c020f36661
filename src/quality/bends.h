/* bends: which elements of order 2 are curved. Measures and runs ask here, so that both count the same
 * ones.
 *
 * A node is off by its distance from the middle of its corners. An element is curved if a node is off by
 * more than PL_STRAIGHT longest edges, and
 *   - by more than the rounding of coordinates, or
 *   - so that the element is not valid, or may become so soon.
 *
 *   pl_find_bends     by how much the elements of a block are bent
 *   pl_is_bent        what decides for most
 *   pl_is_curved      decide
 */
#ifndef PL_QUALITY_BENDS_H
#define PL_QUALITY_BENDS_H

#include "geometry/inline.h"
#include "quality/validity.h"

#include <math.h>
#include <string.h>

/* An element is straight if its nodes are no farther off than this, in longest edges. */
static const double PL_STRAIGHT = 1e-6;

/* Of an element that is as good as straight, the least coefficient of det J over their mean. */
static const double PL_LEAST_OF_STRAIGHT = 0.5;

/** How far nodes of elements are off, one element per lane: squares, in the scale of the block. */
typedef struct pl_bends {
    double farthest[PL_JACOBIAN_LANES]; /* of the nodes */
    double longest[PL_JACOBIAN_LANES];  /* of the edges */
} pl_bends;

/** Raise largest to the square of the distance of two places, in all lanes. */
PL_INLINE void pl_raise_bends(double to[3][PL_JACOBIAN_LANES], double from[3][PL_JACOBIAN_LANES],
                              double largest[], const int dim) {
    for (int l = 0; l < PL_JACOBIAN_LANES; l++) {
        const double x = to[0][l] - from[0][l], y = to[1][l] - from[1][l];
        const double z = dim == 3 ? to[2][l] - from[2][l] : 0;
        const double square = dim == 3 ? x * x + y * y + z * z : x * x + y * y;
        largest[l] = square > largest[l] ? square : largest[l];
    }
}

/** Find by how much the elements of b are bent. Missing nodes are in the middle. */
PL_INLINE void pl_find_bends(const pl_jacobian_rule *rule, const pl_jacobian_block *b,
                             pl_bends *bends, const int dim) {
    const pl_cell_shape *shape = rule->type->shape;
    double farthest[PL_JACOBIAN_LANES] = {0}, longest[PL_JACOBIAN_LANES] = {0};
    double from[3][PL_JACOBIAN_LANES], to[3][PL_JACOBIAN_LANES];
    for (int e = 0; e < shape->n_edges; e++) {
        memcpy(from, b->x[shape->edge[e][0]], sizeof from);
        memcpy(to, b->x[shape->edge[e][1]], sizeof to);
        pl_raise_bends(to, from, longest, dim);
    }
    for (int i = shape->n_corners; i < rule->n_nodes; i++) {
        double middle[3][PL_JACOBIAN_LANES] = {{0}};
        int n = 0;
        for (int c = 0; c < shape->n_corners; c++) {
            if (!(rule->straight[i] >> c & 1))
                continue;
            n++;
            for (int d = 0; d < dim; d++)
                for (int l = 0; l < PL_JACOBIAN_LANES; l++)
                    middle[d][l] += b->x[c][d][l];
        }
        for (int d = 0; d < dim; d++)
            for (int l = 0; l < PL_JACOBIAN_LANES; l++)
                middle[d][l] *= 1.0 / n; /* of a power of two */
        memcpy(to, b->x[i], sizeof to);
        pl_raise_bends(to, middle, farthest, dim);
    }
    memcpy(bends->farthest, farthest, sizeof farthest);
    memcpy(bends->longest, longest, sizeof longest);
}

/** Whether nodes of the element in lane l are off by more than a part of the longest edge, and by more than
 *  rounding (0: of any). */
static inline int pl_is_bent(const pl_bends *bends, int l, double rounding) {
    const double part = PL_STRAIGHT * sqrt(bends->longest[l]);
    const double limit = part > rounding ? part : rounding;
    return bends->farthest[l] > limit * limit;
}

/** Whether the element in lane l is curved. rounding: in the scale of the lane; b has been evaluated. */
static inline int pl_is_curved(const pl_bends *bends, const pl_jacobian_block *b, int l,
                               double rounding, int is_valid) {
    return pl_is_bent(bends, l, rounding) ||
           (pl_is_bent(bends, l, 0) &&
            !(is_valid && b->least[l] > PL_LEAST_OF_STRAIGHT * b->mean[l]));
}

#endif
