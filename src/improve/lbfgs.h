/* lbfgs: L-BFGS (Nocedal 1980): minimise a function of all nodes of a patch. The nodes' own
 * Hessians are the first guess.
 *
 *   pl_lbfgs_create, _destroy     a minimisation over a patch
 *   pl_lbfgs_begin, _iterate      evaluate, and lower the value
 */
#ifndef PL_IMPROVE_LBFGS_H
#define PL_IMPROVE_LBFGS_H

#include "improve/patch.h"

enum { PL_LBFGS_PAIRS = 12, PL_LBFGS_SLOTS = PL_LBFGS_PAIRS + 1 }; /* one slot is for a trial */

/** A step s, and the change y of the gradient by it. */
typedef struct pl_lbfgs_pair {
    double *s, *y;
    double sy; /* s . y */
} pl_lbfgs_pair;

/** Function to minimise. Returns the value at the plan's coordinates, and fills slope [n_stars]
 *  of the patch's stars. Returns INFINITY, with no slopes, where the nodes must not be. Above
 *  enough the slopes need not be filled. */
typedef double pl_lbfgs_function(void *context, double enough, pl_star_slope *slope);

/** A minimisation under way; arrays are owned. */
typedef struct pl_lbfgs {
    pl_patch p;
    pl_lbfgs_function *function;
    void *context;
    double value; /* where the nodes are */
    double *start, *position, *gradient, *direction, *last_gradient;
    pl_star_slope *slope; /* [n_stars] */
    pl_lbfgs_pair pairs[PL_LBFGS_SLOTS];
    int n_pairs, newest;
    int64_t evaluations;
} pl_lbfgs;

/** Begin a minimisation over a patch as for pl_patch_create. Returns 0 without memory; destroy it
 * in any case. */
int pl_lbfgs_create(pl_run *run, const pl_star_problem *problem, const uint8_t *in_patch,
                    pl_lbfgs_function *function, void *context, pl_lbfgs *m);

/** Free the arrays of m. */
void pl_lbfgs_destroy(pl_lbfgs *m);

/** Evaluate the function where the nodes are, and forget the pairs: it has changed, or they have.
 */
void pl_lbfgs_begin(pl_lbfgs *m);

/** Iterate once; 0 if the value could not be lowered, and the nodes are where they were. */
int pl_lbfgs_iterate(pl_lbfgs *m, pl_sweep_tally *tally);

#endif
