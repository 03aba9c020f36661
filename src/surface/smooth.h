/* smooth: one call that smooths a surface mesh.
 *
 *   pl_surface_run_measure, pl_surface_rms, _rms_of_movable    the mesh as it is
 *   pl_surface_sweeps                         sweep until convergence
 *   pl_surface_improve_worst                  stages for the worst elements
 */
#ifndef PL_SURFACE_SMOOTH_H
#define PL_SURFACE_SMOOTH_H

#include "surface/visit.h"

/** Tally of a thread; no line of the cache is shared with another one's. */
typedef struct pl_surface_tally {
    _Alignas(64) pl_star_tally of;
} pl_surface_tally;

/** One call. Arrays are owned, and go by the shape's numbers of nodes. */
typedef struct pl_surface_run {
    const planish_mesh *mesh; /* the caller's */
    double *coordinates;      /* likewise, laid out as mesh->coordinates */
    const planish_options *options;
    planish_result *result;
    const planish_shape *shape;
    int threads;
    double (*x)[3], (*start)[3];     /* [n_nodes] where nodes are, and were */
    double (*scaled)[3];             /* [n_nodes] in the shape's units, for measuring */
    double (*before)[3];             /* [n_nodes] where a trial began */
    double (*lower)[3], (*upper)[3]; /* [n_nodes] bounds, or NULL */
    double *radius;                  /* [n_nodes], or NULL */
    uint8_t *is_movable;             /* [n_nodes] 1: free or slides */
    uint8_t *moves;                  /* [n_nodes] 0: the node stays in this run */
    const uint8_t *held;             /* [n_nodes] 1: it has to stay; NULL: none has. Not owned */
    uint8_t *changed;                /* [n_nodes] */
    double *ratio;                   /* [n_facets] */
    pl_surface_mesh stars;
    pl_star_slide *slide; /* [n_stars] */
    pl_skin skin;
    pl_surface_problem problem;
    pl_surface_tally *tally; /* [threads] */
    pl_surface_sums sums;    /* as measured last */
    double start_seconds, sweep_start;
    int sweep;
    planish_phase phase;
    planish_stop stop;
} pl_surface_run;

/** Root of the mean square ratio of all elements, as measured last. */
double pl_surface_rms(const pl_surface_sums *sums);

/** Root of the mean square ratio of the elements with a movable node, also if this run holds it. */
double pl_surface_rms_of_movable(const pl_surface_sums *sums);

/** Measure the mesh as it is. Errors: _MEMORY. */
int pl_surface_run_measure(pl_surface_run *r, planish_error *error);

/** Sweep until that converges, or must end: r->stop says why. Errors: _MEMORY. */
int pl_surface_sweeps(pl_surface_run *r, planish_error *error);

/** Improve the worst elements, by options.worst. Errors: _MEMORY. */
int pl_surface_improve_worst(pl_surface_run *r, planish_error *error);

#endif
