/* sweep: one pass over the colours of a plan, optimality, and convergence of passes. All in
 * sweep.c.
 *
 *   pl_sweep, pl_follow          visit all colours; place followers
 *   pl_optimality                how far the stars are from a minimum
 *   pl_remainder, pl_left_after, pl_converged   what further sweeps promise
 */
#ifndef PL_SWEEP_SWEEP_H
#define PL_SWEEP_SWEEP_H

#include "plan/plan.h"

/* ---- one pass over the colours ------------------------------------------------------------- */

/** Function called after every colour with the colours done so far and the nodes visited in this
 * one. A result other than 0, a planish_stop, ends the sweep there. With other processes the sweep
 * goes on to its end, and then all of them stop. */
typedef int pl_after_colour_fn(void *context, int colours_done, int64_t visits);

/** Tally of one sweep. */
typedef struct pl_sweep_tally {
    pl_star_tally stars; /* of all visits */
    int colours;         /* done */
    int stopped;         /* answer of pl_after_colour_fn; the largest of the processes */
} pl_sweep_tally;

/** Place followers and images from their leaders. A changed follower marks its leader's star as
 *  changed. pl_sweep calls this before the first colour and after each. */
void pl_follow(const planish_plan *plan, const pl_star_problem *problem);

/** Visit the changed stars of visits, colour by colour, and add to *tally. problem is that of
 * visits. */
void pl_sweep(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
              planish_method method, pl_after_colour_fn *after_colour, void *context,
              pl_sweep_tally *tally);

/* ---- optimality --------------------------------------------------------------------------- */

/** Add the first-order optimality over all stars of visits to *optimality. problem is that of
 *  visits; without a guard nothing constrains the nodes. Errors: _MEMORY. */
int pl_optimality(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
                  pl_star_optimality *optimality, planish_error *error);

/* ---- convergence -------------------------------------------------------------------------- */

enum { PL_CALM_SWEEPS = 3 }; /* sweeps in a row that must bring less than the tolerance */

/** Relative falls of the movable RMS in the last sweeps, latest last. */
typedef struct pl_convergence {
    double fall[PL_CALM_SWEEPS];
    int n_falls;
} pl_convergence;

/** Return the fall that all further sweeps together would bring if the falls shrink on at the rate
 *  of the last sweeps. */
double pl_remainder(const pl_convergence *convergence);

/** Return the fall of F after so many more sweeps, extrapolated as a power of the number of sweeps:
 *  while an error spreads out, falls go this way; infinite if that has no end. */
double pl_left_after(const pl_convergence *convergence, int sweeps);

/** Note one more sweep, from RMS before to after. Return not 0 if smoothing has converged. */
int pl_converged(pl_convergence *convergence, double before, double after, double tolerance);

#endif
