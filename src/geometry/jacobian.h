/* jacobian: the determinant of an element's map, as a polynomial in Bezier form.
 *
 * An element is the image of a reference shape under the map that its nodes define. It is valid if
 * the determinant det J of the map's derivative is positive everywhere. det J is therefore written
 * as a sum of Bernstein polynomials, which are positive and add up to 1: det J is between the least
 * and the largest of its coefficients, and those at corners are values of it (Johnen, Remacle,
 * Geuzaine, "Geometrical validity of curvilinear finite elements", 2013; for hexahedra Johnen,
 * Weill, Remacle, arXiv 1706.01613). Where coefficients have both signs the shape is bisected.
 *
 * All of it is one rule per type, made by pl_jacobian_rule_make:
 *   controls      Bezier points of the map: sums of nodes, by whole numbers
 *   derivatives   differences of two controls, in each of dim directions
 *   products      coefficient += weight * det(derivatives i, j, k)
 *   bisections    coefficients of half of the shape: sums of coefficients
 *   straight      the corners in the middle of which a node is if the element is straight
 * Weights are whole numbers, so that exact arithmetic follows the same rule. Of a pyramid det J is
 * that of the 4 corners of its base, blended, whatever the height; nodes other than corners are not
 * looked at.
 */
#ifndef PL_GEOMETRY_JACOBIAN_H
#define PL_GEOMETRY_JACOBIAN_H

#include "geometry/cell.h"

enum {
    PL_JACOBIAN_DERIVATIVES = 18,   /* of a direction */
    PL_JACOBIAN_COEFFICIENTS = 216, /* those of a triquadratic hexahedron, */
    PL_JACOBIAN_PRODUCTS = 18 * 18 * 18,
    PL_JACOBIAN_CONTROL_TERMS = 27 * 27,
    PL_JACOBIAN_HALF_TERMS = 216 * 6
};

/** Term of a sum: sum number to += weight * number from. */
typedef struct pl_jacobian_term {
    int16_t weight;
    uint16_t from;
    uint16_t to;
} pl_jacobian_term;

/** Derivative: control plus - control minus. */
typedef struct pl_jacobian_derivative {
    uint8_t plus, minus;
} pl_jacobian_derivative;

/** Product: coefficient += weight * det(derivative i of direction 0, j of 1, k of 2); in 2-D k is
 *  0. */
typedef struct pl_jacobian_product {
    uint8_t i, j, k;
    uint16_t coefficient;
    uint16_t weight;
} pl_jacobian_product;

/** Rule of a type. Coefficients come out as det J times a positive number that is the same for all
 *  elements of the type. */
typedef struct pl_jacobian_rule {
    const pl_cell_type *type;
    int n_nodes;                     /* that are looked at: the first ones of an element */
    uint8_t straight[PL_CELL_NODES]; /* bit c: corner c is one of these */
    int n_controls;
    int n_control_terms;  /* 0: controls are nodes */
    int control_weight;   /* largest sum of absolute weights of a control */
    int n_derivatives[3]; /* of each direction */
    int n_coefficients;
    int n_products;      /* in the order of j, k, i */
    int n_products_each; /* most products of a coefficient */
    int common;          /* sum of weight * factor over the products of any coefficient */
    /* Points of the lattices: exponents along each direction; not of a pyramid. A coefficient's point
       is where its polynomial is largest. */
    uint8_t control_point[PL_CELL_NODES][3];
    uint8_t coefficient_point[PL_JACOBIAN_COEFFICIENTS][3];
    uint8_t degree[PL_CELL_SIMPLICES]; /* of det J in each simplex */
    int n_corners;
    int n_turns; /* bisections take turns: of simplex turn [0], [1], ..; 0: corners decide */
    uint8_t turn[3];
    pl_jacobian_term control_term[PL_JACOBIAN_CONTROL_TERMS];
    pl_jacobian_derivative derivative[3][PL_JACOBIAN_DERIVATIVES];
    pl_jacobian_product product[PL_JACOBIAN_PRODUCTS];
    uint16_t factor[PL_JACOBIAN_COEFFICIENTS]; /* a coefficient's sum is multiplied by it */
    uint16_t corner[PL_CELL_CORNERS];          /* coefficients that are values at corners */
    /* Bisection of simplex s into halves 0 and 1: coefficients of the half, times 2^half_shift[s]. */
    int n_half_terms[3][2];
    int half_shift[3];
    pl_jacobian_term half_term[3][2][PL_JACOBIAN_HALF_TERMS]; /* in the order of to */
} pl_jacobian_rule;

/** Make the rule of a type. */
void pl_jacobian_rule_make(const pl_cell_type *type, pl_jacobian_rule *rule);

#endif
