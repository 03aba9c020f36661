/* sweep: passes over the colours of a plan until the RMS converges: options, what is selected, one
 * sweep, volumes, optimality, convergence. */
#ifndef PL_SWEEP_H
#define PL_SWEEP_H

#include "sweep/plan.h"
#include "topology/part.h"

/* ---- options.c ---------------------------------------------------------------------------- */

/** Check struct_size and the ranges of all fields. */
int pl_options_check(const planish_options *options, planish_error *error);

/** The same, and that coordinates [n][dim] are finite: what every call on coordinates begins with.
 */
int pl_call_check(const planish_plan *plan, const double *coordinates,
                  const planish_options *options, planish_error *error);

/** options->threads; instead of 0 fewer than OpenMP would use, if mesh is too small for these. */
int pl_threads_for(const planish_mesh *mesh, const planish_options *options);

/* ---- select.c ------------------------------------------------------------------------------ */

/** Choose the nodes that options->only_worse_than is about: is_selected [n] is filled with 0, or
 *  not 0 for the nodes of elements whose RR is above it, that are below their least volume, or not
 *  positive, and of layers of elements around these. sign: as in pl_boundary. *all_positive: no
 *  element was found that is not. part, which is {0}, is filled if it was found on the way. Errors:
 *  _MESH (of its neighbours), _MEMORY. */
int pl_select(const planish_mesh *mesh, const int8_t *sign, const planish_options *options,
              int threads, uint8_t *is_selected, int *all_positive, pl_part *part,
              planish_error *error);

/** The same for options->around; is_selected [n] is 0 before. */
void pl_select_around(const planish_mesh *mesh, const planish_options *options, int threads,
                      uint8_t *is_selected);

/* ---- sweep.c: one pass over the colours ---------------------------------------------------- */

/** Asked after every colour (colours done so far, nodes visited in this one): a result other than
 * 0, a planish_stop, ends the sweep there; with other processes, all of it, when the sweep ends. */
typedef int pl_after_colour_fn(void *context, int colours_done, int64_t visits);

/** What one sweep did. */
typedef struct pl_sweep_tally {
    pl_sum decrease; /* of the stars' functions, see pl_star_tally */
    int64_t visits, evaluations;
    int64_t improved; /* stars whose function fell by more than a hundredth of itself */
    int64_t restored; /* stars in which elements were brought nearer to their least volume */
    int colours;      /* done */
    int stopped;      /* what pl_after_colour_fn said; the largest of the processes */
} pl_sweep_tally;

/** Put the nodes that follow others, and images, to where these say; a change of theirs is one of
 *  the others. pl_sweep does so before the first colour and after each. */
void pl_follow(const planish_plan *plan, const pl_star_problem *problem);

/** Visit the changed stars of visits, colour by colour, whose problem it is, and add to *tally. */
void pl_sweep(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
              planish_method method, pl_after_colour_fn *after_colour, void *context,
              pl_sweep_tally *tally);

/* ---- volumes.c ---------------------------------------------------------------------------- */

/** What a search for proofs has come to. */
typedef struct pl_infeasible {
    int64_t n;           /* elements _INFEASIBLE */
    int64_t n_undecided; /* elements _BELOW of stars that the limit has kept from being searched */
} pl_infeasible;

/** Turn PLANISH_VOLUME_BELOW into _INFEASIBLE in state [n_elements] for elements that are not
 *  positive and among those that free nodes join, if what the held nodes around these enclose is
 *  not positive: not all of them can be, wherever the free nodes are. x: coordinates by inner
 *  numbers. lost [n_nodes] by inner numbers (may be NULL) becomes 1 at their free nodes. *n: how
 *  many elements it were; none in a mesh in parts. Errors: _MEMORY. */
int pl_mark_enclosed(const planish_plan *plan, const double *x, uint8_t *state, uint8_t *lost,
                     int64_t *n, planish_error *error);

/** Turn _BELOW into _INFEASIBLE in state [m] where the element cannot reach its least volume: it
 * has no free node, or it is part of a proof (pl_star_infeasible) at its only one. The coordinates,
 * and the guard, are the problem's. If part is not NULL only elements that have no free node or are
 * given up are marked, the latter whatever their state was, and *part becomes [link facets of all
 * stars] of pl_star_part, to be released by pl_free. limit (may be
 * NULL) ends the search; its answer is then the largest of the processes. Errors: _MEMORY. */
int pl_mark_infeasible(const planish_plan *plan, const pl_star_problem *problem, uint8_t *state,
                       pl_limit *limit, pl_infeasible *found, uint8_t **part, planish_error *error);

/* ---- optimality.c ------------------------------------------------------------------------- */

/** Add the first-order optimality over all stars of visits, whose problem it is, with a guard.
 *  Errors: _MEMORY. */
int pl_optimality(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
                  pl_star_optimality *optimality, planish_error *error);

/* ---- convergence.c ------------------------------------------------------------------------- */

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
