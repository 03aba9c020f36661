/* cone_problems: projections on cones, at random. */
#include "support/cone_problems.h"

#include <math.h>

static int below(uint64_t *random, int n) {
    return (int)random_below(random, n);
}

/** A row that stands in some relation to the ones before it. */
static void make_row(cone_problem *q, int row, uint64_t *random) {
    double *a = q->rows[row];
    const double *other = q->rows[row > 0 ? below(random, row) : 0];
    int kind = row > 0 ? below(random, 9) : 8;
    double length = row > 0 ? sqrt(cone_dot(other, other, q->n)) : 0;
    double factor = ldexp(1, below(random, 9) - 4); /* exact multiples */
    for (int d = 0; d < q->n; d++) {
        double fresh = below(random, 4) ? random_between(random, -1, 1) : 0;
        switch (kind) {
        case 0: /* the same */
            a[d] = other[d];
            break;
        case 1: /* parallel */
            a[d] = factor * other[d];
            break;
        case 2: /* opposed */
            a[d] = -factor * other[d];
            break;
        case 3: /* nearly parallel */
            a[d] = other[d] + q->nearly * length * random_between(random, -1, 1);
            break;
        case 4: /* nearly opposed */
            a[d] = -other[d] + q->nearly * length * random_between(random, -1, 1);
            break;
        case 5: /* in the plane of two others */
            a[d] = other[d] - factor * q->rows[0][d];
            break;
        case 6: /* small whole numbers: many coincidences */
            a[d] = below(random, 3) - 1;
            break;
        default:
            a[d] = fresh;
        }
    }
}

void cone_problem_make(cone_problem *q, uint64_t *random) {
    q->n = 2 + below(random, 3);
    q->m = below(random, below(random, 20) ? CONE_PROBLEM_FULL : CONE_PROBLEM_ROWS + 1);
    int lattice = below(random, 4) == 0;
    for (int d = 0; d < CONE_DIM; d++)
        q->p[d] = lattice ? below(random, 3) - 1 : random_between(random, -1, 1);
    for (int row = 0; row < q->m; row++)
        make_row(q, row, random);
    if (q->m > 0 && below(random, 16) == 0) /* p along a row: it vanishes */
        for (int d = 0; d < q->n; d++)
            q->p[d] = q->rows[0][d];
}

/** 1, or anything up to 1e100 and down to 1e-100; half of them powers of two, which round nothing.
 */
static double random_factor(uint64_t *random) {
    switch (below(random, 4)) {
    case 0:
        return 1;
    case 1:
        return below(random, 2) ? 1e100 : 1e-100;
    case 2:
        return ldexp(1, below(random, 665) - 332);
    default:
        return pow(10, random_between(random, -100, 100));
    }
}

void cone_problem_scale(cone_problem *q, uint64_t *random) {
    for (int row = 0; row <= q->m; row++) {
        double factor = random_factor(random), *a = row < q->m ? q->rows[row] : q->p;
        for (int d = 0; d < CONE_DIM; d++)
            a[d] *= factor;
    }
}
