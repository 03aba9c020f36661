/* validity: whether det J of elements is positive everywhere: decided, not sampled.
 *
 * A block of elements of one type is evaluated at once, in doubles with a bound of their rounding
 * (geometry/jacobian.h). Where the bound does not decide, the shape is bisected up to
 * PL_VALIDITY_DEPTH times. Where doubles do not decide either, integers as long as needed do the
 * same. Elements that are open then are uncertified: their det J touches 0 between the corners, or
 * comes so near to 0 that pieces of the last bisection do not tell.
 *
 * The error bound holds for elements whose nodes are no farther from the first one than
 * PL_VALIDITY_SIZE. Larger ones are to be scaled by a power of two, and very small ones, too:
 * below 2^-300 nothing is decided in doubles.
 *
 *   pl_jacobian_evaluate   coefficients of a block
 *   pl_validity_of_lane    decide one of its elements
 *   pl_bricks_certify      hexahedra, in floats: most are certified so, in a third of the time
 *   pl_jacobian_bound      elements of any type, in floats
 *   pl_validity_exactly    the same by integers alone: the reference
 */
#ifndef PL_QUALITY_VALIDITY_H
#define PL_QUALITY_VALIDITY_H

#include "geometry/jacobian.h"

#include <stdint.h>

enum {
    PL_JACOBIAN_LANES = 8,
    PL_VALIDITY_DEPTH = 45,   /* bisections of a piece: 15 in each direction of a hexahedron */
    PL_VALIDITY_BOXES = 20000 /* pieces that are looked at */
};

/* Largest distance of a node from the first one, in any direction. */
static const double PL_VALIDITY_SIZE = 0x1p60;

/** Verdict on an element. */
typedef enum pl_validity {
    PL_INVALID = 0,      /* det J is 0 or negative somewhere */
    PL_VALID = 1,        /* positive everywhere */
    PL_UNCERTIFIED = 2,  /* not decided */
    PL_OUT_OF_MEMORY = 3 /* there was no memory to decide */
} pl_validity;

/** Block of elements of one type, one per lane. */
typedef struct pl_jacobian_block {
    double x[PL_CELL_NODES][3][PL_JACOBIAN_LANES]; /* [n_nodes][dim] coordinates, those of order 2
                                                      less those of the first node */
    double coefficient[PL_JACOBIAN_COEFFICIENTS][PL_JACOBIAN_LANES]; /* times the mesh's sign of the
                                                                        lane */
    double error[PL_JACOBIAN_LANES]; /* bound of the error of any of them */
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

/** Block of hexahedra by their corners, one per lane, in floats. */
typedef struct pl_brick_block {
    /* Less a place that is near; numbered so that det J is to be positive. */
    float x[8][3][PL_JACOBIAN_LANES];
    /* What coefficients are to be above, det J in edges; at least 0. */
    float floor[PL_JACOBIAN_LANES];
    /* How far corners may go, added up, while the 19 coefficients that are at no corner stay above
       floor; 0 or less, or NaN: floats do not tell that all 27 are above it. */
    float room[PL_JACOBIAN_LANES];
} pl_brick_block;

/* Bounds of the largest absolute coordinate of a lane; floats do not tell of others. */
static const float PL_BRICK_SMALL = 0x1p-30F, PL_BRICK_LARGE = 0x1p30F;

/** Certify hexahedra. */
void pl_bricks_certify(pl_brick_block *b);

/** Block of elements of one type, one per lane, in floats. */
typedef struct pl_float_block {
    float x[PL_CELL_NODES][3][PL_JACOBIAN_LANES]; /* [n_nodes][dim] less a place that is near */
    float sign[PL_JACOBIAN_LANES];
    /* Results: what coefficients are at least, in the unit of pl_jacobian_block, all of them and those
       that are asked for; 0: floats tell nothing, as the largest coordinate is out of bounds. What
       derivatives along edges are at most. */
    float all[PL_JACOBIAN_LANES], inner[PL_JACOBIAN_LANES], longest[PL_JACOBIAN_LANES];
} pl_float_block;

/** Bound the coefficients of elements. is_passed_over [n_coefficients]: those that inner is not of. */
void pl_jacobian_bound(const pl_jacobian_rule *rule, const uint8_t is_passed_over[],
                       pl_float_block *b);

/** Decide an element as pl_validity_of_lane does, by integers alone. */
pl_validity pl_validity_exactly(const pl_jacobian_rule *rule, const int32_t node[],
                                const double *coordinates, double sign);

#endif
