/* kernel_slide: nodes that stay on a plane, a line or a surface.
 *
 * The local problem is solved in the directions that the node has: gradients are projected on them,
 * the Hessian is made a multiple of the identity in the others, and every trial position is brought
 * back to where the node belongs, from the place where the call began: so rounding does not add up,
 * and a coordinate in whose direction the node cannot go keeps its bits.
 *
 *   sliding_init                   directions of a node
 *   slide_along, slide_hessian     vectors and Hessians in these directions
 *   slide_ask, slide_place         places on the plane, line or surface
 */
#ifndef PL_STAR_KERNEL_SLIDE_H
#define PL_STAR_KERNEL_SLIDE_H

#include "base/context.h"
#include "star/kernel_objectives.h"
#include "star/kernel_direction.h"

/* A vector of which less than this is left by projection has no direction there. */
#define SLIDE_NOTHING 1e-9

/** The directions that a node has, in the star's scale. */
typedef struct sliding {
    planish_constraint kind; /* _FREE: all, and the rest is not set; _FIXED: none */
    const pl_star_slide *of; /* the mesh's */
    double point[3];         /* on the plane or line */
    double direction[3];     /* unit normal of the plane, or along the line */
} sliding;

/** Set s to the plane, line or surface of the star's node; kind PLANISH_CONSTRAINT_FREE: none. */
static inline void sliding_init(sliding *s, const pl_star_problem *problem, int64_t index,
                                double scale, const int dim) {
    s->kind = PLANISH_CONSTRAINT_FREE;
    if (!problem->slide)
        return;
    s->of = &problem->slide[index];
    s->kind = s->of->kind;
    for (int d = 0; d < dim; d++) {
        s->point[d] = s->of->point[d] * scale;
        s->direction[d] = s->of->direction[d];
    }
}

/** Project v on the directions that the node has. */
PL_INLINE void slide_along(const sliding *s, double *v, const int dim) {
    const double along = dot(s->direction, v, dim);
    for (int d = 0; d < dim; d++) {
        const double part = s->direction[d] * along;
        v[d] = s->kind == PLANISH_CONSTRAINT_ON_LINE ? part : v[d] - part;
    }
}

/** Replace the Hessian H by P H P + largest |H_ii| (I - P), P the projection. */
PL_INLINE void slide_hessian(const sliding *s, double *hessian, const int dim) {
    double column[3][3], largest = 0;
    for (int i = 0; i < dim; i++) {
        for (int j = 0; j < dim; j++)
            column[i][j] = hessian[i <= j ? packed(i, j, dim) : packed(j, i, dim)];
        largest = fmax(largest, fabs(column[i][i]));
        slide_along(s, column[i], dim);
    }
    for (int j = 0; j < dim; j++) { /* column[.][j] is H P e_j */
        double row[3], unit[3];
        for (int i = 0; i < dim; i++) {
            row[i] = column[i][j];
            unit[i] = i == j;
        }
        slide_along(s, row, dim);
        slide_along(s, unit, dim);
        for (int i = 0; i <= j; i++)
            hessian[packed(i, j, dim)] = row[i] + largest * ((i == j) - unit[i]);
    }
}

/** Learn the surface at x (in the mesh's scale) from the caller, where it is his; 0 if he cannot
 *  say. place (may be NULL) gets the nearest place on it. */
static inline int slide_ask(const pl_star_problem *problem, sliding *s, const double *x,
                            double *place, const int dim) {
    double at[3] = {0, 0, 0}, direction[3] = {0, 0, 0};
    s->kind = PLANISH_CONSTRAINT_FIXED;
    if (!problem->project)
        return 0;
    for (int d = 0; d < dim; d++)
        at[d] = x[d];
    pl_context *before = pl_context_enter(NULL);
    s->kind = problem->project(s->of->node, at, direction, problem->project_user);
    pl_context_enter(before);
    double length = sqrt(dot(direction, direction, dim));
    if (!(length > 0x1p-500 && length < 0x1p500)) { /* squares of others over- or underflow */
        double largest = 0;
        for (int d = 0; d < dim; d++)
            largest = fmax(largest, fabs(direction[d]));
        for (int d = 0; d < dim; d++)
            direction[d] /= largest;
        length = sqrt(dot(direction, direction, dim));
    }
    if ((s->kind != PLANISH_CONSTRAINT_ON_PLANE && s->kind != PLANISH_CONSTRAINT_ON_LINE) ||
        !(length > 0 && length < INFINITY)) {
        s->kind = PLANISH_CONSTRAINT_FIXED;
        return 0;
    }
    for (int d = 0; d < dim; d++) {
        s->direction[d] = direction[d] / length;
        if (place)
            place[d] = at[d];
    }
    return 1;
}

/** Bring a position (in the star's scale) to where the node belongs; not numbers if that is
 *  nowhere. */
static inline void slide_place(const pl_star_problem *problem, const sliding *s, const star *of,
                               double *position, const int dim) {
    if (s->kind == PLANISH_CONSTRAINT_FREE)
        return;
    if (s->of->kind == PLANISH_CONSTRAINT_ON_SURFACE) {
        sliding there = {.of = s->of};
        double x[3];
        for (int d = 0; d < dim; d++)
            x[d] = position[d] * of->unscale;
        const int known = slide_ask(problem, &there, x, x, dim);
        for (int d = 0; d < dim; d++)
            position[d] = known ? x[d] * of->scale : NAN;
        return;
    }
    double way[3];
    for (int d = 0; d < dim; d++)
        way[d] = position[d] - s->point[d];
    slide_along(s, way, dim);
    for (int d = 0; d < dim; d++)
        position[d] = s->point[d] + way[d];
}

#endif
