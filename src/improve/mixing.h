/* mixing: Anderson's acceleration (1965) of steps from x to g(x) that converge slowly.
 *
 * Of the last steps that combination is taken whose residual g(x) - x is least in the sense of least
 * squares, as if g were affine: Walker and Ni (2011), with one step more than PL_MIXING_DEPTH.
 *
 *   pl_mixing_create, _destroy
 *   pl_mixing_forget            begin anew: the steps are others
 *   pl_mixing_mix               a step: where to go instead
 */
#ifndef PL_IMPROVE_MIXING_H
#define PL_IMPROVE_MIXING_H

#include <stdint.h>

enum { PL_MIXING_DEPTH = 6 };

/** Steps of n numbers. Arrays are owned. */
typedef struct pl_mixing {
    int64_t n;
    int threads;
    int n_steps;            /* that are known, */
    int n_pairs;            /* and differences of such that are kept, at most the depth */
    int next;               /* slot of the next pair */
    double *room;           /* all arrays */
    double *residual, *end; /* [n] of the last step: g(x) - x, g(x) */
    double *d_residual[PL_MIXING_DEPTH], *d_end[PL_MIXING_DEPTH]; /* [n] from step to step */
    double product[PL_MIXING_DEPTH][PL_MIXING_DEPTH];             /* of d_residual */
} pl_mixing;

/** Begin. Returns 0 without memory; destroy it in any case. */
int pl_mixing_create(int64_t n, int threads, pl_mixing *m);

void pl_mixing_destroy(pl_mixing *m);

/** Forget all steps. */
void pl_mixing_forget(pl_mixing *m);

/** Note the step from x [n] to end [n]. end becomes where the steps lead, as far as can be told; returns
 *  0 if it is left as it is. */
int pl_mixing_mix(pl_mixing *m, const double *x, double *end);

#endif
