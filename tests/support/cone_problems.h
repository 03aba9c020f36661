/* cone_problems: projections on cones, at random, with rows that stand in some relation to each
 * other: those are what a solver goes wrong with. */
#ifndef TEST_SUPPORT_CONE_PROBLEMS_H
#define TEST_SUPPORT_CONE_PROBLEMS_H

#include "star/kernel_cone.h"
#include "support/effort.h"

enum { CONE_PROBLEM_ROWS = 12, CONE_PROBLEM_FULL = 7 };

typedef struct cone_problem {
    double rows[CONE_PROBLEM_ROWS][CONE_DIM], p[CONE_DIM];
    int n, m;
    double nearly; /* by what nearly parallel rows differ */
} cone_problem;

/** A problem in 2 to 4 dimensions of, most often, less than CONE_PROBLEM_FULL rows: parallel, the
 *  same, opposed, nearly so (by q->nearly, which is to be set), of small whole numbers, or zero. */
void cone_problem_make(cone_problem *q, uint64_t *random);

/** Multiply rows and p by factors of up to 1e100 and down to 1e-100, each by its own. */
void cone_problem_scale(cone_problem *q, uint64_t *random);

#endif
