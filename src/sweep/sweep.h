/* sweep: one pass over the colours of a plan, optimality, and convergence of passes. All in
 * sweep.c.
 *
 *   pl_sweep, pl_follow          visit all colours; place followers
 *   pl_optimality                how far the stars are from a minimum
 *   pl_remainder, pl_converged   what further sweeps promise
 */
#ifndef PL_SWEEP_SWEEP_H
#define PL_SWEEP_SWEEP_H

#include "plan/plan.h"

/* ---- one pass over the colours ------------------------------------------------------------- */

/** Asked after every colour (colours done so far, nodes visited in this one): a result other than
 * 0, a planish_stop, ends the sweep there; with other processes, all of it, when the sweep ends. */
typedef int pl_after_colour_fn(void *context, int colours_done, int64_t visits);

/** Tally of one sweep. */
typedef struct pl_sweep_tally {
    pl_star_tally stars; /* of all visits */
    int colours;         /* done */
    int stopped;         /* answer of pl_after_colour_fn; the largest of the processes */
} pl_sweep_tally;

/** Put the nodes that follow others, and images, to where these say; a change of theirs is one of
 *  the others. pl_sweep does so before the first colour and after each. */
void pl_follow(const planish_plan *plan, const pl_star_problem *problem);

/** Visit the changed stars of visits, colour by colour, whose problem it is, and add to *tally. */
void pl_sweep(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
              planish_method method, pl_after_colour_fn *after_colour, void *context,
              pl_sweep_tally *tally);

/* ---- optimality --------------------------------------------------------------------------- */

/** Add the first-order optimality over all stars of visits, whose problem it is, with a guard.
 *  Errors: _MEMORY. */
int pl_optimality(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
                  pl_star_optimality *optimality, planish_error *error);

/* ---- convergence -------------------------------------------------------------------------- */

enum { PL_CALM_SWEEPS = 3 }; /* sweeps in a row that must bring less than the tolerance */

/** The relative falls of the movable RMS in the last sweeps, latest last. */
typedef struct pl_convergence {
    double fall[PL_CALM_SWEEPS];
    int n_falls;
} pl_convergence;

/** The fall that all further sweeps together would bring if each brought as much less than the one
 *  before as the last ones did. */
double pl_remainder(const pl_convergence *convergence);

/** Take note of one more sweep, from RMS before to after; not 0 if smoothing has converged. */
int pl_converged(pl_convergence *convergence, double before, double after, double tolerance);

#endif
