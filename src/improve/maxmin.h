/* maxmin: the step that raises the least of several linear functions, near where it begins.
 *
 * Minimise |x|^2 / (2 reach) + (target - t)^2 / (2 spread) over x [n] and t, so that t <= value_i + g_i . x for
 * each raised row, and 0 <= value_i + g_i . x for the others. x = 0 must do for the latter: value_i >= 0.
 *
 * A dual active set after Goldfarb and Idnani (1983), for a projection: in the variables x / sqrt(reach)
 * and t / sqrt(spread) the point (0, target) is projected on the polyhedron of the rows. It begins
 * there, takes in the row that is violated most, and drops rows whose multiplier becomes 0. Serial; the
 * same bits everywhere.
 *
 *   PL_MAXMIN_ROOM      memory that a problem needs
 *   pl_maxmin_solve     the step
 */
#ifndef PL_IMPROVE_MAXMIN_H
#define PL_IMPROVE_MAXMIN_H

#include <stdint.h>

enum { PL_MAXMIN_BLOCKS = 4 };

/* Doubles of room for n variables. */
#define PL_MAXMIN_ROOM(n) (2 * ((n) + 1) * ((n) + 1) + 5 * ((n) + 1))

/** A row. g has at most PL_MAXMIN_BLOCKS blocks of three entries that are not 0. */
typedef struct pl_maxmin_row {
    double value;
    int n_blocks;
    int32_t first[PL_MAXMIN_BLOCKS]; /* variable of the block's first entry */
    double slope[PL_MAXMIN_BLOCKS][3];
    uint8_t width[PL_MAXMIN_BLOCKS]; /* entries of the block */
    uint8_t is_raised;
} pl_maxmin_row;

/** A problem. */
typedef struct pl_maxmin {
    int n; /* variables */
    int m; /* rows */
    const pl_maxmin_row *row;
    double reach, spread, target;
    double *room;       /* [PL_MAXMIN_ROOM(n)] */
    double *x;          /* [n] result: the step, */
    double t;           /* the least raised row there, */
    int n_active;       /* the rows that hold it back, */
    int *active;        /* [n + 1] */
    double *multiplier; /* [n + 1] above 0, of each */
    int64_t work;       /* of the solutions so far: multiplications, roughly */
} pl_maxmin;

/** Solve the problem. Return 0 if rounding left rows violated; the step may still be a good one. */
int pl_maxmin_solve(pl_maxmin *p);

#endif
