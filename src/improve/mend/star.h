/* star: the local problem of one mid or corner of curved elements.
 *
 * The Bezier coefficients of the elements at the node are rows (sweep/rows.h): affine in its way, with
 * a mean ratio that is convex. A visit lowers either the regularised energy of the rows
 * (star/kernel_foldover.h), which untangles, or the sum of their mean ratios with all coefficients
 * positive.
 */
#ifndef PL_IMPROVE_MEND_STAR_H
#define PL_IMPROVE_MEND_STAR_H

#include "improve/mend/handle.h"

/** Star of one node at a time. Arrays are owned. */
typedef struct pl_mend_star {
    pl_mend *curve;
    double *target; /* [elements of the plan] D that is wanted of an element */
    int64_t n, capacity;
    pl_star_row *row; /* [n] */
    double *scale;    /* [n][2] 1 / the wanted D, 1 / the E of the ideal element of this D */
    uint8_t *is_soft; /* [n] of elements that are given up: they pull a little */
} pl_mend_star;

/** Make s; the caller sets target. To be destroyed in any case. Errors: _MEMORY. */
int pl_mend_star_create(pl_mend *c, pl_mend_star *s, planish_error *error);

/** Free the arrays of s. */
void pl_mend_star_destroy(pl_mend_star *s);

/** D of an element as a straight one. */
double pl_mend_straight(const pl_mend *c, int64_t element);

/** Return the energy of the star of h with regularisation epsilon > 0. *least: the least D of a row by
 *  the wanted one, of elements that are not given up. */
double pl_mend_star_energy(pl_mend_star *s, const pl_handle *h, double epsilon, double *least);

/** Visit the star of h: lower its energy with epsilon > 0, or the sum of its mean ratios (epsilon
 *  0). With epsilon 0, elements with a row that is not positive count as given up. Returns by how
 *  much that has fallen, relative; 0: the node has not moved. */
double pl_mend_star_visit(pl_mend_star *s, pl_handle *h, double epsilon);

#endif
