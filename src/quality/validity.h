/* validity: whether det J of elements is positive everywhere: decided, not sampled.
 *
 * A block of elements of one type is evaluated at once, in doubles with a bound of their rounding
 * (geometry/jacobian.h). Where the bound does not decide, the shape is bisected up to
 * PL_VALIDITY_DEPTH times; where that does not decide either, all is done again by integers as long
 * as needed. What is open then is uncertified, which is not valid: elements whose det J touches 0
 * somewhere in between, but none that is wrong by more than rounding.
 *
 *   pl_jacobian_evaluate   coefficients of a block
 *   pl_validity_of_lane    decide one of its elements
 */
#ifndef PL_QUALITY_VALIDITY_H
#define PL_QUALITY_VALIDITY_H

#include "geometry/jacobian.h"

#include <stdint.h>

enum {
    PL_JACOBIAN_LANES = 8,
    PL_VALIDITY_DEPTH = 30,   /* bisections of bisections: 10 in each direction of a hexahedron */
    PL_VALIDITY_BOXES = 20000 /* pieces that are looked at */
};

/** What is known of an element. */
typedef enum pl_validity {
    PL_INVALID = 0,    /* det J is 0 or negative somewhere */
    PL_VALID = 1,      /* positive everywhere */
    PL_UNCERTIFIED = 2 /* not decided, or there was no memory for it */
} pl_validity;

/** Block of elements of one type, one per lane. */
typedef struct pl_jacobian_block {
    double x[PL_CELL_NODES][3][PL_JACOBIAN_LANES]; /* [n_nodes][dim] coordinates, those of order 2
                                                      less those of the first node */
    double coefficient[PL_JACOBIAN_COEFFICIENTS][PL_JACOBIAN_LANES]; /* times the mesh's sign of the
                                                                        lane */
    double error[PL_JACOBIAN_LANES]; /* bound of what rounding did to any of them */
    double least[PL_JACOBIAN_LANES]; /* of the coefficients; NaN where one of them is */
    double mean[PL_JACOBIAN_LANES];
} pl_jacobian_block;

/** Evaluate all lanes of b, whose x is set. sign [PL_JACOBIAN_LANES]: +1 or -1, by which det J is
 *  multiplied. */
void pl_jacobian_evaluate(const pl_jacobian_rule *rule, const double sign[], pl_jacobian_block *b);

/** Decide lane l of b, which has been evaluated. node [n_nodes]: its nodes, -1 for a mid in the
 *  middle of its edge; coordinates [][dim]: of all nodes of the mesh; sign as above. */
pl_validity pl_validity_of_lane(const pl_jacobian_rule *rule, const pl_jacobian_block *b, int l,
                                const int32_t node[], const double *coordinates, double sign);

#endif
