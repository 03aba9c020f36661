/* run: one call of planish_smooth: its mesh, the mesh quality, its sweeps, trials.
 *
 *   pl_run_measure, _measure_fixed             measure the mesh; the rest of it
 *   pl_run_rms_of_movable                      the RMS of movable elements, also held ones
 *   pl_run_objective, _worst_limits            F; the worst element's measures, as limits
 *   pl_run_excess                              by how much the RMS can fall
 *   pl_run_blunt, pl_run_is_within             ratios without sharp angles; sums against limits
 *   pl_run_objective_problem                   the problem of the sums
 *   pl_run_sliding_problem                     the problem of the visits of sliding nodes
 *   pl_run_prepare, _begin_anew                set up the problem of the visits
 *   pl_run_sweeps, _sweep, _sweep_colours      sweep until convergence, once, or over the colours
 *   pl_run_begin_sweep, _end_sweep             frame of a sweep
 *   pl_ask_caller                              the progress function
 *   pl_run_after_colour, _stop_check, _ask_all stop: after a colour, in long work, in any process
 *   pl_run_sweeps_left                         number of sweeps that options still allow
 *   pl_run_has_followers                       whether nodes move with others
 *   pl_trial_begin, _end                       change the mesh, and keep the change or undo it
 */
#ifndef PL_SWEEP_RUN_H
#define PL_SWEEP_RUN_H

#include "quality/measure.h"
#include "sweep/watch.h"
#include "sweep/guard.h"
#include "sweep/rows.h"
#include "sweep/skin.h"
#include "sweep/sweep.h"

struct pl_run;
struct pl_trial;

/** Methods that help a mesh on which sweeps are slow; all nodes move at once. */
typedef enum pl_acceleration { PL_COARSE, PL_CENTRING, PL_DESCENT } pl_acceleration;

/** Move all nodes at once; see pl_run_accelerate. */
typedef int pl_accelerate_fn(struct pl_run *r, pl_acceleration acceleration, double fall);

/** One call of planish_smooth. */
typedef struct pl_run {
    planish_plan *plan;
    const planish_options *options;
    double *coordinates;             /* the caller's */
    const double *given;             /* [n][dim] those of the plan's nodes, as they came */
    pl_objective_sums sums_of_fixed; /* do not change: ratio[0], volume[0] and n[0] over all fixed
                                        elements, inverted and below over those outside of the
                                        plan's subset; all 0 if the plan works on the whole mesh */
    pl_star_problem problem;
    pl_guard guard;
    pl_watch watch;              /* elements of order 2 */
    pl_skin skin;                /* the surface on options.shape */
    pl_star_guard sliding_guard; /* guard of the nodes that slide */
    int plain;                   /* the plain problem: the sum of RR^2, with corners that of mu^2,
                                    nothing else is asked */
    unsigned kinds;              /* with corners: bit 1 << kind of those that there are */
    double measure_scale;        /* a power of two, times which coordinates are measured: ratios are
                                    then the same bits at every scale; 1 where volumes count */
    pl_objective_sums sums; /* as measured last; ratio[1] with the improvement by the sweeps since;
                               of a plain run of simplices without radius, volume, shortfall and
                               domain */
    double ratio_of_held, n_of_held; /* sum of AR^2, or RR^2, of the valid elements whose movable
                                        nodes are all held, and their number: in sums they are of [0] */
    int knows_held;                  /* they are summed up */
    double measured_sum;             /* the sum that is tracked, as measured last */
    double factor;                   /* from a star's function to F, of the last sweep's weights */
    const struct pl_trial
        *shown;          /* not NULL: the sweeps are a trial, and the mesh before it stands */
    int64_t improved;    /* stars that the last sweep improved by more than a hundredth */
    planish_phase phase; /* of the sweeps; _UNTANGLE: the last one brought elements above their
                            minimum volume */
    pl_star_limits
        limits_at_start; /* the worst of the mesh as it came; infinite: nothing is promised */
    int may_be_sharp;    /* angles are of no concern, as elements have targets */
    double
        worst_at_start; /* with corners, whose worst those limits are: largest AR^2 of a cell with
                              a movable node; infinite: nothing is promised */
    pl_objective_sums sums_at_start;   /* of that mesh */
    int64_t n_turned_at_start;         /* watch.n_turned of that mesh */
    double start_seconds, sweep_start; /* clock: of the call, of the sweep */
    pl_marked refusers; /* cells that keep refusing moves: their coefficients are constraints while
                           pl_run_sweeps is under way */
    int sweep;
    int uncounted_sweeps; /* that max_sweeps does not count: those before nodes were put back */
    pl_accelerate_fn *accelerate; /* what sweeps call where they are slow */
    int n_step_tries;             /* calls of PL_COARSE */
    int steps_from;               /* sweeps in a row before the next one */
    planish_stop stop;
    planish_result *result;
} pl_run;

/** Measure the plan's coordinates. */
void pl_run_measure(pl_run *r);

/** Measure them if elements were inverted at the last time: sweeps may have repaired some since. */
void pl_run_measure_inverted(pl_run *r);

/** Measure the rest of the mesh, whose scaled coordinates are all [.][dim]: sums_of_fixed. inverted
 *  and below are then those of all elements: the caller takes off those in the plan's subset. */
void pl_run_measure_fixed(pl_run *r, const double *all);

/** Return the RMS of sums over the elements with a movable node, also where this run holds the node. */
double pl_run_rms_of_movable(const pl_run *r, const pl_objective_sums *sums);

/** Return F of all elements, as measured or tracked last. */
double pl_run_objective(const pl_run *r);

/* Limits of elements, relative to the worst there is: the margin is for the rounding of
 * slivers, whose RR depends on the node it is seen from. */
#define PL_LIMIT_MARGIN (1 - 1e-9)

/** Return the measures of the worst element, as measured last, times margin: RR^2 and acuteness; with
 *  corners mu^2 of one, and 1 / SJ^2. */
pl_star_limits pl_run_worst_limits(const pl_run *r, double margin);

/** Return the part of the RMS by which it can fall at most, 1 if that is not known: with targets what it
 *  is above 1. */
double pl_run_excess(const pl_run *r);

/** Return the RR^2, or mu^2 with corners, up to which none has an angle of larger acuteness, or a
 *  corner of larger 1 / SJ^2. */
double pl_run_blunt(const pl_run *r, double acuteness);

/** Whether the mesh as measured last has no element with a larger RR^2 than ratio, or larger
 *  acuteness; with corners none with a larger mu^2 or 1 / SJ^2. */
int pl_run_is_within(const pl_run *r, double ratio, double acuteness);

/** Return the problem of summing over the mesh in plan->scratch.to_measure. */
pl_objective_problem pl_run_objective_problem(const pl_run *r);

/** Return the problem of the nodes that slide, as the interior's is at present. It always has a
 *  guard. */
pl_star_problem pl_run_sliding_problem(pl_run *r);

/** Set up the problem of the ordinary sweeps, with the guard if one is wanted, for the mesh as
 *  measured last; all stars have changed. */
void pl_run_prepare(pl_run *r);

/** Mark all stars as changed, and forget all that they have kept. */
void pl_run_begin_anew(pl_run *r);

/** Visit all colours, the interior's and those of the nodes that slide. */
void pl_run_sweep_colours(pl_run *r, pl_sweep_tally *tally);

/** Sweep once and tell the caller; not 0 if it was cut short. *visits: those of the sweep. */
int pl_run_sweep(pl_run *r, int64_t *visits);

/** Begin a sweep: count it and note the time. */
void pl_run_begin_sweep(pl_run *r);

/** End a sweep with its tally; returns not 0 if the run is to end: r->stop says why. */
int pl_run_end_sweep(pl_run *r, const pl_sweep_tally *tally);

/** Return the answer of the caller's progress function; 0 if there is none. Memory that the
 *  caller's calls on the plan lack does not count as missing here. */
int pl_ask_caller(const planish_options *options, const planish_progress *progress);

/** Ask the caller after a colour of the sweep; returns not 0 if the run is to end. */
int pl_run_after_colour(void *run, int colours_done, int64_t visits);

/** Return a limit that asks pl_run_after_colour (colour 0), for long work between sweeps. */
pl_stop_check pl_run_stop_check(pl_run *r);

/** Ask as pl_run_after_colour does, in all processes; returns the largest answer. */
int pl_run_ask_all(pl_run *r, int colours_done, int64_t visits);

/** Number of sweeps that may still be begun. */
int pl_run_sweeps_left(const pl_run *r);

/** Whether the plan has followers and the method visits stars. Rounding can worsen a follower's own
 *  elements, because only the leader's star is checked. */
int pl_run_has_followers(const pl_run *r);

/** Sweep until that converges or must end: r->stop says why. */
void pl_run_sweeps(pl_run *r);

/** A trial under way, and the run as it was at the beginning. */
typedef struct pl_trial {
    pl_run *run;
    pl_objective_sums standing; /* of the mesh that stands */
    double *before;             /* its coordinates, the caller's array */
    pl_star_problem problem;
    pl_star_guard guard;
    planish_phase phase;
    void *skin; /* its places and bounds */
    const struct pl_trial *shown;
} pl_trial;

/** Begin a trial with the mesh as measured last. before [n_nodes][dim] is room for coordinates, and
 *  stays the caller's. is_hidden: progress reports show the state before the trial until it ends.
 *  The trial may change the run's problem, guard and phase as it needs. */
void pl_trial_begin(pl_run *r, int is_hidden, double *before, pl_trial *trial);

/** End the trial; the run's problem, guard and phase are again as before. is_taken: the mesh as it
 *  is now, and measured, stands from now on. Else the coordinates from before come back and are
 *  measured. */
void pl_trial_end(const pl_trial *trial, int is_taken);

#endif
