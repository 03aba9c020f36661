/* rows: the Bezier coefficients of det J of an element, as rows of a star.
 *
 * Let a node move by d, and each node that follows it by its rate of d. Then det J is affine in d
 * at every point, and so is each of its Bezier coefficients (geometry/jacobian.h). So each
 * coefficient gives a row in the point form (pl_star_row):
 *
 *     D   the coefficient: where all are positive the element is valid
 *     E   |T|^2 where its polynomial is largest; T = J W^-1, W the ideal element's
 *
 * D is in the unit of corners: det J in the edges of a corner, so that every row of a straight simplex
 * has its own D, E and mean ratio, and rows at corners of linear elements are those of the corners.
 *
 * A coefficient may be negative in a valid element. A proof that an element is invalid, wherever a
 * node goes, may use values of det J alone: coefficients at corners, and pl_row_point.
 *
 *   pl_row_rule_make, _free        what all elements of a type have in common
 *   pl_row_handle                  how fast the nodes of an element move with one of them
 *   pl_rows_of_element             the rows of an element for such a handle
 *   pl_row_coefficients            the coefficients alone
 *   pl_row_point                   det J at a point, by these
 *   pl_marked_make, _destroy       elements of a plan whose rows stars shall heed
 */
#ifndef PL_SWEEP_ROWS_H
#define PL_SWEEP_ROWS_H

#include "geometry/jacobian.h"
#include "star/star.h"
#include "sweep/watch.h"

/** Type of elements as rows know it; not of pyramids. */
typedef struct pl_row_rule {
    pl_jacobian_rule jacobian;
    double unit;         /* a coefficient of the rule by it is one of det J */
    double control_unit; /* likewise of controls; 1 where they are nodes */
    double metric[6];    /* |T|^2 = sum of metric J_a . J_b, by pairs 00 01 02 11 12 22 */
    double factor, k;    /* mu^2 = factor E^2 D^-k */
    /* [n_coefficients][n_nodes][dim] derivatives of the shape functions at each coefficient's point */
    double (*gradient)[PL_CELL_NODES][3];
} pl_row_rule;

/** Make the rule of a type, which is not a pyramid; NULL: there is no memory. */
pl_row_rule *pl_row_rule_make(const pl_cell_type *type);

/** Free rule; NULL: do nothing. */
void pl_row_rule_free(pl_row_rule *rule);

/** Add the handle of node, a place in the element, to rate [n_nodes]: the move of each node of the
 *  element if the node moves by 1. Nodes follow corners: half of each end of an edge, a quarter of
 *  the corners of a face, an eighth of those of the cell. */
void pl_row_handle(const pl_row_rule *rule, int node, double rate[]);

/** Fill row [n_coefficients] with the rows of an element that depend on a handle; returns how many.
 *  x [n_nodes][dim]: its nodes' places; sign: +1 or -1, times which det J is positive in a valid
 *  element; weight: of all rows of the element together; index [n_coefficients] (or NULL): the
 *  coefficient of each row. */
int pl_rows_of_element(const pl_row_rule *rule, const double *x, double sign, const double rate[],
                       double weight, pl_star_row *row, uint8_t *index);

/** Set coefficient [n_coefficients] to those of an element; arguments as above. */
void pl_row_coefficients(const pl_row_rule *rule, const double *x, double sign,
                         double coefficient[]);

/** At a point xi [dim] of the reference element: det J is the sum of blend [n_coefficients] times the
 *  coefficients, and gradient [n_nodes][dim] are the derivatives of the shape functions. */
void pl_row_point(const pl_row_rule *rule, const double *xi, double blend[], double gradient[][3]);

/** Elements of a plan whose rows count in the stars of its interior. Arrays are owned. */
typedef struct pl_marked {
    const pl_watch *watch; /* where nodes are */
    double weight;         /* of an element's rows together; 0: constraints alone */
    int64_t n;             /* elements; of one of corners, its first corner */
    int32_t *element;      /* [n] of the plan's mesh */
    int64_t *begin;        /* [n_nodes + 1] by inner numbers: where place of each node begins */
    int32_t *place;        /* marked elements of each node, by their place in element */
    const uint8_t
        *in_patch; /* [n_nodes] by inner numbers: the nodes that share an element's rows in a
                                sum over stars; NULL: no such sum is wanted. Not owned. */
    const double
        *size;       /* [n_nodes] by inner numbers: length of edges that is wanted there; NULL: 1.
                           Not owned. */
    double *scratch; /* [threads][scratch_stride] of visits, with room for the rows */
    int64_t scratch_stride;
    uint8_t *has_more; /* [n_stars] of the interior: 1: a marked element is at the star's node */
    int64_t max_more;  /* most rows of a star */
    pl_row_rule *rule[PL_WATCH_TYPES]; /* by types; NULL: no such element is marked */
} pl_marked;

/** Mark the elements whose entry in is_marked is not 0: [n_elements of the plan], of elements of
 *  corners that of the first corner. Pyramids are passed over: their corners say all. marked is to
 *  be destroyed in any case. Errors: _MEMORY. */
int pl_marked_make(const pl_watch *watch, const uint8_t *is_marked, double weight,
                   pl_marked *marked, planish_error *error);

/** Free the arrays of marked. */
void pl_marked_destroy(pl_marked *marked);

/** Let the rows of the marked elements count in problem, of the interior's stars. */
void pl_marked_use(const pl_marked *marked, pl_star_problem *problem);

/** Find the places of the nodes of an element (of corners: its first one) at the plan's present
 *  coordinates: x [n_nodes][dim]; returns its type. node [n_nodes] (or NULL): the caller's numbers,
 *  -1: a missing mid. */
const pl_cell_type *pl_places_of_element(const pl_watch *watch, int64_t element, double *x,
                                         int32_t *node);

#endif
