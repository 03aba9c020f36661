/* tangle: the elements that have to be untangled, and the patch of nodes that is moved for it. */
#ifndef PL_SWEEP_TANGLE_H
#define PL_SWEEP_TANGLE_H

#include "sweep/run.h"

/** What untangling works on; arrays are owned. Inner numbers but for state. */
typedef struct pl_tangle {
    pl_run *run;
    pl_star_problem problem;
    pl_star_untangling asked; /* in_patch, size and link_skip point to what follows */
    uint8_t *in_patch;        /* [n_nodes] */
    double *size;             /* [n_nodes] */
    uint8_t *link_skip;       /* [link facets of all stars], or NULL: none is skipped */
    uint8_t *state;           /* [n_elements] pl_tangle_state, as found last */
    uint8_t *hopeless;       /* [n_elements] 1: it cannot be mended, or not all of its kind; NULL */
    int64_t n_tangled;       /* elements whose state is PL_TANGLED */
    int64_t n_patch;         /* nodes of the patch */
    pl_star_energy energy;   /* of the patch, as computed last */
    pl_star_energy *partial; /* of chunks of stars */
} pl_tangle;

typedef enum pl_tangle_state { PL_SOUND = 0, PL_TANGLED = 1, PL_HOPELESS = 2 } pl_tangle_state;

/* ---- tangle.c ------------------------------------------------------------------------------ */

/** Look at the mesh as the run has it. n_tangled 0: there is nothing to be done, and nothing else
 *  is set. Errors: _MEMORY. To be destroyed in any case. */
int pl_tangle_create(pl_run *r, pl_tangle *t, planish_error *error);
void pl_tangle_destroy(pl_tangle *t);

/** Find the tangled elements of the mesh as it is now. */
void pl_tangle_find(pl_tangle *t);

/** Find how large the elements should be around each node: as they are now on average, inverted
 * ones counting negative. 0 without memory: then the sizes are as they were. */
int pl_tangle_find_sizes(pl_tangle *t);

/** Make the patch: the free nodes of tangled elements, and of layers elements around them. */
void pl_tangle_mark(pl_tangle *t, int layers);

/** The patch's energy with the present epsilon. */
void pl_tangle_measure(pl_tangle *t);

/** The same from t->partial [n_chunks]. */
void pl_tangle_total(pl_tangle *t, int64_t n_chunks);

/* ---- patch.c ------------------------------------------------------------------------------- */

/** Move the patch's nodes to where each is at the mean of its neighbours, by conjugate gradients.
 *  Like the next, not 0 if it was cut short; without memory it does nothing. */
int pl_patch_centre(pl_tangle *t);

/** Lower the energy of the patch by L-BFGS for falling epsilons until nothing is tangled. */
int pl_patch_solve(pl_tangle *t);

/* ---- untangle.c ---------------------------------------------------------------------------- */

/** The epsilon to begin with, and the next one, from the energy that the last one has reached. */
double pl_first_epsilon(double least);
double pl_next_epsilon(double epsilon, double before, double after, double least);

#endif
