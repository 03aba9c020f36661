/* cell_judge: whether elements of any type are valid, in fractions (GMP), and their ratios in long double
 * by textbook formulas. Of src only the table of types is used.
 *
 * det J is a polynomial on the reference element, which is the image of a square or cube: a triangle's
 * side, or a tetrahedron's face and side, may shrink to a point. So the polynomial has Bernstein
 * coefficients on the cube. It is positive everywhere if all are, and not if one of a corner is not; else
 * halves of the cube decide.
 */
#ifndef TEST_SUPPORT_CELL_JUDGE_H
#define TEST_SUPPORT_CELL_JUDGE_H

#ifdef PLANISH_HAVE_GMP

#include <planish/planish.h>

/** Whether det J, times sign, of element i of mesh is positive everywhere at x [n_nodes][dim]: 1 or 0.
 *  -1: too close to 0 to be decided. */
int cell_judge_validity(const planish_mesh *mesh, int64_t i, const double *x, int sign);

/** What corners of an element are worth. */
typedef struct cell_worth {
    int is_positive;      /* all corners are */
    long double square;   /* mean over the corners of mu^2, or of what sizes make of it */
    long double jacobian; /* least scaled Jacobian of a corner */
    long double
        volume; /* least that a parallelepiped, prism or pyramid with one of the corners has */
    long double edge; /* longest edge at a corner */
} cell_worth;

/** The corners of element i at x [n_nodes][dim]; against those of the same element at reference
 *  [n_nodes][dim], or of ideal elements if that is NULL. weight: of sizes. sign as above. */
cell_worth cell_judge_worth(const planish_mesh *mesh, int64_t i, const double *x,
                            const double *reference, double weight, int sign);

#endif
#endif
