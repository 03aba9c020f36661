/* rational: small problems with linear constraints, solved without rounding (GMP), as a reference
 * for what the library decides in floating point. Simple and slow.
 *
 * Doubles are rational numbers, so that a problem of doubles is taken as it is. What is found is
 * certain: every answer comes with what proves it, and the proof is checked before it is given.
 */
#ifndef TEST_SUPPORT_RATIONAL_H
#define TEST_SUPPORT_RATIONAL_H

#ifdef PLANISH_HAVE_GMP

#include <gmp.h>
#include <stdint.h>

enum { RATIONAL_DIM = 4, RATIONAL_ROWS = 64 };

/** sum += a b. */
void rational_add_product(mpq_t sum, const mpq_t a, const mpq_t b);

/** The dot product of n numbers. */
void rational_dot(mpq_t result, const mpq_t *a, const mpq_t *b, int n);

/* ---- projection on a cone ------------------------------------------------------------------- */

/** m rows of n <= RATIONAL_DIM numbers and a point p; what is to be found: the point y nearest to p
 *  with row . y <= 0 for all rows, and multipliers >= 0 with p - y = sum multiplier_j row_j. */
typedef struct rational_cone {
    int m, n;
    mpq_t row[RATIONAL_ROWS][RATIONAL_DIM], p[RATIONAL_DIM];
    mpq_t y[RATIONAL_DIM];
    mpq_t multiplier[RATIONAL_DIM];
    int set[RATIONAL_DIM], n_set; /* of the rows with multipliers */
    mpq_t gram[RATIONAL_DIM][RATIONAL_DIM + 1], t[2];
} rational_cone;

void rational_cone_init(rational_cone *c);
void rational_cone_clear(rational_cone *c);
void rational_cone_set(rational_cone *c, const double (*rows)[RATIONAL_DIM], int64_t m,
                       const double *p, int n);

/** Look at the set of rows first (it may save the search), then at all sets. Returns whether it was
 *  the one; there is always one. */
int rational_cone_project(rational_cone *c, const int64_t *set, int n_set);

/* ---- linear inequalities -------------------------------------------------------------------- */

/** m inequalities row . x >= least in n < RATIONAL_DIM unknowns; what is to be found: x, or weights
 *  >= 0 with sum weight_j row_j = 0 and sum weight_j least_j > 0, so that there is none (Farkas).
 */
typedef struct rational_system {
    int m, n;
    mpq_t row[RATIONAL_ROWS][RATIONAL_DIM], least[RATIONAL_ROWS];
    mpq_t x[RATIONAL_DIM], weight[RATIONAL_ROWS];
    mpq_t tableau[RATIONAL_DIM + 1][RATIONAL_ROWS + RATIONAL_DIM + 1], t[2];
    int basis[RATIONAL_DIM];
} rational_system;

void rational_system_init(rational_system *s);
void rational_system_clear(rational_system *s);

/** Whether there is an x; 0: there are weights. Exits if neither proof holds: a fault in here. */
int rational_system_solve(rational_system *s);

#endif
#endif
